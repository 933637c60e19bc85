/* The JSON that btf-info prints for programs.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TOOLS_INFO_JSON_H
#define OPENBTF_TOOLS_INFO_JSON_H

#include "decoder/toolkit/cli.h"
#include "decoder/toolkit/json.h"
#include <openbtf/material.h>

/* Prints all of a material on stdout; file_bytes: the size of its file, 0 where it is not known. Errors, with a
 * message of the program: BTF_ERROR_MEMORY. */
btf_result print_json(const cli_program *program, const char *path, uint64_t file_bytes,
                      const btf_material *material, const btf_material_info *info);

/* Writes the object to stdout and frees it. Errors: BTF_ERROR_MEMORY. */
btf_result put_json(const cli_program *program, json *j);

/* A list of the names of effects. */
void json_effect_list(json *j, const char *key, uint32_t effects);

#endif
