/* Parses a text in GLSL.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_WGSL_PARSE_H
#define OPENBTF_WGSL_PARSE_H

#include "tree.h"

#pragma GCC visibility push(hidden)

/* Parses structs, uniforms and functions; the last token is END. btfi_tree_free frees the tree, after an error as well.
 * Errors, with a message of `message_size` bytes at most: BTF_ERROR_UNSUPPORTED (not of the part of GLSL that the decoder
 * is written in), BTF_ERROR_MEMORY. */
btf_result btfi_parse(const btfi_tokens *tokens, btfi_tree *out_tree, char *message, size_t message_size);

void btfi_tree_free(btfi_tree *tree);

#pragma GCC visibility pop

#endif
