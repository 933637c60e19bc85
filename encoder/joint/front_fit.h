/* Fits of fronts to the points that refer to their sources.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_JOINT_FRONT_FIT_H
#define OPENBTF_ENCODER_JOINT_FRONT_FIT_H

#include "sources.h"

enum { JOINT_PROBED = 64 }; /* texels that a plain SBRDF is tried on first */

/* The mean squared error of a sample that SBRDFs of this kind, alone and each for its own texel, leave of
 * `count` texels evenly spaced. Errors: BTF_ERROR_MEMORY, BTF_ERROR_IO. */
btf_result joint_front_probe(const joint_rows *rows, const joint_front_kind *kind, int starts, size_t count,
                             double *out_error);

/* The first fit of model->front: every source's SBRDF to all samples that refer to it, the residual left
 * out, then its shadows, in closed form, and the SBRDF again. `starts` fixed starts are tried. */
btf_result joint_front_fit(const joint_rows *rows, joint_model *model, int starts);

/* One refit of model->front for the present choices and residual: shadows in closed form, then the SBRDF
 * from where it is, then the shadows again. A step that would raise a source's squared error is not taken,
 * so that the total never rises. Errors of both: BTF_ERROR_MEMORY, BTF_ERROR_IO, BTF_ERROR_INTERRUPTED. */
btf_result joint_front_refit(const joint_rows *rows, joint_model *model);

#endif
