/* A text in GLSL as a tree, whose expressions have types.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_WGSL_TREE_H
#define OPENBTF_WGSL_TREE_H

#include "tokens.h"

#include <openbtf/result.h>

#pragma GCC visibility push(hidden)

typedef enum btfi_base {
    BTFI_VOID,
    BTFI_BOOL,
    BTFI_INT,
    BTFI_UINT,
    BTFI_FLOAT,
    BTFI_STRUCT,
    BTFI_TEXTURE,
} btfi_base;

typedef struct btfi_type {
    uint8_t base;   /* btfi_base */
    uint8_t size;   /* components of a vector, 1 of a scalar; coordinates of a texture, 3 with layers */
    uint16_t of;    /* which struct; the btfi_base of a texture's values */
    uint32_t count; /* elements of an array, 0: none */
} btfi_type;

typedef enum btfi_direction { BTFI_IN, BTFI_OUT, BTFI_INOUT } btfi_direction;

/* A variable, a parameter, a member of a struct or a uniform. */
typedef struct btfi_symbol {
    btfi_token name;
    btfi_type type;
    uint8_t direction; /* btfi_direction, of a parameter */
    uint8_t is_parameter, is_uniform, is_const;
    /* assigned, counted up, handed to an out parameter, or declared without a first value */
    uint8_t is_written;
    uint8_t is_indexed; /* an array in it has an index that is no constant */
    uint8_t has_number; /* a const whose first value is a constant integer: */
    int64_t number;
    uint32_t group, binding;
} btfi_symbol;

typedef enum btfi_node_kind {
    BTFI_NODE_NONE,
    /* Expressions. */
    BTFI_NODE_LITERAL,
    BTFI_NODE_VARIABLE,
    BTFI_NODE_CALL,      /* of a function of the text: `of`, arguments a */
    BTFI_NODE_BUILTIN,   /* of one of the language: `token`, arguments a */
    BTFI_NODE_CONSTRUCT, /* of `type`, arguments a */
    BTFI_NODE_MEMBER,    /* of a: symbol `of` */
    BTFI_NODE_SWIZZLE,   /* of a: `token` */
    BTFI_NODE_INDEX,     /* a[b] */
    BTFI_NODE_UNARY,     /* `token` a */
    BTFI_NODE_STEP,      /* ++a or --a; `token` */
    BTFI_NODE_BINARY,    /* a `token` b */
    BTFI_NODE_TERNARY,   /* a ? b : c */
    BTFI_NODE_ASSIGN,    /* a `token` b */
    /* Statements. */
    BTFI_NODE_BLOCK,      /* a and what follows it */
    BTFI_NODE_DECLARE,    /* symbol `of`, first value a or none */
    BTFI_NODE_EXPRESSION, /* a */
    BTFI_NODE_IF,         /* a, then b, else c or none */
    BTFI_NODE_FOR,        /* for (a; b; c and what follows it) d */
    BTFI_NODE_WHILE,      /* a, body d */
    BTFI_NODE_DO,         /* body d, while a */
    BTFI_NODE_RETURN,     /* a or none */
    BTFI_NODE_BREAK,
    BTFI_NODE_CONTINUE,
} btfi_node_kind;

/* Children are numbers of nodes; 0 is no node. */
typedef struct btfi_node {
    btfi_node_kind kind;
    btfi_type type;
    btfi_token token;
    uint32_t of, a, b, c, d;
    uint32_t next;   /* in a list of arguments or statements */
    uint32_t height; /* of an expression: how many are in one another; the stack must bear them */
    uint32_t kept; /* used while writing: the number of the variable that stands for an argument, 0: none */
} btfi_node;

typedef struct btfi_struct {
    btfi_token name;       /* with the comment in front of the struct */
    uint32_t first, count; /* symbols */
} btfi_struct;

typedef struct btfi_function {
    btfi_token name; /* with the comment in front of the function */
    btfi_type type;
    uint32_t first, count; /* parameters: symbols */
    uint32_t body;
    int is_overloaded;
} btfi_function;

/* All lists are as long as the number of tokens allows: a node, symbol, struct or function takes a token at least. */
typedef struct btfi_tree {
    btfi_node *nodes; /* nodes[0] is of kind NONE */
    btfi_symbol *symbols;
    btfi_struct *structs;
    btfi_function *functions;
    uint32_t n_nodes, n_symbols, n_structs, n_functions;
    uint32_t most; /* of each */
} btfi_tree;

#pragma GCC visibility pop

#endif
