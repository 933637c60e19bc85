/* The level of detail from which on relief no longer pays.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_RELIEF_END_H
#define OPENBTF_ENCODER_RELIEF_END_H

#include "judge.h"
#include "level.h"

#define ENC_RELIEF_LEVEL_MARGIN 0.7 /* dB that a level must gain, mean of linear and sRGB-coded */

/* A further level of detail: errors of views left out that relief acts on, without it and with it, in
 * images of the next level. Neighbours of a view left out lie twice as far away as those of a direction
 * between samples, and displace points by twice as much. Counted in texels of the next level, which are
 * twice as wide, that is the displacement of this level in use. */
typedef struct enc_relief_judged_level {
    enc_judged_error plain, moved;
    double gain; /* dB */
    bool on;
} enc_relief_judged_level;

typedef struct enc_relief_end {
    int end;    /* the first level without relief; where all have it, their number; 0: not asked for */
    int judged; /* levels 1 .. judged, of which the last may be `end` */
    enc_relief_judged_level level[BTF_MAX_LEVELS]; /* [level - 1] */
} enc_relief_end;

/* Judges the levels 1, 2, ... of `levels` in all, with the surface that the file has at each. Relief ends
 * at the first that does not gain ENC_RELIEF_LEVEL_MARGIN, or loses in linear or in sRGB-coded values; the
 * store's own end is not read. Stage steps: texels of the images. The same bits for any number of threads.
 * Memory: enc_relief_end_memory. Errors: those of the data; BTF_ERROR_MEMORY (not logged),
 * BTF_ERROR_INTERRUPTED. */
btf_result enc_relief_find_end(const enc_context *context, const enc_data *data, const enc_seen *seen,
                               int levels, const enc_relief_store *store, enc_relief_end *out);

/* Bytes that enc_relief_find_end takes at most. */
uint64_t enc_relief_end_memory(int width, int height, int n_views, int n_lights);

#endif
