/* Stochastic decode at its limits: random numbers at the borders of the weights, materials and arguments at theirs,
 * undefined levels. Linked with the reference decoder's objects, whose names are hidden.
 *
 * SPDX-License-Identifier: MIT
 */
#include "cases.h"

#include "reference/btf_reference_private.h"
#include "tests/support/reference_material.h"

#include <math.h>
#include <string.h>

enum { OLD_EFFECTS = BTF_REF_SHADOW | BTF_REF_SHIFT | BTF_REF_HIDDEN | BTF_REF_GAIN | BTF_REF_RESIDUAL };

static struct {
    made_storage storage;
    made_factors factors;
    made_relief relief;
} made;

static btf_ref_material make(uint32_t seed, int extreme) {
    btf_ref_material m;
    make_material(seed, seed | 1, seed % 3 ? OLD_EFFECTS : seed / 3 % 32, extreme, &made.storage, &m);
    if (seed % 2) {
        make_factors(seed, extreme, &made.factors, &m);
    }
    make_relief(seed, extreme, &made.relief, &m);
    return m;
}

static btf_ref_neighbours around(const uint16_t *table, uint32_t grid, const float direction[3]) {
    int32_t q[2];
    btf_ref_project(direction, q);
    return btf_ref_lookup(table, grid, q);
}

/* The neighbour whose share holds a number below 4096, found by counting. */
static int owner(const btf_ref_neighbours *n, uint32_t number) {
    uint32_t next = 0;
    for (int i = 0; i < 3; i++) {
        for (uint32_t k = 0; k < n->weight[i]; k++, next++) {
            if (next == number) {
                return i;
            }
        }
    }
    return -1;
}

/* The first and last number of every share, of views and of lights. */
static void borders(void) {
    bool ok = true;
    int count = 0;
    uint32_t random = 3;
    for (uint32_t seed = 1; seed <= 40; seed++) {
        const btf_ref_material m = make(seed, seed % 2 == 0);
        const btf_ref_options o = {OLD_EFFECTS, UINT32_MAX, BTF_REF_LINEAR, BTF_REF_TEXEL};
        for (int i = 0; i < 20; i++) {
            float l[3], v[3];
            random_direction(&random, l);
            random_direction(&random, v);
            if (i % 4 == 0) {
                memcpy(v, made.relief.view_vectors + 4 * random_below(&random, MADE_VIEWS), sizeof v);
            }
            const btf_ref_neighbours views = around(m.view_table, m.view_grid, v),
                                     lights = around(m.light_table, m.light_grid, l);
            const uint32_t w[2][2] = {{views.weight[0], views.weight[1]},
                                      {lights.weight[0], lights.weight[1]}};
            for (int which = 0; which < 36; which++, count++) {
                uint32_t number[2];
                for (int k = 0; k < 2; k++) {
                    const uint32_t ends[6] = {0,    w[k][0] - 1,           w[k][0],
                                              4095, w[k][0] + w[k][1] - 1, w[k][0] + w[k][1]};
                    number[k] = ends[k ? which / 6 : which % 6] & 4095;
                }
                const uint32_t low = random_below(&random, 2) ? 0xFFFFF : 0,
                               r[3] = {number[0] << 20 | low, number[1] << 20 | low, random_bits(&random)};
                const int a = owner(&views, number[0]), b = owner(&lights, number[1]);
                const btf_ref_neighbours view = {{views.index[a], 0, 0}, {4096, 0, 0}},
                                         light = {{lights.index[b], 0, 0}, {4096, 0, 0}};
                const uint32_t column = random_below(&random, MADE_WIDTH),
                               row = random_below(&random, MADE_HEIGHT);
                const float u = ((float)column + 0.5f) / MADE_WIDTH,
                            t = ((float)(MADE_HEIGHT - 1 - row) + 0.5f) / MADE_HEIGHT;
                float rgb[3], expected[3];
                btf_ref_evaluate_stochastic(&m, &o, BTF_REF_PICK_LIGHT, u, t, l, v, r, rgb);
                btf_ref_evaluate_neighbours(&m, &o, column, row, &light, &view, l, v, expected);
                ok = ok && memcmp(rgb, expected, sizeof rgb) == 0;
            }
        }
    }
    cases_add(
        "the first and last random number of every view's and light's share, and of all, other bits 0 or 1",
        "each is its owner's, none that of a neighbour of weight 0", ok, "%d choices", count);
}

static void arguments(void) {
    static const uint32_t parts[12] = {0,          0x80000000, 1,          0x3F800000,
                                       0xBF800000, 0x33800000, 0x337FFFFF, 0x40000000,
                                       0x40000001, 0x7F800000, 0xFF800000, 0x7FC00000};
    bool ok = true, dark = true, within = true;
    int count = 0;
    uint32_t random = 5;
    for (uint32_t kind = 0; kind < 4; kind++) {
        const btf_ref_material m = make(kind, kind & 1);
        for (size_t i = 0; i < 12 * 12 * 12; i++) {
            const float d[3] = {float_of(parts[i % 12]), float_of(parts[i / 12 % 12]),
                                float_of(parts[i / 144])},
                        low[3] = {-1, 0, 0x1p-24f};
            const bool usable =
                fabsf(d[0]) <= 2 && fabsf(d[1]) <= 2 && fabsf(d[2]) <= 2 && d[2] >= 0x1p-24f;
            for (int which = 0; which < 18; which++, count++) {
                const btf_ref_options o = {UINT32_MAX, UINT32_MAX, which & 1, which / 2 % 3};
                const int picks = 1 + which / 6;
                const uint32_t r[3] = {random_bits(&random), random_bits(&random), random_bits(&random)};
                float one[3], mean[3];
                btf_ref_evaluate_stochastic(&m, &o, picks, 0.3f, 0.6f, i & 1 ? low : d, i & 1 ? d : low, r,
                                            one);
                btf_ref_evaluate_radiance_blend(&m, &o, picks, 0.3f, 0.6f, i & 1 ? low : d, i & 1 ? d : low,
                                                mean);
                for (int c = 0; c < 3; c++) {
                    ok = ok && one[c] >= 0 && one[c] <= 0x1.fffffep127f && mean[c] >= 0 &&
                         mean[c] <= 0x1.fffffep127f;
                    dark = dark && (usable || (one[c] == 0 && mean[c] == 0));
                    /* a choice of share s of the mean has at most 1 / s of it, 2^-40 at least */
                    within =
                        within && ((double)one[c] <= 0x1p41 * (double)mean[c] || (double)mean[c] < 0x1p-90);
                }
            }
        }
    }
    cases_add("light or view of every three of 0, -0, 1, -1, 2^-24, 2, denormal, infinities, NaN, the "
              "other grazing",
              "choices and blends finite, all filters and picks; 0 below the horizon and for what is no "
              "direction",
              ok && dark, "%d evaluations", count);
    cases_add("choices of those arguments", "none that the blend gives no weight", within, "%d choices",
              count);
}

static void levels(void) {
    static const struct {
        uint32_t bits;
        int is;
    } list[] = {{0, 0},          {0x80000000, 0}, {1, 0},          {0x80000001, 0}, {0xBF800000, 0},
                {0xFF800000, 0}, {0x7FC00000, 0}, {0xFFC00000, 0}, {0x7F800001, 0}, {0x7F800000, 2},
                {0x7F7FFFFF, 2}, {0x40000000, 2}, {0x40000001, 2}, {0x3F800000, 1}, {0x3B7FFFFF, 0}};
    bool ok = true;
    uint32_t random = 7;
    btf_ref_material m[3];
    for (int i = 0; i < 3; i++) { /* levels whose radiance is in proportion to their number */
        m[i] = make(1, 0);
        m[i].radiance_scale = 1 + (float)i;
    }
    const btf_ref_options o = {UINT32_MAX, UINT32_MAX, BTF_REF_LINEAR, BTF_REF_BILINEAR};
    for (size_t i = 0; i < sizeof list / sizeof *list; i++) {
        float l[3], v[3], rgb[3], expected[3];
        random_direction(&random, l);
        random_direction(&random, v);
        const uint32_t r[3] = {random_bits(&random), random_bits(&random),
                               random_bits(&random) & 0xFFFF00FF};
        const float level = float_of(list[i].bits);
        btf_ref_evaluate_stochastic_between(m, 3, &o, 3, level, 0.3f, 0.6f, l, v, r, rgb);
        btf_ref_evaluate_stochastic(&m[list[i].is], &o, 3, 0.3f, 0.6f, l, v, r, expected);
        ok = ok && memcmp(rgb, expected, sizeof rgb) == 0;
        btf_ref_evaluate_radiance_blend_between(m, 3, &o, 3, level, 0.3f, 0.6f, l, v, rgb);
        btf_ref_evaluate_radiance_blend(&m[list[i].is], &o, 3, 0.3f, 0.6f, l, v, expected);
        ok = ok && memcmp(rgb, expected, sizeof rgb) == 0;
    }
    cases_add("level 0, -0, -1, denormal, NaN of both signs, infinities, 2 of 3 levels and beyond, less "
              "than 1/256",
              "level 0, the last, or the whole one, bit for bit", ok, "%zu levels",
              sizeof list / sizeof *list);
}

int main(void) {
    cases_title("Stochastic decode at its limits, of random numbers, arguments and levels.");
    borders();
    arguments();
    levels();
    return cases_result();
}
