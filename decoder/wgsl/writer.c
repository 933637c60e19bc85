/* Writes expressions in WGSL.
 *
 * SPDX-License-Identifier: MIT
 */
#include "writer.h"

#include "names.h"
#include "types.h"

#include <stdio.h>
#include <string.h>

void btfi_write_fail(btfi_writer *w, const char *what, const btfi_token *at) {
    if (w->result == BTF_OK) {
        w->result = BTF_ERROR_UNSUPPORTED;
        snprintf(w->message, w->message_size, "%s at \"%.*s\"", what, (int)at->length, at->text);
    }
}

void btfi_write_indent(btfi_writer *w) {
    for (int i = 0; i < w->indent; ++i) {
        btfi_append(&w->out, "    ", 4);
    }
}

static void put(btfi_writer *w, const char *text) {
    btfi_append(&w->out, text, strlen(text));
}

static void put_type(btfi_writer *w, btfi_base base, unsigned size) {
    btfi_write_type(&w->out, w->tree, btfi_type_of(base, size));
}

int btfi_is_whole_variable(const btfi_tree *tree, uint32_t node) {
    return tree->nodes[node].kind == BTFI_NODE_VARIABLE;
}

/* 32-bit floats say so: a constant without a type is computed with 64. */
static void write_literal(btfi_writer *w, const btfi_node *n) {
    btfi_append(&w->out, n->token.text, n->token.length - (n->type.base == BTFI_UINT));
    put(w, n->type.base == BTFI_UINT ? "u" : n->type.base == BTFI_FLOAT ? "f" : "");
}

/* A parameter that is handed on by address, or read or written through it. */
static void write_variable(btfi_writer *w, const btfi_node *n) {
    const btfi_symbol *s = &w->tree->symbols[n->of];
    const int by_address = s->is_parameter && s->direction != BTFI_IN;
    put(w, by_address ? "(*" : "");
    btfi_write_name(&w->out, &s->name);
    put(w, by_address ? ")" : "");
}

/* How two operators stand in one another without brackets: WGSL has no order between bits, shifts and the rest. */
enum strength { LOGIC, COMPARISON, SUM, PRODUCT, BITS, SHIFT };

static enum strength strength_of(const btfi_token *mark) {
    if (btfi_compares(mark)) {
        return COMPARISON;
    }
    switch (mark->text[0]) {
    case '<':
    case '>':
        return SHIFT;
    case '+':
    case '-':
        return SUM;
    case '*':
    case '/':
    case '%':
        return PRODUCT;
    default:
        return mark->length == 2 ? LOGIC : BITS;
    }
}

static int needs_brackets(const btfi_node *of, const btfi_node *child, int is_right) {
    if (child->kind != BTFI_NODE_BINARY) {
        return 0;
    }
    if (of->kind != BTFI_NODE_BINARY) {
        return 1;
    }
    const enum strength outer = strength_of(&of->token), inner = strength_of(&child->token);
    if (inner >= BITS || outer >= BITS) {
        return !(outer == BITS && btfi_tokens_equal(&of->token, &child->token) && !is_right);
    }
    if (inner == outer && outer != COMPARISON) {
        return is_right || (outer == LOGIC && !btfi_tokens_equal(&of->token, &child->token));
    }
    return inner <= outer;
}

static void write_bracketed(btfi_writer *w, uint32_t node, int brackets) {
    put(w, brackets ? "(" : "");
    btfi_write_expression(w, node);
    put(w, brackets ? ")" : "");
}

/* An operand, or the argument of a function, that has to be as long as a vector: a scalar is repeated. */
static void write_as_long(btfi_writer *w, uint32_t node, unsigned size, int brackets) {
    const btfi_type type = w->tree->nodes[node].type;
    if (type.size < size) {
        put_type(w, (btfi_base)type.base, size);
        put(w, "(");
        btfi_write_argument(w, node);
        put(w, ")");
    } else {
        write_bracketed(w, node, brackets);
    }
}

/* How far to shift: a uint, for each component of what is shifted. */
static void write_shift_count(btfi_writer *w, uint32_t node, unsigned size) {
    const btfi_node *n = &w->tree->nodes[node];
    const int brackets = n->kind == BTFI_NODE_BINARY;
    if (n->type.size < size || n->type.base == BTFI_INT) {
        if (size > 1 || n->kind != BTFI_NODE_LITERAL) {
            put_type(w, BTFI_UINT, size);
            put(w, "(");
            if (n->type.size < size && n->type.base == BTFI_INT && n->kind != BTFI_NODE_LITERAL) {
                put(w, "u32(");
                btfi_write_argument(w, node);
                put(w, ")");
            } else {
                btfi_write_argument(w, node);
            }
            put(w, ")");
        } else {
            btfi_write_expression(w, node);
            put(w, "u");
        }
        return;
    }
    write_bracketed(w, node, brackets);
}

static void write_binary(btfi_writer *w, const btfi_node *n) {
    const btfi_node *nodes = w->tree->nodes;
    const enum strength s = strength_of(&n->token);
    const int left = needs_brackets(n, &nodes[n->a], 0), right = needs_brackets(n, &nodes[n->b], 1);
    if (s == BITS) {
        write_as_long(w, n->a, n->type.size, left);
    } else {
        write_bracketed(w, n->a, left);
    }
    btfi_print(&w->out, " %.*s ", (int)n->token.length, n->token.text);
    if (s == SHIFT) {
        write_shift_count(w, n->b, n->type.size);
    } else if (s == BITS) {
        write_as_long(w, n->b, n->type.size, right);
    } else {
        write_bracketed(w, n->b, right);
    }
}

void btfi_write_argument(btfi_writer *w, uint32_t node) {
    const btfi_node *n = &w->tree->nodes[node];
    write_bracketed(w, node, n->kind == BTFI_NODE_BINARY && strength_of(&n->token) <= COMPARISON);
}

/* An argument, converted where a part of a vector is of another base. */
static void write_part(btfi_writer *w, uint32_t node, btfi_base base) {
    const btfi_type type = w->tree->nodes[node].type;
    const int converts = type.base != base;
    if (converts) {
        put_type(w, base, type.size);
        put(w, "(");
    }
    btfi_write_argument(w, node);
    put(w, converts ? ")" : "");
}

static void write_construct(btfi_writer *w, const btfi_node *n) {
    const btfi_node *nodes = w->tree->nodes, *first = &nodes[n->a];
    btfi_write_type(&w->out, w->tree, n->type);
    put(w, "(");
    /* One argument as long as the whole is converted as it is; parts have to be of the same base. */
    const int whole = n->type.base == BTFI_STRUCT || (!first->next && first->type.size == n->type.size);
    for (uint32_t argument = n->a; argument; argument = nodes[argument].next) {
        if (whole) {
            btfi_write_argument(w, argument);
        } else {
            write_part(w, argument, (btfi_base)n->type.base);
        }
        put(w, nodes[argument].next ? ", " : "");
    }
    put(w, ")");
}

/* textureLoad takes columns and rows, then the layer of an array. */
static void write_fetch(btfi_writer *w, const btfi_node *n) {
    const btfi_node *nodes = w->tree->nodes;
    const uint32_t texture = n->a, at = nodes[texture].next, level = nodes[at].next;
    put(w, "textureLoad(");
    btfi_write_expression(w, texture);
    put(w, ", ");
    if (nodes[at].type.size == 2) {
        btfi_write_argument(w, at);
    } else if (nodes[at].kind == BTFI_NODE_CONSTRUCT && nodes[nodes[at].a].type.size == 2) {
        const uint32_t column = nodes[at].a;
        write_part(w, column, BTFI_INT);
        put(w, ", ");
        write_part(w, nodes[column].next, BTFI_INT);
    } else {
        const uint32_t column = nodes[at].a, row = nodes[column].next;
        if (nodes[at].kind != BTFI_NODE_CONSTRUCT || !row || !nodes[row].next) {
            btfi_write_fail(
                w, "texelFetch from an array does not name the layer as the last component of an ivec3(..)",
                &n->token);
            return;
        }
        put(w, "vec2i(");
        write_part(w, column, BTFI_INT);
        put(w, ", ");
        write_part(w, row, BTFI_INT);
        put(w, "), ");
        write_part(w, nodes[row].next, BTFI_INT);
    }
    put(w, ", ");
    btfi_write_argument(w, level);
    put(w, ")");
}

static void write_builtin(btfi_writer *w, const btfi_node *n) {
    const btfi_node *nodes = w->tree->nodes;
    if (btfi_token_is(&n->token, "texelFetch")) {
        write_fetch(w, n);
        return;
    }
    if (btfi_token_is(&n->token, "textureSize")) {
        put(w, "vec2i(textureDimensions(");
        btfi_write_argument(w, n->a);
        put(w, ", ");
        btfi_write_argument(w, nodes[n->a].next);
        put(w, "))");
        return;
    }
    if (btfi_keeps_bits(&n->token)) {
        put(w, "bitcast<");
        btfi_write_type(&w->out, w->tree, n->type);
        put(w, ">(");
    } else {
        btfi_append(&w->out, n->token.text, n->token.length);
        put(w, "(");
    }
    for (uint32_t argument = n->a; argument; argument = nodes[argument].next) {
        if (nodes[argument].type.size < nodes[n->a].type.size) {
            write_as_long(w, argument, nodes[n->a].type.size, 0);
        } else {
            btfi_write_argument(w, argument);
        }
        put(w, nodes[argument].next ? ", " : "");
    }
    put(w, ")");
}

static void write_call(btfi_writer *w, const btfi_node *n) {
    const btfi_node *nodes = w->tree->nodes;
    const btfi_function *f = &w->tree->functions[n->of];
    uint32_t parameter = f->first;
    btfi_write_function_name(&w->out, w->tree, f);
    put(w, "(");
    for (uint32_t argument = n->a; argument; argument = nodes[argument].next, ++parameter) {
        const int by_address = w->tree->symbols[parameter].direction != BTFI_IN;
        const btfi_symbol *s = by_address && btfi_is_whole_variable(w->tree, argument)
                                   ? &w->tree->symbols[nodes[argument].of]
                                   : NULL;
        if (nodes[argument].kept) {
            btfi_print(&w->out, "&kept__%u", nodes[argument].kept);
        } else if (s) {
            put(w, s->is_parameter && s->direction != BTFI_IN ? "" : "&");
            btfi_write_name(&w->out, &s->name);
        } else if (by_address) {
            btfi_write_fail(w, "a part of a variable cannot be handed to an out parameter here", &n->token);
        } else {
            btfi_write_argument(w, argument);
        }
        put(w, nodes[argument].next ? ", " : "");
    }
    put(w, ")");
}

void btfi_write_expression(btfi_writer *w, uint32_t node) {
    const btfi_node *n = &w->tree->nodes[node];
    if (w->result != BTF_OK) {
        return;
    }
    switch (n->kind) {
    case BTFI_NODE_LITERAL:
        write_literal(w, n);
        break;
    case BTFI_NODE_VARIABLE:
        write_variable(w, n);
        break;
    case BTFI_NODE_CALL:
        write_call(w, n);
        break;
    case BTFI_NODE_BUILTIN:
        write_builtin(w, n);
        break;
    case BTFI_NODE_CONSTRUCT:
        write_construct(w, n);
        break;
    case BTFI_NODE_MEMBER:
        write_bracketed(w, n->a, needs_brackets(n, &w->tree->nodes[n->a], 0));
        put(w, ".");
        btfi_write_name(&w->out, &n->token);
        break;
    case BTFI_NODE_SWIZZLE:
        write_bracketed(w, n->a,
                        needs_brackets(n, &w->tree->nodes[n->a], 0) ||
                            w->tree->nodes[n->a].kind == BTFI_NODE_UNARY);
        btfi_print(&w->out, ".%.*s", (int)n->token.length, n->token.text);
        break;
    case BTFI_NODE_INDEX:
        write_bracketed(w, n->a, needs_brackets(n, &w->tree->nodes[n->a], 0));
        put(w, "[");
        btfi_write_expression(w, n->b);
        put(w, "]");
        break;
    case BTFI_NODE_UNARY:
        btfi_append(&w->out, n->token.text, n->token.length);
        write_bracketed(w, n->a,
                        needs_brackets(n, &w->tree->nodes[n->a], 1) ||
                            w->tree->nodes[n->a].kind == BTFI_NODE_UNARY);
        break;
    case BTFI_NODE_STEP:
        btfi_write_expression(w, n->a);
        break;
    case BTFI_NODE_BINARY:
        write_binary(w, n);
        break;
    case BTFI_NODE_TERNARY: /* both sides are computed, which neither may notice */
        put(w, "select(");
        btfi_write_argument(w, n->c);
        put(w, ", ");
        btfi_write_argument(w, n->b);
        put(w, ", ");
        btfi_write_argument(w, n->a);
        put(w, ")");
        break;
    default:
        btfi_write_fail(w, "an assignment cannot stand within an expression", &n->token);
    }
}
