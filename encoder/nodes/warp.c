/* Surfaces given as heights. See warp.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "warp.h"

#include <math.h>
#include <stdlib.h>

static int wrapped(int i, int n) {
    const int rest = i % n;
    return rest < 0 ? rest + n : rest;
}

btf_result enc_warp_create(int width, int height, int level, int32_t base, enc_warp *out) {
    const int margin = 2 * ENC_WARP_FARTHEST;
    *out = (enc_warp){.width = width,
                      .height = height,
                      .level = level,
                      .base = base,
                      .top = base,
                      .steps = 1,
                      .column = malloc((size_t)(width + margin) * sizeof *out->column),
                      .row = malloc((size_t)(height + margin) * sizeof *out->row)};
    if (!out->column || !out->row) {
        enc_warp_clear(out);
        return BTF_ERROR_MEMORY;
    }
    for (int i = 0; i < width + margin; i++) {
        out->column[i] = wrapped(i - ENC_WARP_FARTHEST, width);
    }
    for (int i = 0; i < height + margin; i++) {
        out->row[i] = (height - 1 - wrapped(i - ENC_WARP_FARTHEST, height)) * width;
    }
    return BTF_OK;
}

btf_result enc_warp_set_codes(enc_warp *w, int32_t base, int32_t step, int steps, const uint8_t *codes) {
    const size_t texels = (size_t)w->width * (size_t)w->height;
    if (!w->heights) {
        w->heights = malloc(texels * sizeof *w->heights);
    }
    if (!w->heights) {
        return BTF_ERROR_MEMORY;
    }
    w->base = base;
    w->top = base + ((255 * step) >> 8);
    w->steps = steps;
    for (size_t i = 0; i < texels; i++) {
        w->heights[i] = base + ((codes[i] * step) >> 8);
    }
    return BTF_OK;
}

void enc_warp_clear(enc_warp *w) {
    free(w->heights);
    free(w->column);
    free(w->row);
    *w = (enc_warp){0};
}

void enc_warp_slope(const float view[3], int32_t out[2]) {
    const float z = view[2] > 0.25f ? view[2] : 0.25f;
    for (int i = 0; i < 2; i++) {
        const float s = floorf(view[i] / z * ENC_WARP_WEIGHT + 0.5f);
        out[i] = (int32_t)(s < -32767 ? -32767 : s > 32767 ? 32767 : s);
    }
}
