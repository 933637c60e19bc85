/* The text that btf-info prints for people.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TOOLS_INFO_TEXT_H
#define OPENBTF_TOOLS_INFO_TEXT_H

#include <openbtf/material.h>

/* Prints all of a material on stdout; file_bytes: the size of its file, 0 where it is not known. */
void print_text(const char *path, uint64_t file_bytes, const btf_material *material,
                const btf_material_info *info);

#endif
