/* Parses statements of GLSL.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_WGSL_STATEMENT_H
#define OPENBTF_WGSL_STATEMENT_H

#include "parser.h"

#pragma GCC visibility push(hidden)

/* A block from its opening brace on; what it declares is visible in it alone. */
uint32_t btfi_parse_block(btfi_parser *p);

#pragma GCC visibility pop

#endif
