/* The result of a method of analysis, handed to the packer: every map of the model before it is laid out in
 * textures.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_MODEL_SOLUTION_H
#define OPENBTF_ENCODER_MODEL_SOLUTION_H

#include "encoder/data/data.h"
#include "factor_store.h"
#include "sbrdf.h"
#include <openbtf/material.h>

/* Effects between the samples (FORMAT.md section 9, Relief and Gloss). Zeros: none. */
typedef struct enc_relief_store {
    uint32_t effects;    /* BTF_EFFECT_RELIEF, BTF_EFFECT_GLOSS */
    int width, height;   /* of the map, level 0 */
    uint8_t *heights;    /* [texel] codes; NULL: base everywhere */
    uint8_t *views;      /* [view] 0 or 1 */
    int32_t base, step;
    uint32_t steps, gloss_share;
    uint32_t end; /* the first level of detail without relief; 0: all have it */
} enc_relief_store;

/* Frees both arrays and zeroes the struct. */
void enc_relief_clear(enc_relief_store *store);

/* Codes and scales have the meaning of FORMAT.md sections 3 and 4. Arrays that `effects` does not call for are
 * NULL. */
typedef struct enc_solution {
    int width, height, n_views, n_lights;
    btf_domain domain;
    uint32_t effects; /* btf_effect bits */
    float radiance_scale;

    enc_sbrdf *sbrdf;     /* NULL: colour `none` */
    bool half_parameters; /* the parameters are halves already, and can be stored so without loss */

    uint8_t *shadow; /* [light][texel] */
    float shadow_scale;

    int8_t *shift; /* [view][texel][2]: columns, rows; (0, 0) where hidden */
    uint8_t *gain; /* [view][texel]: 0 hidden, else the gain code; BTF_GAIN_ONE without gain */
    float gain_scale;

    /* Stored as packed points (layout tight, shift and gain, no hidden): shifts are within -32..31 and gain codes
     * 0..15, which say gain_base + code * gain_step; gain_scale is not read. */
    bool packed;
    int point_entries; /* with packed: texels have lists of so many pairs (shift, gain code), 1..16; 0: no lists */
    float gain_base, gain_step;

    uint16_t *centre;      /* [view][texel], read where gain is 0 */
    uint8_t *centre_codes; /* [centre][light][3] */
    uint32_t n_centres;
    float centre_scale;

    int8_t *residual_texels;     /* [texel][component] */
    int8_t *residual_directions; /* [view][light][channel][component] */
    float *residual_scales;      /* [component] */
    uint32_t n_components;
    enc_factor_store factors; /* the residual in the other store; n_components is 0 then */
    btf_blend blend;
    enc_relief_store relief; /* a level has heights of its own and shares all else with level 0 */
} enc_solution;

static inline size_t enc_solution_texels(const enc_solution *s) {
    return (size_t)s->width * (size_t)s->height;
}

/* The gain that a code stands for, of a point that is not hidden. */
static inline float enc_solution_gain(const enc_solution *s, int code) {
    return s->packed ? s->gain_base + (float)code * s->gain_step : (float)code * s->gain_scale;
}

/* Components of the residual as FORMAT.md counts them: units, where its store is factors. */
static inline uint32_t enc_solution_components(const enc_solution *s) {
    return !(s->effects & BTF_EFFECT_RESIDUAL) ? 0
           : s->factors.units > 0              ? s->factors.units
                                               : s->n_components;
}

/* Frees every array and the SBRDF, and zeroes the struct. */
void enc_solution_clear(enc_solution *solution);

/* Levels of detail have maps of texels of their own and share centre_codes, residual_directions,
 * residual_scales, factors but for their texels, and every scale with level 0. Returns an empty level of
 * `base`, with pointers to what is shared. */
enc_solution enc_level_of(const enc_solution *base, int width, int height);
/* Frees the arrays that belong to the level alone. */
void enc_level_clear(enc_solution *level);

/* The levels 1 .. count - 1 that belong to a level 0. All zeros: there are none. */
typedef struct enc_levels {
    int count;           /* level 0 included */
    enc_solution *level; /* [count - 1]: level i at i - 1; shared maps point into level 0's */
} enc_levels;

void enc_levels_clear(enc_levels *levels);

/* IEEE half of a float: round to nearest even; magnitudes below 2^-14 become 0, above 65504 become 65504. */
uint16_t enc_half_from_float(float value);

#endif
