/* Names and types as WGSL writes them.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_WGSL_NAMES_H
#define OPENBTF_WGSL_NAMES_H

#include "growing.h"
#include "tree.h"

#pragma GCC visibility push(hidden)

/* A name of the text: with __ behind it where WGSL means something else by it. GLSL keeps names with two underscores for
 * itself, and the parser refuses them: no name that is made with them meets one of the text. */
void btfi_write_name(btfi_growing *out, const btfi_token *name);

/* The name of a function: with its parameters behind it where several have this name, for WGSL has no overloading. */
void btfi_write_function_name(btfi_growing *out, const btfi_tree *tree, const btfi_function *f);

/* Finds an overloaded function whose name would be that of something else of the text, or of another function, or have two
 * underscores one behind the other; *out_function is NULL where there is none. Returns 0 when memory is out. */
int btfi_find_clash(const btfi_tree *tree, const btfi_function **out_function);

/* A type. */
void btfi_write_type(btfi_growing *out, const btfi_tree *tree, btfi_type type);

#pragma GCC visibility pop

#endif
