/* Fits of the joint method in a checkpoint. Internal.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_JOINT_STEPS_H
#define OPENBTF_ENCODER_JOINT_STEPS_H

#include "fit.h"

/* The fit that step `name` holds, without a projection, and `size` bytes beside it, which the caller
 * checks; false when it holds none of these sizes, or none that rounds could have led to. *out_fit is
 * cleared by the caller in any case. */
bool joint_step_take(const joint_rows *rows, const char *name, joint_fit *out_fit, void *beside,
                     size_t size);

/* Keeps a fit and what is beside it. Errors: those of enc_checkpoint_put. */
btf_result joint_step_keep(const char *name, const joint_fit *fit, const void *beside, size_t size);

/* Whether all numbers are finite: for the caller's check of the bytes beside a fit. */
bool joint_step_finite(const double *values, size_t count);

#endif
