/* Writes statements in WGSL.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_WGSL_WRITE_STATEMENT_H
#define OPENBTF_WGSL_WRITE_STATEMENT_H

#include "writer.h"

#pragma GCC visibility push(hidden)

/* The statements of a block, a line each, without its braces. */
void btfi_write_statements(btfi_writer *w, uint32_t block);

#pragma GCC visibility pop

#endif
