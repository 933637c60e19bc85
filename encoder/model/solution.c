/* Solutions and their levels of detail. See solution.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "solution.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

void enc_relief_clear(enc_relief_store *store) {
    free(store->heights);
    free(store->views);
    *store = (enc_relief_store){0};
}

void enc_solution_clear(enc_solution *s) {
    enc_sbrdf_destroy(&s->sbrdf);
    free(s->shadow);
    free(s->shift);
    free(s->gain);
    free(s->centre);
    free(s->centre_codes);
    free(s->residual_texels);
    free(s->residual_directions);
    free(s->residual_scales);
    enc_store_clear(&s->factors);
    enc_relief_clear(&s->relief);
    memset(s, 0, sizeof *s);
}

enc_solution enc_level_of(const enc_solution *base, int width, int height) {
    enc_solution level = *base;
    level.width = width;
    level.height = height;
    level.sbrdf = NULL;
    level.shadow = NULL;
    level.shift = NULL;
    level.gain = NULL;
    level.centre = NULL;
    level.residual_texels = NULL;
    level.factors.texels = NULL;
    level.relief.heights = NULL;
    return level;
}

void enc_level_clear(enc_solution *level) {
    level->centre_codes = NULL;
    level->residual_directions = NULL;
    level->residual_scales = NULL;
    level->factors.directions = NULL;
    level->factors.scales = NULL;
    level->factors.views = NULL;
    level->relief.views = NULL;
    enc_solution_clear(level);
}

void enc_levels_clear(enc_levels *levels) {
    for (int i = 0; i + 1 < levels->count && levels->level; i++) {
        enc_level_clear(&levels->level[i]);
    }
    free(levels->level);
    *levels = (enc_levels){0};
}

uint16_t enc_half_from_float(float value) {
    const float magnitude = fabsf(value);
    const uint16_t sign = value < 0 ? 0x8000 : 0;
    if (!(magnitude >= 0x1p-14f)) {
        return 0;
    }
    if (magnitude >= 65504.0f) {
        return sign | 0x7bff;
    }
    uint32_t bits;
    memcpy(&bits, &magnitude, sizeof bits);
    bits += 0xfff + ((bits >> 13) & 1); /* round to nearest, ties to even */
    return (uint16_t)(sign | ((bits >> 13) - ((127 - 15) << 10)));
}
