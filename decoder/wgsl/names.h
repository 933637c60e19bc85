/* Names and types as WGSL writes them.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_WGSL_NAMES_H
#define OPENBTF_WGSL_NAMES_H

#include "growing.h"
#include "tree.h"

#pragma GCC visibility push(hidden)

/* A name of the text: with _ behind it where WGSL means something else by it. */
void btfi_write_name(btfi_growing *out, const btfi_token *name);

/* The name of a function: with its parameters behind it where several have this name, for WGSL has no overloading. */
void btfi_write_function_name(btfi_growing *out, const btfi_tree *tree, const btfi_function *f);

/* A type. */
void btfi_write_type(btfi_growing *out, const btfi_tree *tree, btfi_type type);

#pragma GCC visibility pop

#endif
