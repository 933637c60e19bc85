/* Parses expressions of GLSL and finds their types.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_WGSL_EXPRESSION_H
#define OPENBTF_WGSL_EXPRESSION_H

#include "parser.h"

/* An expression without commas, assignments among them; 0 after a failure. */
uint32_t btfi_parse_expression(btfi_parser *p);

/* Whether an expression is a constant integer, and its value. */
int btfi_constant(const btfi_tree *tree, uint32_t node, int64_t *out_value);

#endif
