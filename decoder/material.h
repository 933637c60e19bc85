/* OpenBTF: a material in memory.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_MATERIAL_INTERNAL_H
#define OPENBTF_MATERIAL_INTERNAL_H

#include "directions.h"

#pragma GCC visibility push(hidden)

struct btf_material {
    btf_material_info info;
    char *method, *options, *source; /* never NULL once made */
    /* The textures that have a shape (btf_material_texture_shape); direction tables are in views and lights. */
    void *texture[BTF_MAX_LEVELS][BTF_TEXTURE_COUNT];
    btfi_directions views, lights;
    btf_material_error *errors;
    size_t error_count;
    btf_level_error *level_errors;
    size_t level_error_count;
    float *effect_errors; /* attribute openbtf.effectErrors */
    size_t effect_error_count;
    float *effect_differences; /* attribute openbtf.effectDifferences */
    size_t effect_difference_count;
    float *between_errors; /* attribute openbtf.betweenErrors, then the rows of openbtf.levelBetweenErrors */
    size_t between_error_count;
    uint16_t *preview;   /* [height][width][4] halves; NULL: none */
    float *view_vectors; /* [n_views][4], texture view_vectors; NULL: none */
};

/* A copy of a string ("" for NULL), NULL when out of memory. */
char *btfi_copy_string(const char *text, size_t length);
/* An empty material. NULL when out of memory. */
btf_material *btfi_material_new(void);
/* With relief or gloss, makes view_vectors of the material's views: acts[view] 0 or 1 says where relief
 * acts; NULL: everywhere. Errors: BTF_ERROR_MEMORY. */
btf_result btfi_material_make_vectors(const btf_log *log, const uint8_t *acts, btf_material *material);
/* Allocates zeroed textures for material->info. Errors: BTF_ERROR_MEMORY. */
btf_result btfi_material_allocate(const btf_log *log, btf_material *material);
/* Fills the fields of info that follow from the rest, once tables are made. */
void btfi_material_finish(btf_material *material);

#pragma GCC visibility pop

#endif
