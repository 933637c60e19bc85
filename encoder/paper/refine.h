/* Refinement of the hidden map: hidden points that the model can show all the same (paper 2.3.2).
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_PAPER_REFINE_H
#define OPENBTF_ENCODER_PAPER_REFINE_H

#include "encoder/data/data.h"
#include "encoder/model/occlusion.h"
#include "encoder/model/sbrdf.h"

/* Zero means the default beside the field. */
typedef struct enc_refine_options {
    int columns,
        rows; /* search window around the point, cut to the periodic tile; default 256, the paper's,
               * up to 64x64 texels, and beyond 64 around the shift that the flow voted for */
} enc_refine_options;

/* For every hidden point x of every view V, searches the window for the source x' of least
 *   distance(x, V) = sum_l || BTF(x, l, V) - STVS(x', l, V) ||,   || . || Euclidean over R, G, B,
 *   STVS(x', l, V) = max(l.z, 0) * model(x', l, V) * shadow(x', l)
 * and makes x a shifted point where that is below the view's threshold: the mean distance of its points
 * that are not hidden, with the shifts they have (no such point: threshold 0, nothing changes). Of equal
 * distances, the shift that enc_occlusion_compare_shift prefers wins. Points that stay hidden get the
 * winner's shift too: it shows them best where a file is to have no hidden points.
 *
 * sbrdf is of the linear domain. shadow[light][texel] holds codes of value code * shadow_scale.
 * out_thresholds[n_views] may be NULL. The winner is that of the full search in float arithmetic:
 * candidates are skipped only where the triangle inequality over groups of lights says that they cannot
 * win. Time grows with hidden points times window, so that with the default it is linear in texels. Memory:
 * two profiles a texel, and a float a thread and window texel. The stage is called "hidden". The same result
 * for any number of threads. Errors: BTF_ERROR_USAGE (options), BTF_ERROR_MEMORY, BTF_ERROR_IO (scratch
 * file), BTF_ERROR_INTERRUPTED. */
btf_result enc_refine(const enc_context *context, const enc_data *data, const enc_sbrdf *sbrdf,
                      const uint8_t *shadow, float shadow_scale, const enc_refine_options *options,
                      enc_occlusion *occlusion, float *out_thresholds);

#endif
