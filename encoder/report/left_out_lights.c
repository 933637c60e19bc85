/* Lights of gloss without one of them. See left_out_lights.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "left_out_lights.h"

#include "encoder/nodes/interpolate.h"
#include "encoder/relief/gloss.h"

#include <stdlib.h>

struct enc_left_out_lights {
    const enc_data *data;
    float share;
    enc_interpolator *all, *without[ENC_MAX_DIRECTIONS]; /* [light] */
};

static btf_result leave_out(const enc_context *context, const enc_data *data, int light,
                            enc_interpolator **out) {
    enc_direction others[ENC_MAX_DIRECTIONS];
    for (int k = 0, n = 0; k < data->n_lights; k++) {
        if (k != light) {
            others[n++] = data->lights[k];
        }
    }
    return enc_interpolator_create(context, "lights", others, data->n_lights - 1, ENC_INTERPOLATE_LINEAR,
                                   out);
}

btf_result enc_left_out_lights_create(const enc_context *context, const enc_data *data, uint32_t share,
                                      enc_left_out_lights **out) {
    enc_left_out_lights *made = calloc(1, sizeof *made);
    *out = made;
    if (!made) {
        return BTF_ERROR_MEMORY;
    }
    made->data = data;
    made->share = (float)share / 4;
    btf_result result = enc_interpolator_create(context, "lights", data->lights, data->n_lights,
                                                ENC_INTERPOLATE_LINEAR, &made->all);
    const int count = data->n_lights > 1 ? data->n_lights : 0;
#pragma omp parallel for schedule(dynamic) num_threads(context->threads)
    for (int l = 0; l < count; l++) {
        const btf_result mine = leave_out(context, data, l, &made->without[l]);
        enc_keep_worse(&result, mine);
    }
    if (result != BTF_OK) {
        enc_left_out_lights_destroy(out);
    }
    return result;
}

void enc_left_out_lights_destroy(enc_left_out_lights **lights) {
    enc_left_out_lights *l = lights ? *lights : NULL;
    if (!l) {
        return;
    }
    enc_interpolator_destroy(&l->all);
    for (int k = 0; k < ENC_MAX_DIRECTIONS; k++) {
        enc_interpolator_destroy(&l->without[k]);
    }
    free(l);
    *lights = NULL;
}

void enc_left_out_lights_find(const enc_left_out_lights *l, int view, const btf_ref_neighbours *views,
                              int light, bool left_out, btf_ref_neighbours out[3]) {
    const enc_data *data = l->data;
    const bool without = left_out && l->without[light];
    for (int a = 0; a < 3; a++) {
        float around[3];
        enc_weights w;
        enc_gloss_light(data->views[views->index[a]].xyz, data->views[view].xyz, data->lights[light].xyz,
                        l->share, around);
        enc_interpolator_weights(without ? l->without[light] : l->all, around, &w);
        out[a] = (btf_ref_neighbours){.weight = {0}};
        for (int k = 0; k < w.count; k++) {
            out[a].index[k] = w.index[k] + (without && w.index[k] >= (uint32_t)light);
            out[a].weight[k] = (uint32_t)(w.weight[k] * 4096.0f);
        }
    }
}
