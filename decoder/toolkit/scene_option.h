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

/* The words that the option takes, for --help. */
#define SCENE_OPTION_HELP                                                                                  \
    "views=T0:T1[:P0:P1] and lights=..., ranges of theta and phi in degrees\n"                             \
    "(default all); view=T:P and light=T:P, one direction that never changes;\n"                           \
    "pixels=X, the side of a texel on the screen; count=N lights a pixel, still:\n"                        \
    "that never change and are the same in every pixel;\n"                                                 \
    "tolerance=DB below the full decode (default 0.5); interpolate, never take\n"                          \
    "the nearest direction alone. Commas between them; \"all\": the defaults"

/* Help of --costs. */
#define COSTS_OPTION_HELP                                                                                  \
    "with --plan: the prices of a GPU (JSON, openbtf/cost.h), as tests/bench/gpu.sh\n"                     \
    "measures them; default those of llvmpipe, which are built in"

/* The `parse` of a cli_option whose value is a scene_option. */
const char *scene_option_parse(const char *text, void *value);

/* The plan of a material as lines of text, each after `indent`, with scene_plan_reason for each effect. */
void scene_plan_print(FILE *out, const char *indent, const btf_material *material, const btf_plan *plan);

/* The residual that the plan decodes: "16 components", or "7 units" where its store is factors. */
const char *scene_plan_amount(const btf_plan *plan, char *text, size_t size);

/* Why the plan decodes effect number `index` (0: shadow .. 6: gloss) or does not, by what the file's table predicts:
 * "on, without it -3.2/-2.9 dB", "off, with it +0.1/+0.0 dB"; for relief and gloss "on, worth +0.4/+0.3 dB between the
 * samples"; "not in the file". */
const char *scene_plan_reason(const btf_material *material, const btf_plan *plan, int index, char *text,
                              size_t size);

#ifdef __cplusplus
}
#endif
#endif
