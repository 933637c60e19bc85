/* The translator from GLSL to WGSL, construct by construct: what it writes, and what it refuses.
 *
 * SPDX-License-Identifier: MIT
 */
#include "tests/support/messages.h"
#include "tests/support/test.h"

#include <openbtf/shader.h>

/* GLSL, and lines that its translation must hold in this order, indentation aside. */
typedef struct pair {
    const char *glsl;
    const char *lines[8];
} pair;

/* The next line that is exactly this one, indentation aside; NULL: there is none. */
static const char *find_line(const char *text, const char *line) {
    const size_t length = strlen(line);
    while (text && *text) {
        text += strspn(text, " ");
        const size_t own = strcspn(text, "\n");
        if (own == length && memcmp(text, line, length) == 0) {
            return text + own;
        }
        text += own + (text[own] == '\n');
    }
    return NULL;
}

TEST(constructs_are_translated) {
    static const pair pairs[] = {
        {"float f(float x) { return x * 2.0 + 1.0; }",
         {"fn f(x: f32) -> f32 {", "return x * 2.0f + 1.0f;"}},
        /* Literals keep their type; a cast is by name. */
        {"uint f(int i) { return uint(i) + 0x1Fu; }", {"return u32(i) + 0x1Fu;"}},
        /* Shifts take as many uints as what is shifted has components. */
        {"int f(int a, int b) { return a << b >> 3; }", {"return (a << u32(b)) >> 3u;"}},
        {"uvec3 f(uvec3 a, uint b) { return (a >> b) & 3u; }", {"return (a >> vec3u(b)) & vec3u(3u);"}},
        {"ivec2 f(ivec2 a, int b) { return a >> (b + 1); }", {"return a >> vec2u(u32(b + 1));"}},
        /* A scalar among vectors is repeated where WGSL asks for it, and only there. */
        {"vec2 f(vec2 a) { return min(max(a * 3.0, -1.0), 1.0); }",
         {"return min(max(a * 3.0f, vec2f(-1.0f)), vec2f(1.0f));"}},
        {"vec3 f(uvec2 a, int b) { return vec3(a, b); }", {"return vec3f(vec2f(a), f32(b));"}},
        {"uint f(float x) { return floatBitsToUint(x) ^ 7u; }", {"return bitcast<u32>(x) ^ 7u;"}},
        {"vec3 f(uvec3 x) { return uintBitsToFloat(x); }", {"return bitcast<vec3f>(x);"}},
        /* ?: */
        {"int f(int a) { return a < 0 ? -a : a; }", {"return select(a, -a, (a < 0));"}},
        /* Comparisons that could be read as the brackets of a type. */
        {"bool g(bool a, bool b) { return a; } bool f(int a, int b, int c) { return g(a < b, b > c); }",
         {"return g((a < b), (b > c));"}},
        /* Parameters that are assigned are copied; variables that are not are constants. */
        {"int f(int a) { a += 1; int b = a, c = 0; c = b; return c; }",
         {"fn f(a__given: i32) -> i32 {", "var a: i32 = a__given;", "a += 1;", "let b: i32 = a;",
          "var c: i32 = 0;", "c = b;"}},
        /* An array with an index that varies is copied, too: not every compiler takes it from a value. */
        {"int f(int a[4], int i) { return a[i]; }",
         {"fn f(a__given: array<i32, 4>, i: i32) -> i32 {", "var a: array<i32, 4> = a__given;"}},
        {"int f(int a[4]) { return a[2 + 1]; }", {"fn f(a: array<i32, 4>) -> i32 {", "return a[2 + 1];"}},
        /* Out parameters. A part of a variable is handed over by way of another one. */
        {"void g(out int a, inout ivec2 b) { a = b.x; b.y += 1; } int f() { int a; ivec2 b = ivec2(1); "
         "g(a, b); return a; }",
         {"fn g(a: ptr<function, i32>, b: ptr<function, vec2i>) {", "(*a) = (*b).x;", "(*b).y += 1;",
          "var a: i32;", "var b: vec2i = vec2i(1);", "g(&a, &b);"}},
        {"struct s { int a, b; }; void g(out int a, inout int b) { a = b; } int f() { s x; g(x.a, x.b); "
         "return x.a; }",
         {"var kept__1: i32;", "var kept__2: i32 = x.b;", "g(&kept__1, &kept__2);", "x.a = kept__1;",
          "x.b = kept__2;"}},
        {"void h(inout int a) { a = 1; } void f(inout int a) { h(a); }", {"h(a);"}},
        /* Swizzles are assigned one component at a time. */
        {"uvec4 f(uvec4 a) { a.xy += a.zw; return a; }",
         {"let moved__: vec2u = a.xy + a.zw;", "a.x = moved__.x;", "a.y = moved__.y;"}},
        {"int f() { int a, b; a = b = 3; return a; }", {"b = 3;", "a = b;"}},
        /* Loops. */
        {"int f(int n) { int s = 0; for (int i = 0; i < n; ++i) s += i; return s; }",
         {"for (var i: i32 = 0; i < n; i++) {", "s += i;"}},
        {"int f(int n) { int s = 0; for (int i = 0; i < n; ++i, s += 2) { if (s > 9) continue; } return s; "
         "}",
         {"var i: i32 = 0;", "loop {", "if (!(i < n)) {", "break;", "continue;", "continuing {", "i++;",
          "s += 2;"}},
        {"int f(int n) { int i = 0; do { if (i == 3) break; } while (++i < n); return i; }",
         {"loop {", "if (i == 3) {", "break;", "continuing {", "i++;", "break if !(i < n);"}},
        {"int f(int n) { int i = 0; while (i < n) ++i; return i; }", {"while (i < n) {", "i++;"}},
        {"int f(int a) { if (a == 0) return 1; else if (a == 1) return 2; else return 3; }",
         {"if (a == 0) {", "return 1;", "} else if (a == 1) {", "return 2;", "} else {", "return 3;"}},
        /* Functions that share a name. */
        {"float g(float a) { return a; } vec3 g(vec3 a) { return a; } vec3 f(vec3 a) { return g(a) * "
         "g(a.x); }",
         {"fn g_f32(a: f32) -> f32 {", "fn g_vec3f(a: vec3f) -> vec3f {",
          "return g_vec3f(a) * g_f32(a.x);"}},
        /* Names that WGSL keeps for itself. */
        {"int f(int from, int fn) { int let = from, array = fn; return let + array; }",
         {"fn f(from__: i32, fn__: i32) -> i32 {", "let let__: i32 = from__;", "let array__: i32 = fn__;"}},
        {"struct function { int a; }; int f(int texture_2d) { return texture_2d; }",
         {"struct function__ {", "fn f(texture_2d__: i32) -> i32 {"}},
        /* Names that the translator makes up differ from all names of the text. */
        {"vec2 f(vec2 a) { vec2 moved = a; moved.xy = moved.yx; return moved; }",
         {"var moved: vec2f = a;", "let moved__: vec2f = moved.yx;", "moved.x = moved__.x;"}},
        {"void g(out int a) { a = 1; } int f() { int kept_1 = 2; ivec2 v = ivec2(3); g(v.x); return "
         "kept_1; "
         "}",
         {"let kept_1: i32 = 2;", "var kept__1: i32;", "g(&kept__1);", "v.x = kept__1;", "return kept_1;"}},
        {"int f(int x, int x_given) { x += x_given; return x; }",
         {"fn f(x__given: i32, x_given: i32) -> i32 {", "var x: i32 = x__given;", "x += x_given;"}},
        {"int f(int filter, int filter_) { return filter - filter_; }",
         {"fn f(filter__: i32, filter_: i32) -> i32 {", "return filter__ - filter_;"}},
        /* Textures. */
        {"layout(set = 2, binding = 5) uniform highp usampler2DArray t; uint f(uvec2 x, uint layer) { "
         "return texelFetch(t, ivec3(x, layer), 1).y; }",
         {"@group(2) @binding(5) var t: texture_2d_array<u32>;",
          "return textureLoad(t, vec2i(x), i32(layer), 1).y;"}},
        {"layout(binding = 1) uniform sampler2D t; vec4 f(ivec2 x) { return texelFetch(t, x, 0); } ivec2 "
         "g() { return textureSize(t, 0); }",
         {"@group(0) @binding(1) var t: texture_2d<f32>;", "return textureLoad(t, x, 0);",
          "return vec2i(textureDimensions(t, 0));"}},
        {"layout(binding = 7) uniform highp uint zero; uint f() { return zero; }",
         {"@group(0) @binding(7) var<uniform> zero: u32;"}},
        /* The preprocessor. */
        {"#define ADD(a, b) ((a) + (b))\n#define TWO 2\n#if TWO > 1 && defined(WGSL) && "
         "!defined(OTHER)\nint f(int x) { return ADD(x,\n ADD(TWO, 3)); }\n#else\nno\n#endif\n",
         {"return x + (2 + 3);"}},
        {"#ifdef WGSL\n#if 0\n#if UNKNOWN\n#endif\nno\n#else\nint f() { return __VERSION__; "
         "}\n#endif\n#endif\n",
         {"return 300;"}},
        {"#define f(x) f(x + 1)\nint g(int x) { return x; }\n#undef f\nint h(int f) { return f; }\n",
         {"fn h(f: i32) -> i32 {"}},
        /* A macro goes on in the next line, whichever way lines end. */
        {"#define TWO 1 + \\\n 1\nint f() { return TWO; }\n", {"return 1 + 1;"}},
        {"#define TWO 1 + \\\r\n 1\r\nint f() { return TWO; }\r\n", {"return 1 + 1;"}},
        /* The comment in front of a function stays; precision and `const` need no words. */
        {"precision highp float;\n/* Twice. */\nfloat f(const highp float x) { const int n = 2; float a[n "
         "+ 1]; a[0] = x; return a[0]; }",
         {"/* Twice. */", "fn f(x: f32) -> f32 {", "let n: i32 = 2;", "var a: array<f32, 3>;"}},
    };
    for (size_t i = 0; i < sizeof pairs / sizeof *pairs; ++i) {
        char *text = NULL;
        last_message[0] = 0;
        if (btf_shader_wgsl(pairs[i].glsl, &log_keep, &text) != BTF_OK) {
            fail_msg("%s: %s", pairs[i].glsl, last_message);
        }
        const char *at = text;
        for (size_t line = 0; line < 8 && pairs[i].lines[line]; ++line) {
            at = find_line(at, pairs[i].lines[line]);
            if (!at) {
                fail_msg("%s\ngives\n%swithout \"%s\" where it belongs", pairs[i].glsl, text,
                         pairs[i].lines[line]);
            }
        }
        btf_free(text);
    }
}

TEST(other_glsl_is_refused) {
    static const char *const wrong[][2] = {
        /* The message names the error itself, not one that follows from it. */
        {"float f(float x) { return foo(x, 1.0, x) + 2.0; }",
         "no function that is defined above has this name and these parameters at \"foo\""},
        {"float f(float x) { return x + 1; }", "this operation on these types at \"+\""},
        {"int f(int a) { return b; }", "the name is not declared at \"b\""},
        {"int f(int a) { return a ? 1 : 2; }", "this operation on these types at \"?\""},
        {"vec3 f(vec3 a) { return vec3(a.xy); }", "this operation on these types at \"vec3\""},
        {"int f(ivec2 a) { return a.z; }", "this operation on these types at \"z\""},
        {"int f(int a) { int b = 1.0; return b; }", "of another type than its variable at \"b\""},
        {"mat3 f(vec3 a) { return a; }", "a struct, a uniform or a function is expected"},
        {"uniform sampler2D t;", "the uniform has no binding at \"t\""},
        {"layout(location = 1) uniform int t;", "layout takes set and binding alone"},
        {"precise float f(float a) { return a; }", "a struct, a uniform or a function is expected"},
        {"int f(int a) { return a", "\";\" is expected"},
        {"int f(int a) { if (a > 0) { return a; }", "the block has no closing brace"},
        {"int f(int a) { a; return a; }", "the statement has no effect"},
        {"int f(int a) { return a > 0 ? ++a : a; }", "operand of ?: has a side effect"},
        {"int f(int a) { if (++a > 0) return a; return 1; }", "the condition has a side effect"},
        {"int f(int a) { a <<= 2; return a; }", "which shifts"},
        {"int f(int n) { int a[n]; return 0; }", "the length of an array must be a constant"},
        {"layout(binding = 0) uniform sampler2DArray t; vec4 f(ivec3 x) { return texelFetch(t, x, 0); }",
         "does not name the layer"},
        {"#if\n#endif\n", "the condition is not an integer expression"},
        {"#if 1 +\n#endif\n", "the condition is not an integer expression"},
        {"#if UNKNOWN\n#endif\n", "the condition is not an integer expression"},
        {"#if (1\n#endif\n", "the condition has no closing bracket"},
        {"#if 1 2\n#endif\n", "the condition is followed by other text"},
        {"#if 1\n", "a condition has no #endif"},
        {"#endif\n", "this directive"},
        {"#version 300 es\n", "this directive"},
        {"#define\n", "no name follows #define"},
        {"#define F(a) a\nint f() { return F(1, 2); }\n", "another number of arguments"},
        {"#define F(a) a\nint f() { return F(1", "another number of arguments"},
        {"#define F(a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p) a\nint f() { return F(1, 2, 3, 4, 5, "
         "6, 7, 8, "
         "9, 10, 11, 12, 13, 14, 15, 16, 17); }\n",
         "another number of arguments"},
        {"#if 0\n#elif 1\n#endif\n", "this directive"},
        /* The left side of an assignment may have no side effects. */
        {"int f(int a[4]) { int i = 0; a[++i] = 3; return i; }",
         "named by an expression with a side effect"},
        {"int f(int a[4]) { int i = 0; ++a[++i]; return i; }", "named by an expression with a side effect"},
        {"void g(out int a) { a = 1; } int f(int a[4]) { int i = 0; g(a[++i]); return i; }",
         "named by an expression with a side effect"},
        {"int h(inout int a) { ++a; return a; } int f(int x) { ivec2 v[3]; v[h(x)].xy = ivec2(1); return "
         "x; }",
         "named by an expression with a side effect"},
        {"void f(int a[4], int n) { int j = 0; for (int i = 0; i < n; ++a[++j]) ; }",
         "named by an expression with a side effect"},
        /* Names that the translator makes, and that it would make twice. */
        {"int f(int a__b) { return 1; }", "the name is reserved (it holds __, or is _ alone) at \"a__b\""},
        {"int f() { int moved__ = 1; return moved__; }",
         "the name is reserved (it holds __, or is _ alone) at \"moved__\""},
        {"int f__() { return 1; }", "the name is reserved (it holds __, or is _ alone) at \"f__\""},
        {"struct __s { int a; };", "the name is reserved (it holds __, or is _ alone) at \"__s\""},
        {"struct s { int a__; };", "the name is reserved (it holds __, or is _ alone) at \"a__\""},
        {"layout(binding = 1) uniform uint u__u;",
         "the name is reserved (it holds __, or is _ alone) at \"u__u\""},
        {"int f(int _) { return 1; }", "the name is reserved (it holds __, or is _ alone) at \"_\""},
        {"int g(int a) { return a; } int g(uint a) { return 1; } int g_i32() { return 2; }",
         "the name that the overloaded function would have in WGSL is taken or reserved, at \"g\""},
        {"int g(int a) { return a; } int g(uint a) { return 1; } int f(int g_u32) { return g(g_u32); }",
         "the overloaded function would have"},
        {"struct i32x2 { int a; }; int g(i32x2 a) { return 1; } int g(int a[2]) { return 2; }",
         "the overloaded function would have"},
        {"struct given { int a; }; int x_(given a) { return 1; } int x_(int a) { return 2; }",
         "the overloaded function would have"},
        {"int g(int a) { return a; } int g(int b) { return b; }", "the overloaded function would have"},
        /* Texts that are no GLSL. */
        {"uint f(uint a) { return -a; }", "this operation on these types"},
        {"int f(int a) { return !a; }", "this operation on these types"},
        {"struct s { int a; }; s f(s a) { return -a; }", "this operation on these types"},
        {"bool f(bool a) { ++a; return a; }", "this operation on these types"},
        {"struct 5 { int a; };", "the struct has no name at \"5\""},
        {"void +() {}", "the function has no name at \"+\""},
        {"float f(x) { return 1.0; }", "the parameter has no known type"},
        {"layout(binding = 1) uniform mat3 m;", "the uniform has no known type"},
        {"float f() { return 1.2.3; }", "the number is malformed"},
        {"float f() { return 1e; }", "the number is malformed"},
        {"int f() { return 0x; }", "the number is malformed"},
        {"int f() { return 010; }", "the number is malformed"},
        {"void f(vec3 a) { a.xyz.xy = a.xy; }", "components of components"},
        {"void f(float[3] a[4]) {}", "arrays of arrays"},
        {"int f(int a) { const int b = 1; b = 2; return b; }", "only a variable can be assigned at \"b\""},
        {"int f(int 5) { return 1; }", "a name is expected at \"5\""},
    };
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; ++i) {
        char *text = (char *)wrong;
        last_message[0] = 0;
        if (btf_shader_wgsl(wrong[i][0], &log_keep, &text) != BTF_ERROR_UNSUPPORTED) {
            fail_msg("not refused: %s", wrong[i][0]);
        }
        assert_null(text);
        if (!strstr(last_message, wrong[i][1]) || strncmp(last_message, "shader: WGSL: ", 14) != 0) {
            fail_msg("%s: \"%s\", not \"%s\"", wrong[i][0], last_message, wrong[i][1]);
        }
    }
}

/* Brackets, operators, statements and conditions nested 100,000 deep are refused, before the stack overflows. */
TEST(depth_is_bounded) {
    enum { DEEP = 100000 };
    static const char *const parts[][3] = {
        {"int f(int a) { return ", "(", ""},
        {"int f(int a) { return ", "-", ""},
        {"int f(int a) { return ", "a = ", ""},
        {"int f(int a) { return ", "a < 1 ? ", ""},
        {"int f(int a) { ", "{", ""},
        {"int f(int a) { ", "if (a > 0) ", ""},
        {"int f(int a) { return ", "a[", ""},
        {"int f(int a) { return ", "f(", ""},
        {"#if ", "(", "\n"},
        {"#if ", "!", "\n"},
        {"int f(int a) { return ", "int(", ""},
        {"int f(int a) { ", "if (a > 0) ; else ", ""},
        {"int f() { return 1", "+1", "; }"},
        {"ivec2 f(ivec2 v) { return v", ".xy", "; }"},
        {"#define F(x) x\nint f() { return ", "F(", ""},
    };
    for (size_t i = 0; i < sizeof parts / sizeof *parts; ++i) {
        const size_t length = strlen(parts[i][1]), head = strlen(parts[i][0]);
        char *glsl = malloc(head + DEEP * length + 10), *text = NULL;
        assert_non_null(glsl);
        strcpy(glsl, parts[i][0]);
        for (size_t d = 0; d < DEEP; ++d) {
            memcpy(glsl + head + d * length, parts[i][1], length);
        }
        strcpy(glsl + head + DEEP * length, parts[i][2]);
        if (btf_shader_wgsl(glsl, &log_keep, &text) != BTF_ERROR_UNSUPPORTED) {
            fail_msg("not refused: %s, then %s again and again", parts[i][0], parts[i][1]);
        }
        free(glsl);
    }
}

/* A chain of macros, each of whose bodies is the next macro, is bounded though the text itself is not nested. */
TEST(chains_of_macros_are_bounded) {
    enum { CHAIN = 20000, LINE = 40 };
    char *glsl = malloc((size_t)CHAIN * LINE + 100), *text = NULL;
    assert_non_null(glsl);
    for (int length = 150; length <= CHAIN; length += CHAIN - 150) {
        size_t n = 0;
        for (int i = 0; i < length; ++i) {
            n += (size_t)snprintf(glsl + n, LINE, "#define M%d M%d\n", i, i + 1);
        }
        snprintf(glsl + n, 100, "#define M%d 7\nint f() { return M0; }\n", length);
        const btf_result result = btf_shader_wgsl(glsl, &log_keep, &text);
        if (length == CHAIN) {
            assert_int_equal(result, BTF_ERROR_UNSUPPORTED);
            assert_non_null(strstr(last_message, "macros are nested too deeply"));
        } else {
            assert_int_equal(result, BTF_OK);
            assert_non_null(strstr(text, "return 7;"));
        }
        btf_free(text);
    }
    free(glsl);
}

/* Macros and constants that double 60 times are refused, or calculated once each. */
TEST(doubling_is_bounded) {
    char glsl[4000], *text = NULL;
    size_t n = 0;
    for (int i = 0; i < 60; ++i) {
        n += (size_t)snprintf(glsl + n, sizeof glsl - n, "#define M%d M%d M%d\n", i, i + 1, i + 1);
    }
    snprintf(glsl + n, sizeof glsl - n, "M0\n");
    assert_int_equal(btf_shader_wgsl(glsl, &log_keep, &text), BTF_ERROR_UNSUPPORTED);
    assert_non_null(strstr(last_message, "too many words"));
    n = (size_t)snprintf(glsl, sizeof glsl, "int f(int x[4]) { const int c0 = 0;\n");
    for (int i = 0; i < 60; ++i) {
        n += (size_t)snprintf(glsl + n, sizeof glsl - n, "const int c%d = c%d + c%d;\n", i + 1, i, i);
    }
    snprintf(glsl + n, sizeof glsl - n, "return x[c60]; }\n");
    assert_int_equal(btf_shader_wgsl(glsl, &log_keep, &text), BTF_OK);
    btf_free(text);
}

/* Comments nest in WGSL, so a comment that holds the beginning of another would not end there. */
TEST(comments_that_nest_are_dropped) {
    char *text = NULL;
    assert_int_equal(btf_shader_wgsl("/* One /* two */ int f() { return 1; }", &log_keep, &text), BTF_OK);
    assert_null(strstr(text, "two"));
    btf_free(text);
}

/* The text of the self-test is translated; one line is checked here, and browsers run it (tests/web). */
TEST(the_self_test_is_translated) {
    char *text = NULL;
    assert_int_equal(btf_shader_wgsl(btf_shader_self_test(), &log_keep, &text), BTF_OK);
    assert_non_null(strstr(text, "fn btf_self_test(zero: u32) -> u32 {"));
    assert_non_null(strstr(text, "@group(0) @binding(23) var<uniform> btf_zero: u32;"));
    btf_free(text);
}

RUN_TESTS(NULL, NULL)
