/* Names and types as WGSL writes them.
 *
 * SPDX-License-Identifier: MIT
 */
#include "names.h"

#include "types.h"

#include <stdlib.h>
#include <string.h>

/* Keywords and reserved words of WGSL (WebGPU Shading Language, sections 15.1 and 15.2) that GLSL leaves free, and the
 * predeclared names that a translated text uses: a variable of such a name would hide them. A space
 * stands before and behind each. */
static const char taken[] =
    " "
    "NULL Self abstract alias alignas alignof array as asm async auto await become bitcast bool "
    "cast catch class co_await co_return co_yield common compile concept const_assert const_cast "
    "consteval constexpr constinit continuing crate debugger decltype delete demote diagnostic "
    "dynamic_cast enable enum explicit export extends extern external f16 f32 fallthrough filter "
    "final finally fn friend from function fxgroup get goto groupshared i32 impl implements import inline "
    "instanceof interface let loop macro macro_rules match meta mod module move mut mutable "
    "namespace new nil noexcept noinline null nullptr of operator override package packoffset "
    "pass patch pixelfragment premerge priv protected ptr pub public ref regardless register "
    "reinterpret_cast require requires resource restrict select self set sizeof snorm static "
    "static_assert static_cast std subroutine super target template textureDimensions "
    "textureLoad texture_2d texture_2d_array this thread_local throw trait try type typedef typeid "
    "typename typeof u32 union "
    "unless unorm unsafe unsized use using var vec2f vec2i vec2u vec3f vec3i vec3u vec4f vec4i "
    "vec4u virtual wgsl where with yield ";

void btfi_write_name(btfi_growing *out, const btfi_token *name) {
    int is_taken = btfi_is_builtin(name);
    for (const char *p = taken; !is_taken && p[1]; p += 1 + strcspn(p + 1, " ")) {
        is_taken = strncmp(p + 1, name->text, name->length) == 0 && p[1 + name->length] == ' ';
    }
    btfi_append(out, name->text, name->length);
    btfi_append(out, "__", is_taken ? 2 : 0);
}

void btfi_write_type(btfi_growing *out, const btfi_tree *tree, btfi_type type) {
    static const char *const scalars[] = {"void", "bool", "i32", "u32", "f32"};
    if (type.count) {
        const uint32_t count = type.count;
        type.count = 0;
        btfi_append(out, "array<", 6);
        btfi_write_type(out, tree, type);
        btfi_print(out, ", %u>", count);
    } else if (type.base == BTFI_STRUCT) {
        btfi_write_name(out, &tree->structs[type.of].name);
    } else if (type.base == BTFI_TEXTURE) {
        btfi_print(out, "texture_2d%s<%s>", type.size == 3 ? "_array" : "", scalars[type.of]);
    } else if (type.size == 1) {
        btfi_print(out, "%s", scalars[type.base]);
    } else if (type.base == BTFI_BOOL) {
        btfi_print(out, "vec%u<bool>", type.size);
    } else {
        btfi_print(out, "vec%u%c", type.size, scalars[type.base][0]);
    }
}

/* A type as part of a name. */
static void write_suffix(btfi_growing *out, const btfi_tree *tree, btfi_type type) {
    const uint32_t count = type.count;
    type.count = 0;
    btfi_append(out, "_", 1);
    if (type.base == BTFI_TEXTURE) {
        btfi_print(out, "texture%u", type.of * 4u + type.size);
    } else {
        btfi_write_type(out, tree, type);
    }
    if (count) {
        btfi_print(out, "x%u", count);
    }
}

void btfi_write_function_name(btfi_growing *out, const btfi_tree *tree, const btfi_function *f) {
    btfi_write_name(out, &f->name);
    for (uint32_t i = 0; f->is_overloaded && i < f->count; ++i) {
        write_suffix(out, tree, tree->symbols[f->first + i].type);
    }
}

/* A name that the translation has, or of which its own is made. */
typedef struct known_name {
    const char *text;
    size_t length;
    const btfi_function *of; /* of an overloaded function; NULL: a name as the text has it */
} known_name;

static int compare_names(const void *first, const void *second) {
    const known_name *a = first, *b = second;
    const int order = memcmp(a->text, b->text, a->length < b->length ? a->length : b->length);
    return order ? order : (a->length > b->length) - (a->length < b->length);
}

static const btfi_function *clash_among(known_name *list, size_t count) {
    qsort(list, count, sizeof *list, compare_names);
    for (size_t i = 0; i < count; ++i) {
        const known_name *n = &list[i];
        for (size_t c = 0; n->of && c + 1 < n->length; ++c) {
            if (n->text[c] == '_' && n->text[c + 1] == '_') {
                return n->of;
            }
        }
        if (i > 0 && compare_names(n - 1, n) == 0 && (n->of || n[-1].of)) {
            return n->of ? n->of : n[-1].of;
        }
    }
    return NULL;
}

int btfi_find_clash(const btfi_tree *tree, const btfi_function **out_function) {
    const size_t most = (size_t)tree->n_symbols + tree->n_structs + tree->n_functions;
    known_name *list = malloc((most + 1) * sizeof *list);
    btfi_growing made = {0};
    size_t count = 0, at = 0;
    *out_function = NULL;
    if (!list) {
        return 0;
    }
    for (uint32_t i = 0; i < tree->n_symbols; ++i) {
        const btfi_token *name = &tree->symbols[i].name;
        list[count++] = (known_name){.text = name->text, .length = name->length};
    }
    for (uint32_t i = 0; i < tree->n_structs; ++i) {
        const btfi_token *name = &tree->structs[i].name;
        list[count++] = (known_name){.text = name->text, .length = name->length};
    }
    for (uint32_t i = 0; i < tree->n_functions; ++i) {
        const btfi_function *f = &tree->functions[i];
        const size_t before = made.length;
        if (f->is_overloaded) {
            btfi_write_function_name(&made, tree, f);
        }
        list[count++] = (known_name){.text = f->name.text,
                                     .length = f->is_overloaded ? made.length - before : f->name.length,
                                     .of = f->is_overloaded ? f : NULL};
    }
    for (size_t i = 0; i < count && !made.failed; ++i) { /* where they lie, now that no more is made */
        if (list[i].of) {
            list[i].text = made.data + at;
            at += list[i].length;
        }
    }
    *out_function = made.failed ? NULL : clash_among(list, count);
    const int done = !made.failed;
    free(made.data);
    free(list);
    return done;
}
