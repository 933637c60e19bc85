/* Each direction of a list seen from the others: the neighbours and weights that a decoder would find for
 * it if it had not been sampled.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_LEFT_OUT_H
#define OPENBTF_ENCODER_LEFT_OUT_H

#include <openbtf/reference.h>
#include "encoder/data/data.h"

typedef struct enc_left_out {
    int count;      /* directions that can be left out */
    int index[ENC_MAX_DIRECTIONS];               /* [count] in the list, ascending */
    btf_ref_neighbours near[ENC_MAX_DIRECTIONS]; /* [count]: indices in the list */
} enc_left_out;

/* A direction at the rim can be left out only where the hull of the others ends close to it: nearer than
 * half of the way to the nearest other direction, which holds of rings but not of a single direction that
 * is farthest out. A list of one has none. Errors: those of btf_material_create, BTF_ERROR_MEMORY. */
btf_result enc_left_out_make(const enc_context *context, const enc_direction *directions, int count,
                             enc_left_out *out);

#endif
