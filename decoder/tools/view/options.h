/* btf-view's command line, read into options.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_VIEW_OPTIONS_H
#define OPENBTF_VIEW_OPTIONS_H

#include "decoder/toolkit/cli.h"
#include <stdbool.h>
#include <stdint.h>

/* As given, with defaults for the rest. */
typedef struct view_settings {
    const char *mesh, *original, *screenshots, *costs_file;
    int size[2], interpolation, filter, math, level, plan;
    double tolerance;
    uint32_t effects;
    bool verbose, quiet;
} view_settings;

extern view_settings view_options;
extern const cli_program view_program;

#endif
