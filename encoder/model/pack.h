/* Packing (paper 3.1): from a solution to the textures of a material.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_MODEL_PACK_H
#define OPENBTF_ENCODER_MODEL_PACK_H

#include "solution.h"

typedef struct enc_pack_options {
    btf_layout layout;
    bool half_float;    /* SBRDF parameters as halves; values too small for a normal half become 0 */
    const char *method; /* provenance strings of FORMAT.md section 7 */
    const char *options;
    const char *source;
    const btf_material_error *errors;
    size_t error_count;
    const float *effect_errors; /* effect_errors.h */
    size_t effect_error_count;
    const float *effect_differences; /* likewise */
    size_t effect_difference_count;
    const float *between_errors; /* leave_one_out.h */
    size_t between_error_count;
    const enc_solution *level; /* [levels - 1] levels 1 .. levels - 1; layout `tight` */
    int levels;                /* 0 means 1 */
    const btf_level_error *level_errors;
    size_t level_error_count;
    const uint16_t *preview; /* btf_material_desc.preview; NULL: none */
} enc_pack_options;

/* Lays the solution out in textures and makes the material. Directions come from `data`. The atlas of
 * layout `paper` is made large enough for all centres. Errors: BTF_ERROR_UNSUPPORTED (no legal atlas),
 * BTF_ERROR_MEMORY. */
btf_result enc_pack(const enc_context *context, const enc_data *data, const enc_solution *solution,
                    const enc_pack_options *options, btf_material **out_material);

/* The number of centres that layout `paper` has room for with `hidden` present (paper: 1984 for 64x64 and
 * 81 directions). */
btf_result enc_pack_centre_room(const enc_context *context, int width, int height, int n_views,
                                int n_lights, uint32_t *out_room);

#endif
