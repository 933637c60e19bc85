/* A material as evaluation reads it.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_EVALUATE_PREPARED_H
#define OPENBTF_EVALUATE_PREPARED_H

#include <openbtf/evaluate.h>

#include <stdbool.h>

enum { BTFI_UNIT_BYTES = 16, BTFI_CLASSES = BTF_FACTOR_CLASSES, BTFI_TIERS = 3 };

/* A unit of factors (FORMAT.md section 3). */
typedef struct btfi_unit {
    uint8_t class_index, tier;
    bool whole;
    uint8_t channel[4]; /* of each word: 0 Y, 1 C1, 2 C2 */
    uint32_t u;         /* byte of its codes in those of a texel */
    float scale[4];     /* of each word, times 2^(s - 12) */
} btfi_unit;

typedef struct btfi_level {
    uint32_t width, height, shift; /* shift: level of detail, reliefLevel added */
    const void *sbrdf;
    const uint8_t *shadow, *shifts, *gain, *points, *point_lists, *point_indices, *heights;
    uint8_t *u;         /* [texel][u_bytes] codes of factors, in the order of those of w */
    int8_t *components; /* [texel][k], of components */
} btfi_level;

struct btf_evaluator {
    btf_material_info info;
    bool components_stored, factors_stored, modelled;
    const uint16_t *view_table, *light_table;
    uint32_t view_grid, light_grid;
    const float *view_vectors, *factor_views;
    const uint8_t *maps, *centre_texels;
    uint32_t *centre_at; /* [K] texel of each centre under light 0 */
    size_t centre_step;  /* texels to the next light */

    btfi_unit *units; /* [n_w] */
    size_t u_bytes;   /* of a texel */
    uint8_t *w;       /* [view][light][n_w][BTFI_UNIT_BYTES] */
    int8_t *v;        /* [view][light][k][4], of components: R, G, B, 0 */
    float *scales;    /* [k], of components, times 2^-12 */
    uint32_t
        *partners; /* [view] codes of decoder/evaluate/partners.h; NULL where no sums of products are folded */

    const struct btfi_kernels *kernels;
    btfi_level levels[BTF_MAX_LEVELS];
};

#endif
