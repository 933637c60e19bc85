/* The state and the steps that the parsers of declarations, statements and expressions share.
 *
 * SPDX-License-Identifier: MIT
 */
#include "parser.h"

#include <stdio.h>

enum { DEEPEST = 200 };

static void fail(btfi_parser *p, const char *what, const char *where, const btfi_token *t) {
    if (p->result == BTF_OK) {
        p->result = BTF_ERROR_UNSUPPORTED;
        snprintf(p->message, p->message_size, "%s %s \"%.*s\"", what, where,
                 t->length < 60 ? (int)t->length : 60, t->text);
        p->at = p->count - 1;
    }
}

void btfi_parse_fail(btfi_parser *p, const char *what) {
    fail(p, what, "near", btfi_peek(p));
}

void btfi_parse_fail_at(btfi_parser *p, const char *what, const btfi_token *at) {
    fail(p, what, "at", at);
}

void btfi_check_name(btfi_parser *p, const btfi_token *name) {
    int is_reserved = btfi_token_is(name, "_");
    for (uint32_t i = 0; i + 1 < name->length; ++i) {
        is_reserved |= name->text[i] == '_' && name->text[i + 1] == '_';
    }
    if (is_reserved && name->kind == BTFI_TOKEN_NAME) {
        btfi_parse_fail_at(p, "the name is reserved (it holds __, or is _ alone)", name);
    }
}

const btfi_token *btfi_peek(const btfi_parser *p) {
    return &p->tokens[p->at];
}

int btfi_next_is(const btfi_parser *p, const char *text) {
    return btfi_token_is(&p->tokens[p->at], text);
}

btfi_token btfi_take(btfi_parser *p) {
    const btfi_token t = p->tokens[p->at];
    p->at += p->at + 1 < p->count;
    return t;
}

int btfi_accept(btfi_parser *p, const char *text) {
    if (!btfi_next_is(p, text)) {
        return 0;
    }
    btfi_take(p);
    return 1;
}

void btfi_expect(btfi_parser *p, const char *text) {
    if (!btfi_accept(p, text)) {
        char what[60];
        snprintf(what, sizeof what, "\"%s\" is expected", text);
        btfi_parse_fail(p, what);
    }
}

int btfi_deeper(btfi_parser *p) {
    if (++p->depth > DEEPEST) {
        btfi_parse_fail(p, "brackets or statements are nested too deeply");
        return 0;
    }
    return 1;
}

uint32_t btfi_new_node(btfi_parser *p, btfi_node_kind kind, btfi_token token) {
    btfi_tree *t = p->tree;
    if (p->result != BTF_OK) {
        return 0;
    }
    if (t->n_nodes == t->most) {
        btfi_parse_fail(p, "the text has too many parts");
        return 0;
    }
    t->nodes[t->n_nodes] = (btfi_node){.kind = kind, .token = token};
    return t->n_nodes++;
}

uint32_t btfi_new_symbol(btfi_parser *p, btfi_token name, btfi_type type) {
    btfi_tree *t = p->tree;
    if (p->result == BTF_OK && name.kind != BTFI_TOKEN_NAME) {
        btfi_parse_fail_at(p, "a name is expected", &name);
    }
    btfi_check_name(p, &name);
    if (p->result != BTF_OK || t->n_symbols == t->most) {
        btfi_parse_fail(p, "the text declares too many names");
        return 0;
    }
    t->symbols[t->n_symbols] = (btfi_symbol){.name = name, .type = type};
    return t->n_symbols++;
}

void btfi_show(btfi_parser *p, uint32_t symbol) {
    if (p->result == BTF_OK) {
        p->visible[p->n_visible++] = symbol; /* as long as the list of symbols */
    }
}

int32_t btfi_find_struct(const btfi_tree *tree, const btfi_token *name) {
    for (uint32_t i = 0; i < tree->n_structs; ++i) {
        if (btfi_tokens_equal(&tree->structs[i].name, name)) {
            return (int32_t)i;
        }
    }
    return -1;
}
