/* Every variant of the library in WGSL: the translator accepts it, and its text is complete, has no word of GLSL left,
 * uses no undeclared name, declares only the textures of its effects, and makes every exact sum and product with the
 * run-time zero. Browsers compile the texts in tests/web/webgpu.
 *
 *     test_wgsl                 every two settings of options meet
 *     test_wgsl --long          every four
 *     test_wgsl --write FOLDER  writes the texts of the first and the list texts.json into a folder that exists
 *
 * SPDX-License-Identifier: MIT
 */
#include "variant_rows.h"

#include <ctype.h>
#include <openbtf/shader.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void print_message(void *user, btf_log_level level, const char *message) {
    (void)user;
    (void)level;
    fprintf(stderr, "%s\n", message);
}

static const btf_log log_print = {.callback = print_message};

static int is_word(char c) {
    return isalnum((unsigned char)c) || c == '_';
}

/* Overwrites comments with spaces. */
static void drop_comments(char *text) {
    for (char *p = text; (p = strstr(p, "/*")) != NULL;) {
        char *end = strstr(p, "*/");
        memset(p, ' ', end ? (size_t)(end + 2 - p) : strlen(p));
    }
}

/* The words of a text, sorted, each once, as offsets and lengths in it. */
typedef struct word {
    const char *text;
    size_t length;
    int is_declared;
} word;

typedef struct words {
    word list[3000];
    size_t count;
} words;

static word *find_word(words *w, const char *text, size_t length) {
    for (size_t i = 0; i < w->count; ++i) {
        if (w->list[i].length == length && memcmp(w->list[i].text, text, length) == 0) {
            return &w->list[i];
        }
    }
    if (w->count == sizeof w->list / sizeof *w->list) {
        fprintf(stderr, "more words than the test has room for\n");
        exit(4);
    }
    w->list[w->count] = (word){.text = text, .length = length};
    return &w->list[w->count++];
}

/* Words of WGSL that texts of the library may have. */
static const char known[] = " abs array binding bitcast bool break clamp const continue continuing dot "
                            "else exp2 f32 false floor fn for function "
                            "group i32 if let log2 loop max min ptr return select struct textureDimensions "
                            "textureLoad texture_2d texture_2d_array "
                            "true u32 uniform var vec2f vec2i vec2u vec3f vec3i vec3u vec4f vec4i vec4u "
                            "while x y z w xy xz zw yz xyz yzx zxy xyx yyy yzw ";

static int is_known(const word *w) {
    for (const char *p = known; (p = strstr(p + 1, " ")) != NULL && p[1];) {
        if (strncmp(p + 1, w->text, w->length) == 0 && p[1 + w->length] == ' ') {
            return 1;
        }
    }
    return strncmp(known + 1, w->text, w->length) == 0 && known[1 + w->length] == ' ';
}

/* Counts undeclared words: those that nowhere precede a colon or follow `fn`, `let`, `var` or `struct`. */
static int undeclared(const char *text) {
    static words w;
    int wrong = 0;
    w.count = 0;
    const char *before = "";
    size_t before_length = 0;
    for (const char *p = text; *p;) {
        if (!is_word(*p)) {
            ++p;
            continue;
        }
        const char *begin = p;
        while (is_word(*p)) {
            ++p;
        }
        if (isdigit((unsigned char)*begin)) {
            continue;
        }
        word *found = find_word(&w, begin, (size_t)(p - begin));
        static const char *const declaring[] = {"fn", "struct", "let", "var", "uniform"};
        for (size_t i = 0; i < sizeof declaring / sizeof *declaring; ++i) {
            found->is_declared |=
                before_length == strlen(declaring[i]) && strncmp(before, declaring[i], before_length) == 0;
        }
        found->is_declared |= *p == ':'; /* a parameter or member */
        before = begin;
        before_length = (size_t)(p - begin);
    }
    for (size_t i = 0; i < w.count; ++i) {
        if (!w.list[i].is_declared && !is_known(&w.list[i])) {
            fprintf(stderr, "%.*s is not declared\n", (int)w.list[i].length, w.list[i].text);
            ++wrong;
        }
    }
    return wrong;
}

/* Counts brackets that do not close, and characters that WGSL does not have. */
static int unbalanced(const char *text) {
    char open[100];
    size_t depth = 0;
    for (const char *p = text; *p; ++p) {
        const char *opens = strchr("({[", *p), *closes = strchr(")}]", *p);
        if (opens && depth < sizeof open) {
            open[depth++] = ")}]"[opens - "({["];
        } else if (closes && (depth == 0 || open[--depth] != *closes)) {
            fprintf(stderr, "a %c closes nothing\n", *closes);
            return 1;
        } else if (*p == '?' || *p == '#') {
            fprintf(stderr, "%c is left\n", *p);
            return 1;
        }
    }
    if (depth) {
        fprintf(stderr, "%zu brackets are left open\n", depth);
    }
    return depth > 0;
}

/* Checks that `part` occurs `times` times in the text. */
static int counted(const char *text, const char *part, size_t times) {
    size_t n = 0;
    for (const char *p = text; (p = strstr(p, part)) != NULL; p += strlen(part)) {
        ++n;
    }
    if (n != times) {
        fprintf(stderr, "\"%s\" stands there %zu times, not %zu\n", part, n, times);
    }
    return n != times;
}

/* Products and sums of floats occur in btf_mul and btf_add alone, each XORed with the run-time zero; fast math has no
 * such functions. */
static int check_protection(const char *text, const uint8_t *row) {
    const size_t times = row[FAST] ? 0 : 1;
    return counted(text, "bitcast<f32>(bitcast<u32>(a * b) ^ btf_zero)", times) +
           counted(text, "bitcast<f32>(bitcast<u32>(a + b) ^ btf_zero)", times) +
           counted(text, "bitcast<vec3f>(bitcast<vec3u>(a * b) ^ vec3u(btf_zero))", 2 * times) +
           counted(text, "bitcast<vec3f>(bitcast<vec3u>(a + b) ^ vec3u(btf_zero))", times) +
           counted(text, "bitcast<vec4f>(bitcast<vec4u>(a * b) ^ vec4u(btf_zero))", 2 * times) +
           counted(text, "@group(0) @binding(23) var<uniform> btf_zero: u32;", times);
}

/* Textures are declared where their effect is decoded, with the number of their kind. */
static int check_textures(const char *text, const uint8_t *row) {
    const int tight = row[LAYOUT] == 1, codes = row[SHIFT] || row[HIDDEN] == 2;
    const struct {
        const char *declaration;
        int present;
    } textures[] = {
        {"@binding(0) var btf_sbrdf: texture_2d_array<f32>;", row[COLOUR] != 2},
        {"@binding(2) var btf_shadow: texture_2d_array<u32>;", tight && row[SHADOW] && row[COLOUR] != 2},
        {"@binding(3) var btf_shift: texture_2d_array<u32>;", tight && !row[POINTS] && codes},
        {"@binding(5) var btf_centres: texture_2d<u32>;", tight && row[HIDDEN] == 2},
        {"@binding(6) var btf_residual_texels: texture_2d_array<i32>;",
         row_components(row) > 0 && !row_has_factors(row)},
        {"@binding(9) var btf_view_table: texture_2d<u32>;", 1},
        {"@binding(12) var btf_factor_directions: texture_2d_array<u32>;", row_has_factors(row)},
        {"@binding(13) var btf_factor_scales: texture_2d<f32>;", row_has_factors(row)},
        {"@binding(17) var btf_point_indices: texture_2d_array<u32>;",
         row[POINTS] == 2 && (row[SHIFT] || row[GAIN])},
        {"@binding(18) var btf_heights: texture_2d<u32>;", row[RELIEF] > 1},
        {"@binding(19) var btf_view_vectors: texture_2d<f32>;", row[RELIEF] || row[GLOSS]},
    };
    int wrong = 0;
    for (size_t i = 0; i < sizeof textures / sizeof *textures; ++i) {
        wrong += counted(text, textures[i].declaration, (size_t)textures[i].present);
    }
    return wrong;
}

/* The library behind macros, in WGSL; NULL where the translator refuses it. */
static void translate(const char *macros, char **out_text) {
    const char *library = btf_shader_library();
    const size_t size = strlen(macros) + strlen(library) + 1;
    char *glsl = malloc(size);
    if (!glsl) {
        exit(4);
    }
    snprintf(glsl, size, "%s%s", macros, library);
    btf_shader_wgsl(glsl, &log_print, out_text);
    free(glsl);
}

/* Options that rows do not have, in front of the macros of a plain row, and what the text then has. */
typedef struct extra {
    const char *macros, *part;
    uint8_t relief;
} extra;

static const extra extras[] = {
    {"#define BTF_FOLDED 1\n#define BTF_N_VIEWS 81u\n",
     "fn btf_evaluate_folded(uv: vec2f, v: vec3f, light: i32, level: i32) -> vec3f {", 0},
    {"#define BTF_FOLDED 2\n", "@group(0) @binding(20) var btf_folded: texture_2d_array<u32>;", 0},
    {"#define BTF_FOLDED 3\n",
     "return bitcast<vec3f>(textureLoad(btf_folded, vec2i(x), layer, level).xyz);", 2},
    {"#define BTF_FOLDED 4\n#define BTF_BLEND_ROOTS 1\n#define BTF_N_VIEWS 81u\n",
     "fn btf_folded_pair(x: vec2u, layer: i32, level: i32, views: vec2u, own: vec2u, weight: vec2u) -> "
     "vec3f {",
     0},
    {"#define BTF_SAMPLING 1\n",
     "fn btf_sample_light(uv: vec2f, v: vec3f, u1: u32, u2: u32, pdf: ptr<function, f32>) -> vec3f {", 0},
    {"#define BTF_FIXED_VIEW 3\n#define BTF_FIXED_VIEW_INDEX uvec3(7u, 5u, 6u)\n"
     "#define BTF_FIXED_VIEW_WEIGHT uvec3(2000u, 1000u, 1096u)\n#define BTF_FIXED_LIGHT 1\n"
     "#define BTF_FIXED_LIGHT_INDEX uvec3(3u)\n#define BTF_FIXED_LIGHT_WEIGHT uvec3(4096u, 0u, 0u)\n",
     "(*s).views = btf_neighbours(vec3u(7u, 5u, 6u), vec3u(2000u, 1000u, 1096u));", 0},
};
enum { EXTRAS = sizeof extras / sizeof *extras };

static void extra_macros(const extra *e, char *out) {
    const uint8_t row[PAIRWISE_FACTORS] = {[LAYOUT] = 1, [COLOUR] = 2, [RELIEF] = e->relief};
    const size_t length = strlen(e->macros);
    memcpy(out, e->macros, length);
    row_macros(row, out + length);
}

static int check_extra(const extra *e) {
    const uint8_t exact[PAIRWISE_FACTORS] = {0};
    char macros[2 * ROW_MACROS];
    extra_macros(e, macros);
    char *text;
    translate(macros, &text);
    if (!text) {
        return 1;
    }
    drop_comments(text);
    const int wrong =
        unbalanced(text) + undeclared(text) + check_protection(text, exact) + counted(text, e->part, 1);
    if (wrong) {
        fprintf(stderr, "with\n%s", e->macros);
    }
    btf_free(text);
    return wrong;
}

/* Returns how many things are wrong with one variant. */
static int check_variant(const uint8_t *row) {
    static const char *const functions[] = {
        "fn btf_evaluate(uv: vec2f, l: vec3f, v: vec3f) -> vec3f {",
        "fn btf_evaluate_stochastic(uv: vec2f, l: vec3f, v: vec3f, random: vec3u) -> vec3f {"};
    char macros[ROW_MACROS];
    row_macros(row, macros);
    char *text;
    translate(macros, &text);
    int wrong = !text;
    if (text) {
        drop_comments(text);
        wrong = unbalanced(text) + undeclared(text) + check_protection(text, row) +
                check_textures(text, row) + counted(text, functions[row[PICKS] > 0], 1);
    }
    if (wrong) {
        fprintf(stderr, "levels");
        for (int f = 0; f < FACTORS; ++f) {
            fprintf(stderr, " %d", row[f]);
        }
        fprintf(stderr, "\n");
    }
    btf_free(text);
    return wrong;
}

/* Breaks texts and requires that the checks of this file notice. */
static int check_checks(const uint8_t *row) {
    char macros[ROW_MACROS];
    row_macros(row, macros);
    char *text;
    translate(macros, &text);
    if (!text) {
        return 1;
    }
    drop_comments(text);
    fprintf(stderr, "Complaints that are meant to be seen:\n");
    char *product = strstr(text, "^ btf_zero"), *name = strstr(text, "btf_lookup("),
         *brace = strrchr(text, '}'), *texture = strstr(text, "var btf_view_table: texture_2d<u32>;");
    if (!product || !name || !brace || !texture) {
        fprintf(stderr, "a text without a product, a lookup, a brace or a table of views\n");
        btf_free(text);
        return 1;
    }
    product[0] = '+';
    int noticed = check_protection(text, row) > 0;
    name[4] = 'L'; /* the declaration, so that calls name nothing */
    noticed += undeclared(text) > 0;
    *brace = ' ';
    noticed += unbalanced(text) > 0;
    *brace = ']';
    noticed += unbalanced(text) > 0;
    *brace = '?';
    noticed += unbalanced(text) > 0;
    texture[4] = 'B';
    noticed += check_textures(text, row) > 0;
    btf_free(text);
    fprintf(stderr, "These were. Noticed: %d of 6\n", noticed);
    return noticed != 6;
}

static int write_text(const char *folder, size_t number, const char *macros) {
    char path[4096];
    char *text;
    translate(macros, &text);
    snprintf(path, sizeof path, "%s/%zu.wgsl", folder, number);
    FILE *file = text ? fopen(path, "w") : NULL;
    int written = file && fputs(text, file) >= 0;
    written = file && fclose(file) == 0 && written;
    btf_free(text);
    if (!written) {
        fprintf(stderr, "%s: not written\n", path);
    }
    return written;
}

/* Writes the texts of all rows and extras, for compilers of WGSL. */
static int write_texts(const char *folder, size_t count, uint8_t (*rows)[PAIRWISE_FACTORS]) {
    char path[4096], macros[2 * ROW_MACROS];
    snprintf(path, sizeof path, "%s/texts.json", folder);
    FILE *list = fopen(path, "w");
    int written = list != NULL;
    for (size_t i = 0; written && i < count + EXTRAS; ++i) {
        if (i < count) {
            row_macros(rows[i], macros);
        } else {
            extra_macros(&extras[i - count], macros);
        }
        written = write_text(folder, i, macros) && fprintf(list, "%s\"%zu.wgsl\"", i ? ", " : "[", i) > 0;
    }
    written = list && fputs("]\n", list) >= 0 && written;
    written = list && fclose(list) == 0 && written;
    if (!written) {
        fprintf(stderr, "%s: not written\n", path);
        return 1;
    }
    printf("%zu texts written\n", count + EXTRAS);
    return 0;
}

int main(int argc, char **argv) {
    enum { MOST = 2000 };
    static uint8_t rows[MOST][PAIRWISE_FACTORS];
    const int many = argc > 1 && strcmp(argv[1], "--long") == 0;
    const size_t count = many ? rows_of_fours(MOST, rows) : rows_of_pairs(MOST, rows);
    if (count == 0 || count == MOST) {
        fprintf(stderr, "rows: no memory for them, or more than %d\n", MOST);
        return 1;
    }
    if (argc > 2 && strcmp(argv[1], "--write") == 0) {
        return write_texts(argv[2], count, rows);
    }
    size_t exact = 0;
    while (rows[exact][FAST] && exact + 1 < count) {
        ++exact;
    }
    int wrong = check_checks(rows[exact]);
    for (size_t i = 0; i < count && wrong < 10; ++i) {
        wrong += check_variant(rows[i]);
    }
    for (size_t i = 0; i < EXTRAS; ++i) {
        wrong += check_extra(&extras[i]);
    }
    printf("%zu variants in WGSL, %d wrong\n", count + EXTRAS, wrong);
    return wrong > 0;
}
