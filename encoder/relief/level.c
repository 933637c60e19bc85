/* The surface of a level of detail. See level.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "level.h"

#include "encoder/math/area.h"

#include <stdlib.h>

/* The mean height code over the texels that a texel of the level covers, rounded. */
static uint8_t filtered(const enc_relief_store *s, int width, int height, int column, int row) {
    int first[2], end[2];
    int64_t sum = 0;
    const int64_t whole = (int64_t)s->width * s->height;
    enc_area_span(s->width, width, column, &first[0], &end[0]);
    enc_area_span(s->height, height, row, &first[1], &end[1]);
    for (int r = first[1]; r < end[1]; r++) {
        const int64_t down = enc_area_overlap(s->height, height, row, r);
        for (int c = first[0]; c < end[0]; c++) {
            sum += down * enc_area_overlap(s->width, width, column, c) *
                   s->heights[(size_t)r * (size_t)s->width + (size_t)c];
        }
    }
    return (uint8_t)((2 * sum + whole) / (2 * whole));
}

btf_result enc_relief_level(const enc_relief_store *s, int width, int height, int level,
                            uint8_t **out_codes, enc_warp *out_warp) {
    uint8_t *codes = NULL;
    btf_result result = enc_warp_create(width, height, level, s->base, out_warp);
    if (s->heights && result == BTF_OK) {
        codes = malloc((size_t)width * (size_t)height);
        for (int t = 0; codes && t < width * height; t++) {
            codes[t] = filtered(s, width, height, t % width, t / width);
        }
        result =
            codes ? enc_warp_set_codes(out_warp, s->base, s->step, (int)s->steps, codes) : BTF_ERROR_MEMORY;
    }
    if (result != BTF_OK) {
        enc_warp_clear(out_warp);
    }
    if (out_codes && result == BTF_OK) {
        *out_codes = codes;
    } else {
        free(codes);
    }
    return result;
}
