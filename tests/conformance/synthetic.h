/* Random materials that follow every rule of the format and reach its limits, but show nothing meaningful.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_CONFORMANCE_SYNTHETIC_H
#define OPENBTF_CONFORMANCE_SYNTHETIC_H

#include <openbtf/material.h>

/* How direction lists are made. */
typedef enum synthetic_directions {
    SYNTHETIC_RINGS,  /* rings of rising theta, azimuths counter-clockwise: co-circular ties everywhere */
    SYNTHETIC_RANDOM, /* anywhere above the horizon */
    SYNTHETIC_COLLINEAR, /* on one meridian */
} synthetic_directions;

typedef enum synthetic_values {
    SYNTHETIC_PLAUSIBLE, /* parameters as fits give them */
    SYNTHETIC_EXTREME,   /* magnitudes from 2^-24 to 2^24, both signs, many zeros */
} synthetic_values;

/* Codes of factors. */
typedef enum synthetic_codes {
    SYNTHETIC_ANY,    /* each at random */
    SYNTHETIC_BOUNDS, /* mostly words of nothing but the largest or the smallest code, so that sums reach
                         their bounds */
} synthetic_codes;

/* Heights of the effect relief. */
typedef enum synthetic_relief {
    SYNTHETIC_FLAT,   /* one height, no map */
    SYNTHETIC_GENTLE, /* as a wall of bricks has them, below and above the plane of the data */
    SYNTHETIC_DEEP,   /* from the lowest height there may be, in one step */
    SYNTHETIC_HIGH,   /* to the highest, in 64 steps, half of the texels at a limit */
    SYNTHETIC_EVEN,   /* a map of one height */
    SYNTHETIC_RELIEFS
} synthetic_relief;

typedef struct synthetic_spec {
    uint64_t seed;
    uint32_t width, height, n_views, n_lights;
    btf_layout layout;
    btf_domain domain;
    btf_colour colour;
    int half_float;
    uint32_t lobes, effects, components;
    uint32_t centres; /* asked for; at most what the atlas holds; used with hidden */
    int all_hidden;   /* with hidden: every point is; else about a third */
    synthetic_directions directions;
    synthetic_values values;
    uint32_t levels; /* of detail: at most so many, as far as size and layout allow; 0 means 1 */
    /* Version 2. With units, the residual is factors, and `components` is their number. */
    uint32_t classes[BTF_FACTOR_CLASSES][3]; /* units, words of C1, words of C2 */
    synthetic_codes codes;
    btf_blend blend;
    float horizon_scale; /* 0 means 1 */
    int packed;          /* shift and gain are packed points: layout tight, both effects, not hidden */
    uint32_t entries;    /* with packed: of a texel's list; 0: no lists */
    synthetic_relief relief; /* with the effect */
    int relief_mixed;        /* relief acts on about half of the views; else on all */
    uint32_t relief_end;     /* the first level without it, if there are so many; 0: none */
    uint32_t gloss_share;    /* with the effect gloss: 1 or 2 */
    const float *effect_errors, *between_errors; /* as in btf_material_desc; NULL: none */
    size_t effect_error_count, between_error_count;
} synthetic_spec;

/* Makes it. Errors as btf_material_create. */
btf_result synthetic_create(const synthetic_spec *spec, const btf_log *log, btf_material **out_material);

#endif
