/* WGSL from the GLSL of the decoder: the part of GLSL that the texts of shaders/ are written in.
 *
 * One source of truth: an effect that is added to the GLSL is in the WGSL, too. WGSL has no preprocessor, no overloading, no
 * swizzled assignment, no out parameters and no expressions that assign; its types convert by name alone, bits and shifts
 * have brackets around them, and it has no `precise`: sums and products pass through the run-time zero (shaders/exact.glsl).
 *
 * SPDX-License-Identifier: MIT
 */
#include "names.h"
#include "parse.h"
#include "preprocess.h"
#include "write_statement.h"

#include <openbtf/shader.h>
#include <stdio.h>
#include <stdlib.h>

static void write_comment(btfi_writer *w, const btfi_token *name) {
    btfi_append(&w->out, "\n", 1);
    int nests = 0; /* in WGSL, comments do */
    for (uint32_t i = 2; name->comment && i + 1 < name->comment_length; ++i) {
        nests |= name->comment[i] == '/' && name->comment[i + 1] == '*';
    }
    if (name->comment && !nests) {
        btfi_append(&w->out, name->comment, name->comment_length);
        btfi_append(&w->out, "\n", 1);
    }
}

static void write_struct(btfi_writer *w, const btfi_struct *s) {
    write_comment(w, &s->name);
    btfi_append(&w->out, "struct ", 7);
    btfi_write_name(&w->out, &s->name);
    btfi_append(&w->out, " {\n", 3);
    for (uint32_t i = s->first; i < s->first + s->count; ++i) {
        btfi_append(&w->out, "    ", 4);
        btfi_write_name(&w->out, &w->tree->symbols[i].name);
        btfi_append(&w->out, ": ", 2);
        btfi_write_type(&w->out, w->tree, w->tree->symbols[i].type);
        btfi_append(&w->out, ",\n", 2);
    }
    btfi_append(&w->out, "}\n", 2);
}

static void write_uniform(btfi_writer *w, const btfi_symbol *s) {
    btfi_print(&w->out, "@group(%u) @binding(%u) var%s ", s->group, s->binding,
               s->type.base == BTFI_TEXTURE ? "" : "<uniform>");
    btfi_write_name(&w->out, &s->name);
    btfi_append(&w->out, ": ", 2);
    btfi_write_type(&w->out, w->tree, s->type);
    btfi_append(&w->out, ";\n", 2);
}

/* WGSL's parameters cannot be assigned, nor an array among them be indexed by a variable in every compiler. */
static int is_copied(const btfi_symbol *s) {
    return s->direction == BTFI_IN && (s->is_written || s->is_indexed);
}

static void write_function(btfi_writer *w, const btfi_function *f) {
    write_comment(w, &f->name);
    btfi_append(&w->out, "fn ", 3);
    btfi_write_function_name(&w->out, w->tree, f);
    btfi_append(&w->out, "(", 1);
    for (uint32_t i = f->first; i < f->first + f->count; ++i) {
        const btfi_symbol *s = &w->tree->symbols[i];
        btfi_write_name(&w->out, &s->name);
        btfi_print(&w->out, "%s: %s", is_copied(s) ? "__given" : "",
                   s->direction == BTFI_IN ? "" : "ptr<function, ");
        btfi_write_type(&w->out, w->tree, s->type);
        btfi_print(&w->out, "%s%s", s->direction == BTFI_IN ? "" : ">",
                   i + 1 < f->first + f->count ? ", " : "");
    }
    btfi_append(&w->out, ")", 1);
    if (f->type.base != BTFI_VOID) {
        btfi_append(&w->out, " -> ", 4);
        btfi_write_type(&w->out, w->tree, f->type);
    }
    btfi_append(&w->out, " {\n", 3);
    w->indent = 1;
    w->kept = 0;
    for (uint32_t i = f->first; i < f->first + f->count; ++i) {
        const btfi_symbol *s = &w->tree->symbols[i];
        if (is_copied(s)) {
            btfi_append(&w->out, "    var ", 8);
            btfi_write_name(&w->out, &s->name);
            btfi_append(&w->out, ": ", 2);
            btfi_write_type(&w->out, w->tree, s->type);
            btfi_append(&w->out, " = ", 3);
            btfi_write_name(&w->out, &s->name);
            btfi_append(&w->out, "__given;\n", 9);
        }
    }
    btfi_write_statements(w, f->body);
    btfi_append(&w->out, "}\n", 2);
}

static void write_all(btfi_writer *w) {
    static const char head[] = "/* OpenBTF: WGSL that libopenbtf made of its GLSL. Every global name "
                               "begins with its prefix; names that several\n"
                               " * functions share in GLSL have the types of parameters behind them.\n"
                               " *\n"
                               " * SPDX-License-Identifier: MIT\n"
                               " */\n";
    const btfi_tree *t = w->tree;
    btfi_append(&w->out, head, sizeof head - 1);
    const btfi_function *clashing = NULL;
    if (!btfi_find_clash(t, &clashing)) {
        w->out.failed = 1;
    } else if (clashing) {
        btfi_write_fail(w, "the name that the overloaded function would have in WGSL is taken or reserved,",
                        &clashing->name);
        return;
    }
    for (uint32_t i = 0; i < t->n_symbols; ++i) {
        if (t->symbols[i].is_uniform) {
            write_uniform(w, &t->symbols[i]);
        }
    }
    for (uint32_t i = 0; i < t->n_structs; ++i) {
        write_struct(w, &t->structs[i]);
    }
    for (uint32_t i = 0; i < t->n_functions && w->result == BTF_OK; ++i) {
        write_function(w, &t->functions[i]);
    }
    if (w->out.failed && w->result == BTF_OK) {
        w->result = BTF_ERROR_MEMORY;
        snprintf(w->message, w->message_size, "out of memory");
    }
}

btf_result btf_shader_wgsl(const char *glsl, const btf_log *log, char **out_text) {
    char why[160] = "", message[200];
    btfi_tokens tokens = {0};
    btfi_tree tree = {0};
    btfi_writer w = {.tree = &tree, .message = why, .message_size = sizeof why};
    *out_text = NULL;
    btf_result result = btfi_preprocess(glsl, &tokens, why, sizeof why);
    if (result == BTF_OK) {
        result = btfi_parse(&tokens, &tree, why, sizeof why);
    }
    if (result == BTF_OK) {
        write_all(&w);
        result = w.result;
    }
    btfi_tokens_free(&tokens);
    btfi_tree_free(&tree);
    if (result != BTF_OK) {
        free(w.out.data);
        if (log && log->callback) {
            snprintf(message, sizeof message, "shader: WGSL: %s", why);
            log->callback(log->user, BTF_LOG_ERROR, message);
        }
        return result;
    }
    *out_text = w.out.data;
    return BTF_OK;
}
