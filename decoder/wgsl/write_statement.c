/* Writes statements in WGSL.
 *
 * WGSL has no expressions that assign, and takes the address of a whole variable alone: what GLSL does within an expression
 * gets lines of its own, in front of and behind the statement.
 *
 * SPDX-License-Identifier: MIT
 */
#include "write_statement.h"

#include "names.h"
#include "types.h"

#include <string.h>

static void line(btfi_writer *w, const char *text) {
    btfi_write_indent(w);
    btfi_print(&w->out, "%s\n", text);
}

static void end_line(btfi_writer *w, const char *text) {
    btfi_print(&w->out, "%s\n", text);
}

static const btfi_node *node_of(const btfi_writer *w, uint32_t node) {
    return &w->tree->nodes[node];
}

static btfi_direction direction(const btfi_writer *w, const btfi_node *call, uint32_t argument) {
    return (btfi_direction)w->tree->symbols[w->tree->functions[call->of].first + argument].direction;
}

/* Whether an expression changes a variable. */
static int has_effects(const btfi_writer *w, uint32_t node) {
    const btfi_node *n = node_of(w, node);
    if (n->kind == BTFI_NODE_STEP || n->kind == BTFI_NODE_ASSIGN) {
        return 1;
    }
    const int has_list =
        n->kind == BTFI_NODE_CALL || n->kind == BTFI_NODE_BUILTIN || n->kind == BTFI_NODE_CONSTRUCT;
    if (!has_list) {
        return (n->a && has_effects(w, n->a)) || (n->b && has_effects(w, n->b)) ||
               (n->c && has_effects(w, n->c));
    }
    uint32_t i = 0;
    for (uint32_t argument = n->a; argument; argument = node_of(w, argument)->next, ++i) {
        if ((n->kind == BTFI_NODE_CALL && direction(w, n, i) != BTFI_IN) || has_effects(w, argument)) {
            return 1;
        }
    }
    return 0;
}

/* Refuses side effects in the variable of an assignment: WGSL may take it several times, and nothing can be written
 * in front of it. */
static void refuse_effects(btfi_writer *w, uint32_t assigned) {
    if (has_effects(w, assigned)) {
        btfi_write_fail(w, "a variable that is assigned is named by an expression with a side effect",
                        &node_of(w, assigned)->token);
    }
}

static void write_before(btfi_writer *w, uint32_t node);

/* Variables for arguments that are parts of others. */
static void keep_arguments(btfi_writer *w, const btfi_node *call) {
    uint32_t i = 0;
    for (uint32_t argument = call->a; argument; argument = node_of(w, argument)->next, ++i) {
        btfi_node *n = &w->tree->nodes[argument];
        const int by_address = call->kind == BTFI_NODE_CALL && direction(w, call, i) != BTFI_IN;
        if (!by_address) {
            write_before(w, argument);
            continue;
        }
        refuse_effects(w, argument);
        if (btfi_is_whole_variable(w->tree, argument)) {
            continue;
        }
        const uint32_t number = ++w->kept;
        btfi_write_indent(w);
        btfi_print(&w->out, "var kept__%u: ", number);
        btfi_write_type(&w->out, w->tree, n->type);
        if (direction(w, call, i) == BTFI_INOUT) {
            btfi_print(&w->out, " = ");
            btfi_write_expression(w, argument);
        }
        end_line(w, ";");
        n->kept = number;
    }
}

/* Lines in front of a statement with this expression. */
static void write_before(btfi_writer *w, uint32_t node) {
    const btfi_node *n = node_of(w, node);
    if (node == 0 || w->result != BTF_OK) {
        return;
    }
    switch (n->kind) {
    case BTFI_NODE_STEP:
        refuse_effects(w, n->a);
        btfi_write_indent(w);
        btfi_write_expression(w, n->a);
        btfi_print(&w->out, "%.*s;\n", (int)n->token.length, n->token.text);
        break;
    case BTFI_NODE_CALL:
    case BTFI_NODE_BUILTIN:
    case BTFI_NODE_CONSTRUCT:
        keep_arguments(w, n);
        break;
    case BTFI_NODE_TERNARY:
        if (has_effects(w, n->b) || has_effects(w, n->c)) {
            btfi_write_fail(w, "the second or third operand of ?: has a side effect", &n->token);
        }
        write_before(w, n->a);
        break;
    case BTFI_NODE_BINARY:
        write_before(w, n->a);
        if (has_effects(w, n->b) && (btfi_token_is(&n->token, "&&") || btfi_token_is(&n->token, "||"))) {
            btfi_write_fail(w, "the second operand of && or || has a side effect", &n->token);
        }
        write_before(w, n->b);
        break;
    case BTFI_NODE_INDEX:
        write_before(w, n->a);
        write_before(w, n->b);
        break;
    case BTFI_NODE_MEMBER:
    case BTFI_NODE_SWIZZLE:
    case BTFI_NODE_UNARY:
        write_before(w, n->a);
        break;
    default:
        break;
    }
}

/* Lines behind it: what out arguments were given goes where it belongs. Returns how many. */
static uint32_t write_after(btfi_writer *w, uint32_t node) {
    btfi_node *n = &w->tree->nodes[node];
    uint32_t lines = 0;
    const int has_list =
        n->kind == BTFI_NODE_CALL || n->kind == BTFI_NODE_BUILTIN || n->kind == BTFI_NODE_CONSTRUCT;
    if (node == 0 || n->kind == BTFI_NODE_VARIABLE || n->kind == BTFI_NODE_LITERAL) {
        return 0;
    }
    if (!has_list) {
        return write_after(w, n->a) + write_after(w, n->b) + write_after(w, n->c);
    }
    for (uint32_t argument = n->a; argument; argument = node_of(w, argument)->next) {
        btfi_node *a = &w->tree->nodes[argument];
        if (a->kept) {
            const uint32_t number = a->kept;
            a->kept = 0;
            btfi_write_indent(w);
            btfi_write_expression(w, argument);
            btfi_print(&w->out, " = kept__%u;\n", number);
            ++lines;
        } else {
            lines += write_after(w, argument);
        }
    }
    return lines;
}

static void write_declaration(btfi_writer *w, const btfi_node *n) {
    const btfi_symbol *s = &w->tree->symbols[n->of];
    btfi_append(&w->out, s->is_written || s->is_indexed ? "var " : "let ", 4);
    btfi_write_name(&w->out, &s->name);
    btfi_append(&w->out, ": ", 2);
    btfi_write_type(&w->out, w->tree, s->type);
    if (n->a) {
        btfi_append(&w->out, " = ", 3);
        btfi_write_expression(w, n->a);
    }
}

/* Components of a vector: WGSL assigns one at a time. */
static void write_swizzle_assignment(btfi_writer *w, const btfi_node *n) {
    const btfi_node *target = node_of(w, n->a);
    line(w, "{");
    ++w->indent;
    btfi_write_indent(w);
    btfi_print(&w->out, "let moved__: ");
    btfi_write_type(&w->out, w->tree, target->type);
    btfi_print(&w->out, " = ");
    if (n->token.length > 1) {
        btfi_write_expression(w, n->a);
        const int brackets = node_of(w, n->b)->kind == BTFI_NODE_BINARY;
        btfi_print(&w->out, " %.*s %s", (int)n->token.length - 1, n->token.text, brackets ? "(" : "");
        btfi_write_expression(w, n->b);
        btfi_print(&w->out, brackets ? ")" : "");
    } else {
        btfi_write_expression(w, n->b);
    }
    end_line(w, ";");
    for (uint32_t i = 0; i < target->token.length; ++i) {
        btfi_write_indent(w);
        btfi_write_expression(w, target->a);
        btfi_print(&w->out, ".%c = moved__.%c;\n", target->token.text[i], "xyzw"[i]);
    }
    --w->indent;
    line(w, "}");
}

/* An assignment whose value is no assignment, without indentation and semicolon. */
static void write_assignment(btfi_writer *w, const btfi_node *n) {
    const btfi_node *target = node_of(w, n->a), *value = node_of(w, n->b);
    const int of_bits = n->token.length > 1 && !strchr("+-*/%", n->token.text[0]);
    if (of_bits && (n->token.length > 2 || value->type.size != target->type.size)) {
        btfi_write_fail(
            w, "WGSL has no such assignment, which shifts, or combines the bits of a vector and a scalar,",
            &n->token);
    }
    btfi_write_expression(w, n->a);
    btfi_print(&w->out, " %.*s ", (int)n->token.length, n->token.text);
    btfi_write_expression(w, n->b);
}

static int moves_components(const btfi_writer *w, const btfi_node *assignment) {
    const btfi_node *target = node_of(w, assignment->a);
    return target->kind == BTFI_NODE_SWIZZLE && target->token.length > 1;
}

static void write_assignments(btfi_writer *w, const btfi_node *n) {
    const btfi_node *value = node_of(w, n->b);
    refuse_effects(w, n->a);
    if (value->kind == BTFI_NODE_ASSIGN) { /* a = b = c: b = c first */
        write_assignments(w, value);
        if (n->token.length > 1 || moves_components(w, n) || moves_components(w, value)) {
            btfi_write_fail(w, "a chain of assignments can have no operator but =, and no swizzles,",
                            &n->token);
        }
        btfi_write_indent(w);
        btfi_write_expression(w, n->a);
        btfi_print(&w->out, " = ");
        btfi_write_expression(w, value->a);
        end_line(w, ";");
        return;
    }
    write_before(w, n->b);
    if (moves_components(w, n)) {
        write_swizzle_assignment(w, n);
    } else {
        btfi_write_indent(w);
        write_assignment(w, n);
        end_line(w, ";");
    }
    write_after(w, n->b);
}

static void write_effect(btfi_writer *w, uint32_t node) {
    const btfi_node *n = node_of(w, node);
    if (n->kind == BTFI_NODE_ASSIGN) {
        write_assignments(w, n);
        return;
    }
    write_before(w, node);
    if (n->kind == BTFI_NODE_CALL) {
        btfi_write_indent(w);
        btfi_write_expression(w, node);
        end_line(w, ";");
    } else if (n->kind != BTFI_NODE_STEP) {
        btfi_write_fail(w, "the statement has no effect", &n->token);
    }
    write_after(w, node);
}

static void write_condition(btfi_writer *w, uint32_t node) {
    if (has_effects(w, node)) {
        btfi_write_fail(w, "the condition has a side effect", &node_of(w, node)->token);
    }
    btfi_write_expression(w, node);
}

static void write_block(btfi_writer *w, uint32_t block) {
    ++w->indent;
    btfi_write_statements(w, block);
    --w->indent;
}

static void write_if(btfi_writer *w, const btfi_node *n) {
    btfi_print(&w->out, "if (");
    write_condition(w, n->a);
    end_line(w, ") {");
    write_block(w, n->b);
    btfi_write_indent(w);
    if (!n->c) {
        end_line(w, "}");
        return;
    }
    const btfi_node *only = node_of(w, node_of(w, n->c)->a);
    if (only->kind == BTFI_NODE_IF && !only->next) {
        btfi_print(&w->out, "} else ");
        write_if(w, only);
        return;
    }
    end_line(w, "} else {");
    write_block(w, n->c);
    line(w, "}");
}

/* Steps of a loop, then the end of it. */
static void write_continuing(btfi_writer *w, uint32_t first_step, uint32_t condition) {
    line(w, "continuing {");
    ++w->indent;
    for (uint32_t step = first_step; step; step = node_of(w, step)->next) {
        write_effect(w, node_of(w, step)->a);
    }
    if (condition) {
        write_before(w, condition);
        btfi_write_indent(w);
        btfi_print(&w->out, "break if !(");
        btfi_write_expression(w, condition);
        end_line(w, ");");
        if (write_after(w, condition)) {
            btfi_write_fail(w, "the condition of the loop hands a part of a variable to an out parameter",
                            &node_of(w, condition)->token);
        }
    }
    --w->indent;
    line(w, "}");
}

/* WGSL's `for` has one step. */
static void write_for(btfi_writer *w, const btfi_node *n) {
    const btfi_node *first = node_of(w, n->a), *step = node_of(w, n->c), *effect = node_of(w, step->a);
    const int is_simple =
        first->kind == BTFI_NODE_DECLARE && first->a && !has_effects(w, first->a) && !step->next &&
        !has_effects(w, effect->a) &&
        (effect->kind == BTFI_NODE_STEP ||
         (effect->kind == BTFI_NODE_ASSIGN && !moves_components(w, effect) && !has_effects(w, effect->b)));
    if (is_simple) {
        btfi_print(&w->out, "for (");
        write_declaration(w, first);
        btfi_print(&w->out, "; ");
        write_condition(w, n->b);
        btfi_print(&w->out, "; ");
        if (effect->kind == BTFI_NODE_STEP) {
            btfi_write_expression(w, effect->a);
            btfi_print(&w->out, "%.*s", (int)effect->token.length, effect->token.text);
        } else {
            write_assignment(w, effect);
        }
        end_line(w, ") {");
        write_block(w, n->d);
        line(w, "}");
        return;
    }
    end_line(w, "{");
    ++w->indent;
    btfi_write_indent(w);
    if (first->kind == BTFI_NODE_DECLARE && !has_effects(w, first->a)) {
        write_declaration(w, first);
        end_line(w, ";");
    } else {
        btfi_write_fail(w, "the loop does not begin with a declaration without side effects", &n->token);
    }
    line(w, "loop {");
    ++w->indent;
    btfi_write_indent(w);
    btfi_print(&w->out, "if (!(");
    write_condition(w, n->b);
    end_line(w, ")) {");
    line(w, "    break;");
    line(w, "}");
    btfi_write_statements(w, n->d);
    write_continuing(w, n->c, 0);
    --w->indent;
    line(w, "}");
    --w->indent;
    line(w, "}");
}

static void write_return(btfi_writer *w, const btfi_node *n) {
    write_before(w, n->a);
    btfi_write_indent(w);
    btfi_print(&w->out, n->a ? "return " : "return");
    if (n->a) {
        btfi_write_expression(w, n->a);
    }
    end_line(w, ";");
    if (write_after(w, n->a)) {
        btfi_write_fail(w, "return cannot hand a part of a variable to an out parameter", &n->token);
    }
}

static void write_statement(btfi_writer *w, const btfi_node *n) {
    switch (n->kind) {
    case BTFI_NODE_DECLARE:
        write_before(w, n->a);
        btfi_write_indent(w);
        write_declaration(w, n);
        end_line(w, ";");
        write_after(w, n->a);
        break;
    case BTFI_NODE_EXPRESSION:
        write_effect(w, n->a);
        break;
    case BTFI_NODE_RETURN:
        write_return(w, n);
        break;
    case BTFI_NODE_BREAK:
        line(w, "break;");
        break;
    case BTFI_NODE_CONTINUE:
        line(w, "continue;");
        break;
    case BTFI_NODE_BLOCK:
        line(w, "{");
        write_block(w, (uint32_t)(n - w->tree->nodes));
        line(w, "}");
        break;
    case BTFI_NODE_IF:
        btfi_write_indent(w);
        write_if(w, n);
        break;
    case BTFI_NODE_FOR:
        btfi_write_indent(w);
        write_for(w, n);
        break;
    case BTFI_NODE_WHILE:
        btfi_write_indent(w);
        btfi_print(&w->out, "while (");
        write_condition(w, n->a);
        end_line(w, ") {");
        write_block(w, n->d);
        line(w, "}");
        break;
    case BTFI_NODE_DO:
        line(w, "loop {");
        write_block(w, n->d);
        ++w->indent;
        write_continuing(w, 0, n->a);
        --w->indent;
        line(w, "}");
        break;
    default:
        btfi_write_fail(w, "a statement is expected", &n->token);
    }
}

void btfi_write_statements(btfi_writer *w, uint32_t block) {
    for (uint32_t s = node_of(w, block)->a; s && w->result == BTF_OK; s = node_of(w, s)->next) {
        write_statement(w, node_of(w, s));
    }
}
