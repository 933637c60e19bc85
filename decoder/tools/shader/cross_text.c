/* Texts of SPIRV-Cross as libraries. See cross_text.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "cross_text.h"

#include "decoder/toolkit/file.h"
#include <ctype.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

char *cross_join(const char *const *texts) {
    size_t length = 1;
    for (const char *const *t = texts; *t; t++) {
        length += strlen(*t);
    }
    char *joined = malloc(length);
    if (joined) {
        char *end = joined;
        for (const char *const *t = texts; *t; t++) {
            const size_t size = strlen(*t);
            memcpy(end, *t, size);
            end += size;
        }
        *end = 0;
    }
    return joined;
}

static bool is_word(char c) {
    return isalnum((unsigned char)c) || c == '_';
}

/* A copy in which `to` takes the place of words that are `from`, or where `whole` is false of the beginnings of words
 * that begin with it. */
static char *replace(const char *text, const char *from, const char *to, bool whole) {
    const size_t from_size = strlen(from), to_size = strlen(to);
    size_t found = 0;
    for (const char *p = text; (p = strstr(p, from)); p += from_size) {
        found++;
    }
    char *copy = malloc(strlen(text) + found * to_size + 1), *end = copy;
    const char *at = text;
    while (copy && *at) {
        if ((at == text || !is_word(at[-1])) && strncmp(at, from, from_size) == 0 &&
            !(whole && is_word(at[from_size]))) {
            memcpy(end, to, to_size);
            end += to_size;
            at += from_size;
        } else {
            *end++ = *at++;
        }
    }
    if (copy) {
        *end = 0;
    }
    return copy;
}

char *cross_replace_prefix(const char *text, const char *from, const char *prefix) {
    char to[64];
    snprintf(to, sizeof to, "%s_", prefix);
    return replace(text, from, to, false);
}

/* Removes the text from `begin`, at the beginning of a line, to the end of the next `end`; false where it is not
 * there. */
static bool cut(char *text, const char *begin, const char *end) {
    char *from = strstr(text, begin);
    while (from && from != text && from[-1] != '\n') {
        from = strstr(from + 1, begin);
    }
    char *to = from ? strstr(from, end) : NULL;
    if (!to) {
        return false;
    }
    to += strlen(end);
    memmove(from, to, strlen(to) + 1);
    return true;
}

/* Gives the prefix to constants at file scope that SPIRV-Cross made up and called _123. Takes over a text and returns
 * one; NULL without memory. */
static char *name_constants(char *text, const char *keyword, const char *prefix) {
    const char *line = text;
    char name[32], better[80];
    while (text && line) {
        const char *equals = strstr(line, " = "), *next = strchr(line, '\n');
        if (strncmp(line, keyword, strlen(keyword)) == 0 && equals && (!next || equals < next)) {
            const char *begin = equals;
            while (begin > line && begin[-1] != ' ') {
                begin--;
            }
            const size_t length = strcspn(begin, " [");
            if (begin[0] == '_' && isdigit((unsigned char)begin[1]) && length < sizeof name) {
                memcpy(name, begin, length);
                name[length] = 0;
                snprintf(better, sizeof better, "%s_constant%s", prefix, name);
                char *renamed = replace(text, name, better, true);
                free(text);
                text = renamed;
                line = text;
                continue;
            }
        }
        line = next ? next + 1 : NULL;
    }
    return text;
}

static btf_result finish(char *text, bool known, const char *language, const btf_log *log,
                         char **out_text) {
    if (text && !known) {
        free(text);
        file_say(log, "btf-shader cannot edit the %s that this version of SPIRV-Cross writes", language);
        return BTF_ERROR_INTERNAL;
    }
    if (!text) {
        file_say(log, "out of memory for a shader");
    }
    *out_text = text;
    return text ? BTF_OK : BTF_ERROR_MEMORY;
}

btf_result cross_hlsl(const char *text, const char *prefix, const btf_log *log, char **out_text) {
    char *copy = strdup(text);
    bool known = copy != NULL;
    if (copy) {
        char *entry = strstr(copy, "void comp_main()\n");
        known = entry && cut(copy, "RWByteAddressBuffer ", "\n") &&
                cut(copy, "static uint3 gl_GlobalInvocationID;", "};\n");
        entry = strstr(copy, "void comp_main()\n");
        if (entry) {
            *entry = 0;
        }
        cut(copy, "static const uint3 gl_WorkGroupSize", "\n");
    }
    copy = copy ? name_constants(copy, "static const ", prefix) : NULL;
    return finish(copy, known, "HLSL", log, out_text);
}

/* Copies the text up to `end` and protects every product in it, with the sign of a zero; NULL without memory. Fast
 * math protects none. */
static char *protect_products(const char *text, const char *end) {
    static const struct {
        const char *written, *better;
    } changes[] = {
        {"return fma(l, r, T(0));", "return fma(l, r, T(-0.0));"},
        /* SPIRV-Cross passes over products of a vector and a number (exact.glsl has two). */
        {"float3 r = a * b;", "float3 r = spvFMul(a, float3(b));"},
        {"float4 r = a * b;", "float4 r = spvFMul(a, float4(b));"},
    };
    char *made = strndup(text, (size_t)(end - text));
    if (!made || !strstr(made, changes[0].written)) {
        return made;
    }
    for (size_t i = 0; i < sizeof changes / sizeof *changes && made; i++) {
        char *changed = replace(made, changes[i].written, changes[i].better, false);
        free(made);
        made = changed;
    }
    return made;
}

btf_result cross_msl(const char *text, const char *prefix, const btf_log *log, char **out_text) {
    const char *kernel = strstr(text, "\nkernel void ");
    char *library = kernel ? protect_products(text, kernel) : strdup(text), *made = NULL;
    char upper[64];
    snprintf(upper, sizeof upper, "%s_ENTRY", prefix);
    for (char *c = upper; *c; c++) {
        *c = (char)toupper((unsigned char)*c);
    }
    if (library) {
        made = cross_join(
            (const char *const[]){library, "\n#ifdef ", upper, kernel ? kernel : "", "#endif\n", NULL});
    }
    free(library);
    made = made ? name_constants(made, "constant ", prefix) : NULL;
    return finish(made, kernel != NULL, "Metal's language", log, out_text);
}
