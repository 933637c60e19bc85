/* Relief and gloss at their limits: grazing views, half vectors that vanish, look-ups that sink below the horizon,
 * marches that meet nothing, the largest integers. Linked with the reference decoder's objects, whose names are hidden.
 *
 * SPDX-License-Identifier: MIT
 */
#include "cases.h"

#include "reference/btf_reference_private.h"
#include "tests/support/reference_material.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

enum { SIDE = 16384 };

/* A material of relief alone, of one texel. */
static btf_ref_material one_texel(int32_t base, int32_t step, uint32_t steps, uint32_t level,
                                  const uint8_t *height) {
    return (btf_ref_material){.width = 1,
                              .height = 1,
                              .relief_base = base,
                              .relief_step = step,
                              .relief_steps = steps,
                              .level = level,
                              .heights = height};
}

/* ---- relief ---- */

static void grazing_slopes(void) {
    bool ok = true;
    int32_t s[2], at_quarter[2];
    for (uint32_t bits = 0x33800000; bits <= 0x3E800000; bits += 4099) { /* 2^-24 to 1/4 */
        const float low[3] = {0.6f, -0.8f, float_of(bits)}, quarter[3] = {0.6f, -0.8f, 0.25f};
        btf_ref_slope(low, s);
        btf_ref_slope(quarter, at_quarter);
        ok = ok && memcmp(s, at_quarter, sizeof s) == 0;
    }
    cases_add("slopes of views from the horizon up to z = 1/4", "those of z = 1/4", ok, "%d, %d of 4096",
              at_quarter[0], at_quarter[1]);
    const float longest[3] = {2, -2, 0x1p-24f};
    btf_ref_slope(longest, s);
    cases_add("slope of (2, -2, 2^-24), as long as a view may be", "32767 and -32767",
              s[0] == 32767 && s[1] == -32767, "%d, %d", s[0], s[1]);
}

/* Relief of section 9 in 64-bit integers, with `>>` as a division that rounds down: the result that 32 bits have to
 * give. */

static int64_t down(int64_t value, uint32_t shift) {
    const int64_t by = (int64_t)1 << shift;
    return value >= 0 ? value / by : -((-value + by - 1) / by);
}

static int64_t wide_move(const btf_ref_material *m, int axis, int64_t x, int64_t z, int64_t s) {
    const int64_t length = 256 * (int64_t)(axis ? m->height : m->width);
    const int64_t there = x + down(z * s, 12 + m->level);
    return (there % length + length) % length;
}

static int64_t wide_height(const btf_ref_material *m, int64_t code) {
    return m->relief_base + down(code * m->relief_step, 8);
}

static int64_t wide_march(const btf_ref_material *m, const int64_t x[2], const int64_t s[2]) {
    int64_t z = wide_height(m, 255), steps = m->relief_steps;
    const int64_t fall = (z - m->relief_base + steps - 1) / steps;
    for (int64_t n = 0; n <= steps; n++, z -= fall) {
        const int64_t column = wide_move(m, 0, x[0], z, s[0]) / 256,
                      row = m->height - 1 - wide_move(m, 1, x[1], z, s[1]) / 256;
        const int64_t t = wide_height(m, m->heights[row * m->width + column]);
        if (t >= z) {
            return n == 0 ? z : t < z + fall ? t : z + down(fall, 1);
        }
    }
    return m->relief_base;
}

static void wide_relief(const btf_ref_material *m, const btf_ref_neighbours *views, const float v[3],
                        const int32_t at[2], int64_t out_x[3][2], int64_t out_weights[3]) {
    int64_t e = 0, s[4][2], x[4][2], seen[3] = {0, 0, 0}, total = 0;
    for (int a = 0; a < 3; a++) {
        e += m->view_vectors[4 * views->index[a] + 3] != 0 ? views->weight[a] : 0;
    }
    for (int a = 0; a < 4; a++) {
        int32_t slope[2];
        btf_ref_slope(a < 3 ? m->view_vectors + 4 * views->index[a] : v, slope);
        for (int k = 0; k < 2; k++) {
            s[a][k] = down(slope[k] * e, 12);
            x[a][k] = at[k];
        }
    }
    const int64_t z = m->relief_step > 0 ? wide_march(m, x[3], s[3]) : m->relief_base;
    for (int a = 0; a < 3; a++) {
        for (int k = 0; k < 2; k++) {
            const int64_t length = 256 * (int64_t)(k ? m->height : m->width);
            const int64_t there =
                at[k] + down(z * s[3][k], 12 + m->level) - down(z * s[a][k], 12 + m->level);
            x[a][k] = out_x[a][k] = (there % length + length) % length;
        }
        if (m->relief_step > 0 && views->weight[a] > 0) {
            const int64_t above = down(down((wide_march(m, x[a], s[a]) - z) * e, 12), m->level),
                          o = 6144 - 8 * above;
            seen[a] = views->weight[a] * (o < 1229 ? 1229 : o > 4096 ? 4096 : o);
        }
        total += seen[a];
        out_weights[a] = views->weight[a];
    }
    if (m->relief_step > 0) {
        out_weights[0] = seen[0] / 64 * 4096 / (total / 64);
        out_weights[1] = seen[2] > 0 ? seen[1] / 64 * 4096 / (total / 64) : 4096 - out_weights[0];
        out_weights[2] = 4096 - out_weights[0] - out_weights[1];
    }
}

/* The integers of relief fit 32 bits (FORMAT.md, section 9): random materials, half of them at the limits of base, step
 * and level, must give what 64 bits give; so must moves between the extremes. */
static void integer_limits(void) {
    static made_storage storage;
    static made_relief relief;
    static const int32_t bases[5] = {-32768, -32767, 0, 1, 32767};
    bool ok = true;
    int count = 0;
    uint32_t random = 3;
    for (uint32_t seed = 0; seed < 400; seed++) {
        btf_ref_material m;
        make_material(1, 1, BTF_REF_SHADOW, 0, &storage, &m);
        make_relief(seed, 1, &relief, &m);
        if (seed % 2 == 0) {
            m.relief_base = bases[seed / 2 % 5];
            const int32_t room = (int32_t)floor((32767.0 - m.relief_base) * 256 / 255);
            m.relief_step = room < 32767 ? room : 32767;
            m.relief_steps = seed % 3 == 0 ? 64 : 1 + seed % 64;
            m.level = seed % 8 == 0 ? 14 : seed % 4;
        }
        for (int i = 0; i < 300; i++, count++) {
            float v[3] = {random_float(&random, -2, 4), random_float(&random, -2, 4),
                          random_float(&random, 0, 1) + 0x1p-24f};
            const int32_t at[2] = {(int32_t)random_below(&random, 256 * MADE_WIDTH),
                                   (int32_t)random_below(&random, 256 * MADE_HEIGHT)};
            const uint32_t w = random_below(&random, 4097);
            const btf_ref_neighbours views = {
                {random_below(&random, MADE_VIEWS), random_below(&random, MADE_VIEWS),
                 random_below(&random, MADE_VIEWS)},
                {w, i % 4 ? (4096 - w) / 2 : 0, 4096 - w - (i % 4 ? (4096 - w) / 2 : 0)}};
            int32_t x[3][2];
            uint32_t weights[3];
            int64_t wide_x[3][2], wide_weights[3];
            btf_ref_relief(&m, &views, v, true, at, x, weights);
            wide_relief(&m, &views, v, at, wide_x, wide_weights);
            for (int a = 0; a < 3; a++) {
                ok = ok && weights[a] == wide_weights[a] && x[a][0] == wide_x[a][0] &&
                     x[a][1] == wide_x[a][1];
            }
        }
    }
    cases_add("heights of -32768 to 32767 under slopes of 8, at random",
              "the positions and weights that 64 bits give", ok, "%d", count);

    ok = true;
    const int32_t start[2] = {0, 0};
    int32_t to[2];
    for (uint32_t level = 0; level <= 14; level++) {
        for (int way = 0; way < 4; way++) {
            btf_ref_material m = one_texel(0, 0, 1, level, NULL);
            const int32_t s[2] = {way & 1 ? 32767 : -32767, way & 1 ? -32767 : 32767},
                          z = way & 2 ? 32767 : -32768;
            m.width = m.height = SIDE;
            btf_ref_move(&m, start, z, s, to);
            ok = ok && to[0] == wide_move(&m, 0, 0, z, s[0]) && to[1] == wide_move(&m, 1, 0, z, s[1]);
        }
    }
    cases_add("moves of the lowest and highest height under the steepest slopes, levels 0 to 14", "exact",
              ok, "from the corner to %d, %d of 4194304", to[0], to[1]);
}

static void marches(void) {
    bool ok = true;
    const int32_t middle[2] = {128, 128}, s[2] = {32767, -32767};
    uint8_t lowest = 0, highest = 255;
    int count = 0;
    for (uint32_t steps = 1; steps <= 64; steps++) {
        for (int32_t step = 1; step <= 32767; step = step * 2 + 1, count++) {
            const btf_ref_material m = one_texel(-32768, step, steps, steps % 15, &lowest);
            ok = ok && btf_ref_march(&m, middle, s) == -32768;
        }
    }
    cases_add("a march that meets no height but the lowest, 1 to 64 steps",
              "the lowest height, however steps divide the depth", ok, "%d marches", count);
    ok = true;
    for (uint32_t steps = 1; steps <= 64; steps++) {
        const btf_ref_material m = one_texel(-7, 1000, steps, 0, &highest),
                               flat = one_texel(9, 1, steps, 0, &highest);
        ok = ok && btf_ref_march(&m, middle, s) == -7 + 996 && btf_ref_march(&flat, middle, s) == 9;
    }
    cases_add("a march that begins in the surface", "the highest height", ok,
              "also of reliefStep 1, whose steps are 0");

    uint8_t *heights = mmap(NULL, (size_t)SIDE * SIDE, PROT_READ | PROT_WRITE,
                            MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    const char *const input = "16384 x 16384 heights, the last texel alone high",
                      *const expected = "only the ray that ends there meets it";
    if (heights == MAP_FAILED) {
        cases_skip(input, expected, "no address space");
        return;
    }
    btf_ref_material m = one_texel(0, 32767, 16, 0, heights);
    m.width = m.height = SIDE;
    heights[(size_t)SIDE * SIDE - 1] = 255; /* the right end of the bottom row */
    const int32_t straight[2] = {0, 0}, at[2] = {256 * SIDE - 128, 128},
                  beside[2] = {256 * SIDE - 384, 128}, above[2] = {256 * SIDE - 128, 384};
    const int32_t left[2] = {-4096, 0},
                  over_the_border[2] = {128, 128}; /* 32639 to the left of the highest */
    const int32_t found = btf_ref_march(&m, at, straight),
                  over[2] = {(256 * SIDE - 128 + 32639) % (256 * SIDE), 128};
    ok = found == 32639 && btf_ref_march(&m, beside, straight) == 0 &&
         btf_ref_march(&m, above, straight) == 0 && btf_ref_march(&m, over_the_border, straight) == 0 &&
         btf_ref_march(&m, over, left) == 32639;
    cases_add(input, expected, ok, "height %d, across the border too", found);
    munmap(heights, (size_t)SIDE * SIDE);
}

static void weights(void) {
    enum { WIDE = 31 };
    static const float vectors[12] = {0.57f, 0, 0.82f,   1,       -0.285f, 0.494f,
                                      0.82f, 1, -0.285f, -0.494f, 0.82f,   1};
    uint8_t heights[WIDE * WIDE];
    btf_ref_material m = one_texel(0, 4096, 64, 0, heights);
    m.width = m.height = WIDE;
    m.view_vectors = vectors;
    const btf_ref_neighbours views = {{0, 1, 2}, {1366, 1365, 1365}};
    const float pole[3] = {0, 0, 1};
    const int32_t middle[2] = {256 * 15 + 128, 256 * 15 + 128};
    int32_t x[3][2];
    uint32_t w[3];
    memset(heights, 255, sizeof heights);
    heights[15 * WIDE + 15] = 0; /* a shaft, 16 texels deep */
    btf_ref_relief(&m, &views, pole, true, middle, x, w);
    bool ok = w[0] + w[1] + w[2] == 4096;
    for (int a = 0; a < 3; a++) {
        ok = ok && abs((int)w[a] - (int)views.weight[a]) <= 2;
    }
    cases_add("the bottom of a shaft: hidden in all three views, all at the least of visibility",
              "the weights that they have without relief, within 2", ok, "%u, %u, %u", w[0], w[1], w[2]);
    for (int i = 0; i < WIDE * WIDE; i++) { /* a cliff: the first view sees the low ground left of it */
        heights[i] = i % WIDE > 15 ? 255 : 0;
    }
    btf_ref_relief(&m, &views, pole, true, middle, x, w);
    const double share = 4096 * 0.3 / 2.3;
    cases_add("below a cliff that one of three views has in front", "that view weighs 0.3 parts of 2.3",
              w[0] + w[1] + w[2] == 4096 && fabs(w[0] - share) <= 2, "%u of 4096", w[0]);
    const btf_ref_neighbours rim = {{0, 1, 0}, {1, 4095, 0}}, last = {{2, 1, 0}, {0, 1, 4095}};
    btf_ref_relief(&m, &rim, pole, true, middle, x, w);
    ok = w[0] + w[1] == 4096 && w[2] == 0;
    btf_ref_relief(&m, &last, pole, true, middle, x, w);
    ok = ok && w[0] == 0 && w[1] + w[2] == 4096;
    cases_add("neighbours of weight 0 and of 1 of 4096, one of them hidden",
              "what weighed nothing weighs nothing; the sum is 4096", ok, "%u, %u, %u", w[0], w[1], w[2]);
}

/* ---- gloss ---- */

static void look_up(const float a[3], uint32_t share, const float l[3], const float v[3],
                    int32_t out_q[2]) {
    const float vector[4] = {a[0], a[1], a[2], 1};
    const btf_ref_material m = {.n_views = 1, .view_vectors = vector, .gloss_share = share};
    btf_ref_gloss(&m, 0, l, v, out_q);
}

static int apart(const int32_t p[2], const int32_t q[2]) {
    const int x = abs(p[0] - q[0]), y = abs(p[1] - q[1]);
    return x > y ? x : y;
}

static bool in_disc(const int32_t q[2]) {
    return hypot(q[0] - 8192, q[1] - 8192) < 8193.5;
}

static void glossy_limits(void) {
    const float a[3] = {0.36f, 0.48f, 0.8f};
    int32_t q[2], before[2] = {0, 0};
    int widest = 0;
    bool ok = true;
    for (int i = 0; i <= 200000;
         i++) { /* the light sinks to where it opposes the view, both 2^-24 high in the end */
        const double t = 1.5707963 * i / 200000;
        const float v[3] = {-1, 0, 0x1p-24f}, l[3] = {(float)sin(t), 0, fmaxf((float)cos(t), 0x1p-24f)};
        look_up(a, 2, l, v, q);
        ok = ok && in_disc(q);
        if (i > 0 && apart(q, before) > widest) {
            widest = apart(q, before);
        }
        memcpy(before, q, sizeof q);
    }
    cases_add("a light that sinks until it opposes a grazing view: the half vector vanishes",
              "looked up in the disc, without a jump", ok && widest <= 2,
              "at most %d of 16384 units apart, at %d, %d in the end", widest, q[0], q[1]);

    const float right[3] = {1, 0, 0x1p-24f}, up[3] = {0, 1, 0x1p-24f}, below[3] = {0, -1, 0x1p-24f};
    look_up(below, 2, right, up, q);
    cases_add("the mirrored light opposes the light: half way there is no direction",
              "looked up at the pole", q[0] == 8192 && q[1] == 8192, "%d, %d", q[0], q[1]);

    int sunk = 0;
    ok = true;
    uint32_t random = 5;
    for (int i = 0; i < 200000; i++) {
        float l[3], v[3], sampled[3];
        random_direction(&random, l);
        random_direction(&random, v);
        random_direction(&random, sampled);
        look_up(sampled, 1 + random_below(&random, 2), l, v, q);
        sunk += hypot(q[0] - 8192, q[1] - 8192) > 8191.2;
        ok = ok && in_disc(q);
    }
    cases_add("lights mirrored into the ground", "looked up at the horizon, never beyond", ok && sunk > 500,
              "%d of 200000 at the horizon", sunk);

    static const float steps[] = {0x1p-149f,       0x1p-126f, 0x1p-60f, 0x1p-30f,
                                  0x1.fffffep-25f, 0x1p-24f,  0x1p-20f};
    ok = true;
    for (int i = 0; i < 70000; i++) { /* many lights: in few the two ways to project differ */
        const float pole[3] = {0, 0, 1}, step = steps[i % 7], v[3] = {step, -step, 1};
        float l[3];
        int32_t plain[2];
        random_direction(&random, l);
        look_up(pole, 2, l, v, q);
        btf_ref_project(l, plain);
        ok = ok && apart(q, plain) <= (i % 7 < 5 ? 0 : 1);
    }
    cases_add("a view beside the sampled one by the least denormal, 2^-126, ... up to 2^-20",
              "looked up at the light; nothing depends on a denormal", ok,
              "7 distances, 10000 lights each");
}

/* ---- both ---- */

static void every_argument(void) {
    static made_storage storage;
    static made_relief relief;
    static const uint32_t parts[12] = {0,          0x80000000, 1,          0x3F800000,
                                       0xBF800000, 0x33800000, 0x337FFFFF, 0x40000000,
                                       0x40000001, 0x7F800000, 0xFF800000, 0x7FC00000};
    bool ok = true, dark = true;
    int count = 0;
    for (uint32_t kind = 0; kind < 4; kind++) {
        btf_ref_material m;
        make_material(kind, 1 + 2 * kind, 31, kind & 1, &storage, &m);
        make_relief(kind, kind & 1, &relief, &m);
        for (size_t i = 0; i < 12 * 12 * 12; i++) {
            const float d[3] = {float_of(parts[i % 12]), float_of(parts[i / 12 % 12]),
                                float_of(parts[i / 144])};
            const float low[3] = {-1, 0, 0x1p-24f};
            for (int which = 0; which < 6; which++, count++) {
                const btf_ref_options options = {UINT32_MAX, UINT32_MAX, which & 1, which / 2};
                float rgb[3];
                btf_ref_evaluate(&m, &options, 0.3f, 0.6f, i & 1 ? low : d, i & 1 ? d : low, rgb);
                for (int c = 0; c < 3; c++) {
                    ok = ok && rgb[c] >= 0 && rgb[c] <= 0x1.fffffep127f;
                }
                const bool usable =
                    fabsf(d[0]) <= 2 && fabsf(d[1]) <= 2 && fabsf(d[2]) <= 2 && d[2] >= 0x1p-24f;
                dark = dark && (usable || (rgb[0] == 0 && rgb[1] == 0 && rgb[2] == 0));
            }
        }
    }
    cases_add("light or view of every three of 0, -0, 1, -1, 2^-24, 2, denormal, infinities, NaN, the "
              "other grazing",
              "finite, all filters; 0 below the horizon and for what is no direction", ok && dark,
              "%d evaluations", count);
}

int main(void) {
    cases_title("Relief and gloss at their limits, of integers and of directions.");
    grazing_slopes();
    integer_limits();
    marches();
    weights();
    glossy_limits();
    every_argument();
    return cases_result();
}
