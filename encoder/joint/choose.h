/* The choice of source and gain, for all points.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_JOINT_CHOOSE_H
#define OPENBTF_ENCODER_JOINT_CHOOSE_H

#include "projection.h"

/* Chooses sources (with `search`) and gains of all points for the present u, v and front; *out_error is the
 * sum of squares that remains. Never raises it. With a front the search is in the projection's basis, exact
 * but for the inner product beyond it, and its choice is taken where it is truly better than the present.
 */
btf_result joint_choose(const joint_rows *rows, const joint_projection *projection, bool search,
                        double tolerance, joint_model *model, double *out_error);

#endif
