/* The uncompressed BTF as something to render with: the images that a material was made from, looked up and
 * blended as the decoder does it (FORMAT.md, sections 6 and 9).
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_RENDER_ORIGINAL_H
#define OPENBTF_RENDER_ORIGINAL_H

#include "render.h"

/* A sampled direction in the tangent frame: theta from the normal, phi, both in degrees; xyz the unit
 * vector. */
typedef struct original_direction {
    double theta, phi;
    float xyz[3];
} original_direction;

/* A data set as its reader hands it over. */
typedef struct original_data {
    int width, height, n_views, n_lights;
    const original_direction *views, *lights;
    const float *samples; /* [row][column][view][channel][light], linear radiance, row 0 at the top */
    void *owner;          /* of all of them */
    void (*release)(void *owner);
} original_data;

/* The type of a function that reads a data set: the renderer knows no format of them, its program hands it the reader
 * (decoder/tools/original). Errors, on log: its own. `p` is a progress object or NULL. */
typedef btf_result original_reader(const char *input, int threads, void *p, const btf_log *log,
                                   original_data *out_data);

typedef struct original original;

/* Reads a data set. Errors, on log: those of reading; BTF_ERROR_USAGE when its size or its directions are
 * not those of the material (both are named). */
btf_result original_open(original_reader *read, const char *input, const btf_material *material,
                         int threads, void *p, const btf_log *log, original **out_original);
void original_close(original **o);

/* An evaluator that blends three neighbouring views and three lights of one texel. */
evaluator original_evaluator(original *o);

/* All samples, as in original_data. */
const float *original_samples(const original *o);

#endif
