/* The data set whose steps are fuzzed. See step_data.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "step_data.h"

#include <openbtf/material.h>
#include <stdlib.h>

const char *const step_names[STEP_COUNT] = {"fit",          "shadow",    "flow",      "refine",  "cluster",
                                            "components-0", "factors-0", "matched-0", "match-0", "relief"};

enc_factor_options step_factors(bool match) {
    return (enc_factor_options){.budget = 2048,
                                .sweeps = 1,
                                .match = match ? ENC_FACTOR_MATCH : ENC_FACTOR_NO_MATCH,
                                .gain = true,
                                .measure = true};
}

enc_data *step_data(const enc_context *context) {
    const enc_direction list[2] = {enc_direction_from_angles(0, 0), enc_direction_from_angles(45, 90)};
    enc_data *data = NULL;
    if (enc_data_create(context, STEP_SIDE, STEP_SIDE, STEP_VIEWS, list, STEP_LIGHTS, list, &data) !=
        BTF_OK) {
        return NULL;
    }
    for (int i = 0; i < STEP_TEXELS * STEP_VIEWS * STEP_LIGHTS * 3; i++) {
        data->samples[i] = (float)(i * 37 % 101) / 101;
    }
    return data;
}

void step_relief(const enc_data *data, enc_relief_choice *out_choice, enc_relief_store *out_store) {
    const size_t texels = enc_data_texel_count(data), views = (size_t)data->n_views;
    *out_choice = (enc_relief_choice){.tried = true, .share = 0.5, .chosen = 1, .n_rings = 2};
    out_choice->candidate[1] = (enc_relief_candidate){.scale = 0.5, .judged = true, .gain = 1, .rings = 1};
    out_choice->ring[1] = (enc_relief_ring){45, 1, {0.02, 0.02}, {0.01, 0.01}, 3, true};
    out_choice->gloss = (enc_gloss_choice){.judged = true, .best = 0.3, .quarters = 1};
    *out_store = (enc_relief_store){.effects = BTF_EFFECT_RELIEF | BTF_EFFECT_GLOSS,
                                    .width = data->width,
                                    .height = data->height,
                                    .heights = calloc(texels, 1),
                                    .views = calloc(views, 1),
                                    .base = -300,
                                    .step = 256,
                                    .steps = 8,
                                    .end = 1,
                                    .gloss_share = 1};
    for (size_t t = 0; t < texels && out_store->heights; t++) {
        out_store->heights[t] = (uint8_t)(t * 31);
    }
    if (out_store->views) {
        out_store->views[views - 1] = 1;
    }
}
