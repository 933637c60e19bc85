/* The state and the steps that the parsers of declarations, statements and expressions share.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_WGSL_PARSER_H
#define OPENBTF_WGSL_PARSER_H

#include "tree.h"

#pragma GCC visibility push(hidden)

/* Once something failed, the parser stands at the last token, END, and every call returns without doing anything. */
typedef struct btfi_parser {
    const btfi_token *tokens;
    size_t at, count; /* tokens[count - 1] is END */
    btfi_tree *tree;
    uint32_t *visible; /* symbols, the innermost last */
    uint32_t n_visible;
    uint32_t depth; /* of brackets and statements in one another */
    btf_result result;
    char *message;
    size_t message_size;
} btfi_parser;

/* Ends parsing with a message, to which the next token is added as the place. */
void btfi_parse_fail(btfi_parser *p, const char *what);

/* The same with a token that was taken before as the place. */
void btfi_parse_fail_at(btfi_parser *p, const char *what, const btfi_token *at);

/* Fails on a name that GLSL or WGSL reserves: `_`, and names with __, which the writer gives to names that it
 * makes. Every name that the text declares is checked. */
void btfi_check_name(btfi_parser *p, const btfi_token *name);

/* The next token, and whether it is this text. */
const btfi_token *btfi_peek(const btfi_parser *p);
int btfi_next_is(const btfi_parser *p, const char *text);

/* Takes the next token. */
btfi_token btfi_take(btfi_parser *p);

/* Takes the next token when it is this text, and says whether it was. */
int btfi_accept(btfi_parser *p, const char *text);

/* Takes the next token, and fails when it is not this text. */
void btfi_expect(btfi_parser *p, const char *text);

/* Goes one level deeper; fails, and returns 0, where that is too deep. In both cases the caller goes up by
 * --depth. */
int btfi_deeper(btfi_parser *p);

/* A new node; 0 after a failure. */
uint32_t btfi_new_node(btfi_parser *p, btfi_node_kind kind, btfi_token token);

/* A new symbol, not yet visible; 0 after a failure, and for the first. */
uint32_t btfi_new_symbol(btfi_parser *p, btfi_token name, btfi_type type);

/* Makes a symbol visible from here on. */
void btfi_show(btfi_parser *p, uint32_t symbol);

/* The struct of this name; -1: none. */
int32_t btfi_find_struct(const btfi_tree *tree, const btfi_token *name);

#pragma GCC visibility pop

#endif
