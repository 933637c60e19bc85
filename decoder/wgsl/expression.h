/* Parses expressions of GLSL, and types, and finds the types of expressions.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_WGSL_EXPRESSION_H
#define OPENBTF_WGSL_EXPRESSION_H

#include "parser.h"

#pragma GCC visibility push(hidden)

/* An expression without commas, assignments among them; 0 after a failure. */
uint32_t btfi_parse_expression(btfi_parser *p);

/* Takes the name of a type when one comes next, structs among them, and [COUNT] behind it; size 0 where none comes. */
btfi_type btfi_parse_type(btfi_parser *p);

/* Takes [COUNT] when that comes next, and returns the type of an array of such elements; else `element`. */
btfi_type btfi_parse_array(btfi_parser *p, btfi_type element);

/* Whether an expression is a constant integer, and its value. */
int btfi_constant(const btfi_tree *tree, uint32_t node, int64_t *out_value);

#pragma GCC visibility pop

#endif
