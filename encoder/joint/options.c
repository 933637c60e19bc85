/* Defaults and presets of the joint method. See options.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "options.h"

#include <openbtf/material.h>

static const joint_preset_values presets[] = {
    [ENC_JOINT_FAST] = {3, 1, 1, 5, 2, 2e-3},
    [ENC_JOINT_MEDIUM] = {4, 3, 2, 18, 4, 5e-4},
    [ENC_JOINT_THOROUGH] = {5, 6, 4, 60, 10, 1e-4},
    [ENC_JOINT_EXHAUSTIVE] = {8, 20, 6, ENC_JOINT_MAX_ROUNDS, 100, 1e-6},
};

enc_joint_options enc_joint_options_default(void) {
    return (enc_joint_options){.preset = ENC_JOINT_MEDIUM,
                               .effects = BTF_EFFECT_ALL,
                               .choose = true,
                               .effect_tolerance = 0.05,
                               .front_tolerance = 0.1};
}

joint_preset_values joint_preset_of(const enc_joint_options *options) {
    joint_preset_values values = presets[options->preset];
    if (options->tolerance > 0.0)
        values.tolerance = options->tolerance;
    return values;
}
