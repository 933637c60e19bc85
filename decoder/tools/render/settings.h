/* btf-render's command line, read into settings.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_RENDER_SETTINGS_H
#define OPENBTF_RENDER_SETTINGS_H

#include "lights.h"
#include "decoder/toolkit/cli.h"
#include <stdbool.h>
#include <stdint.h>

typedef struct settings {
    const char *out, *mesh, *device, *environment, *environment_layer, *original, *baseline;
    double view[2], repeat, fov, zoom, exposure, background, env_rotate, env_gain, tolerance;
    bool repeat_given, zoom_given, interpolation_given, figure13, stats, cast_shadows, quiet, stochastic,
        spp_given, env_sampled, env_lights_given;
    light_list lights;
    uint32_t effects;
    int size[2], samples, env_lights, components, math, interpolation, filter, tone, frames, animate,
        threads, repeats, level, plan, fold, spp;
    const char *costs_file;
} settings;

/* As given, with defaults for the rest. */
extern settings render_options;
extern const cli_program render_program;

/* Checks the rules between options. Errors, with a message: BTF_ERROR_USAGE. */
btf_result settings_check(void);

#endif
