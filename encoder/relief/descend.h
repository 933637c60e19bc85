/* Heights by analysis and synthesis: coordinate descent on the decoder's error at views left out.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_RELIEF_DESCEND_H
#define OPENBTF_ENCODER_RELIEF_DESCEND_H

#include "images.h"
#include "seen.h"

/* Improves the heights of *io_warp, which has the images' size, level 0 and a height for each texel. Other
 * heights are tried at each texel, `sweeps` times, and kept where the sum falls of the squared error of the
 * views left out, as a share of that of a flat surface, and the total variation of the heights. Also sets
 * base, top and steps. *out_share: the squared error left, as a share of the flat surface's. Stage steps:
 * sweeps times the texels. The same bits for any number of threads. Errors, not logged: BTF_ERROR_MEMORY,
 * BTF_ERROR_INTERRUPTED. */
btf_result enc_relief_descend(const enc_context *context, const enc_relief_images *images,
                              const enc_seen *seen, int sweeps, enc_warp *io_warp, double *out_share);

#endif
