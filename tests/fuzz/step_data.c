/* The data set whose steps are fuzzed. See step_data.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "step_data.h"

const char *const step_names[STEP_COUNT] = {"fit",     "shadow",       "flow",      "refine",
                                           "cluster", "components-0", "factors-0", "matched-0", "match-0"};

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
        BTF_OK)
        return NULL;
    for (int i = 0; i < STEP_TEXELS * STEP_VIEWS * STEP_LIGHTS * 3; i++)
        data->samples[i] = (float)(i * 37 % 101) / 101;
    return data;
}
