/* The types of GLSL that the decoder uses, and of what its operators and functions give.
 *
 * SPDX-License-Identifier: MIT
 */
#include "types.h"

#include <string.h>

btfi_type btfi_type_of(btfi_base base, unsigned size) {
    return (btfi_type){.base = (uint8_t)base, .size = (uint8_t)size};
}

btfi_type btfi_named_type(const btfi_token *name) {
    static const struct {
        const char *name;
        uint8_t base, size, of;
    } types[] = {
        {"void", BTFI_VOID, 1, 0},
        {"bool", BTFI_BOOL, 1, 0},
        {"int", BTFI_INT, 1, 0},
        {"ivec2", BTFI_INT, 2, 0},
        {"ivec3", BTFI_INT, 3, 0},
        {"ivec4", BTFI_INT, 4, 0},
        {"uint", BTFI_UINT, 1, 0},
        {"uvec2", BTFI_UINT, 2, 0},
        {"uvec3", BTFI_UINT, 3, 0},
        {"uvec4", BTFI_UINT, 4, 0},
        {"float", BTFI_FLOAT, 1, 0},
        {"vec2", BTFI_FLOAT, 2, 0},
        {"vec3", BTFI_FLOAT, 3, 0},
        {"vec4", BTFI_FLOAT, 4, 0},
        {"sampler2D", BTFI_TEXTURE, 2, BTFI_FLOAT},
        {"isampler2D", BTFI_TEXTURE, 2, BTFI_INT},
        {"usampler2D", BTFI_TEXTURE, 2, BTFI_UINT},
        {"sampler2DArray", BTFI_TEXTURE, 3, BTFI_FLOAT},
        {"isampler2DArray", BTFI_TEXTURE, 3, BTFI_INT},
        {"usampler2DArray", BTFI_TEXTURE, 3, BTFI_UINT},
    };
    for (size_t i = 0; i < sizeof types / sizeof *types; ++i) {
        if (btfi_token_is(name, types[i].name)) {
            return (btfi_type){.base = types[i].base, .size = types[i].size, .of = types[i].of};
        }
    }
    return (btfi_type){0};
}

int btfi_types_equal(btfi_type a, btfi_type b) {
    return a.base == b.base && a.size == b.size && a.of == b.of && a.count == b.count;
}

int btfi_is_plain(btfi_type t) {
    return t.count == 0 && t.size > 0 && t.base >= BTFI_BOOL && t.base <= BTFI_FLOAT;
}

int btfi_compares(const btfi_token *mark) {
    return btfi_token_is(mark, "==") || btfi_token_is(mark, "!=") || btfi_token_is(mark, "<") ||
           btfi_token_is(mark, ">") || btfi_token_is(mark, "<=") || btfi_token_is(mark, ">=");
}

int btfi_arithmetic(char mark, int64_t a, int64_t b, int64_t *out_value) {
    const uint64_t x = (uint64_t)a, y = (uint64_t)b;
    switch (mark) {
    case '+':
        *out_value = (int64_t)(x + y);
        return 1;
    case '-':
        *out_value = (int64_t)(x - y);
        return 1;
    case '*':
        *out_value = (int64_t)(x * y);
        return 1;
    case '/':
        *out_value = b == 0 ? 0 : b == -1 ? (int64_t)(0 - x) : a / b;
        return b != 0;
    case '%':
        *out_value = b == 0 || b == -1 ? 0 : a % b;
        return b != 0;
    default:
        return 0;
    }
}

btfi_type btfi_binary_type(const btfi_token *mark, btfi_type a, btfi_type b) {
    const btfi_type none = {0}, boolean = btfi_type_of(BTFI_BOOL, 1);
    if (!btfi_is_plain(a) || !btfi_is_plain(b)) {
        return none;
    }
    if (btfi_compares(mark)) {
        return btfi_types_equal(a, b) && a.size == 1 ? boolean : none;
    }
    if (btfi_token_is(mark, "&&") || btfi_token_is(mark, "||")) {
        return btfi_types_equal(a, boolean) && btfi_types_equal(b, boolean) ? boolean : none;
    }
    const int integers =
        (a.base == BTFI_INT || a.base == BTFI_UINT) && (b.base == BTFI_INT || b.base == BTFI_UINT);
    if (mark->length >= 2 && (mark->text[0] == '<' || mark->text[0] == '>')) {
        return integers && (b.size == 1 || b.size == a.size) ? a : none;
    }
    const int for_integers =
        mark->text[0] == '%' || mark->text[0] == '&' || mark->text[0] == '|' || mark->text[0] == '^';
    if (a.base != b.base || a.base == BTFI_BOOL || (for_integers && !integers) ||
        (a.size != b.size && a.size != 1 && b.size != 1)) {
        return none;
    }
    return a.size >= b.size ? a : b;
}

/* By the number of arguments, and what a function gives: */
enum gives {
    FIRST,  /* the type of the first argument, which the others have or of which they are a component */
    BITS,   /* the first's, of another base */
    SCALAR, /* a component of the first */
    TEXEL,  /* four values of a texture */
    EXTENT, /* columns and rows of a texture */
};
static const struct {
    const char *name;
    uint8_t count, gives, from, to;
} builtins[] = {
    {"abs", 1, FIRST, 0, 0},
    {"floor", 1, FIRST, BTFI_FLOAT, 0},
    {"log2", 1, FIRST, BTFI_FLOAT, 0},
    {"exp2", 1, FIRST, BTFI_FLOAT, 0},
    {"min", 2, FIRST, 0, 0},
    {"max", 2, FIRST, 0, 0},
    {"clamp", 3, FIRST, 0, 0},
    {"dot", 2, SCALAR, BTFI_FLOAT, 0},
    {"floatBitsToUint", 1, BITS, BTFI_FLOAT, BTFI_UINT},
    {"floatBitsToInt", 1, BITS, BTFI_FLOAT, BTFI_INT},
    {"uintBitsToFloat", 1, BITS, BTFI_UINT, BTFI_FLOAT},
    {"intBitsToFloat", 1, BITS, BTFI_INT, BTFI_FLOAT},
    {"texelFetch", 3, TEXEL, 0, 0},
    {"textureSize", 2, EXTENT, 0, 0},
};

int btfi_is_builtin(const btfi_token *name) {
    for (size_t i = 0; i < sizeof builtins / sizeof *builtins; ++i) {
        if (btfi_token_is(name, builtins[i].name)) {
            return 1;
        }
    }
    return 0;
}

int btfi_keeps_bits(const btfi_token *name) {
    for (size_t i = 0; i < sizeof builtins / sizeof *builtins; ++i) {
        if (btfi_token_is(name, builtins[i].name)) {
            return builtins[i].gives == BITS;
        }
    }
    return 0;
}

static btfi_type texture_function(int gives, const btfi_type *arguments) {
    const btfi_type whole = btfi_type_of(BTFI_INT, 1), t = arguments[0];
    if (t.base != BTFI_TEXTURE) {
        return (btfi_type){0};
    }
    if (gives == EXTENT) {
        return t.size == 2 && btfi_types_equal(arguments[1], whole) ? btfi_type_of(BTFI_INT, 2)
                                                                    : (btfi_type){0};
    }
    return btfi_types_equal(arguments[1], btfi_type_of(BTFI_INT, t.size)) &&
                   btfi_types_equal(arguments[2], whole)
               ? btfi_type_of((btfi_base)t.of, 4)
               : (btfi_type){0};
}

btfi_type btfi_builtin_type(const btfi_token *name, const btfi_type *arguments, size_t count) {
    const btfi_type none = {0};
    for (size_t i = 0; i < sizeof builtins / sizeof *builtins; ++i) {
        if (!btfi_token_is(name, builtins[i].name)) {
            continue;
        }
        if (count != builtins[i].count) {
            return none;
        }
        if (builtins[i].gives >= TEXEL) {
            return texture_function(builtins[i].gives, arguments);
        }
        const btfi_type first = arguments[0];
        if (!btfi_is_plain(first) || first.base == BTFI_BOOL ||
            (builtins[i].from && first.base != builtins[i].from)) {
            return none;
        }
        for (size_t a = 1; a < count; ++a) {
            if (arguments[a].base != first.base || arguments[a].count ||
                (arguments[a].size != first.size && arguments[a].size != 1)) {
                return none;
            }
        }
        return builtins[i].gives == FIRST    ? first
               : builtins[i].gives == SCALAR ? btfi_type_of((btfi_base)first.base, 1)
                                             : btfi_type_of((btfi_base)builtins[i].to, first.size);
    }
    return none;
}
