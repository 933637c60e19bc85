/* Views left out. See seen.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "seen.h"

#include "encoder/nodes/left_out.h"

#include <stdlib.h>

static enc_seen_view view_of(const enc_direction *views, int view, const btf_ref_neighbours *near) {
    enc_seen_view s = {.view = view};
    enc_warp_slope(views[view].xyz, s.slope);
    for (int k = 0; k < 3; k++) {
        if (near->weight[k] > 0) {
            s.near[s.count] = (int)near->index[k];
            s.weight[s.count] = (int32_t)near->weight[k];
            enc_warp_slope(views[near->index[k]].xyz, s.near_slope[s.count++]);
        }
    }
    return s;
}

btf_result enc_seen_make(const enc_context *context, const enc_direction *views, int count,
                         double least_theta, double most_theta, enc_seen *out) {
    enc_left_out *left = malloc(sizeof *left);
    btf_result result = left ? enc_left_out_make(context, views, count, left) : BTF_ERROR_MEMORY;
    out->count = 0;
    for (int i = 0; result == BTF_OK && i < left->count; i++) {
        const double theta = views[left->index[i]].theta;
        if (theta >= least_theta && theta <= most_theta) {
            out->of[out->count++] = view_of(views, left->index[i], &left->near[i]);
        }
    }
    free(left);
    return result;
}
