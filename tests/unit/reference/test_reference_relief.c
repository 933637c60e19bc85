/* The reference decoder's relief, step by step, against geometry in double precision: slopes, moves,
 * marches through height maps and through boxes, what hides a point, weights. Compiled with the decoder's
 * sources, whose names are hidden.
 *
 * SPDX-License-Identifier: MIT
 */
#include "reference_assert.h"
#include "tests/support/reference_material.h"
#include "tests/support/test.h"

#include "reference/btf_reference_private.h"

enum { FIELD_WIDTH = 48, FIELD_HEIGHT = 24, FIELD_TEXELS = FIELD_WIDTH * FIELD_HEIGHT };

/** A height map, and three views around the pole, 35 degrees down. */
typedef struct field {
    btf_ref_material m;
    uint8_t heights[FIELD_TEXELS];
    float view_vectors[3 * 4];
} field;

static const btf_ref_neighbours thirds = {{0, 1, 2}, {1366, 1365, 1365}};

static void make_field(int32_t base, int32_t step, uint32_t steps, uint32_t level, field *f) {
    memset(f, 0, sizeof *f);
    f->m = (btf_ref_material){.width = FIELD_WIDTH,
                              .height = FIELD_HEIGHT,
                              .n_views = 3,
                              .layout_tight = 1,
                              .effects = BTF_REF_RELIEF,
                              .heights = f->heights,
                              .view_vectors = f->view_vectors,
                              .relief_base = base,
                              .relief_step = step,
                              .relief_steps = steps,
                              .level = level};
    static const float vectors[3][4] = {{0.5735764f, 0, 0.8191520f, 1},
                                        {-0.2867882f, 0.4967318f, 0.8191520f, 1},
                                        {-0.2867882f, -0.4967318f, 0.8191520f, 1}};
    memcpy(f->view_vectors, vectors, sizeof vectors);
}

/** The height of a code of the field, by division. */
static int32_t height_of(const field *f, uint8_t code) {
    return f->m.relief_base + (int32_t)floor(code * (double)f->m.relief_step / 256);
}

/** The texel that holds a position, in 1/256, of an axis of so many texels. */
static int texel_of(double position, int size) {
    double texels = floor(position / 256);
    return (int)(texels - size * floor(texels / size));
}

/** The height at a position given in double. */
static int32_t height_at(const field *f, double u, double v) {
    int column = texel_of(u, FIELD_WIDTH), row = FIELD_HEIGHT - 1 - texel_of(v, FIELD_HEIGHT);
    return height_of(f, f->heights[row * FIELD_WIDTH + column]);
}

/** Whether a ray is in the surface at a height. */
static bool is_inside(const field *f, const int32_t x[2], const int32_t s[2], int32_t z) {
    double scale = ldexp(1, -12 - (int)f->m.level);
    return height_at(f, x[0] + z * scale * s[0], x[1] + z * scale * s[1]) >= z;
}

/** The highest of all integers, tried one by one, at which the ray is in the surface. */
static int32_t cast_ray(const field *f, const int32_t x[2], const int32_t s[2]) {
    int32_t z = height_of(f, 255);
    while (!is_inside(f, x, s, z)) {
        --z;
    }
    return z;
}

/** How far a march falls in a step. */
static int32_t descent_of(const field *f) {
    double depth = height_of(f, 255) - f->m.relief_base;
    return (int32_t)ceil(depth / f->m.relief_steps);
}

static void random_position(uint32_t *random, int32_t out_x[2]) {
    out_x[0] = (int32_t)random_below(random, FIELD_WIDTH * 256);
    out_x[1] = (int32_t)random_below(random, FIELD_HEIGHT * 256);
}

static void random_slope(uint32_t *random, int32_t out_s[2]) {
    float direction[3];
    random_direction(random, direction);
    btf_ref_slope(direction, out_s);
}

/* --- single steps --- */

TEST(test_shift_down) {
    uint32_t random = 3;
    static const int32_t limits[] = {0, 1, -1, INT32_MAX, INT32_MIN, -4096, 4095};
    for (int i = 0; i < 200000; ++i) {
        uint32_t bits = random_bits(&random) ^ random_bits(&random) << 7;
        int32_t value = i < 7 ? limits[i] : (int32_t)(bits >> 1) - (1 << 30);
        uint32_t shift = random_below(&random, 27);
        assert_int_equal(btf_ref_shift_down(value, shift), (int64_t)floor(ldexp(value, -(int)shift)));
    }
}

TEST(test_slope) {
    uint32_t random = 5;
    double worst = 0;
    for (int i = 0; i < 500000; ++i) {
        float d[3];
        int32_t s[2];
        random_direction(&random, d);
        if (i % 4 == 0) { /* no unit vectors, as long as an argument may be */
            for (int k = 0; k < 3; ++k) {
                d[k] = k == 2 ? random_float(&random, 0, 2) + 0x1p-24f : random_float(&random, -2, 4);
            }
        }
        btf_ref_slope(d, s);
        for (int k = 0; k < 2; ++k) {
            double truth = 4096 * (double)d[k] / fmax((double)d[2], 0.25);
            truth = fmin(fmax(truth, -32767), 32767);
            worst = fmax(worst, fabs(s[k] - truth));
        }
    }
    print_message("slopes differ by %.4f of 1/4096 from the truth\n", worst);
    assert_true(worst <= 0.505); /* half a unit of rounding and 1.2e-7 of 32767 */
}

TEST(test_move) {
    uint32_t random = 7;
    static field f;
    make_field(0, 0, 1, 0, &f);
    for (int i = 0; i < 300000; ++i) {
        int32_t x[2], s[2], to[2];
        f.m.level = random_below(&random, 15);
        random_position(&random, x);
        int32_t z = (int32_t)random_below(&random, 65536) - 32768;
        for (int k = 0; k < 2; ++k) {
            s[k] = i == 0 ? 32767 : i == 1 ? -32767 : (int32_t)random_below(&random, 65535) - 32767;
        }
        z = i < 2 ? -32768 : z;
        btf_ref_move(&f.m, x, z, s, to);
        for (int k = 0; k < 2; ++k) {
            double length = 256 * (k == 0 ? FIELD_WIDTH : FIELD_HEIGHT);
            double there = x[k] + floor((double)z * s[k] * ldexp(1, -12 - (int)f.m.level));
            assert_int_equal(to[k], there - length * floor(there / length));
        }
    }
}

TEST(test_steep) {
    for (uint32_t f = 0; f < 256; ++f) {
        double part = (double)f / 256, expected = 256 * fmin(fmax(2 * part - 0.5, 0), 1);
        assert_int_equal(btf_ref_steep(f), expected);
    }
}

/* --- the march --- */

/** Adds rectangles of at least 6 texels, so large that a ray cannot step over one except at a corner. */
static void add_boxes(uint32_t *random, field *f) {
    memset(f->heights, (int)random_below(random, 64), sizeof f->heights);
    for (int box = 0; box < 3; ++box) {
        uint32_t left = random_below(random, FIELD_WIDTH), top = random_below(random, FIELD_HEIGHT);
        uint32_t width = 6 + random_below(random, 14), height = 6 + random_below(random, 10);
        uint8_t code = box == 0 ? 255 : (uint8_t)random_below(random, 256);
        for (uint32_t y = 0; y < height; ++y) {
            for (uint32_t x = 0; x < width; ++x) {
                f->heights[(top + y) % FIELD_HEIGHT * FIELD_WIDTH + (left + x) % FIELD_WIDTH] = code;
            }
        }
    }
}

/** A march stops less than a step above the surface. Where the ray stays in the surface for a step, it stops within a
 * step of the ray's first hit; on the top of a box exactly there. */
TEST(test_march_against_rays) {
    static field f;
    uint32_t random = 11, rays = 0, held = 0, landed = 0;
    double worst = 0;
    for (int round = 0; round < 300; ++round) {
        uint32_t steps = 1 + random_below(&random, 64);
        make_field((int32_t)random_below(&random, 1024) - 768, (int32_t)random_below(&random, 1500), steps,
                   (uint32_t)round % 3, &f);
        if (round % 4 == 0) { /* any heights */
            random_bytes(&random, f.heights, sizeof f.heights);
        } else {
            add_boxes(&random, &f);
        }
        int32_t descent = descent_of(&f);
        for (int i = 0; i < 100; ++i) {
            int32_t x[2], s[2];
            random_position(&random, x);
            random_slope(&random, s);
            if (f.m.relief_step == 0) {
                continue;
            }
            int32_t truth = cast_ray(&f, x, s), z = btf_ref_march(&f.m, x, s);
            ++rays;
            assert_true(z < truth + (descent > 0 ? descent : 1));
            assert_true(z > f.m.relief_base - (int32_t)steps && z <= height_of(&f, 255));
            bool holds = true, lands = true;
            double scale = ldexp(1, -12 - (int)f.m.level);
            for (int32_t below = truth; below > truth - descent; --below) {
                holds = holds && is_inside(&f, x, s, below);
                lands = lands &&
                        height_at(&f, x[0] + below * scale * s[0], x[1] + below * scale * s[1]) == truth;
            }
            if (holds) {
                ++held;
                assert_true(z > truth - (descent > 0 ? descent : 1));
                if (descent > 0) {
                    worst = fmax(worst, fabs((double)(z - truth) / descent));
                }
            }
            if (lands) {
                ++landed;
                assert_int_equal(z, truth);
            }
        }
    }
    print_message(
        "%u rays; %u meet what holds for a step, at most %.3f steps off; %u land on a top, exactly\n", rays,
        held, worst, landed);
    assert_true(held > rays * 0.8 && landed > rays / 2);
}

/** In a map of one height a march ends exactly there. */
TEST(test_march_on_a_plane) {
    static field f;
    uint32_t random = 13;
    for (int i = 0; i < 100000; ++i) {
        int32_t x[2], s[2];
        if (i % 100 == 0) {
            make_field((int32_t)random_below(&random, 65536) - 32768, 0, 1 + random_below(&random, 64), 0,
                       &f);
            int32_t room = 32767 - f.m.relief_base;
            f.m.relief_step = (int32_t)random_below(&random, 1 + (uint32_t)(room < 32767 ? room : 32767));
            f.m.level = random_below(&random, 15);
            memset(f.heights, i / 100 % 8 == 0 ? 255 : (int)random_below(&random, 256), sizeof f.heights);
        }
        random_position(&random, x);
        random_slope(&random, s);
        assert_int_equal(btf_ref_march(&f.m, x, s), height_of(&f, f.heights[0]));
    }
}

/* --- where views show a point, and how much they weigh --- */

/** A distance on an axis that wraps. */
static double apart(double a, double b, int size) {
    double length = 256.0 * size, d = a - b;
    return d - length * floor(d / length + 0.5);
}

/** The point at height h that is seen at x from V lies above x + h V.xy / V.z, and a view A shows it at that place less
 * h A.xy / A.z. */
TEST(test_parallax) {
    static field f;
    uint32_t random = 17;
    double worst = 0;
    for (int i = 0; i < 50000; ++i) {
        int32_t x[2], positions[3][2];
        uint32_t weights[3], w1 = random_below(&random, 4097), w2 = random_below(&random, 4097 - w1);
        int32_t height = (int32_t)random_below(&random, 4097) - 2048;
        make_field(height, i % 2 ? 1000 : 0, i % 2 ? 8 : 1, (uint32_t)i / 2 % 3, &f);
        btf_ref_neighbours views = {{0, 1, 2}, {4096 - w1 - w2, w1, w2}};
        float v[3];
        do {
            random_direction(&random, v);
        } while (v[2] < 0.25f);
        double share = 0;
        for (int a = 0; a < 3; ++a) {
            f.view_vectors[4 * a + 3] = random_below(&random, 3) == 0 ? 0.0f : 1.0f;
            share += f.view_vectors[4 * a + 3] != 0 ? views.weight[a] / 4096.0 : 0;
        }
        random_position(&random, x);
        btf_ref_relief(&f.m, &views, v, true, x, positions, weights);
        /* two slopes, each rounded and faded, to 1.5 of 1/4096; two moves rounded down */
        double bound = 3 * fabs((double)height) / 4096 * ldexp(1, -(int)f.m.level) + 2.01;
        for (int a = 0; a < 3; ++a) {
            const float *d = f.view_vectors + 4 * a;
            for (int k = 0; k < 2; ++k) {
                double shift = share * height * ((double)v[k] / (double)v[2] - (double)d[k] / (double)d[2]);
                double there = x[k] + shift * ldexp(1, -(int)f.m.level);
                double off = fabs(apart(positions[a][k], there, k == 0 ? FIELD_WIDTH : FIELD_HEIGHT));
                worst = fmax(worst, off / bound);
                assert_true(off <= bound);
            }
            assert_int_equal(weights[a], views.weight[a]); /* nothing hides a plane */
        }
    }
    print_message("positions off by %.3f of the bound\n", worst);
    assert_true(worst > 0.3); /* of the bound: it is not too wide to test anything */
}

/** Weights from heights that rays meet in double. */
static void weights_in_double(const field *f, const btf_ref_neighbours *views, const float v[3],
                              const int32_t x[2], int32_t positions[3][2], bool *out_sure,
                              double out_weights[3]) {
    int32_t s[2], descent = descent_of(f);
    double sum = 0;
    btf_ref_slope(v, s);
    int32_t z = cast_ray(f, x, s);
    *out_sure = btf_ref_march(&f->m, x, s) == z;
    for (int a = 0; a < 3; ++a) {
        btf_ref_slope(f->view_vectors + 4 * a, s);
        int32_t shown = cast_ray(f, positions[a], s);
        /* a side that a march met is known to a step only */
        *out_sure = *out_sure && (btf_ref_march(&f->m, positions[a], s) == shown || descent == 0);
        double texels = (shown - z) / 256.0 * ldexp(1, -(int)f->m.level);
        out_weights[a] = views->weight[a] * fmin(fmax(1.5 - texels / 2, 0.3), 1);
        sum += out_weights[a];
    }
    for (int a = 0; a < 3; ++a) {
        out_weights[a] *= 4096 / sum;
    }
}

/** Beside a wall, views from behind it weigh less, according to its height above the point: compared in double. */
TEST(test_walls_hide) {
    static field f;
    uint32_t random = 19, compared = 0, hidden = 0;
    double worst = 0;
    for (int round = 0; round < 400; ++round) {
        make_field((int32_t)random_below(&random, 1024) - 512, 256 + (int32_t)random_below(&random, 2048),
                   16 + random_below(&random, 49), (uint32_t)round % 2, &f);
        add_boxes(&random, &f);
        for (int i = 0; i < 50; ++i) {
            int32_t x[2], positions[3][2];
            uint32_t weights[3];
            double expected[3];
            bool sure;
            const float v[3] = {random_float(&random, -0.3f, 0.6f), random_float(&random, -0.3f, 0.6f),
                                0.9f};
            random_position(&random, x);
            btf_ref_relief(&f.m, &thirds, v, true, x, positions, weights);
            weights_in_double(&f, &thirds, v, x, positions, &sure, expected);
            assert_int_equal(weights[0] + weights[1] + weights[2], 4096);
            if (!sure) {
                continue;
            }
            ++compared;
            for (int a = 0; a < 3; ++a) {
                double off = fabs(weights[a] - expected[a]);
                worst = fmax(worst, off);
                hidden += expected[a] < 1000;
            }
        }
    }
    print_message("%u sets of weights, %u neighbours that something hides; off by %.2f of 4096\n", compared,
                  hidden, worst);
    assert_true(compared > 10000 && hidden > 500);
    assert_true(worst <= 9); /* 8 of 4096 of o_a for a unit of height, which levels round */
}

/** For any heights and neighbours: weights are in 0 .. 4096 and sum to 4096; a weight of 0 stays 0; positions are in
 * the level; without occlusion the weights stay. */
TEST(test_weights_sum) {
    static made_storage storage;
    static made_relief relief;
    btf_ref_material m;
    uint32_t random = 23, changed = 0;
    enum { MATERIALS = 500, EACH = 4000 };
    for (uint32_t round = 0; round < MATERIALS; ++round) {
        make_material(1, 1, BTF_REF_SHADOW, 0, &storage, &m);
        make_relief(round, round % 3 == 0, &relief, &m);
        for (int i = 0; i < EACH; ++i) {
            int32_t x[2] = {(int32_t)random_below(&random, MADE_WIDTH * 256),
                            (int32_t)random_below(&random, MADE_HEIGHT * 256)};
            int32_t positions[3][2];
            uint32_t weights[3], kept[3], parts[3] = {0, 0, 0}, left = 4096;
            uint32_t first = random_below(&random, 3);
            for (uint32_t k = 0; k < 2; ++k) {
                uint32_t choice = random_below(&random, 4);
                parts[(first + k) % 3] = choice == 0   ? 0
                                         : choice == 1 ? left
                                                       : random_below(&random, left + 1);
                left -= parts[(first + k) % 3];
            }
            parts[(first + 2) % 3] = left;
            btf_ref_neighbours views = {{random_below(&random, MADE_VIEWS),
                                         random_below(&random, MADE_VIEWS),
                                         random_below(&random, MADE_VIEWS)},
                                        {parts[0], parts[1], parts[2]}};
            float v[3];
            random_direction(&random, v);
            btf_ref_relief(&m, &views, v, true, x, positions, weights);
            assert_int_equal(weights[0] + weights[1] + weights[2], 4096);
            for (int a = 0; a < 3; ++a) {
                assert_true(weights[a] <= 4096);
                assert_true(parts[a] > 0 || weights[a] == 0);
                assert_true(parts[a] < 4096 || weights[a] == 4096);
                assert_in_range(positions[a][0], 0, MADE_WIDTH * 256 - 1);
                assert_in_range(positions[a][1], 0, MADE_HEIGHT * 256 - 1);
                changed += weights[a] != parts[a];
            }
            btf_ref_relief(&m, &views, v, false, x, positions, kept);
            assert_memory_equal(kept, parts, sizeof kept);
        }
    }
    print_message("%d sets of weights, %u weights changed\n", MATERIALS * EACH, changed);
    assert_true(changed > MATERIALS * EACH / 10);
}

RUN_TESTS(NULL, NULL)
