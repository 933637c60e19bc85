/* Hidden points of the joint method: points that a cluster centre shows better than the best source.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_JOINT_HIDDEN_H
#define OPENBTF_ENCODER_JOINT_HIDDEN_H

#include "run.h"

#include <stdint.h>

enum { JOINT_MOST_CENTRES = 512 }; /* the time of the clustering grows with their square */

/* Centres as the file holds them, and the points that take them. All zeros: none. */
typedef struct joint_hidden {
    size_t count;
    float scale;    /* root of a value = code * scale */
    uint8_t *codes; /* [centre][light][3] */
    size_t n_points;
    uint32_t *point;  /* [n_points] view * texels + texel, ascending */
    uint16_t *centre; /* [n_points] */
    float *error;     /* [n_points] squared distance to the codes' centre */
    double saved;     /* squared error that the points lose by it */
} joint_hidden;

/* Finds up to `count` centres, global to the file, so that views share them by what they gain: k-means++
 * and Lloyd's rounds among the worst points of `fit`, of which each keeps the better of its source and its
 * nearest centre; a centre that nobody takes restarts at the point of largest error. The fit is not changed
 * but for its projection. Errors: BTF_ERROR_MEMORY, BTF_ERROR_IO, BTF_ERROR_INTERRUPTED. */
btf_result joint_hidden_find(joint_fit *fit, size_t count, joint_hidden *out_centres);
void joint_hidden_clear(joint_hidden *centres);

/* Gives the fit, which has shift and gain, these centres: effect hidden from here on. *centres is emptied.
 */
btf_result joint_hidden_apply(joint_fit *fit, joint_hidden *centres);

/* Hidden points and centres for r->best, where it has shift and gain: in the bytes that are left, or in
 * those of the last four components where that saves more. */
btf_result joint_try_hidden(joint_run *r);

#endif
