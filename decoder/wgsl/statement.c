/* Parses statements of GLSL.
 *
 * SPDX-License-Identifier: MIT
 */
#include "statement.h"

#include "expression.h"
#include "types.h"

/* A list of nodes by their `next`. */
typedef struct list {
    uint32_t first, last;
} list;

static void add(btfi_parser *p, list *l, uint32_t node) {
    if (p->result != BTF_OK || node == 0) {
        return;
    }
    if (l->first) {
        p->tree->nodes[l->last].next = node;
    } else {
        l->first = node;
    }
    l->last = node;
}

/* One name of a declaration, with its first value. */
static uint32_t parse_declarator(btfi_parser *p, btfi_type type, int is_const) {
    const btfi_token name = btfi_take(p);
    type = btfi_next_is(p, "[") ? btfi_parse_array(p, type) : type;
    const uint32_t symbol = btfi_new_symbol(p, name, type),
                   node = btfi_new_node(p, BTFI_NODE_DECLARE, name);
    uint32_t value = 0;
    if (btfi_accept(p, "=")) {
        value = btfi_parse_expression(p);
        if (!btfi_types_equal(p->tree->nodes[value].type, type)) {
            btfi_parse_fail_at(p, "the first value is of another type than its variable", &name);
        }
    }
    if (p->result != BTF_OK) {
        return 0;
    }
    btfi_symbol *s = &p->tree->symbols[symbol];
    s->is_written = value == 0;
    s->is_const = (uint8_t)is_const;
    s->has_number = (uint8_t)(is_const && value && btfi_constant(p->tree, value, &s->number));
    p->tree->nodes[node].of = symbol;
    p->tree->nodes[node].a = value;
    btfi_show(p, symbol);
    return node;
}

/* A declaration up to its semicolon when one comes next: a list of its names. */
static int parse_declaration(btfi_parser *p, list *l) {
    const int is_const = btfi_accept(p, "const");
    const btfi_token *first = btfi_peek(p);
    const int names_type = btfi_named_type(first).size > 0 || btfi_find_struct(p->tree, first) >= 0;
    if (!names_type || p->tokens[p->at + 1].kind != BTFI_TOKEN_NAME) {
        return 0;
    }
    const btfi_type type = btfi_parse_type(p);
    if (type.base == BTFI_VOID || type.base == BTFI_TEXTURE) {
        btfi_parse_fail(p, "a variable cannot be of type void or a sampler");
    }
    do {
        add(p, l, parse_declarator(p, type, is_const));
    } while (btfi_accept(p, ","));
    btfi_expect(p, ";");
    return 1;
}

static uint32_t parse_expression_statement(btfi_parser *p, const char *end) {
    const btfi_token token = *btfi_peek(p);
    const uint32_t value = btfi_parse_expression(p), node = btfi_new_node(p, BTFI_NODE_EXPRESSION, token);
    p->tree->nodes[node].a = value;
    if (end) {
        btfi_expect(p, end);
    }
    return node;
}

static void parse_statement(btfi_parser *p, list *l);

/* A statement as a block of its own. */
static uint32_t parse_body(btfi_parser *p) {
    list l = {0};
    const btfi_token token = *btfi_peek(p);
    if (btfi_next_is(p, "{")) {
        return btfi_parse_block(p);
    }
    const uint32_t visible = p->n_visible, node = btfi_new_node(p, BTFI_NODE_BLOCK, token);
    parse_statement(p, &l);
    p->n_visible = visible;
    p->tree->nodes[node].a = l.first;
    return node;
}

static uint32_t parse_condition(btfi_parser *p) {
    btfi_expect(p, "(");
    const uint32_t node = btfi_parse_expression(p);
    btfi_expect(p, ")");
    if (p->tree->nodes[node].type.base != BTFI_BOOL) {
        btfi_parse_fail(p, "the condition is not of type bool");
    }
    return node;
}

static uint32_t parse_if(btfi_parser *p, btfi_token token) {
    const uint32_t condition = parse_condition(p), yes = parse_body(p);
    const uint32_t no = btfi_accept(p, "else") ? parse_body(p) : 0,
                   node = btfi_new_node(p, BTFI_NODE_IF, token);
    btfi_node *n = &p->tree->nodes[node];
    n->a = condition;
    n->b = yes;
    n->c = no;
    return node;
}

static uint32_t parse_for(btfi_parser *p, btfi_token token) {
    list first = {0}, steps = {0};
    const uint32_t visible = p->n_visible;
    btfi_expect(p, "(");
    if (!parse_declaration(p, &first)) {
        add(p, &first, parse_expression_statement(p, ";"));
    }
    if (first.first != first.last) {
        btfi_parse_fail(p, "a loop can declare one variable alone");
    }
    const uint32_t condition = btfi_parse_expression(p);
    btfi_expect(p, ";");
    do {
        add(p, &steps, parse_expression_statement(p, NULL));
    } while (btfi_accept(p, ","));
    btfi_expect(p, ")");
    const uint32_t body = parse_body(p), node = btfi_new_node(p, BTFI_NODE_FOR, token);
    p->n_visible = visible;
    btfi_node *n = &p->tree->nodes[node];
    n->a = first.first;
    n->b = condition;
    n->c = steps.first;
    n->d = body;
    return node;
}

static uint32_t parse_loop(btfi_parser *p, btfi_token token, int at_end) {
    uint32_t condition = at_end ? 0 : parse_condition(p);
    const uint32_t body = parse_body(p);
    if (at_end) {
        btfi_expect(p, "while");
        condition = parse_condition(p);
        btfi_expect(p, ";");
    }
    const uint32_t node = btfi_new_node(p, at_end ? BTFI_NODE_DO : BTFI_NODE_WHILE, token);
    p->tree->nodes[node].a = condition;
    p->tree->nodes[node].d = body;
    return node;
}

static void parse_statement(btfi_parser *p, list *l) {
    const btfi_token token = *btfi_peek(p);
    if (!btfi_deeper(p)) {
        --p->depth;
        return;
    }
    if (btfi_next_is(p, "{")) {
        add(p, l, btfi_parse_block(p));
    } else if (btfi_accept(p, "if")) {
        add(p, l, parse_if(p, token));
    } else if (btfi_accept(p, "for")) {
        add(p, l, parse_for(p, token));
    } else if (btfi_accept(p, "while")) {
        add(p, l, parse_loop(p, token, 0));
    } else if (btfi_accept(p, "do")) {
        add(p, l, parse_loop(p, token, 1));
    } else if (btfi_accept(p, "break")) {
        add(p, l, btfi_new_node(p, BTFI_NODE_BREAK, token));
        btfi_expect(p, ";");
    } else if (btfi_accept(p, "continue")) {
        add(p, l, btfi_new_node(p, BTFI_NODE_CONTINUE, token));
        btfi_expect(p, ";");
    } else if (btfi_accept(p, "return")) {
        const uint32_t value = btfi_next_is(p, ";") ? 0 : btfi_parse_expression(p);
        const uint32_t node = btfi_new_node(p, BTFI_NODE_RETURN, token);
        p->tree->nodes[node].a = value;
        add(p, l, node);
        btfi_expect(p, ";");
    } else if (!btfi_accept(p, ";") && !parse_declaration(p, l)) {
        add(p, l, parse_expression_statement(p, ";"));
    }
    --p->depth;
}

uint32_t btfi_parse_block(btfi_parser *p) {
    list l = {0};
    const uint32_t visible = p->n_visible, node = btfi_new_node(p, BTFI_NODE_BLOCK, *btfi_peek(p));
    btfi_expect(p, "{");
    while (p->result == BTF_OK && !btfi_accept(p, "}")) {
        if (btfi_peek(p)->kind == BTFI_TOKEN_END) {
            btfi_parse_fail(p, "the block has no closing brace");
        }
        parse_statement(p, &l);
    }
    p->n_visible = visible;
    p->tree->nodes[node].a = l.first;
    return node;
}
