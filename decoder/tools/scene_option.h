/* A scene on the command line: "views=0:30,lights=0:75,pixels=1.5".
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TOOLS_SCENE_OPTION_H
#define OPENBTF_TOOLS_SCENE_OPTION_H

#include <openbtf/plan.h>
#include <stdio.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct scene_option {
    btf_scene scene;
    float tolerance; /* dB */
} scene_option;

/* What the words are, for --help. */
#define SCENE_OPTION_HELP                                                                                  \
    "views=T0:T1[:P0:P1] and lights=... ranges of theta and phi in degrees (default everything),\n"        \
    "view=T:P and light=T:P one direction that never changes, pixels=X side of a texel on the screen,\n"   \
    "count=N lights a pixel, tolerance=DB below the full decode (default 0.5), interpolate: never\n"       \
    "nearest directions; commas between, \"all\" for all defaults"

/* A cli_option's `parse` into a scene_option. */
const char *scene_option_parse(const char *text, void *value);

/* The plan as lines of text, each after `indent`. */
void scene_plan_print(FILE *out, const char *indent, const btf_plan *plan);

#ifdef __cplusplus
}
#endif
#endif
