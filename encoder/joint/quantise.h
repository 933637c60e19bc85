/* From a float model to the codes of the file: a basis that wastes no bits, and rounding that knows the
 * errors it makes.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_JOINT_QUANTISE_H
#define OPENBTF_ENCODER_JOINT_QUANTISE_H

#include "solve.h"

/* Codes of the residual (FORMAT.md section 3): v = v code * v_step * m(l) and u = u code * u_step. */
typedef struct joint_codes {
    int8_t *u;               /* [texel][k] */
    int8_t *v;               /* [view][k][row] */
    double *u_step, *v_step; /* [k] */
} joint_codes;

/* Errors: BTF_ERROR_MEMORY. Free with joint_codes_clear in any case. */
btf_result joint_codes_init(const joint_rows *rows, size_t k, joint_codes *out_codes);
void joint_codes_clear(joint_codes *codes);

/* Chooses a basis in which the columns of u are orthonormal times sqrt(texels): what keeps the solves well
 * conditioned and gives the prior its scale. Sources stay what they are. */
btf_result joint_orthogonalise(const joint_rows *rows, joint_model *model);

/* Chooses the basis of the components: uncorrelated over the points, in falling order of what they
 * contribute, so that a decoder may use the first few alone. Sources stay what they are. energy [k] (may be
 * NULL) receives what each contributes to the sum of squares: exactly while every point is its own source.
 */
btf_result joint_principal_basis(const joint_rows *rows, joint_model *model, double *energy);

/* Rounds the model to codes, v then u, and solves each again for the rounded other; then chooses sources
 * and gains for what was rounded. The model holds the rounded values afterwards; *out_error is the sum of
 * squares that remains. tolerance: of joint_choose. */
btf_result joint_quantise(const joint_rows *rows, joint_projection *projection, double tolerance,
                          joint_model *model, joint_codes *codes, double *out_error);

#endif
