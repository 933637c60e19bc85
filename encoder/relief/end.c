/* The level of detail at which relief ends. See end.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "end.h"

#include "encoder/data/level_filter.h"

#include <stdlib.h>

/* The mean over the views left out that relief acts on. */
static enc_judged_error mean_of(const enc_seen *seen, const uint8_t *views, const enc_judged_error *error) {
    enc_judged_error sum = {0, 0};
    int count = 0;
    for (int i = 0; i < seen->count; i++) {
        if (views[seen->of[i].view]) {
            sum.linear += error[i].linear;
            sum.srgb += error[i].srgb;
            count++;
        }
    }
    return count > 0 ? (enc_judged_error){sum.linear / count, sum.srgb / count} : sum;
}

static btf_result judge_level(const enc_context *context, const enc_data *data, const enc_seen *seen,
                              const enc_relief_store *store, int level, enc_relief_judged_level *out) {
    const int by = level + 1, width = enc_level_side(data->width, by),
              height = enc_level_side(data->height, by);
    enc_judged judged = {0};
    enc_warp surface = {0}, plane = {0};
    enc_judged_error *error = malloc((size_t)(seen->count + 1) * sizeof *error);
    btf_result result = error ? enc_judged_create(context, data, by, &judged) : BTF_ERROR_MEMORY;
    if (result == BTF_OK) {
        result = enc_relief_level(store, width, height, by, NULL, &surface);
    }
    if (result == BTF_OK) {
        result = enc_warp_create(width, height, by, 0, &plane);
    }
    if (result == BTF_OK) {
        enc_judge_surface(context, &judged, seen, &plane, error);
        out->plain = mean_of(seen, store->views, error);
        enc_judge_surface(context, &judged, seen, &surface, error);
        out->moved = mean_of(seen, store->views, error);
        out->gain = enc_judged_gain(out->plain, out->moved);
        out->on = out->gain > ENC_RELIEF_LEVEL_MARGIN && out->moved.linear < out->plain.linear &&
                  out->moved.srgb < out->plain.srgb;
    }
    enc_warp_clear(&plane);
    enc_warp_clear(&surface);
    enc_judged_clear(&judged);
    free(error);
    return result;
}

btf_result enc_relief_find_end(const enc_context *context, const enc_data *data, const enc_seen *seen,
                               int levels, const enc_relief_store *store, enc_relief_end *out) {
    btf_result result = BTF_OK;
    bool on = true;
    *out = (enc_relief_end){0};
    for (int level = 1; level < levels && on && result == BTF_OK; level++) {
        enc_relief_judged_level *judged = &out->level[level - 1];
        result = enc_cancelled(context) ? BTF_ERROR_INTERRUPTED
                                        : judge_level(context, data, seen, store, level, judged);
        on = judged->on;
        out->judged = level;
    }
    out->end = on ? levels : out->judged;
    return result;
}

uint64_t enc_relief_end_memory(int width, int height, int n_views, int n_lights) {
    const int wide = enc_level_side(width, 2), high = enc_level_side(height, 2);
    return enc_judged_bytes(wide, high, n_views) + 8 * (uint64_t)wide * (uint64_t)high +
           8 * (uint64_t)n_views * (uint64_t)n_lights;
}
