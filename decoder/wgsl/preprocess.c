/* The preprocessor of GLSL: conditions are resolved and macros expanded.
 *
 * SPDX-License-Identifier: MIT
 */
#include "preprocess.h"

#include "types.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    MOST_ARGUMENTS = 16,
    MOST_NESTED = 64,     /* conditions */
    DEEPEST = 200,        /* brackets and operators of a condition, and macros, in one another */
    MOST_STEPS = 1 << 22, /* tokens that expansion looks at in a text: each macro can double them */
};

typedef struct macro {
    btfi_token name;
    size_t parameters, n_parameters; /* where they begin in `tokens`; of a function alone */
    size_t body, n_body;
    int is_function, busy, gone; /* busy: it is being expanded, and is no macro within itself */
} macro;

typedef struct state {
    btfi_reader reader;
    btfi_tokens tokens; /* of all macros */
    macro *macros;
    size_t n_macros, capacity;
    struct {
        int alive, outer; /* this branch, and all around it */
    } conditions[MOST_NESTED];
    size_t n_conditions;
    size_t depth, steps; /* of the expansion of macros */
    btf_result result;
    char *message;
    size_t message_size;
} state;

static void fail(state *s, btf_result result, const char *what, const btfi_token *at) {
    if (s->result == BTF_OK) {
        s->result = result;
        if (at) {
            snprintf(s->message, s->message_size, "%s at \"%.*s\"", what, (int)at->length, at->text);
        } else {
            snprintf(s->message, s->message_size, "%s", what);
        }
    }
}

static macro *find(state *s, const btfi_token *name) {
    for (size_t i = s->n_macros; i > 0; --i) {
        macro *m = &s->macros[i - 1];
        if (btfi_tokens_equal(&m->name, name)) {
            return m->gone ? NULL : m;
        }
    }
    return NULL;
}

/* A new macro; NULL where memory is out. */
static macro *add(state *s, btfi_token name) {
    if (s->n_macros == s->capacity) {
        size_t capacity = 2 * s->capacity + 64;
        macro *grown = realloc(s->macros, capacity * sizeof *grown);
        if (!grown) {
            fail(s, BTF_ERROR_MEMORY, "out of memory", &name);
            return NULL;
        }
        s->macros = grown;
        s->capacity = capacity;
    }
    macro *m = &s->macros[s->n_macros++];
    *m = (macro){.name = name, .parameters = s->tokens.count, .body = s->tokens.count};
    return m;
}

static void expand(state *s, const btfi_token *list, size_t count, btfi_tokens *out);

/* Where the arguments of a call of a macro lie; list[0] is its opening bracket. Returns how many tokens the call takes
 * from there on, 0 where it does not end or has more than MOST_ARGUMENTS. */
static size_t find_arguments(const btfi_token *list, size_t count, size_t begin[MOST_ARGUMENTS],
                             size_t length[MOST_ARGUMENTS], size_t *out_arguments) {
    size_t depth = 0, n = 0, from = 1;
    for (size_t i = 0; i < count; ++i) {
        depth += btfi_token_is(&list[i], "(");
        int closes = btfi_token_is(&list[i], ")");
        if ((closes || btfi_token_is(&list[i], ",")) && depth == 1) {
            if (n == MOST_ARGUMENTS) {
                return 0;
            }
            begin[n] = from;
            length[n++] = i - from;
            from = i + 1;
        }
        depth -= (size_t)closes;
        if (depth == 0) {
            *out_arguments = n;
            return i + 1;
        }
    }
    return 0;
}

/* Expands a call of macro number m whose opening bracket is list[0]; returns the tokens that it takes. */
static size_t expand_call(state *s, size_t m, const btfi_token *list, size_t count, btfi_tokens *out) {
    size_t begin[MOST_ARGUMENTS], length[MOST_ARGUMENTS], arguments = 0;
    const size_t taken = find_arguments(list, count, begin, length, &arguments);
    if (taken == 0 || arguments != s->macros[m].n_parameters) {
        fail(s, BTF_ERROR_UNSUPPORTED,
             "the macro is called with another number of arguments than it has parameters",
             &s->macros[m].name);
        return count;
    }
    btfi_tokens body = {0};
    for (size_t i = 0; i < s->macros[m].n_body; ++i) {
        const btfi_token *token = &s->tokens.list[s->macros[m].body + i];
        size_t p = 0;
        while (p < arguments && !btfi_tokens_equal(token, &s->tokens.list[s->macros[m].parameters + p])) {
            ++p;
        }
        if (p == arguments) {
            btfi_tokens_add(&body, *token);
        } else {
            expand(s, list + begin[p], length[p], &body);
        }
    }
    out->failed |= body.failed;
    s->macros[m].busy = 1;
    expand(s, body.list, body.count, out);
    s->macros[m].busy = 0;
    btfi_tokens_free(&body);
    return taken;
}

/* Appends tokens, their macros expanded. A function-like macro's name without a bracket is no call. */
static void expand(state *s, const btfi_token *list, size_t count, btfi_tokens *out) {
    if (++s->depth > DEEPEST) {
        fail(s, BTF_ERROR_UNSUPPORTED, "macros are nested too deeply", count ? list : NULL);
    }
    for (size_t i = 0; i < count && s->result == BTF_OK; ++i) {
        if (++s->steps > MOST_STEPS) {
            fail(s, BTF_ERROR_UNSUPPORTED, "macros expand to too many words", &list[i]);
        }
        const macro *found = list[i].kind == BTFI_TOKEN_NAME ? find(s, &list[i]) : NULL;
        const int call = found && found->is_function && i + 1 < count && btfi_token_is(&list[i + 1], "(");
        if (!found || found->busy || (found->is_function && !call)) {
            btfi_tokens_add(out, list[i]);
            continue;
        }
        const size_t m = (size_t)(found - s->macros);
        if (call) {
            i += expand_call(s, m, list + i + 1, count - i - 1, out);
        } else {
            s->macros[m].busy = 1;
            expand(s, s->tokens.list + s->macros[m].body, s->macros[m].n_body, out);
            s->macros[m].busy = 0;
        }
    }
    --s->depth;
}

/* Conditions: a recursive descent over the tokens of a line. */
typedef struct condition {
    state *s;
    const btfi_token *list;
    size_t count, at, depth;
} condition;

static int64_t evaluate(condition *c, int level);
static int64_t apply(const char *mark, int64_t a, int64_t b);

static int takes(condition *c, const char *mark) {
    if (c->at < c->count && btfi_token_is(&c->list[c->at], mark)) {
        ++c->at;
        return 1;
    }
    return 0;
}

static int64_t evaluate_one(condition *c) {
    if (++c->depth > DEEPEST) {
        fail(c->s, BTF_ERROR_UNSUPPORTED, "the condition is nested too deeply", NULL);
        c->at = c->count;
    }
    if (takes(c, "!")) {
        int64_t value = !evaluate_one(c);
        --c->depth;
        return value;
    }
    if (takes(c, "-")) {
        int64_t value = apply("-", 0, evaluate_one(c));
        --c->depth;
        return value;
    }
    if (takes(c, "(")) {
        int64_t value = evaluate(c, 0);
        if (!takes(c, ")")) {
            fail(c->s, BTF_ERROR_UNSUPPORTED, "the condition has no closing bracket", NULL);
        }
        --c->depth;
        return value;
    }
    --c->depth;
    if (c->at < c->count &&
        (c->list[c->at].kind == BTFI_TOKEN_INT || c->list[c->at].kind == BTFI_TOKEN_UINT)) {
        return strtoll(c->list[c->at++].text, NULL, 0);
    }
    fail(c->s, BTF_ERROR_UNSUPPORTED, "the condition is not an integer expression",
         c->at < c->count ? &c->list[c->at] : NULL);
    return 0;
}

static int64_t apply(const char *mark, int64_t a, int64_t b) {
    int64_t value = 0;
    switch (mark[0]) {
    case '|':
        return a || b;
    case '&':
        return a && b;
    case '=':
        return a == b;
    case '!':
        return a != b;
    case '<':
        return mark[1] ? a <= b : a < b;
    case '>':
        return mark[1] ? a >= b : a > b;
    default:
        btfi_arithmetic(mark[0], a, b, &value);
        return value;
    }
}

static int64_t evaluate(condition *c, int level) {
    /* By the strength with which they bind, the weakest first. */
    static const char *const marks[][5] = {{"||"},     {"&&"},         {"==", "!="}, {"<=", ">=", "<", ">"},
                                           {"+", "-"}, {"*", "/", "%"}};
    if (level == sizeof marks / sizeof *marks) {
        return evaluate_one(c);
    }
    int64_t value = evaluate(c, level + 1);
    for (int m = 0; m < 5 && marks[level][m];) {
        if (takes(c, marks[level][m])) {
            value = apply(marks[level][m], value, evaluate(c, level + 1));
            m = 0;
        } else {
            ++m;
        }
    }
    return value;
}

/* The value of the condition in a line: defined(NAME) first, then macros. */
static int condition_holds(state *s, const btfi_tokens *line) {
    static const char *const values[] = {"0", "1"};
    btfi_tokens known = {0}, expanded = {0};
    for (size_t i = 0; i < line->count; ++i) {
        if (!btfi_token_is(&line->list[i], "defined")) {
            btfi_tokens_add(&known, line->list[i]);
            continue;
        }
        const size_t bracket = i + 1 < line->count && btfi_token_is(&line->list[i + 1], "(");
        if (i + 1 + 2 * bracket >= line->count) {
            fail(s, BTF_ERROR_UNSUPPORTED, "no name follows the word defined", &line->list[i]);
            break;
        }
        const char *value = values[find(s, &line->list[i + 1 + bracket]) != NULL];
        btfi_tokens_add(&known, (btfi_token){.kind = BTFI_TOKEN_INT, .text = value, .length = 1});
        i += 1 + 2 * bracket;
    }
    expand(s, known.list, known.count, &expanded);
    condition c = {.s = s, .list = expanded.list, .count = expanded.count};
    const int holds = evaluate(&c, 0) != 0;
    if (c.at < c.count) {
        fail(s, BTF_ERROR_UNSUPPORTED, "the condition is followed by other text", &c.list[c.at]);
    }
    if (known.failed || expanded.failed) {
        fail(s, BTF_ERROR_MEMORY, "out of memory", NULL);
    }
    btfi_tokens_free(&known);
    btfi_tokens_free(&expanded);
    return holds;
}

/* line[0] is the name. Parameters stand in a bracket that touches it. */
static void define(state *s, const btfi_tokens *line) {
    macro *m = line->count && line->list[0].kind == BTFI_TOKEN_NAME ? add(s, line->list[0]) : NULL;
    if (!m) {
        fail(s, BTF_ERROR_UNSUPPORTED, "no name follows #define", line->count ? line->list : NULL);
        return;
    }
    size_t i = 1;
    if (i < line->count && btfi_token_is(&line->list[i], "(") &&
        line->list[i].text == m->name.text + m->name.length) {
        m->is_function = 1;
        for (++i; i < line->count && !btfi_token_is(&line->list[i], ")"); ++i) {
            if (line->list[i].kind == BTFI_TOKEN_NAME) {
                btfi_tokens_add(&s->tokens, line->list[i]);
                ++m->n_parameters;
            }
        }
        ++i;
    }
    m->body = s->tokens.count;
    for (; i < line->count; ++i) {
        btfi_token token = line->list[i];
        token.comment = NULL;
        btfi_tokens_add(&s->tokens, token);
    }
    m->n_body = s->tokens.count - m->body;
    if (s->tokens.failed) { /* the macro has fewer tokens than its numbers say */
        fail(s, BTF_ERROR_MEMORY, "out of memory", &line->list[0]);
    }
}

static int alive(const state *s) {
    return s->n_conditions == 0 ||
           (s->conditions[s->n_conditions - 1].alive && s->conditions[s->n_conditions - 1].outer);
}

static void open_condition(state *s, int holds, const btfi_token *at) {
    if (s->n_conditions == MOST_NESTED) {
        fail(s, BTF_ERROR_UNSUPPORTED, "conditions are nested too deeply", at);
        return;
    }
    const int outer = alive(s);
    s->conditions[s->n_conditions].alive = holds;
    s->conditions[s->n_conditions++].outer = outer;
}

/* The rest of a line that began with #. */
static void directive(state *s) {
    btfi_tokens line = {0};
    const btfi_token word = btfi_read_token(&s->reader, 1);
    for (btfi_token t = btfi_read_token(&s->reader, 1); t.kind != BTFI_TOKEN_END;
         t = btfi_read_token(&s->reader, 1)) {
        btfi_tokens_add(&line, t);
    }
    const macro *named = line.count ? find(s, &line.list[0]) : NULL;
    if (btfi_token_is(&word, "if")) {
        open_condition(s, alive(s) && condition_holds(s, &line), &word);
    } else if (btfi_token_is(&word, "ifdef")) {
        open_condition(s, named != NULL, &word);
    } else if (btfi_token_is(&word, "ifndef")) {
        open_condition(s, named == NULL, &word);
    } else if (btfi_token_is(&word, "else") && s->n_conditions) {
        s->conditions[s->n_conditions - 1].alive ^= 1;
    } else if (btfi_token_is(&word, "endif") && s->n_conditions) {
        --s->n_conditions;
    } else if (alive(s) && btfi_token_is(&word, "define")) {
        define(s, &line);
    } else if (alive(s) && btfi_token_is(&word, "undef") && named) {
        s->macros[named - s->macros].gone = 1;
    } else if (alive(s) || (btfi_token_is(&word, "elif") && s->conditions[s->n_conditions - 1].outer)) {
        fail(s, BTF_ERROR_UNSUPPORTED, "the translator does not know this directive of the preprocessor",
             &word);
    }
    if (line.failed) {
        fail(s, BTF_ERROR_MEMORY, "out of memory", &word);
    }
    btfi_tokens_free(&line);
}

/* The next token that lives; directives before it are carried out. */
static btfi_token next(state *s) {
    for (;;) {
        const btfi_token t = btfi_read_token(&s->reader, 0);
        if (t.kind == BTFI_TOKEN_DIRECTIVE) {
            directive(s);
        } else if (t.kind == BTFI_TOKEN_END || alive(s)) {
            return t;
        }
        if (s->result != BTF_OK) {
            return (btfi_token){.text = s->reader.at};
        }
    }
}

/* Reads a token, and with the name of a function-like macro its arguments. */
static void read_unit(state *s, btfi_token first, btfi_tokens *unit) {
    btfi_tokens_add(unit, first);
    const macro *m = first.kind == BTFI_TOKEN_NAME ? find(s, &first) : NULL;
    if (!m || !m->is_function) {
        return;
    }
    for (int depth = 0;;) {
        const btfi_token t = next(s);
        depth += btfi_token_is(&t, "(") - btfi_token_is(&t, ")");
        if (t.kind == BTFI_TOKEN_END) {
            return;
        }
        btfi_tokens_add(unit, t);
        if (depth <= 0) {
            return;
        }
    }
}

btf_result btfi_preprocess(const char *glsl, btfi_tokens *out_tokens, char *message, size_t message_size) {
    static const char *const predefined[] = {"GL_ES 1", "WGSL 1", "__VERSION__ 300"};
    state s = {.message = message, .message_size = message_size};
    memset(out_tokens, 0, sizeof *out_tokens);
    for (size_t i = 0; i < sizeof predefined / sizeof *predefined; ++i) {
        btfi_reader reader = {.at = predefined[i]};
        btfi_tokens line = {0};
        btfi_tokens_add(&line, btfi_read_token(&reader, 1));
        btfi_tokens_add(&line, btfi_read_token(&reader, 1));
        define(&s, &line);
        btfi_tokens_free(&line);
    }
    s.reader = (btfi_reader){.at = glsl, .begins_line = 1};
    for (btfi_token t = next(&s); s.result == BTF_OK; t = next(&s)) {
        btfi_tokens unit = {0};
        if (t.kind == BTFI_TOKEN_END) {
            btfi_tokens_add(out_tokens, t);
            break;
        }
        read_unit(&s, t, &unit);
        const size_t before = out_tokens->count;
        expand(&s, unit.list, unit.count, out_tokens);
        if (out_tokens->count > before) {
            out_tokens->list[before].comment = t.comment;
            out_tokens->list[before].comment_length = t.comment_length;
        }
        out_tokens->failed |= unit.failed;
        btfi_tokens_free(&unit);
    }
    if (s.tokens.failed || out_tokens->failed) {
        fail(&s, BTF_ERROR_MEMORY, "out of memory", NULL);
    } else if (s.n_conditions > 0) {
        fail(&s, BTF_ERROR_UNSUPPORTED, "a condition has no #endif", NULL);
    }
    btfi_tokens_free(&s.tokens);
    free(s.macros);
    return s.result;
}
