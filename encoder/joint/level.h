/* A level of detail of a material that the joint method made.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_JOINT_LEVEL_H
#define OPENBTF_ENCODER_JOINT_LEVEL_H

#include "encoder/model/solution.h"

/* Fits the maps that a level has for itself to its data, with what it shares with `base`, the solution of
 * level 0: V, scales and effects. U, SBRDF, shadow, shifts and gains are found in turn by least squares and
 * search, as for level 0; then U is rounded to codes and the choices are made for those. *out_solution owns
 * its own maps and no others (enc_level_clear). Errors: BTF_ERROR_MEMORY, BTF_ERROR_IO,
 * BTF_ERROR_INTERRUPTED. */
btf_result enc_joint_level(const enc_context *context, const enc_data *data, const enc_solution *base,
                           enc_solution *out_solution);

#endif
