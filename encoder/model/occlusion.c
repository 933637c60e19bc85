/* The occlusion analysis' result: storage and the arithmetic of wrapped shifts.
 *
 * SPDX-License-Identifier: MIT
 */
#include "occlusion.h"

#include <assert.h>
#include <stdlib.h>

btf_result enc_occlusion_create(int n_views, size_t n_texels, enc_occlusion **out_occlusion) {
    assert(out_occlusion);
    *out_occlusion = NULL;
    if (n_views < 1 || n_texels < 1 || n_texels > SIZE_MAX / 16 / (size_t)n_views) {
        return BTF_ERROR_USAGE;
    }
    enc_occlusion *o = calloc(1, sizeof *o);
    if (!o) {
        return BTF_ERROR_MEMORY;
    }
    const size_t n = (size_t)n_views * n_texels;
    o->n_views = n_views;
    o->n_texels = n_texels;
    o->shift = calloc(n, 2 * sizeof *o->shift);
    o->hidden = calloc(n, sizeof *o->hidden);
    o->hidden_voted = calloc(n, sizeof *o->hidden_voted);
    o->ratio = calloc(n, sizeof *o->ratio);
    o->centre = calloc(n, sizeof *o->centre);
    if (!o->shift || !o->hidden || !o->hidden_voted || !o->ratio || !o->centre) {
        enc_occlusion_destroy(&o);
        return BTF_ERROR_MEMORY;
    }
    *out_occlusion = o;
    return BTF_OK;
}

void enc_occlusion_destroy(enc_occlusion **occlusion) {
    if (!occlusion || !*occlusion) {
        return;
    }
    free((*occlusion)->shift);
    free((*occlusion)->hidden);
    free((*occlusion)->hidden_voted);
    free((*occlusion)->ratio);
    free((*occlusion)->centre);
    free(*occlusion);
    *occlusion = NULL;
}

size_t enc_occlusion_hidden_count(const enc_occlusion *occlusion, int view) {
    const size_t first = view < 0 ? 0 : (size_t)view * occlusion->n_texels;
    const size_t n = view < 0 ? (size_t)occlusion->n_views * occlusion->n_texels : occlusion->n_texels;
    size_t count = 0;
    for (size_t i = 0; i < n; i++) {
        count += occlusion->hidden[first + i] != 0;
    }
    return count;
}

size_t enc_occlusion_source(int width, int height, size_t texel, int columns, int rows) {
    const int column = (int)(texel % (size_t)width), row = (int)(texel / (size_t)width);
    return (size_t)enc_occlusion_modulo(row + rows, height) * (size_t)width +
           (size_t)enc_occlusion_modulo(column + columns, width);
}

int enc_occlusion_wrap(int delta, int size) {
    const int r = enc_occlusion_modulo(delta, size);
    return 2 * r > size || r > 127 ? r - size : r;
}

int enc_occlusion_compare_shift(const int8_t a[2], const int8_t b[2]) {
    const int la = a[0] * a[0] + a[1] * a[1], lb = b[0] * b[0] + b[1] * b[1];
    if (la != lb) {
        return la < lb ? -1 : 1;
    }
    if (a[1] != b[1]) {
        return a[1] < b[1] ? -1 : 1;
    }
    return (a[0] > b[0]) - (a[0] < b[0]);
}
