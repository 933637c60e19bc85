/* The plan of a scene that btf-info prints.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TOOLS_INFO_PLAN_H
#define OPENBTF_TOOLS_INFO_PLAN_H

#include "decoder/toolkit/cli.h"
#include "decoder/toolkit/scene_option.h"
#include <openbtf/material.h>
#include <stdbool.h>

/* Plans a scene for a material and prints the plan on stdout, as text or as JSON. Errors, with a message of the
 * program: those of btf_plan_effects, BTF_ERROR_MEMORY. */
btf_result print_plan(const cli_program *program, const char *path, const btf_material *material,
                      const scene_option *scene, bool as_json);

#endif
