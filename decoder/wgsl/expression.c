/* Parses expressions of GLSL, and types, and finds the types of expressions.
 *
 * SPDX-License-Identifier: MIT
 */
#include "expression.h"

#include "types.h"

#include <stdlib.h>
#include <string.h>

enum { MOST_ARGUMENTS = 16, HIGHEST = 1000 };

int btfi_constant(const btfi_tree *tree, uint32_t node, int64_t *out_value) {
    const btfi_node *n = &tree->nodes[node];
    int64_t a = 0, b = 0;
    switch (n->kind) {
    case BTFI_NODE_LITERAL:
        *out_value = strtoll(n->token.text, NULL, 0);
        return n->type.base == BTFI_INT || n->type.base == BTFI_UINT;
    case BTFI_NODE_VARIABLE:
        *out_value = tree->symbols[n->of].number;
        return tree->symbols[n->of].has_number;
    case BTFI_NODE_UNARY:
        if (!btfi_token_is(&n->token, "-") || !btfi_constant(tree, n->a, &a)) {
            return 0;
        }
        return btfi_arithmetic('-', 0, a, out_value);
    case BTFI_NODE_BINARY:
        if (n->token.length > 1 || !btfi_constant(tree, n->a, &a) || !btfi_constant(tree, n->b, &b)) {
            return 0;
        }
        return btfi_arithmetic(n->token.text[0], a, b, out_value);
    default:
        return 0;
    }
}

btfi_type btfi_parse_array(btfi_parser *p, btfi_type element) {
    int64_t count = 0;
    if (!btfi_accept(p, "[")) {
        return element;
    }
    if (element.count) {
        btfi_parse_fail(p, "arrays of arrays are not translated");
    }
    if (!btfi_constant(p->tree, btfi_parse_expression(p), &count) || count < 1 || count > 4096) {
        btfi_parse_fail(p, "the length of an array must be a constant integer from 1 to 4096");
    }
    btfi_expect(p, "]");
    element.count = (uint32_t)count;
    return element;
}

btfi_type btfi_parse_type(btfi_parser *p) {
    const btfi_token *name = btfi_peek(p);
    btfi_type type = btfi_named_type(name);
    const int32_t structure = type.size ? -1 : btfi_find_struct(p->tree, name);
    if (structure >= 0) {
        type = btfi_type_of(BTFI_STRUCT, 1);
        type.of = (uint16_t)structure;
    }
    if (type.size) {
        btfi_take(p);
        type = btfi_parse_array(p, type);
    }
    return type;
}

/* A node whose type was not found fails. */
static uint32_t typed(btfi_parser *p, uint32_t node, btfi_type type) {
    if (type.size == 0) {
        btfi_parse_fail_at(p, "the translator does not know this operation on these types",
                           &p->tree->nodes[node].token);
        return 0;
    }
    btfi_node *nodes = p->tree->nodes;
    nodes[node].type = type;
    if (p->result != BTF_OK) {
        return 0;
    }
    uint32_t height = nodes[nodes[node].b].height;
    height = nodes[nodes[node].c].height > height ? nodes[nodes[node].c].height : height;
    for (uint32_t part = nodes[node].a; part; part = nodes[part].next) {
        height = nodes[part].height > height ? nodes[part].height : height;
    }
    nodes[node].height = height + 1;
    if (height >= HIGHEST) {
        btfi_parse_fail(p, "the expression has too many parts");
    }
    return node;
}

/* The variable at the root of what is assigned or read through members and indices; NULL: none. */
static btfi_symbol *root(btfi_tree *tree, uint32_t node) {
    for (;;) {
        const btfi_node *n = &tree->nodes[node];
        if (n->kind == BTFI_NODE_VARIABLE) {
            return &tree->symbols[n->of];
        }
        if (n->kind != BTFI_NODE_MEMBER && n->kind != BTFI_NODE_SWIZZLE && n->kind != BTFI_NODE_INDEX) {
            return NULL;
        }
        node = n->a;
    }
}

static void mark_written(btfi_parser *p, uint32_t node) {
    const btfi_node *n = &p->tree->nodes[node];
    if ((n->kind == BTFI_NODE_SWIZZLE || n->kind == BTFI_NODE_INDEX) &&
        p->tree->nodes[n->a].kind == BTFI_NODE_SWIZZLE) {
        btfi_parse_fail(p, "components of components cannot be assigned");
    }
    btfi_symbol *s = root(p->tree, node);
    if (!s || s->is_const || s->is_uniform) {
        btfi_parse_fail_at(p, "only a variable can be assigned", &n->token);
        return;
    }
    s->is_written = 1;
}

/* Arguments up to the closing bracket, as a list; their types and number. */
static uint32_t parse_arguments(btfi_parser *p, btfi_type types[MOST_ARGUMENTS], size_t *count) {
    uint32_t first = 0, last = 0;
    *count = 0;
    btfi_expect(p, "(");
    btfi_deeper(p);
    while (p->result == BTF_OK && !btfi_next_is(p, ")")) {
        const uint32_t node = btfi_parse_expression(p);
        if (*count == MOST_ARGUMENTS) {
            btfi_parse_fail(p, "the call has too many arguments");
            break;
        }
        types[(*count)++] = p->tree->nodes[node].type;
        if (first) {
            p->tree->nodes[last].next = node;
        } else {
            first = node;
        }
        last = node;
        if (!btfi_accept(p, ",")) {
            break;
        }
    }
    --p->depth;
    btfi_expect(p, ")");
    return first;
}

/* The function of these parameters; -1: none. */
static int32_t find_function(const btfi_tree *tree, const btfi_token *name, const btfi_type *types,
                             size_t count) {
    for (uint32_t f = 0; f < tree->n_functions; ++f) {
        const btfi_function *of = &tree->functions[f];
        int fits = of->count == count && btfi_tokens_equal(&of->name, name);
        for (uint32_t i = 0; fits && i < count; ++i) {
            fits = btfi_types_equal(tree->symbols[of->first + i].type, types[i]);
        }
        if (fits) {
            return (int32_t)f;
        }
    }
    return -1;
}

static uint32_t parse_call(btfi_parser *p, btfi_token name) {
    btfi_type types[MOST_ARGUMENTS];
    size_t count;
    const uint32_t first = parse_arguments(p, types, &count);
    btfi_tree *tree = p->tree;
    const int32_t f = find_function(tree, &name, types, count);
    if (f < 0 && btfi_is_builtin(&name)) {
        const uint32_t node = btfi_new_node(p, BTFI_NODE_BUILTIN, name);
        tree->nodes[node].a = first;
        return typed(p, node, btfi_builtin_type(&name, types, count));
    }
    if (f < 0) {
        btfi_parse_fail_at(p, "no function that is defined above has this name and these parameters",
                           &name);
        return 0;
    }
    const uint32_t node = btfi_new_node(p, BTFI_NODE_CALL, name);
    uint32_t argument = first;
    for (uint32_t i = 0; i < count && p->result == BTF_OK; ++i, argument = tree->nodes[argument].next) {
        if (tree->symbols[tree->functions[f].first + i].direction != BTFI_IN) {
            mark_written(p, argument);
        }
    }
    tree->nodes[node].a = first;
    tree->nodes[node].of = (uint32_t)f;
    return typed(p, node, tree->functions[f].type);
}

static uint32_t parse_construct(btfi_parser *p, btfi_token name, btfi_type type) {
    btfi_type types[MOST_ARGUMENTS];
    size_t count, components = 0;
    const uint32_t first = parse_arguments(p, types, &count);
    const uint32_t node = btfi_new_node(p, BTFI_NODE_CONSTRUCT, name);
    p->tree->nodes[node].a = first;
    if (type.base == BTFI_STRUCT) {
        const btfi_struct *s = &p->tree->structs[type.of];
        int fits = s->count == count;
        for (uint32_t i = 0; fits && i < count; ++i) {
            fits = btfi_types_equal(p->tree->symbols[s->first + i].type, types[i]);
        }
        return typed(p, node, fits ? type : (btfi_type){0});
    }
    for (size_t i = 0; i < count; ++i) {
        components += types[i].size;
        if (!btfi_is_plain(types[i])) {
            return typed(p, node, (btfi_type){0});
        }
    }
    /* One scalar fills a vector; else every component is given. */
    const int fills = count == 1 && types[0].size == 1;
    return typed(p, node,
                 btfi_is_plain(type) && (fills || components == type.size) ? type : (btfi_type){0});
}

/* Whether a number is written as GLSL and WGSL both read it. */
static int is_whole(const btfi_token *t) {
    const char *end = t->text + t->length - (t->kind == BTFI_TOKEN_UINT);
    const size_t length = (size_t)(end - t->text);
    if (t->kind != BTFI_TOKEN_FLOAT) { /* 0x without digits; octal, which WGSL does not have */
        return t->text[0] != '0' || length == 1 || ((t->text[1] == 'x' || t->text[1] == 'X') && length > 2);
    }
    int points = 0;
    for (const char *c = t->text; c < end; ++c) {
        points += *c == '.';
    }
    return points <= 1 && !strchr("eE+-", end[-1]);
}

static uint32_t parse_primary(btfi_parser *p) {
    if (btfi_accept(p, "(")) {
        const uint32_t node = btfi_deeper(p) ? btfi_parse_expression(p) : 0;
        --p->depth;
        btfi_expect(p, ")");
        return node;
    }
    const btfi_token t = *btfi_peek(p);
    if (t.kind == BTFI_TOKEN_INT || t.kind == BTFI_TOKEN_UINT || t.kind == BTFI_TOKEN_FLOAT ||
        btfi_token_is(&t, "true") || btfi_token_is(&t, "false")) {
        if (!is_whole(&t) && t.kind != BTFI_TOKEN_NAME) {
            btfi_parse_fail(p, "the number is malformed, or octal");
        }
        btfi_take(p);
        const btfi_base base = t.kind == BTFI_TOKEN_INT     ? BTFI_INT
                               : t.kind == BTFI_TOKEN_UINT  ? BTFI_UINT
                               : t.kind == BTFI_TOKEN_FLOAT ? BTFI_FLOAT
                                                            : BTFI_BOOL;
        return typed(p, btfi_new_node(p, BTFI_NODE_LITERAL, t), btfi_type_of(base, 1));
    }
    const btfi_type type = btfi_parse_type(p);
    if (type.size) {
        return parse_construct(p, t, type);
    }
    if (t.kind != BTFI_TOKEN_NAME) {
        btfi_parse_fail(p, "an expression is expected");
        return 0;
    }
    btfi_take(p);
    if (btfi_next_is(p, "(")) {
        return parse_call(p, t);
    }
    for (uint32_t i = p->n_visible; i > 0; --i) {
        const uint32_t symbol = p->visible[i - 1];
        if (btfi_tokens_equal(&p->tree->symbols[symbol].name, &t)) {
            const uint32_t node = btfi_new_node(p, BTFI_NODE_VARIABLE, t);
            p->tree->nodes[node].of = symbol;
            return typed(p, node, p->tree->symbols[symbol].type);
        }
    }
    btfi_parse_fail_at(p, "the name is not declared", &t);
    return 0;
}

static uint32_t parse_member(btfi_parser *p, uint32_t of) {
    btfi_tree *tree = p->tree;
    const btfi_token name = btfi_take(p);
    const btfi_type type = tree->nodes[of].type;
    if (type.base == BTFI_STRUCT && type.count == 0) {
        const btfi_struct *s = &tree->structs[type.of];
        for (uint32_t i = s->first; i < s->first + s->count; ++i) {
            if (btfi_tokens_equal(&tree->symbols[i].name, &name)) {
                const uint32_t node = btfi_new_node(p, BTFI_NODE_MEMBER, name);
                tree->nodes[node].a = of;
                tree->nodes[node].of = i;
                return typed(p, node, tree->symbols[i].type);
            }
        }
    }
    int fits = btfi_is_plain(type) && type.size > 1 && name.length >= 1 && name.length <= 4;
    for (uint32_t i = 0; fits && i < name.length; ++i) {
        const char *component = memchr("xyzw", name.text[i], type.size);
        fits = component != NULL;
    }
    const uint32_t node = btfi_new_node(p, BTFI_NODE_SWIZZLE, name);
    tree->nodes[node].a = of;
    return typed(p, node, fits ? btfi_type_of((btfi_base)type.base, name.length) : (btfi_type){0});
}

static uint32_t parse_index(btfi_parser *p, uint32_t of) {
    btfi_tree *tree = p->tree;
    btfi_type type = tree->nodes[of].type;
    const btfi_token mark = *btfi_peek(p);
    const uint32_t index = btfi_deeper(p) ? btfi_parse_expression(p) : 0;
    --p->depth;
    btfi_expect(p, "]");
    const uint32_t node = btfi_new_node(p, BTFI_NODE_INDEX, mark);
    int64_t value;
    btfi_symbol *s = root(tree, of);
    if (type.count && s && !btfi_constant(tree, index, &value)) {
        s->is_indexed = 1;
    }
    if (type.count) {
        type.count = 0;
    } else {
        type =
            btfi_is_plain(type) && type.size > 1 ? btfi_type_of((btfi_base)type.base, 1) : (btfi_type){0};
    }
    tree->nodes[node].a = of;
    tree->nodes[node].b = index;
    return typed(p, node, type);
}

static uint32_t parse_postfix(btfi_parser *p) {
    uint32_t node = parse_primary(p);
    while (p->result == BTF_OK) {
        if (btfi_accept(p, ".")) {
            node = parse_member(p, node);
        } else if (btfi_accept(p, "[")) {
            node = parse_index(p, node);
        } else {
            break;
        }
    }
    return node;
}

static uint32_t parse_unary(btfi_parser *p) {
    const btfi_token mark = *btfi_peek(p);
    const int steps = btfi_token_is(&mark, "++") || btfi_token_is(&mark, "--");
    if (!steps && !btfi_token_is(&mark, "-") && !btfi_token_is(&mark, "!")) {
        return parse_postfix(p);
    }
    btfi_take(p);
    const uint32_t of = btfi_deeper(p) ? parse_unary(p) : 0;
    --p->depth;
    if (steps) {
        mark_written(p, of);
    }
    const uint32_t node = btfi_new_node(p, steps ? BTFI_NODE_STEP : BTFI_NODE_UNARY, mark);
    p->tree->nodes[node].a = of;
    const btfi_type type = p->tree->nodes[of].type;
    const int fits = btfi_token_is(&mark, "!")   ? type.base == BTFI_BOOL && type.size == 1
                     : btfi_token_is(&mark, "-") ? type.base == BTFI_INT || type.base == BTFI_FLOAT
                                                 : type.base != BTFI_BOOL;
    return typed(p, node, fits && btfi_is_plain(type) ? type : (btfi_type){0});
}

/* Operators by the strength with which they bind, the weakest first. */
static uint32_t parse_binary(btfi_parser *p, int level) {
    static const char *const marks[][5] = {
        {"||"},       {"&&"},     {"|"},          {"^"}, {"&"}, {"==", "!="}, {"<", ">", "<=", ">="},
        {"<<", ">>"}, {"+", "-"}, {"*", "/", "%"}};
    if (level == sizeof marks / sizeof *marks) {
        return parse_unary(p);
    }
    uint32_t node = parse_binary(p, level + 1);
    for (int m = 0; m < 5 && marks[level][m];) {
        const btfi_token mark = *btfi_peek(p);
        if (!btfi_accept(p, marks[level][m])) {
            ++m;
            continue;
        }
        const uint32_t right = parse_binary(p, level + 1), both = btfi_new_node(p, BTFI_NODE_BINARY, mark);
        p->tree->nodes[both].a = node;
        p->tree->nodes[both].b = right;
        node =
            typed(p, both, btfi_binary_type(&mark, p->tree->nodes[node].type, p->tree->nodes[right].type));
        m = 0;
    }
    return node;
}

static uint32_t parse_ternary(btfi_parser *p) {
    const uint32_t condition = parse_binary(p, 0);
    const btfi_token mark = *btfi_peek(p);
    if (!btfi_accept(p, "?")) {
        return condition;
    }
    const uint32_t yes = btfi_deeper(p) ? btfi_parse_expression(p) : 0;
    btfi_expect(p, ":");
    const uint32_t no = btfi_parse_expression(p), node = btfi_new_node(p, BTFI_NODE_TERNARY, mark);
    --p->depth;
    btfi_node *nodes = p->tree->nodes;
    nodes[node].a = condition;
    nodes[node].b = yes;
    nodes[node].c = no;
    /* WGSL's select takes numbers and vectors alone. */
    const int fits = btfi_types_equal(nodes[yes].type, nodes[no].type) && btfi_is_plain(nodes[yes].type) &&
                     btfi_types_equal(nodes[condition].type, btfi_type_of(BTFI_BOOL, 1));
    return typed(p, node, fits ? nodes[yes].type : (btfi_type){0});
}

uint32_t btfi_parse_expression(btfi_parser *p) {
    const uint32_t left = parse_ternary(p);
    const btfi_token mark = *btfi_peek(p);
    const int assigns =
        mark.kind == BTFI_TOKEN_MARK && mark.text[mark.length - 1] == '=' && !btfi_compares(&mark);
    if (!assigns || p->result != BTF_OK) {
        return left;
    }
    btfi_take(p);
    const uint32_t right = btfi_deeper(p) ? btfi_parse_expression(p) : 0,
                   node = btfi_new_node(p, BTFI_NODE_ASSIGN, mark);
    --p->depth;
    btfi_node *nodes = p->tree->nodes;
    nodes[node].a = left;
    nodes[node].b = right;
    mark_written(p, left);
    btfi_type type = nodes[left].type;
    if (mark.length > 1) {
        const btfi_token operation = {
            .kind = BTFI_TOKEN_MARK, .text = mark.text, .length = mark.length - 1};
        const btfi_type both = btfi_binary_type(&operation, type, nodes[right].type);
        type = btfi_types_equal(both, type) ? type : (btfi_type){0};
    } else if (!btfi_types_equal(type, nodes[right].type)) {
        type = (btfi_type){0};
    }
    return typed(p, node, type);
}
