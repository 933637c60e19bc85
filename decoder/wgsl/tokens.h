/* The words of a text in GLSL.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_WGSL_TOKENS_H
#define OPENBTF_WGSL_TOKENS_H

#include <stddef.h>
#include <stdint.h>

#pragma GCC visibility push(hidden)

typedef enum btfi_token_kind {
    BTFI_TOKEN_END,  /* behind the last */
    BTFI_TOKEN_NAME, /* and keywords */
    BTFI_TOKEN_INT,
    BTFI_TOKEN_UINT,
    BTFI_TOKEN_FLOAT,
    BTFI_TOKEN_MARK,      /* an operator, a bracket, a comma and so on */
    BTFI_TOKEN_DIRECTIVE, /* the # that opens a line of the preprocessor */
} btfi_token_kind;

/* Text is the caller's, and not 0-terminated. */
typedef struct btfi_token {
    btfi_token_kind kind;
    uint32_t length, comment_length;
    const char *text;
    const char *comment; /* the one in front of the token; NULL: none */
} btfi_token;

/* A list that grows. All zeros is an empty one; `failed` stays set once memory runs out. */
typedef struct btfi_tokens {
    btfi_token *list;
    size_t count, capacity;
    int failed;
} btfi_tokens;

void btfi_tokens_add(btfi_tokens *t, btfi_token token);

void btfi_tokens_free(btfi_tokens *t);

/* The place in a text that is read next. */
typedef struct btfi_reader {
    const char *at;
    int begins_line; /* 1 at the beginning of the text and of each line */
} btfi_reader;

/* The next token. With `within_line`, END at the end of the line, which stays to be read. A character that no token
 * begins with is a MARK of its own. */
btfi_token btfi_read_token(btfi_reader *r, int within_line);

/* Whether a token is this text. */
int btfi_token_is(const btfi_token *token, const char *text);

/* Whether two tokens are the same text. */
int btfi_tokens_equal(const btfi_token *a, const btfi_token *b);

#pragma GCC visibility pop

#endif
