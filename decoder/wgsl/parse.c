/* Parses a text in GLSL.
 *
 * SPDX-License-Identifier: MIT
 */
#include "parse.h"

#include "expression.h"
#include "statement.h"
#include "types.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void skip_precision(btfi_parser *p) {
    while (btfi_accept(p, "highp") || btfi_accept(p, "mediump") || btfi_accept(p, "lowp")) {
    }
}

static void parse_struct(btfi_parser *p, const btfi_token *first) {
    btfi_tree *tree = p->tree;
    btfi_struct s = {.name = btfi_take(p), .first = tree->n_symbols};
    s.name.comment = first->comment;
    s.name.comment_length = first->comment_length;
    if (s.name.kind != BTFI_TOKEN_NAME) {
        btfi_parse_fail_at(p, "the struct has no name", &s.name);
    }
    btfi_check_name(p, &s.name);
    btfi_expect(p, "{");
    while (p->result == BTF_OK && !btfi_accept(p, "}")) {
        const btfi_type type = btfi_parse_type(p);
        do {
            const btfi_token member = btfi_take(p);
            btfi_new_symbol(p, member, btfi_parse_array(p, type));
        } while (btfi_accept(p, ","));
        btfi_expect(p, ";");
        if (type.size == 0) {
            btfi_parse_fail(p, "the member of the struct has no known type");
        }
    }
    btfi_expect(p, ";");
    s.count = tree->n_symbols - s.first;
    if (p->result == BTF_OK && tree->n_structs < UINT16_MAX) {
        tree->structs[tree->n_structs++] = s; /* shorter than the list of tokens */
    }
}

static uint32_t parse_number(btfi_parser *p) {
    int64_t value = 0;
    if (!btfi_constant(p->tree, btfi_parse_expression(p), &value) || value < 0 || value > UINT32_MAX) {
        btfi_parse_fail(p, "a set or binding must be a whole number");
    }
    return (uint32_t)value;
}

/* Behind the words layout(set = .., binding = ..), of which the latter is needed, and `uniform`. */
static void parse_uniform(btfi_parser *p, uint32_t group, int64_t binding) {
    skip_precision(p);
    const btfi_type type = btfi_parse_type(p);
    if (type.size == 0) {
        btfi_parse_fail(p, "the uniform has no known type");
    }
    const btfi_token name = btfi_take(p);
    const uint32_t symbol = btfi_new_symbol(p, name, type);
    btfi_expect(p, ";");
    if (binding < 0) {
        btfi_parse_fail_at(p, "the uniform has no binding", &name);
    }
    if (p->result == BTF_OK) {
        btfi_symbol *s = &p->tree->symbols[symbol];
        s->is_uniform = 1;
        s->group = group;
        s->binding = (uint32_t)binding;
        btfi_show(p, symbol);
    }
}

static void parse_layout(btfi_parser *p, uint32_t *group, int64_t *binding) {
    btfi_expect(p, "(");
    do {
        const btfi_token name = btfi_take(p);
        btfi_expect(p, "=");
        if (btfi_token_is(&name, "set")) {
            *group = parse_number(p);
        } else if (btfi_token_is(&name, "binding")) {
            *binding = parse_number(p);
        } else {
            btfi_parse_fail(p, "layout takes set and binding alone");
        }
    } while (btfi_accept(p, ","));
    btfi_expect(p, ")");
}

static void parse_parameter(btfi_parser *p) {
    const btfi_direction direction = btfi_accept(p, "inout") ? BTFI_INOUT
                                     : btfi_accept(p, "out") ? BTFI_OUT
                                                             : BTFI_IN;
    btfi_accept(p, "in");
    btfi_accept(p, "const");
    skip_precision(p);
    btfi_type type = btfi_parse_type(p);
    if (type.size == 0 || type.base == BTFI_VOID) {
        btfi_parse_fail(p, "the parameter has no known type");
    }
    const btfi_token name = btfi_take(p);
    type = btfi_next_is(p, "[") ? btfi_parse_array(p, type) : type;
    const uint32_t symbol = btfi_new_symbol(p, name, type);
    if (p->result == BTF_OK) {
        p->tree->symbols[symbol].is_parameter = 1;
        p->tree->symbols[symbol].direction = (uint8_t)direction;
        btfi_show(p, symbol);
    }
}

static void parse_function(btfi_parser *p, const btfi_token *first) {
    btfi_tree *tree = p->tree;
    btfi_function f = {.type = btfi_parse_type(p)};
    const uint32_t visible = p->n_visible;
    f.name = btfi_take(p);
    f.name.comment = first->comment;
    f.name.comment_length = first->comment_length;
    f.first = tree->n_symbols;
    if (f.name.kind != BTFI_TOKEN_NAME) {
        btfi_parse_fail_at(p, "the function has no name", &f.name);
    }
    btfi_check_name(p, &f.name);
    btfi_expect(p, "(");
    if (!btfi_next_is(p, ")")) {
        do {
            parse_parameter(p);
        } while (btfi_accept(p, ","));
    }
    btfi_expect(p, ")");
    f.count = tree->n_symbols - f.first;
    for (uint32_t i = 0; i < tree->n_functions; ++i) {
        if (btfi_tokens_equal(&tree->functions[i].name, &f.name)) {
            f.is_overloaded = tree->functions[i].is_overloaded = 1;
        }
    }
    f.body = btfi_parse_block(p);
    p->n_visible = visible;
    if (p->result == BTF_OK) {
        tree->functions[tree->n_functions++] = f; /* shorter than the list of tokens */
    }
}

static void parse_global(btfi_parser *p) {
    const btfi_token *first = btfi_peek(p);
    uint32_t group = 0;
    int64_t binding = -1;
    if (btfi_accept(p, ";")) {
        return;
    }
    if (btfi_accept(p, "precision")) {
        skip_precision(p);
        btfi_parse_type(p);
        btfi_expect(p, ";");
        return;
    }
    if (btfi_accept(p, "struct")) {
        parse_struct(p, first);
        return;
    }
    if (btfi_accept(p, "layout")) {
        parse_layout(p, &group, &binding);
    }
    if (btfi_accept(p, "uniform")) {
        parse_uniform(p, group, binding);
        return;
    }
    if (btfi_named_type(btfi_peek(p)).size == 0 && btfi_find_struct(p->tree, btfi_peek(p)) < 0) {
        btfi_parse_fail(p, "a struct, a uniform or a function is expected");
        return;
    }
    parse_function(p, first);
}

btf_result btfi_parse(const btfi_tokens *tokens, btfi_tree *out_tree, char *message, size_t message_size) {
    btfi_parser p = {.tokens = tokens->list,
                     .count = tokens->count,
                     .tree = out_tree,
                     .message = message,
                     .message_size = message_size};
    btfi_tree *t = out_tree;
    memset(t, 0, sizeof *t);
    t->most = (uint32_t)tokens->count + 2;
    t->nodes = calloc(t->most, sizeof *t->nodes);
    t->symbols = calloc(t->most, sizeof *t->symbols);
    t->structs = calloc(t->most, sizeof *t->structs);
    t->functions = calloc(t->most, sizeof *t->functions);
    p.visible = calloc(t->most, sizeof *p.visible);
    if (!t->nodes || !t->symbols || !t->structs || !t->functions || !p.visible) {
        snprintf(message, message_size, "out of memory");
        p.result = BTF_ERROR_MEMORY;
    } else {
        t->n_nodes = 1;
        while (p.result == BTF_OK && btfi_peek(&p)->kind != BTFI_TOKEN_END) {
            parse_global(&p);
        }
    }
    free(p.visible);
    return p.result;
}

void btfi_tree_free(btfi_tree *tree) {
    free(tree->nodes);
    free(tree->symbols);
    free(tree->structs);
    free(tree->functions);
    memset(tree, 0, sizeof *tree);
}
