/* The reference decoder, its steps: arithmetic against libm, addressing at its limits, look-ups of
 * directions against numbers worked out by hand, the self-test.
 *
 * SPDX-License-Identifier: MIT
 */
#include "reference_assert.h"
#include "tests/support/reference_material.h"
#include "tests/support/test.h"

/** Steps of the bit pattern between arguments where all of them would take too long; a prime. */
enum { STRIDE = 7 };

/* --- section 8 --- */

TEST(test_log2) {
    double absolute = 0, relative = 0;
    for (uint32_t bits = 0x33800000u; bits < 0x4E800000u; bits += STRIDE) { /* [2^-24, 2^30) */
        double x = (double)float_of(bits), truth = log2(x);
        double error = fabs((double)btf_ref_log2(float_of(bits)) - truth);
        absolute = fmax(absolute, error);
        if (truth != 0) {
            relative = fmax(relative, error / fabs(truth));
        }
    }
    print_message("log2: absolute %.3g, relative %.3g\n", absolute, relative);
    assert_true(absolute <= 1.05e-6 && relative <= 4.94e-7);
    for (int k = -126; k <= 127; ++k) {
        assert_bits(btf_ref_log2(ldexpf(1.0f, k)), (float)k);
    }
}

TEST(test_exp2) {
    double relative = 0;
    for (int negative = 0; negative < 2; ++negative) {
        uint32_t last = negative ? 0x42700000u : 0x42200000u; /* -60, 40 */
        for (uint32_t bits = 0x2F800000u; bits <= last; bits += STRIDE) {
            float x = negative ? -float_of(bits) : float_of(bits);
            double truth = exp2((double)x);
            relative = fmax(relative, fabs((double)btf_ref_exp2(x) - truth) / truth);
        }
    }
    print_message("exp2: relative %.3g\n", relative);
    assert_true(relative <= 1.04e-7);
    for (int k = -60; k <= 40; ++k) {
        assert_bits(btf_ref_exp2((float)k), ldexpf(1.0f, k));
    }
    assert_bits(btf_ref_exp2(-0.0f), 1.0f);
    assert_bits(btf_ref_exp2(float_of(1)), 1.0f);
}

TEST(test_reciprocal) {
    double relative = 0;
    for (uint32_t bits = 0x3F000000u; bits <= 0x40800000u; ++bits) { /* all of [0.5, 4] */
        double x = (double)float_of(bits);
        relative = fmax(relative, fabs((double)btf_ref_reciprocal(float_of(bits)) * x - 1));
    }
    print_message("reciprocal: relative %.3g\n", relative);
    assert_true(relative <= 9.94e-8);
    assert_bits(btf_ref_reciprocal(1.0f),
                float_of(0x3F7FFFFFu)); /* a step below: a fixed point of Newton's */
    assert_bits(btf_ref_reciprocal(2.0f), float_of(0x3EFFFFFFu));
}

TEST(test_pow) {
    uint32_t random = 5;
    double worst = 0, absolute = 0;
    for (int i = 0; i < 2000000; ++i) {
        float base = i % 2 ? float_of(0x33800000u + random_bits(&random) % 0x1A000000u)  /* to 2^28 */
                           : float_of(0x3F000000u + random_bits(&random) % 0x01000000u); /* 0.5 to 2 */
        float n = random_parameter(&random);
        double t = (double)n * log2((double)base);
        if (t < -59.99 || t > 39.99) {
            continue;
        }
        double truth = pow((double)base, (double)n), error = fabs((double)btf_ref_pow(base, n) - truth);
        worst = fmax(worst, error / truth / (1.04e-7 + 3.84e-7 * fabs(t)));
        if (base <= 1 && n >= 0) {
            absolute = fmax(absolute, error);
        }
    }
    print_message("pow: %.3f of its bound, absolute %.3g for bases to 1\n", worst, absolute);
    assert_true(worst <= 1 && absolute <= 1.75e-7);

    const float below = float_of(0x337FFFFFu);
    assert_bits(btf_ref_pow(0x1p-24f, 0.0f), 1.0f);
    assert_bits(btf_ref_pow(1e9f, 0.0f), 1.0f);
    assert_bits(btf_ref_pow(below, 0.0f), 0.0f);
    assert_bits(btf_ref_pow(below, -5.0f), 0.0f);
    assert_bits(btf_ref_pow(0.0f, 3.0f), 0.0f);
    assert_bits(btf_ref_pow(-0.0f, -3.0f), 0.0f);
    assert_bits(btf_ref_pow(-1.0f, 2.0f), 0.0f);
    assert_bits(btf_ref_pow(NAN, 2.0f), 0.0f);
    assert_bits(btf_ref_pow(0.5f, 60.0f), 0x1p-60f);
    assert_bits(btf_ref_pow(0.5f, 60.001f), 0.0f);
    assert_bits(btf_ref_pow(0x1p-24f, 0x1p24f), 0.0f);
    assert_bits(btf_ref_pow(0x1p-24f, -0x1p24f), 0x1p40f);
    assert_bits(btf_ref_pow(2.0f, 1000.0f), 0x1p40f);
    assert_bits(btf_ref_pow(1.0f, 0x1p24f), 1.0f);
    assert_bits(btf_ref_pow(0.25f, 0.5f), 0.5f);
}

TEST(test_half) {
    for (uint32_t h = 0; h < 65536; ++h) {
        int sign = h & 0x8000 ? -1 : 1, exponent = (int)(h >> 10 & 31), mantissa = (int)(h & 1023);
        float value = btf_ref_half((uint16_t)h);
        if (exponent == 31) {
            assert_true(mantissa ? isnan(value) : isinf(value));
        } else {
            double truth = exponent ? ldexp(1024 + mantissa, exponent - 25) : ldexp(mantissa, -24);
            assert_bits(value, (float)(sign * truth));
        }
        assert_int_equal(bits_of(value) >> 31, h >> 15);
    }
}

/* --- section 9, texture coordinates; sections 3 and 5 --- */

TEST(test_coordinate) {
    static const uint32_t zero[] = {
        0,           0x80000000u,                           /* 0, -0 */
        1,           0x80000001u, 0x007FFFFFu, 0x807FFFFFu, /* denormal */
        0x45800001u, 0xC5800001u,                           /* the floats beyond 4096 */
        0x7F800000u, 0xFF800000u,                           /* infinite */
        0x7FC00000u, 0xFFC00001u, 0x7F800001u, 0x7F7FFFFFu,
    };
    for (size_t i = 0; i < sizeof zero / sizeof *zero; ++i) {
        assert_int_equal(btf_ref_coordinate(float_of(zero[i]), 16384), 0);
    }
    assert_int_equal(btf_ref_coordinate(0x1p-126f, 16384), 0);
    assert_int_equal(btf_ref_coordinate(-0x1p-126f, 16384),
                     0x3FFFFu * 16384u); /* just below 0: the far end */
    assert_int_equal(btf_ref_coordinate(-0x1p-126f, 1), 0x3FFFFu);
    assert_int_equal(btf_ref_coordinate(4096.0f, 16384), 0);
    assert_int_equal(btf_ref_coordinate(-4096.0f, 16384), 0);
    assert_int_equal(btf_ref_coordinate(float_of(0x457FFFFFu), 16384) >> 18,
                     16380); /* 4096 - 2^-12, of 4 texels */
    assert_int_equal(btf_ref_coordinate(0.5f, 3), 3u << 17);
    assert_int_equal(btf_ref_coordinate(0.75f, 16384) >> 18, 12288);
    assert_int_equal(btf_ref_coordinate(-0.25f, 16384) >> 18, 12288);
    assert_int_equal(btf_ref_coordinate(float_of(0x3F7FFFFFu), 16384) >> 18, 16383); /* just below 1 */

    uint32_t random = 9;
    for (int i = 0; i < 200000; ++i) {
        float c = random_float(&random, -3000.0f, 6000.0f);
        uint32_t size = 1 + random_below(&random, 16384);
        double fixed = floor((double)c * 262144.0);
        double wrapped = fixed - 262144.0 * floor(fixed / 262144.0);
        if (fabsf(c) >= 0x1p-126f) {
            assert_true((double)btf_ref_coordinate(c, size) == wrapped * size);
        }
    }
}

TEST(test_bilinear) {
    static const uint32_t sizes[] = {1, 2, 3, 5, 81, 4096, 16383, 16384};
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; ++i) {
        uint32_t size = sizes[i], c0, c1, weight;
        for (uint32_t c = 0; c < size; ++c) {
            btf_ref_bilinear((c << 18) + (1u << 17), size, &c0, &c1, &weight); /* at a texel's centre */
            assert_int_equal(c0, c);
            assert_int_equal(c1, (c + 1) % size);
            assert_int_equal(weight, 0);
            btf_ref_bilinear(c << 18, size, &c0, &c1, &weight); /* on the border to the texel before */
            assert_int_equal(c0, (c + size - 1) % size);
            assert_int_equal(c1, c);
            assert_int_equal(weight, 128);
            btf_ref_bilinear((c << 18) + (1u << 17) - 1, size, &c0, &c1, &weight);
            assert_int_equal(c1, c);
            assert_int_equal(weight, 255);
        }
    }
}

TEST(test_wrap) {
    static const uint32_t sizes[] = {1, 2, 3, 64, 127, 128, 129, 16384};
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; ++i) {
        for (int shift = -128; shift <= 127; ++shift) {
            uint32_t positions[3] = {0, sizes[i] / 2, sizes[i] - 1};
            for (int p = 0; p < 3; ++p) {
                int64_t expected = (int64_t)positions[p] + shift + 128 * (int64_t)sizes[i];
                assert_int_equal(btf_ref_wrap(positions[p], shift, sizes[i]), expected % sizes[i]);
            }
        }
    }
}

/** Every tile and every centre has its own texels of the atlas; `room` centres fit, and no more. */
static void check_atlas(uint32_t size, uint32_t directions, uint32_t width, uint32_t height,
                        uint32_t room) {
    btf_ref_material m = {
        .width = size,
        .height = size,
        .n_views = directions,
        .n_lights = directions,
        .effects = BTF_REF_HIDDEN,
        .centres = room,
        .atlas_width = width,
        .atlas_height = height,
    };
    uint8_t *used = calloc(width, height);
    assert_non_null(used);
    uint32_t x, y;
    for (uint32_t tile = 0; tile < directions; ++tile) {
        btf_ref_tile(&m, tile, size - 1, size - 1, &x, &y);
        assert_true(x < width && y < height);
        btf_ref_tile(&m, tile, 0, 0, &x, &y);
        for (uint32_t row = 0; row < size; ++row) {
            uint8_t *line = used + (size_t)(y + row) * width + x;
            assert_null(memchr(line, 1, size));
            memset(line, 1, size);
        }
    }
    for (uint32_t centre = 0; centre < room; ++centre) {
        for (uint32_t light = 0; light < directions; ++light) {
            btf_ref_centre(&m, centre, light, &x, &y);
            if (!(x < width && y < height) || used[(size_t)y * width + x] != 0) {
                fail_msg("centre %u light %u at (%u, %u) is outside or taken", centre, light, x, y);
            }
            used[(size_t)y * width + x] = 1;
        }
    }
    btf_ref_centre(&m, room, directions - 1, &x, &y);
    assert_true(y >= height);
    free(used);
}

TEST(test_atlas) {
    check_atlas(64, 81, 1024, 512, 1984);
    check_atlas(32, 81, 512, 256, 480);
    check_atlas(256, 81, 4096, 2048, 35840);
    check_atlas(400, 151, 8192, 4096, 52336);
    check_atlas(64, 16, 512, 512, 12288); /* full rows of tiles: no narrow band */
    check_atlas(64, 9, 512, 128, 3136);   /* none but narrow bands */

    btf_ref_material m = {.width = 64, .height = 64, .n_views = 81, .n_lights = 81, .centres = 1984};
    m.atlas_width = 1024, m.atlas_height = 512;
    uint32_t x, y;
    btf_ref_tile(&m, 80, 5, 6, &x, &y); /* below the 80 tiles of 1024 x 320 */
    assert_true(x == 5 && y == 326);
    btf_ref_tile(&m, 17, 5, 6, &x, &y);
    assert_true(x == 69 && y == 70);
    btf_ref_centre(&m, 0, 3, &x, &y);
    assert_true(x == 64 && y == 323);
    btf_ref_centre(&m, 959, 0, &x, &y);
    assert_true(x == 1023 && y == 320);
    btf_ref_centre(&m, 960, 80, &x, &y);
    assert_true(x == 0 && y == 481);
    btf_ref_centre(&m, 1983, 80, &x, &y);
    assert_true(x == 1023 && y == 481);
}

TEST(test_tight_centres) {
    /* blocks, rows */
    static const uint32_t cases[][3] = {
        {1, 1, 1}, {4096, 1, 4096}, {4097, 2, 2049}, {10000, 3, 3334}, {65536, 16, 4096},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        btf_ref_material m = {.n_lights = 7, .layout_tight = 1, .centres = cases[i][0]};
        uint32_t rows = cases[i][2];
        for (uint32_t centre = 0; centre < cases[i][0]; ++centre) {
            uint32_t x, y;
            btf_ref_centre(&m, centre, 6, &x, &y);
            assert_int_equal(y, centre % rows);
            assert_int_equal(x, centre / rows * 7 + 6);
            assert_true(x < 7 * cases[i][1]);
        }
    }
}

/* --- section 6 --- */

static void assert_neighbours(btf_ref_neighbours n, uint32_t i0, uint32_t w0, uint32_t i1, uint32_t w1,
                              uint32_t i2, uint32_t w2) {
    if (n.index[0] != i0 || n.index[1] != i1 || n.index[2] != i2 || n.weight[0] != w0 ||
        n.weight[1] != w1 || n.weight[2] != w2) {
        fail_msg("(%u %u) (%u %u) (%u %u), expected (%u %u) (%u %u) (%u %u)", n.index[0], n.weight[0],
                 n.index[1], n.weight[1], n.index[2], n.weight[2], i0, w0, i1, w1, i2, w2);
    }
}

static btf_ref_neighbours look_up(const uint16_t *table, uint32_t grid, int32_t x, int32_t y) {
    int32_t q[2] = {x, y};
    return btf_ref_lookup(table, grid, q);
}

TEST(test_project) {
    static const struct {
        float direction[3];
        int32_t q[2];
    } cases[] = {
        {{0, 0, 1}, {8192, 8192}},
        {{1, 0, 0}, {16384, 8192}},
        {{-1, 0, 0}, {0, 8192}},
        {{0, 1, 0}, {8192, 16384}},
        {{0, -1, 0}, {8192, 0}},
        {{0.6f, 0, 0.8f}, {8192 + 2731, 8192}}, /* 8192 / 3 = 2730.7 */
        {{0, -0.6f, 0.8f}, {8192, 8192 - 2731}},
        {{2, -2, 0x1p-24f}, {16384, 0}}, /* clamped */
        {{-0.0f, 0x1p-149f, 1}, {8192, 8192}},
        {{NAN, INFINITY, 1}, {0, 16384}}, /* undefined, but within the plane */
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        int32_t q[2];
        btf_ref_project(cases[i].direction, q);
        assert_int_equal(q[0], cases[i].q[0]);
        assert_int_equal(q[1], cases[i].q[1]);
    }
    /* against the formula in double: halves may round either way */
    uint32_t random = 3;
    for (int i = 0; i < 100000; ++i) {
        float d[3];
        int32_t q[2];
        random_direction(&random, d);
        btf_ref_project(d, q);
        for (int k = 0; k < 2; ++k) {
            assert_true(fabs((double)d[k] / (1 + (double)d[2]) * 8192 + 8192 - q[k]) <= 0.502);
        }
    }
}

TEST(test_lookup_small) {
    static uint16_t table[4 * 64 * 64 * (1 + 3 * 4)]; /* 64 x 64 cells of 4 records */

    /* one direction: a cell without records */
    memset(table, 0, sizeof table);
    assert_neighbours(look_up(table, 1, 16384, 0), 0, 4096, 0, 0, 0, 0);

    /* two directions: along, beside and beyond the edge there and back */
    direction_set two = {
        .n_vertices = 2, .n_hull = 2, .vertices = {{1000, 8000}, {5096, 8000}}, .hull = {0, 1}};
    make_table(&two, 2, table);
    assert_neighbours(look_up(table, 2, 1000, 8000), 0, 4096, 1, 0, 0, 0);
    assert_neighbours(look_up(table, 2, 5096, 8000), 0, 0, 1, 4096, 0, 0);
    assert_neighbours(look_up(table, 2, 1001, 8000), 0, 4095, 1, 1, 0, 0);
    assert_neighbours(look_up(table, 2, 2024, 3000), 0, 3072, 1, 1024, 0, 0);
    assert_neighbours(look_up(table, 2, 2024, 16384), 1, 1024, 0, 3072, 1, 0); /* the way back */
    assert_neighbours(look_up(table, 2, 16384, 9000), 1, 4096, 1, 0, 1, 0);
    assert_neighbours(look_up(table, 2, 0, 9000), 0, 4096, 0, 0, 0, 0);

    /* three in a line */
    direction_set line = {.n_vertices = 3,
                          .n_hull = 4,
                          .vertices = {{0, 0}, {4096, 4096}, {16384, 16384}},
                          .hull = {0, 1, 2, 1}};
    make_table(&line, 1, table);
    assert_neighbours(look_up(table, 1, 2048, 2048), 0, 2048, 1, 2048, 0, 0);
    assert_neighbours(look_up(table, 1, 16384, 0), 1, 4096 - 1365, 2, 1365, 1, 0);
    assert_neighbours(look_up(table, 1, 0, 16384), 2, 1366, 1, 2730, 2, 0);

    /* one triangle over all the square: the largest areas, with shifts */
    direction_set large = {.n_vertices = 3,
                           .n_triangles = 1,
                           .n_hull = 3,
                           .vertices = {{0, 0}, {16384, 0}, {0, 16384}},
                           .triangles = {{0, 1, 2}},
                           .hull = {0, 1, 2}};
    make_table(&large, 64, table);
    assert_int_equal(table[4 * 64 * 64 + 7] >> 1, 10);       /* A = 2^28 */
    assert_int_equal(table[4 * (64 * 64 + 6) + 7] >> 1, 11); /* n = 2^29, the second edge */
    assert_neighbours(look_up(table, 64, 0, 0), 0, 4096, 1, 0, 2, 0);
    assert_neighbours(look_up(table, 64, 16384, 0), 0, 0, 1, 4096, 2, 0);
    assert_neighbours(look_up(table, 64, 0, 16384), 0, 0, 1, 0, 2, 4096);
    assert_neighbours(look_up(table, 64, 8192, 4096), 0, 1024, 1, 2048, 2, 1024);
    assert_neighbours(look_up(table, 64, 16384, 16384), 1, 2048, 2, 2048, 1,
                      0); /* beyond the slanted edge */
    assert_neighbours(look_up(table, 64, 16384, 8192), 1, 3072, 2, 1024, 1, 0);
}

/** Numbers of directions take 16 bits each, whichever record names them. */
TEST(test_lookup_wide) {
    static const uint32_t indices[][3] = {
        {256, 511, 4095}, {4095, 255, 256}, {0x1234, 0xABCD, 0xFFFF}, {65535, 0, 65534}};
    for (size_t i = 0; i < sizeof indices / sizeof *indices; ++i) {
        const uint16_t a = (uint16_t)indices[i][0], b = (uint16_t)indices[i][1],
                       c = (uint16_t)indices[i][2];
        /* a triangle of area 2^24, shift 6, and the edge below it with the cone at its end */
        const uint16_t table[] = {0, 2, 0,    0,    4096, 4096, 8192, 4096, 4096, 8192, c, 12, a, b,
                                  0, 0, 4096, 4096, 8192, 4096, 4096, 8192, c,    13,   a, b,  0, 0};
        assert_neighbours(look_up(table, 1, 5120, 6144), a, 1024, b, 1024, c, 2048);
        assert_neighbours(look_up(table, 1, 5120, 4000), a, 3072, b, 1024, a, 0);
        assert_neighbours(look_up(table, 1, 9000, 4000), b, 4096, b, 0, b, 0);
    }
}

TEST(test_lookup_corner) {
    static uint16_t table[MADE_TABLE];
    direction_set corner = {.n_vertices = 3,
                            .n_triangles = 1,
                            .n_hull = 3,
                            .vertices = {{4096, 4096}, {8192, 4096}, {8192, 8192}},
                            .triangles = {{0, 1, 2}},
                            .hull = {0, 1, 2}};
    make_table(&corner, 2, table);
    assert_neighbours(look_up(table, 2, 9000, 4096), 1, 4096, 1, 0, 1, 0);
    assert_neighbours(look_up(table, 2, 9000, 4097), 1, 4095, 2, 1, 1, 0);
    assert_neighbours(look_up(table, 2, 9000, 8192), 1, 0, 2, 4096, 1, 0);
    assert_neighbours(look_up(table, 2, 8192, 4000), 0, 0, 1, 4096, 0, 0);
}

TEST(test_lookup_octagon) {
    static uint16_t table[2][MADE_TABLE];
    make_table(&made_views, MADE_GRID, table[0]);
    make_table(&made_views, 1, table[1]);
    for (uint32_t i = 0; i < made_views.n_vertices; ++i) { /* exact on the samples */
        btf_ref_neighbours n = btf_ref_nearest(
            look_up(table[0], MADE_GRID, made_views.vertices[i][0], made_views.vertices[i][1]));
        assert_neighbours(n, i, 4096, i, 0, i, 0);
    }
    /* midway on an edge: rounded down twice, and the third gets the rest */
    assert_neighbours(look_up(table[0], MADE_GRID, 11192, 8192), 0, 2047, 1, 2047, 2, 2);
    assert_neighbours(look_up(table[0], MADE_GRID, 16384, 8192), 1, 4096, 1, 0, 1, 0);
    assert_neighbours(look_up(table[0], MADE_GRID, 16384, 16384), 2, 4096, 2, 0, 2, 0);

    uint32_t random = 11;
    for (int i = 0; i < 200000; ++i) {
        int32_t x = (int32_t)random_below(&random, 16385), y = (int32_t)random_below(&random, 16385);
        btf_ref_neighbours n = look_up(table[0], MADE_GRID, x, y), m = look_up(table[1], 1, x, y);
        assert_memory_equal(&n, &m, sizeof n);
        assert_int_equal(n.weight[0] + n.weight[1] + n.weight[2], 4096);
        double px = 0, py = 0;
        for (int k = 0; k < 3; ++k) {
            px += made_views.vertices[n.index[k]][0] * n.weight[k] / 4096.0;
            py += made_views.vertices[n.index[k]][1] * n.weight[k] / 4096.0;
        }
        double radius = hypot(x - 8192.0, y - 8192.0), error = hypot(px - x, py - y);
        if (radius < 5500) {
            assert_true(error < 8); /* inside, the weights reproduce the point, up to their step */
        } else if (radius > 6100) {
            assert_true(error < radius - 5500 &&
                        hypot(px - 8192, py - 8192) < 6010); /* outside, one of the hull */
        }
    }
}

TEST(test_nearest) {
    btf_ref_neighbours n = {{3, 5, 7}, {2000, 2000, 96}};
    assert_neighbours(btf_ref_nearest(n), 3, 4096, 3, 0, 3, 0);
    n = (btf_ref_neighbours){{3, 5, 7}, {100, 1998, 1998}};
    assert_neighbours(btf_ref_nearest(n), 5, 4096, 5, 0, 5, 0);
    n = (btf_ref_neighbours){{3, 5, 7}, {1365, 1365, 1366}};
    assert_neighbours(btf_ref_nearest(n), 7, 4096, 7, 0, 7, 0);
}

/* --- the build --- */

TEST(test_self_test) {
    assert_int_equal(btf_ref_self_test(), 1);
}

RUN_TESTS(NULL, NULL)
