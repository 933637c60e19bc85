/* The uncompressed BTF as something to render with: the images that a material was made from, looked up and
 * blended as the decoder does it (FORMAT.md, sections 6 and 9).
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_RENDER_ORIGINAL_H
#define OPENBTF_RENDER_ORIGINAL_H

#include "render.h"

typedef struct original original;

/* Reads a data set (encoder/input/reader.h, default options). Errors, on log: those of reading; BTF_ERROR_USAGE
 * when its size or its directions are not those of the material (both are named). `p` is a progress object
 * or NULL. */
btf_result original_open(const char *input, const btf_material *material, int threads, void *p,
                         const btf_log *log, original **out_original);
void original_close(original **o);

/* Three neighbouring views and lights blended, one texel. */
evaluator original_evaluator(original *o);

/* All samples, [texel][view][channel][light] (encoder/data/data.h). */
const float *original_samples(const original *o);

#endif
