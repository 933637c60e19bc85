/* Writes expressions in WGSL.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_WGSL_WRITER_H
#define OPENBTF_WGSL_WRITER_H

#include "growing.h"
#include "tree.h"

#pragma GCC visibility push(hidden)

typedef struct btfi_writer {
    btfi_growing out;
    btfi_tree *tree;
    uint32_t kept; /* variables made for arguments so far, in a function */
    int indent;
    btf_result result;
    char *message;
    size_t message_size;
} btfi_writer;

/* Ends writing with a message, to which token `at` is added as the place: the text written so far is of no use. */
void btfi_write_fail(btfi_writer *w, const char *what, const btfi_token *at);

/* Begins a line. */
void btfi_write_indent(btfi_writer *w);

/* An expression without side effects but those of the functions that it calls. ++ and what was handed to an out parameter
 * have been taken care of: a STEP stands for its variable, an argument with `kept` for the variable of that number. */
void btfi_write_expression(btfi_writer *w, uint32_t node);

/* Writes an argument, a comparison in brackets: WGSL could take its < and the > of the next argument for those of a
 * type. */
void btfi_write_argument(btfi_writer *w, uint32_t node);

/* Whether an out argument is a variable, whose address WGSL takes as it is. */
int btfi_is_whole_variable(const btfi_tree *tree, uint32_t node);

#pragma GCC visibility pop

#endif
