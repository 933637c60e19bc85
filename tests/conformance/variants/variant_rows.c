/* Variants of the decoder's text: the macros that choose them, and rows of settings in which they meet.
 *
 * SPDX-License-Identifier: MIT
 */
#include "variant_rows.h"

#include <stdio.h>
#include <string.h>

static const uint8_t levels[FACTORS] = {2, 2, 3, 4, 2, 2, 3, 2, 4, 2, 2, 2, 3, 2, 3, 4, 3, 2, 4};
static const int components[] = {0, 1, 6, 16};

/* Of each class units, words of C1 and of C2, of the stores after the first. */
static const int classes[][5][3] = {
    {{1, 1, 2}, {2, 1, 3}, {3, 0, 1}, {1, 0, 0}, {2, 4, 4}},
    {{0, 0, 0}, {2, 0, 0}, {0, 0, 0}, {0, 0, 0}, {9, 3, 2}},
};

int row_components(const uint8_t *row) {
    return components[row[COMPONENTS]];
}

int row_has_factors(const uint8_t *row) {
    return row[STORE] > 0 && components[row[COMPONENTS]] > 0;
}

/* The names that the library defines for a material of version 2. */
static void write_version_2(char *out, size_t size, const uint8_t *row) {
    size_t at =
        (size_t)snprintf(out, size, "%s#define BTF_POINTS %d\n%s",
                         row[ROOTS] && row[DOMAIN] ? "#define BTF_BLEND_ROOTS 1\n" : "", row[POINTS],
                         row[POINTS] ? "#define BTF_GAIN_BASE 0.25\n#define BTF_GAIN_STEP 0.125\n" : "");
    if (row[RELIEF]) {
        at += (size_t)snprintf(
            out + at, size - at,
            "#define BTF_RELIEF %d\n#define BTF_RELIEF_BASE (-300)\n#define BTF_RELIEF_STEP 900\n"
            "#define BTF_RELIEF_STEPS 8\n%s",
            row[RELIEF] == 1 ? 1 : 2, row[RELIEF] == 3 ? "#define BTF_RELIEF_END 2\n" : "");
    }
    if (row[GLOSS]) {
        at += (size_t)snprintf(out + at, size - at, "#define BTF_GLOSS %d\n", row[GLOSS]);
    }
    if (row[STEEP]) {
        at += (size_t)snprintf(out + at, size - at, "#define BTF_STEEP %d\n", row[BILINEAR]);
    }
    if (!row_has_factors(row)) {
        return;
    }
    const int(*of)[3] = classes[row[STORE] - 1];
    at += (size_t)snprintf(out + at, size - at, "#define BTF_FACTORS 1\n#define BTF_HORIZON_SCALE 3.75\n");
    for (int c = 0; c < 5; ++c) {
        at += (size_t)snprintf(
            out + at, size - at,
            "#define BTF_FACTOR_UNITS_%d %d\n#define BTF_FACTOR_C1_%d %d\n#define BTF_FACTOR_C2_%d %d\n", c,
            of[c][0], c, of[c][1], c, of[c][2]);
    }
}

static void write_options(char *out, size_t size, const uint8_t *row) {
    int colour = row[COLOUR];
    snprintf(
        out, size,
        "#define BTF_LAYOUT_TIGHT %d\n#define BTF_DOMAIN_SQRT %d\n#define BTF_COLOUR %d\n#define BTF_LOBES "
        "%d\n"
        "#define BTF_SHADOW %d\n#define BTF_SHIFT %d\n#define BTF_HIDDEN %d\n#define BTF_CODE_ZERO %d\n"
        "#define BTF_GAIN %d\n#define BTF_COMPONENTS %d\n#define BTF_NEAREST %d\n#define BTF_BILINEAR %d\n"
        "#define BTF_FAST_MATH %d\n#define BTF_STOCHASTIC %d\n"
        "#define BTF_WIDTH 64u\n#define BTF_HEIGHT 48u\n#define BTF_LEVELS 3u\n#define BTF_N_LIGHTS "
        "81u\n#define BTF_VIEW_GRID "
        "16u\n"
        "#define BTF_LIGHT_GRID 8u\n#define BTF_ATLAS_WIDTH 1024u\n#define BTF_ATLAS_HEIGHT 512u\n"
        "#define BTF_TILES 81u\n#define BTF_CENTRE_ROWS 100u\n"
        "#define BTF_RADIANCE_SCALE 1.0\n#define BTF_SHADOW_SCALE uintBitsToFloat(0x35808081u)\n"
        "#define BTF_GAIN_SCALE 0.0078125\n#define BTF_CENTRE_SCALE uintBitsToFloat(0x35808081u)\n",
        row[LAYOUT], row[DOMAIN], colour, colour == 2 ? 0 : 1 + row[LOBES], colour == 2 ? 0 : row[SHADOW],
        row[SHIFT], row[HIDDEN] == 2, row[HIDDEN] > 0, row[GAIN], components[row[COMPONENTS]], row[NEAREST],
        row[BILINEAR], row[FAST], row[PICKS]);
}

void row_macros(const uint8_t *row, char *out) {
    write_options(out, ROW_MACROS, row);
    write_version_2(out + strlen(out), ROW_MACROS - strlen(out), row);
}

size_t rows_of_pairs(size_t most, uint8_t (*rows)[PAIRWISE_FACTORS]) {
    /* All pairs without packed points, then with them: these allow one layout and no hidden points. */
    uint8_t fewer[FACTORS];
    memcpy(fewer, levels, sizeof fewer);
    fewer[POINTS] = fewer[RELIEF] = fewer[GLOSS] = fewer[STEEP] = 1;
    size_t count = pairwise_rows(1, FACTORS, fewer, most, rows);
    fewer[LAYOUT] = fewer[HIDDEN] = 1;
    fewer[POINTS] = 2;
    const size_t more = pairwise_rows(2, FACTORS, fewer, most - count, rows + count);
    for (size_t i = 0; i < more; ++i, ++count) {
        rows[count][LAYOUT] = 1;
        rows[count][POINTS]++; /* packed, or in lists */
    }
    /* Then relief, gloss and the steep filter. */
    memcpy(fewer, levels, sizeof fewer);
    fewer[LAYOUT] = fewer[LOBES] = 1;
    const size_t last = pairwise_rows(3, FACTORS, fewer, most - count, rows + count);
    for (size_t i = 0; i < last; ++i, ++count) {
        rows[count][LAYOUT] = 1;
        rows[count][POINTS] = rows[count][HIDDEN] ? 0 : rows[count][POINTS];
    }
    return count;
}

size_t rows_of_fours(size_t most, uint8_t (*rows)[PAIRWISE_FACTORS]) {
    static const pairwise_need needs[] = {
        {LOBES, COLOUR, 1 | 2}, {SHADOW, COLOUR, 1 | 2}, {STORE, COMPONENTS, 2 | 4 | 8},
        {ROOTS, DOMAIN, 2},     {POINTS, LAYOUT, 2},     {POINTS, HIDDEN, 1},
        {RELIEF, LAYOUT, 2},    {GLOSS, LAYOUT, 2},      {STEEP, LAYOUT, 2},
        {STEEP, BILINEAR, 2},
    };
    return fourwise_rows(1, FACTORS, levels, needs, sizeof needs / sizeof *needs, most, rows);
}
