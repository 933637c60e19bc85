/* The reference decoder, whole evaluations: small materials worked out by hand, made-up ones against a
 * model in double precision and against each other, hostile ones for what is promised of every result.
 *
 * SPDX-License-Identifier: MIT
 */
#include "reference_assert.h"
#include "tests/support/reference_material.h"

#define ALL_EFFECTS (BTF_REF_SHADOW | BTF_REF_SHIFT | BTF_REF_HIDDEN | BTF_REF_GAIN | BTF_REF_RESIDUAL)

/* --- section 9, by hand --- */

/** A material whose numbers a test sets: 7 x 5 texels, 9 views, 5 lights; all zero but scales of 1. */
typedef struct fixture {
    made_storage s;
    btf_ref_material m;
    btf_ref_options o;
} fixture;

static fixture *plain(int layout_tight, uint32_t effects) {
    static fixture f;
    make_material(1, (uint32_t)layout_tight, effects, 0, &f.s, &f.m);
    memset(f.s.sbrdf, 0, sizeof f.s.sbrdf);
    memset(f.s.maps, 0, sizeof f.s.maps);
    memset(f.s.shadow, 0, sizeof f.s.shadow);
    memset(f.s.shift, 0, sizeof f.s.shift);
    memset(f.s.gain, 0, sizeof f.s.gain);
    memset(f.s.centre, 0, sizeof f.s.centre);
    memset(f.s.residual_texels, 0, sizeof f.s.residual_texels);
    memset(f.s.residual_directions, 0, sizeof f.s.residual_directions);
    memset(f.s.residual_scales, 0, sizeof f.s.residual_scales);
    f.m.lobes = 1;
    f.m.components = 1;
    f.m.radiance_scale = f.m.shadow_scale = f.m.gain_scale = f.m.centre_scale = 1.0f;
    f.o = (btf_ref_options){.effects = UINT32_MAX, .components = UINT32_MAX};
    return &f;
}

static float *parameter(fixture *f, uint32_t layer, uint32_t column, uint32_t row) {
    return f->s.sbrdf + 4 * ((layer * MADE_HEIGHT + row) * MADE_WIDTH + column);
}

static void set_shadow(fixture *f, uint32_t column, uint32_t row, uint32_t light, uint8_t code) {
    uint32_t x, y;
    btf_ref_tile(&f->m, light, column, row, &x, &y);
    f->s.maps[4 * (y * MADE_ATLAS + x)] = code;
    f->s.shadow[(light * MADE_HEIGHT + row) * MADE_WIDTH + column] = code;
}

static void set_view(fixture *f, uint32_t column, uint32_t row, uint32_t view, uint8_t gain, int b0,
                     int b1) {
    uint32_t x, y, texel = (view * MADE_HEIGHT + row) * MADE_WIDTH + column;
    btf_ref_tile(&f->m, view, column, row, &x, &y);
    uint8_t *map = f->s.maps + 4 * (y * MADE_ATLAS + x);
    map[1] = f->s.gain[texel] = gain;
    map[2] = f->s.shift[2 * texel] = (uint8_t)b0;
    map[3] = f->s.shift[2 * texel + 1] = (uint8_t)b1;
}

static void set_centre(fixture *f, uint32_t centre, uint32_t light, uint8_t r, uint8_t g, uint8_t b) {
    uint32_t x, y;
    btf_ref_centre(&f->m, centre, light, &x, &y);
    uint8_t *texel =
        f->m.layout_tight ? f->s.centre + 4 * (y * MADE_LIGHTS + x) : f->s.maps + 4 * (y * MADE_ATLAS + x);
    texel[0] = r;
    texel[1] = g;
    texel[2] = b;
}

/** Any direction beside the vertices does; these two project to vertex 0 of their sets: exactly for the
 * pole. */
static const float pole[3] = {0, 0, 1};

/** Texel (column, row), the view that is index `view` alone, the light index `light` alone. */
static void evaluate_pair(const fixture *f, uint32_t column, uint32_t row, uint32_t light_index,
                          uint32_t view_index, const float light[3], const float view[3],
                          float out_rgb[3]) {
    btf_ref_neighbours lights = {{light_index, 0, 0}, {4096, 0, 0}},
                       views = {{view_index, 0, 0}, {4096, 0, 0}};
    btf_ref_evaluate_neighbours(&f->m, &f->o, column, row, &lights, &views, light, view, out_rgb);
}

/** Texel (column, row) is 1 / (1 + column + 8 row) of white: each has a value of its own. */
static float own_albedo(uint32_t column, uint32_t row) {
    return 1.0f / (float)(1 + column + 8 * row);
}

static void set_lambertian(fixture *f) {
    for (uint32_t row = 0; row < MADE_HEIGHT; ++row) {
        for (uint32_t column = 0; column < MADE_WIDTH; ++column) {
            float *p = parameter(f, 0, column, row);
            p[0] = 1.0f, p[1] = 0.5f, p[2] = 0.25f, p[3] = own_albedo(column, row);
        }
    }
}

static void test_lambertian(void **state) {
    (void)state;
    float light[3] = {0.6f, 0.0f, 0.8f}, rgb[3];
    for (int tight = 0; tight < 2; ++tight) {
        fixture *f = plain(tight, 0);
        set_lambertian(f);
        float value = own_albedo(3, 2) * 0.8f;
        btf_ref_evaluate_texel(&f->m, &f->o, 3, 2, light, pole, rgb);
        assert_rgb(rgb, value, 0.5f * value, 0.25f * value);
        f->m.radiance_scale = 4.0f;
        btf_ref_evaluate_texel(&f->m, &f->o, 3, 2, light, pole, rgb);
        assert_rgb(rgb, 4 * value, 2 * value, value);

        /* sqrt: y = albedo * sqrt(l.z), L = y * y; the root of 1/4 is exact */
        f->m.domain_sqrt = 1;
        f->m.radiance_scale = 1.0f;
        float low[3] = {0.9f, 0.0f, 0.25f}, y = own_albedo(3, 2) * 0.5f;
        btf_ref_evaluate_texel(&f->m, &f->o, 3, 2, low, pole, rgb);
        assert_rgb(rgb, y * y, 0.25f * (y * y), 0.0625f * (y * y));
    }
}

static void test_lobes(void **state) {
    (void)state;
    float l[3] = {0.5f, 0.0f, 0.5f}, v[3] = {-0.5f, 0.25f, 1.0f}, rgb[3];
    fixture *f = plain(1, 0);
    f->m.lobes = 2;
    float *colour = parameter(f, 0, 0, 0), *first = parameter(f, 1, 0, 0), *second = parameter(f, 2, 0, 0);
    /* P = (-1/4, 0, 1/2): b = 1/4 + 0 + 1/4 = 1/2, cubed 1/8; the second is below the horizon */
    colour[0] = 1.0f, colour[1] = 2.0f, colour[2] = 3.0f, colour[3] = 0.5f;
    first[0] = -1.0f, first[1] = 7.0f, first[2] = 0.5f, first[3] = 3.0f;
    second[0] = 1.0f, second[1] = -1.0f, second[2] = 0.25f, second[3] = 2.0f;
    btf_ref_evaluate_texel(&f->m, &f->o, 0, 0, l, v, rgb);
    assert_rgb(rgb, 0.625f * 0.5f, 1.25f * 0.5f, 1.875f * 0.5f);

    /* the same lobes with colours: numbers 0..2 diffuse, 3..5 and 6..8 weights; lobes in layers 3 and 4 */
    f->m.colour = BTF_REF_RGB;
    memset(f->s.sbrdf, 0, sizeof f->s.sbrdf);
    static const float numbers[9] = {0.5f, 0.25f, 0.125f, 8.0f, 16.0f, 32.0f, 99.0f, 99.0f, 99.0f};
    for (uint32_t i = 0; i < 9; ++i)
        parameter(f, i / 4, 0, 0)[i % 4] = numbers[i];
    first = parameter(f, 3, 0, 0), second = parameter(f, 4, 0, 0);
    first[0] = -1.0f, first[1] = 7.0f, first[2] = 0.5f, first[3] = 3.0f;
    second[0] = 1.0f, second[1] = -1.0f, second[2] = 0.25f, second[3] = 2.0f;
    btf_ref_evaluate_texel(&f->m, &f->o, 0, 0, l, v, rgb);
    assert_rgb(rgb, (0.5f + 1) * 0.5f, (0.25f + 2) * 0.5f, (0.125f + 4) * 0.5f);

    /* as halves */
    f->m.half_float = 1;
    f->m.sbrdf = f->s.sbrdf_half;
    memset(f->s.sbrdf_half, 0, sizeof f->s.sbrdf_half);
    f->s.sbrdf_half[0] = 0x3C00, f->s.sbrdf_half[1] = 0xBC00, f->s.sbrdf_half[2] = 1; /* 1, -1, 2^-24 */
    btf_ref_evaluate_texel(&f->m, &f->o, 0, 0, l, v, rgb);
    assert_rgb(rgb, 0.5f, 0.0f, 0x1p-25f);

    /* negative lobes and weights may not make light */
    f->m.half_float = 0;
    f->m.sbrdf = f->s.sbrdf;
    parameter(f, 0, 0, 0)[3] = -1000.0f;
    btf_ref_evaluate_texel(&f->m, &f->o, 0, 0, l, v, rgb);
    assert_bits(rgb[0], 0.0f);
}

static void test_shadow(void **state) {
    (void)state;
    float rgb[3];
    for (int tight = 0; tight < 2; ++tight) {
        fixture *f = plain(tight, BTF_REF_SHADOW);
        set_lambertian(f);
        f->m.shadow_scale = 0x1p-7f;
        set_shadow(f, 4, 1, 0, 128);
        set_shadow(f, 4, 1, 1, 64);
        set_shadow(f, 4, 1, 2, 255);
        float albedo = own_albedo(4, 1);
        evaluate_pair(f, 4, 1, 0, 0, pole, pole, rgb);
        assert_rgb(rgb, albedo, 0.5f * albedo, 0.25f * albedo);
        evaluate_pair(f, 4, 1, 1, 0, pole, pole, rgb);
        assert_bits(rgb[0], 0.5f * albedo);
        evaluate_pair(f, 4, 1, 3, 0, pole, pole, rgb);
        assert_bits(rgb[0], 0.0f);

        /* three lights: (1024 * 128 + 2048 * 64 + 1024 * 255) / 4096 = 127.75 */
        f->o.interpolation = BTF_REF_LINEAR;
        btf_ref_neighbours lights = {{0, 1, 2}, {1024, 2048, 1024}}, views = {{0, 0, 0}, {4096, 0, 0}};
        btf_ref_evaluate_neighbours(&f->m, &f->o, 4, 1, &lights, &views, pole, pole, rgb);
        assert_bits(rgb[0], albedo * 0.998046875f);
        f->o.interpolation = BTF_REF_NEAREST;
        btf_ref_evaluate_neighbours(&f->m, &f->o, 4, 1, &lights, &views, pole, pole, rgb);
        assert_bits(rgb[0], 0.5f * albedo);

        f->o.effects = 0;
        evaluate_pair(f, 4, 1, 3, 0, pole, pole, rgb);
        assert_bits(rgb[0], albedo);
    }
}

static void test_shift_and_gain(void **state) {
    (void)state;
    float rgb[3];
    for (int tight = 0; tight < 2; ++tight) {
        fixture *f = plain(tight, BTF_REF_SHIFT | BTF_REF_GAIN | BTF_REF_SHADOW);
        set_lambertian(f);
        f->m.gain_scale = 0x1p-7f;
        f->m.shadow_scale = 0x1p-7f;
        for (uint32_t row = 0; row < MADE_HEIGHT; ++row)
            for (uint32_t column = 0; column < MADE_WIDTH; ++column)
                set_shadow(f, column, row, 0, row == 3 ? 64 : 128);

        set_view(f, 1, 1, 4, 128, 2, 1); /* + is to the right and down; the shadow is the source's */
        evaluate_pair(f, 1, 1, 0, 4, pole, pole, rgb);
        assert_bits(rgb[0], own_albedo(3, 2));
        set_view(f, 1, 1, 4, 192, 2, 2);
        evaluate_pair(f, 1, 1, 0, 4, pole, pole, rgb);
        assert_bits(rgb[0], own_albedo(3, 3) * 0.5f * 1.5f);
        set_view(f, 1, 1, 4, 1, 256 - 2, 256 - 3); /* wrapped: column 6, row 3 */
        evaluate_pair(f, 1, 1, 0, 4, pole, pole, rgb);
        assert_bits(rgb[0], own_albedo(6, 3) * 0.5f * 0x1p-7f);
        set_view(f, 1, 1, 4, 255, 127, 128); /* 1 + 127 = 128 = 18 * 7 + 2; 1 - 128 = -127 = -26 * 5 + 3 */
        evaluate_pair(f, 1, 1, 0, 4, pole, pole, rgb);
        assert_bits(rgb[0], own_albedo(2, 3) * 0.5f * (255 * 0x1p-7f));

        f->o.effects = BTF_REF_SHADOW | BTF_REF_SHIFT; /* no gain */
        evaluate_pair(f, 1, 1, 0, 4, pole, pole, rgb);
        assert_bits(rgb[0], own_albedo(2, 3) * 0.5f);
        f->o.effects = BTF_REF_GAIN | BTF_REF_SHADOW; /* no shift */
        evaluate_pair(f, 1, 1, 0, 4, pole, pole, rgb);
        assert_bits(rgb[0], own_albedo(1, 1) * (255 * 0x1p-7f));
    }

    /* a file with shifts alone stores no gain code, whatever stands there */
    fixture *f = plain(0, BTF_REF_SHIFT);
    set_lambertian(f);
    set_view(f, 1, 1, 4, 0, 2, 1);
    evaluate_pair(f, 1, 1, 0, 4, pole, pole, rgb);
    assert_bits(rgb[0], own_albedo(3, 2));
}

/** Columns and rows from -32, a code of the gain, as section 3 packs them. */
static void set_point(fixture *f, uint32_t column, uint32_t row, uint32_t view, int columns, int rows,
                      int code) {
    uint8_t *bytes = f->s.shift + 2 * ((view * MADE_HEIGHT + row) * MADE_WIDTH + column);
    int p = columns + 32 + 64 * (rows + 32) + 4096 * code;
    bytes[0] = (uint8_t)(p % 256);
    bytes[1] = (uint8_t)(p / 256);
}

static void test_packed_points(void **state) {
    (void)state;
    float rgb[3];
    fixture *f = plain(1, BTF_REF_SHIFT | BTF_REF_GAIN);
    set_lambertian(f);
    make_points(1, 0, &f->s, &f->m);
    f->m.gain_base = 0.25f;
    f->m.gain_step = 0.125f;
    f->m.gain_scale = 77; /* not read */
    set_point(f, 1, 1, 4, 2, 1, 6);
    evaluate_pair(f, 1, 1, 0, 4, pole, pole, rgb);
    assert_bits(rgb[0], own_albedo(3, 2));
    set_point(f, 1, 1, 4, -2, -3, 0); /* code 0 hides nothing; wrapped: column 6, row 3 */
    evaluate_pair(f, 1, 1, 0, 4, pole, pole, rgb);
    assert_bits(rgb[0], own_albedo(6, 3) * 0.25f);
    set_point(f, 1, 1, 4, 31, -32, 15); /* 1 + 31 = 32 = 4 * 7 + 4; 1 - 32 = -31 = -7 * 5 + 4 */
    evaluate_pair(f, 1, 1, 0, 4, pole, pole, rgb);
    assert_bits(rgb[0], own_albedo(4, 4) * 2.125f);
    set_point(f, 1, 1, 4, -32, 31, 15); /* -31 = -5 * 7 + 4; 32 = 6 * 5 + 2 */
    evaluate_pair(f, 1, 1, 0, 4, pole, pole, rgb);
    assert_bits(rgb[0], own_albedo(4, 2) * 2.125f);

    f->o.effects = BTF_REF_SHIFT; /* no gain */
    evaluate_pair(f, 1, 1, 0, 4, pole, pole, rgb);
    assert_bits(rgb[0], own_albedo(4, 2));
    f->o.effects = BTF_REF_GAIN; /* no shift */
    evaluate_pair(f, 1, 1, 0, 4, pole, pole, rgb);
    assert_bits(rgb[0], own_albedo(1, 1) * 2.125f);
    f->o.effects = 0;
    evaluate_pair(f, 1, 1, 0, 4, pole, pole, rgb);
    assert_bits(rgb[0], own_albedo(1, 1));

    /* one multiplication, then one addition, each rounded */
    f->o.effects = UINT32_MAX;
    f->m.gain_base = 1.0f;
    f->m.gain_step = 0x1.555556p-26f; /* 3 of them are 2^-24 rounded, and more than that before: a tie, not 1 + 2^-23 */
    set_point(f, 1, 1, 4, 0, 0, 3);
    parameter(f, 0, 1, 1)[3] = 1.0f;
    evaluate_pair(f, 1, 1, 0, 4, pole, pole, rgb);
    assert_bits(rgb[0], 1.0f);
    f->m.gain_base = -1.0f; /* of either sign, clamped as ever */
    evaluate_pair(f, 1, 1, 0, 4, pole, pole, rgb);
    assert_rgb(rgb, 0, 0, 0);
}

/* A texel's list, and half a byte a view that names an entry: the low one of an even view. */
static void test_lists(void **state) {
    (void)state;
    static uint8_t indices[MADE_VIEWS * MADE_TEXELS];
    float rgb[3];
    fixture *f = plain(1, BTF_REF_SHIFT | BTF_REF_GAIN);
    set_lambertian(f);
    make_points(1, 0, &f->s, &f->m);
    make_lists(1, 1, &indices, &f->s, &f->m);
    f->m.gain_base = 0.25f;
    f->m.gain_step = 0.125f;
    const uint32_t texel = MADE_WIDTH + 1;
    for (int entry = 0; entry < 5; ++entry) /* set_point's view is an entry here */
        set_point(f, 1, 1, (uint32_t)entry, entry - 1, entry == 4, 2 * entry);
    indices[2 * MADE_TEXELS + texel] = 0x14; /* view 4 has entry 4, view 5 entry 1 */
    evaluate_pair(f, 1, 1, 0, 4, pole, pole, rgb);
    assert_bits(rgb[0], own_albedo(4, 2) * 1.25f);
    evaluate_pair(f, 1, 1, 0, 5, pole, pole, rgb);
    assert_bits(rgb[0], own_albedo(1, 1) * 0.5f);
    indices[2 * MADE_TEXELS + texel] = 0x03;
    evaluate_pair(f, 1, 1, 0, 4, pole, pole, rgb);
    assert_bits(rgb[0], own_albedo(3, 1));
    evaluate_pair(f, 1, 1, 0, 5, pole, pole, rgb);
    assert_bits(rgb[0], own_albedo(0, 1) * 0.25f);
    indices[2 * MADE_TEXELS + texel + 1] = 0xFF; /* another texel's says nothing here */
    f->o.effects = BTF_REF_SHIFT;
    evaluate_pair(f, 1, 1, 0, 4, pole, pole, rgb);
    assert_bits(rgb[0], own_albedo(3, 1));
    f->o.effects = BTF_REF_GAIN;
    evaluate_pair(f, 1, 1, 0, 5, pole, pole, rgb);
    assert_bits(rgb[0], own_albedo(1, 1) * 0.25f);
}

static void test_hidden(void **state) {
    (void)state;
    float light[3] = {0.0f, 0.0f, 0.5f}, rgb[3];
    for (int tight = 0; tight < 2; ++tight) {
        for (int domain = 0; domain < 2; ++domain) {
            fixture *f = plain(tight, BTF_REF_SHIFT | BTF_REF_GAIN | BTF_REF_HIDDEN);
            set_lambertian(f);
            f->m.domain_sqrt = domain;
            f->m.centre_scale = 0x1p-8f;
            f->m.gain_scale = 0x1p-7f;
            set_centre(f, 120, 3, 128, 64, 255);
            set_centre(f, 120, 4, 64, 64, 1);
            set_view(f, 2, 4, 7, 0, 120, 0);
            evaluate_pair(f, 2, 4, 3, 7, light, pole,
                          rgb); /* squared in both domains; no cosine, no gain */
            assert_rgb(rgb, 0.25f, 0.0625f, 255.0f / 256 * (255.0f / 256));
            f->o.interpolation = BTF_REF_LINEAR;
            btf_ref_neighbours lights = {{3, 4, 0}, {1024, 3072, 0}}, views = {{7, 0, 0}, {4096, 0, 0}};
            btf_ref_evaluate_neighbours(&f->m, &f->o, 2, 4, &lights, &views, light, pole, rgb);
            assert_rgb(rgb, 80.0f / 256 * (80.0f / 256), 0.0625f, 64.5f / 256 * (64.5f / 256));

            /* without hidden: no shift, no gain, whatever the bytes say */
            f->o.effects = BTF_REF_SHIFT | BTF_REF_GAIN;
            float y = own_albedo(2, 4) * btf_ref_pow(0.5f, domain ? 0.5f : 1.0f);
            evaluate_pair(f, 2, 4, 3, 7, light, pole, rgb);
            assert_bits(rgb[0], domain ? y * y : y);
            f->o.effects = BTF_REF_SHIFT; /* the code is read even so: 120 is no shift */
            evaluate_pair(f, 2, 4, 3, 7, light, pole, rgb);
            assert_bits(rgb[0], domain ? y * y : y);
            f->o.effects = BTF_REF_HIDDEN;
            evaluate_pair(f, 2, 4, 3, 7, light, pole, rgb);
            assert_bits(rgb[0], 0.25f);
        }
    }
}

/** Centre 259 is bytes 3 and 1, the low one first. */
static void test_centre_index(void **state) {
    (void)state;
    static uint8_t centres[4 * 300 * MADE_LIGHTS]; /* one block of 300 rows */
    float rgb[3];
    fixture *f = plain(1, BTF_REF_HIDDEN);
    f->m.centres = 300;
    f->m.centre = centres;
    centres[4 * (259 * MADE_LIGHTS + 2)] = 3;
    centres[4 * (259 * MADE_LIGHTS + 2) + 1] = 255;
    set_view(f, 0, 0, 8, 0, 3, 1);
    evaluate_pair(f, 0, 0, 2, 8, pole, pole, rgb);
    assert_rgb(rgb, 9.0f, 65025.0f, 0.0f);
}

static void test_two_views(void **state) {
    (void)state;
    float rgb[3];
    fixture *f = plain(0, BTF_REF_GAIN | BTF_REF_SHIFT | BTF_REF_HIDDEN);
    set_lambertian(f);
    f->m.domain_sqrt = 1; /* each view is squared before they are blended */
    f->m.gain_scale = 0x1p-7f;
    f->m.centre_scale = 0x1p-8f;
    f->o.interpolation = BTF_REF_LINEAR;
    set_view(f, 0, 0, 1, 64, 0, 0);  /* y = 1/2, L = 1/4 */
    set_view(f, 0, 0, 2, 128, 0, 0); /* L = 1 */
    set_view(f, 0, 0, 3, 0, 5, 0);
    set_centre(f, 5, 0, 192, 0, 0); /* L = 9/16 */
    btf_ref_neighbours lights = {{0, 0, 0}, {4096, 0, 0}}, views = {{1, 2, 3}, {1024, 2048, 1024}};
    btf_ref_evaluate_neighbours(&f->m, &f->o, 0, 0, &lights, &views, pole, pole, rgb);
    assert_bits(rgb[0], 0.25f * 0.25f + 0.5f + 0.5625f * 0.25f);
}

/** Sets V_j(view, light) of all channels: v, 2 v, -v. */
static void set_v(fixture *f, uint32_t j, uint32_t view, uint32_t light, int v) {
    static const int factors[3] = {1, 2, -1};
    for (uint32_t c = 0; c < 3; ++c) {
        uint32_t layer = 3 * (j / 4) + c;
        f->s.residual_directions[4 * ((layer * MADE_VIEWS + view) * MADE_LIGHTS + light) + j % 4] =
            (int8_t)(v * factors[c]);
    }
}

static void set_u(fixture *f, uint32_t j, uint32_t column, uint32_t row, int u) {
    f->s.residual_texels[4 * ((j / 4 * MADE_HEIGHT + row) * MADE_WIDTH + column) + j % 4] = (int8_t)u;
}

static void test_residual(void **state) {
    (void)state;
    float light[3] = {0.0f, 0.0f, 0.5f}, rgb[3];
    fixture *f = plain(0, BTF_REF_RESIDUAL | BTF_REF_SHIFT);
    f->m.components = 6;
    f->s.residual_scales[0] = 0x1p-10f;
    f->s.residual_scales[5] = -0x1p-8f;
    set_view(f, 1, 2, 6, 128, 1, 0); /* source (2, 2) */
    set_u(f, 0, 2, 2, 100);
    set_u(f, 5, 2, 2, -20);
    set_v(f, 0, 6, 4, 50);
    set_v(f, 5, 6, 4, 10);
    float *p = parameter(f, 0, 2, 2);
    p[0] = p[1] = p[2] = 1.0f, p[3] = 1.0f;
    /* r = 100 * 50 / 1024 + 20 * 10 / 256 = 5000 / 1024 + 800 / 1024 = 5800 / 1024; cosine 1/2 */
    evaluate_pair(f, 1, 2, 4, 6, light, pole, rgb);
    assert_rgb(rgb, (1 + 5800.0f / 1024) / 2, (1 + 11600.0f / 1024) / 2, 0.0f); /* 1 - 5800 / 1024 < 0 */
    f->o.components = 5;                                                        /* as many as are wanted */
    evaluate_pair(f, 1, 2, 4, 6, light, pole, rgb);
    assert_bits(rgb[0], (1 + 5000.0f / 1024) / 2);
    f->o.components = 0;
    evaluate_pair(f, 1, 2, 4, 6, light, pole, rgb);
    assert_rgb(rgb, 0.5f, 0.5f, 0.5f);
    f->o.components = UINT32_MAX;
    f->o.effects = BTF_REF_SHIFT;
    evaluate_pair(f, 1, 2, 4, 6, light, pole, rgb);
    assert_rgb(rgb, 0.5f, 0.5f, 0.5f);

    /* two lights, 3/4 and 1/4; component 5 has light 4 alone */
    f->o.effects = UINT32_MAX;
    f->o.interpolation = BTF_REF_LINEAR;
    set_v(f, 0, 6, 1, 30);
    btf_ref_neighbours lights = {{4, 1, 0}, {3072, 1024, 0}}, views = {{6, 0, 0}, {4096, 0, 0}};
    btf_ref_evaluate_neighbours(&f->m, &f->o, 1, 2, &lights, &views, light, pole, rgb);
    assert_bits(rgb[0], (1 + 4500.0f / 1024 + 600.0f / 1024) / 2);

    /* without an SBRDF: the residual alone, and nothing without it */
    f->m.colour = BTF_REF_NONE;
    f->m.sbrdf = NULL;
    f->m.lobes = 0;
    evaluate_pair(f, 1, 2, 4, 6, light, pole, rgb);
    assert_rgb(rgb, 5800.0f / 2048, 11600.0f / 2048, 0.0f);
    f->o.effects = BTF_REF_SHIFT;
    evaluate_pair(f, 1, 2, 4, 6, light, pole, rgb);
    assert_rgb(rgb, 0.0f, 0.0f, 0.0f);
}

static void test_clamps(void **state) {
    (void)state;
    float rgb[3];
    fixture *f = plain(1, BTF_REF_GAIN);
    float *p = parameter(f, 0, 0, 0);
    set_view(f, 0, 0, 0, 255, 0, 0);
    p[0] = 0x1p24f, p[1] = 0x1p-6f, p[2] = float_of(bits_of(0x1p-6f) - 1), p[3] = 0x1p-24f;
    f->o.effects = 0;
    evaluate_pair(f, 0, 0, 0, 0, pole, pole, rgb);
    assert_rgb(rgb, 1.0f, 0x1p-30f, 0.0f); /* 2^-30 is kept, less is not */
    p[3] = 0x1p24f;
    evaluate_pair(f, 0, 0, 0, 0, pole, pole, rgb);
    assert_rgb(rgb, 0x1p32f, 0x1p18f, float_of(bits_of(0x1p18f) - 1));
    f->m.domain_sqrt = 1;
    evaluate_pair(f, 0, 0, 0, 0, pole, pole, rgb);
    assert_bits(rgb[0], 0x1p64f);

    /* the largest of everything overflows before it is clamped */
    f->m.effects |= BTF_REF_SHADOW;
    f->o.effects = UINT32_MAX;
    f->m.lobes = 4;
    for (uint32_t layer = 1; layer <= 4; ++layer) {
        float *lobe = parameter(f, layer, 0, 0);
        lobe[0] = lobe[1] = lobe[2] = lobe[3] = 0x1p24f;
    }
    set_shadow(f, 0, 0, 0, 255);
    f->m.shadow_scale = f->m.gain_scale = f->m.radiance_scale = 0x1p24f;
    float two[3] = {2.0f, 2.0f, 2.0f};
    evaluate_pair(f, 0, 0, 0, 0, two, two, rgb);
    assert_bits(rgb[0], 0x1p88f);
}

static void test_horizon(void **state) {
    (void)state;
    fixture *f = plain(0, 0);
    set_lambertian(f);
    static const uint32_t bad[] = {
        0x7FC00000u, 0xFFC00000u, 0x7F800001u, 0x7F800000u,
        0xFF800000u, 0x40000001u, 0xC0000001u, 0x7F7FFFFFu,
    };
    static const float low[] = {0.0f, -0.0f, -1.0f, -2.0f, 0x1p-149f, 0x1p-126f};
    const float below = float_of(0x337FFFFFu); /* the float below 2^-24 */
    for (int which = 0; which < 2; ++which) {
        for (int i = 0; i < 3; ++i) {
            for (size_t k = 0; k < sizeof bad / sizeof *bad + sizeof low / sizeof *low + 1; ++k) {
                float d[2][3] = {{0, 0, 1}, {0, 0, 1}}, rgb[3] = {7, 7, 7};
                size_t n_bad = sizeof bad / sizeof *bad;
                if (k < n_bad)
                    d[which][i] = float_of(bad[k]);
                else
                    d[which][i] = k - n_bad < sizeof low / sizeof *low ? low[k - n_bad] : below;
                btf_ref_evaluate_texel(&f->m, &f->o, 0, 0, d[0], d[1], rgb);
                bool dark = k < n_bad || i == 2;
                assert_bits(rgb[0], dark ? 0.0f : 1.0f);
                btf_ref_evaluate(&f->m, &f->o, 0.01f, 0.99f, d[0], d[1], rgb);
                assert_bits(rgb[0], dark ? 0.0f : 1.0f);
                evaluate_pair(f, 0, 0, 0, 0, d[0], d[1], rgb);
                assert_bits(rgb[0], dark ? 0.0f : 1.0f);
            }
        }
    }
    float rgb[3], grazing[3] = {-2.0f, 2.0f, 0x1p-24f};
    btf_ref_evaluate_texel(&f->m, &f->o, 0, 0, grazing, grazing, rgb);
    assert_bits(rgb[0], 0x1p-24f);
}

static void test_filter(void **state) {
    (void)state;
    fixture *f = plain(0, 0);
    /* 4 x 4 of the 7 x 5: powers of two, so that u = (c + 0.5) / W is exact */
    f->m.width = f->m.height = 4;
    for (uint32_t i = 0; i < 16; ++i)
        f->s.sbrdf[4 * i] = 1.0f, f->s.sbrdf[4 * i + 3] = (float)(1 + i * i);
    float rgb[3], texel[3];
    for (int row = 0; row < 4; ++row) {
        for (int column = 0; column < 4; ++column) {
            float u = ((float)column + 0.5f) / 4, v = 1 - ((float)row + 0.5f) / 4;
            btf_ref_evaluate_texel(&f->m, &f->o, (uint32_t)column, (uint32_t)row, pole, pole, texel);
            assert_bits(texel[0], (float)(1 + (4 * row + column) * (4 * row + column)));
            for (int filter = 0; filter < 2; ++filter) {
                f->o.filter = filter;
                btf_ref_evaluate(&f->m, &f->o, u, v, pole, pole, rgb);
                assert_bits(rgb[0], texel[0]);
                btf_ref_evaluate(&f->m, &f->o, u - 3, v + 17, pole, pole, rgb);
                assert_bits(rgb[0], texel[0]);
            }
        }
    }
    /* a quarter of a texel right of (3, 0), half a texel up: wraps both ways. Texels 3, 0, 15, 12 */
    f->o.filter = BTF_REF_BILINEAR;
    btf_ref_evaluate(&f->m, &f->o, 3.75f / 4, 1.0f, pole, pole, rgb);
    assert_bits(rgb[0], (10 * 0.75f + 1 * 0.25f) / 2 + (226 * 0.75f + 145 * 0.25f) / 2);
    f->o.filter = BTF_REF_TEXEL;
    btf_ref_evaluate(&f->m, &f->o, 0.0f, 0.0f, pole, pole, rgb); /* the lower left corner */
    assert_bits(rgb[0], 145.0f);
    btf_ref_evaluate(&f->m, &f->o, NAN, INFINITY, pole, pole, rgb);
    assert_bits(rgb[0], 145.0f);
    btf_ref_evaluate(&f->m, &f->o, 0.0f, -1e-30f, pole, pole, rgb); /* just below: the top row */
    assert_bits(rgb[0], 1.0f);
}

/* --- section 9, in bulk --- */

/** The same radiance in double precision, with libm, for layout tight and floats; formulas as FORMAT.md
 * states them in words. */
static void model_in_double(const btf_ref_material *m, uint32_t column, uint32_t row,
                            const btf_ref_neighbours *lights, const btf_ref_neighbours *views,
                            const float l[3], const float v[3], double out_rgb[3]) {
    const float *sbrdf = m->sbrdf;
    size_t texels = (size_t)m->width * m->height;
    for (int c = 0; c < 3; ++c) {
        out_rgb[c] = 0;
        for (int a = 0; a < 3; ++a) {
            size_t view = views->index[a], texel = row * m->width + column;
            uint8_t code = m->gain[view * texels + texel];
            const uint8_t *bytes = m->shift + 2 * (view * texels + texel);
            double value = 0;
            if (code == 0) {
                for (int b = 0; b < 3; ++b)
                    value += lights->weight[b] / 4096.0 * (double)m->centre_scale *
                             m->centre[4 * ((size_t)bytes[0] * m->n_lights + lights->index[b]) + (size_t)c];
                out_rgb[c] += value * value * views->weight[a] / 4096.0 * (double)m->radiance_scale;
                continue;
            }
            uint32_t x = (column + 7 * 128 + (uint32_t)(int32_t)(int8_t)bytes[0]) % m->width;
            uint32_t y = (row + 5 * 128 + (uint32_t)(int32_t)(int8_t)bytes[1]) % m->height;
            texel = y * m->width + x;
            size_t first_lobe = m->colour == BTF_REF_MONO ? 1 : (3 * (1 + m->lobes) + 3) / 4;
            const float *factors[5];
            for (size_t i = 0; i < 5; ++i)
                factors[i] = sbrdf + 4 * (i * texels + texel);
            size_t at = (size_t)c;
            double diffuse = (double)(m->colour == BTF_REF_MONO ? factors[0][3] : factors[0][c]);
            double f = diffuse;
            for (uint32_t j = 0; j < m->lobes; ++j) {
                const float *lobe = sbrdf + 4 * ((first_lobe + j) * texels + texel);
                double base = 0;
                for (int i = 0; i < 3; ++i)
                    base += (double)lobe[i] * (double)l[i] * (double)v[i];
                at += 3;
                double weight = m->colour == BTF_REF_MONO ? 1 : (double)factors[at / 4][at % 4];
                f += weight * (base > 0 ? pow(base, (double)lobe[3]) : 0);
            }
            if (m->colour == BTF_REF_MONO)
                f *= (double)factors[0][c];
            double shadow = 0, residual = 0;
            for (int b = 0; b < 3; ++b) {
                shadow += lights->weight[b] / 4096.0 * m->shadow[lights->index[b] * texels + texel];
                for (uint32_t j = 0; j < m->components; ++j) {
                    size_t direction = (3 * (j / 4) + (uint32_t)c) * m->n_views + view;
                    residual +=
                        lights->weight[b] / 4096.0 * (double)m->residual_scales[j] *
                        m->residual_texels[4 * (j / 4 * texels + texel) + j % 4] *
                        m->residual_directions[4 * (direction * m->n_lights + lights->index[b]) + j % 4];
                }
            }
            value = f * shadow * (double)m->shadow_scale + residual;
            value *= (m->domain_sqrt ? sqrt((double)l[2]) : (double)l[2]) * code * (double)m->gain_scale;
            value = value > 0 ? value : 0;
            value = m->domain_sqrt ? value * value : value;
            out_rgb[c] += value * views->weight[a] / 4096.0 * (double)m->radiance_scale;
        }
    }
}

static void test_against_double(void **state) {
    (void)state;
    static made_storage storage;
    btf_ref_material m;
    btf_ref_options options = {UINT32_MAX, UINT32_MAX, BTF_REF_LINEAR, BTF_REF_TEXEL};
    uint32_t random = 21;
    double worst = 0;
    for (uint32_t round = 0; round < 200; ++round) {
        uint32_t kind =
            1 + 2 * (round % 2) + 8 * (round / 2 % 2); /* tight, float; both domains, mono and RGB */
        make_material(round, kind, ALL_EFFECTS, 0, &storage, &m);
        m.centres = MADE_CENTRES;
        for (int i = 0; i < 100; ++i) {
            float l[3], v[3], rgb[3];
            int32_t ql[2], qv[2];
            double truth[3];
            random_direction(&random, l);
            random_direction(&random, v);
            uint32_t column = random_below(&random, MADE_WIDTH), row = random_below(&random, MADE_HEIGHT);
            btf_ref_project(l, ql);
            btf_ref_project(v, qv);
            btf_ref_neighbours lights = btf_ref_lookup(m.light_table, m.light_grid, ql);
            btf_ref_neighbours views = btf_ref_lookup(m.view_table, m.view_grid, qv);
            btf_ref_evaluate_texel(&m, &options, column, row, l, v, rgb);
            model_in_double(&m, column, row, &lights, &views, l, v, truth);
            for (int c = 0; c < 3; ++c) {
                double error = fabs((double)rgb[c] - truth[c]) / (1 + fabs(truth[c]));
                if (error > 2e-5)
                    fail_msg("round %u, %d, channel %d: %.9g, in double %.9g", round, i, c, (double)rgb[c],
                             truth[c]);
                worst = fmax(worst, error);
            }
        }
    }
    print_message("against double: %.3g\n", worst);
}

/** Copies what layout tight holds into an atlas. */
static void copy_to_atlas(const btf_ref_material *tight, made_storage *s, btf_ref_material *out_paper) {
    *out_paper = *tight;
    out_paper->layout_tight = 0;
    uint32_t x, y;
    for (uint32_t tile = 0; tile < MADE_VIEWS; ++tile) {
        for (uint32_t texel = 0; texel < MADE_TEXELS; ++texel) {
            btf_ref_tile(out_paper, tile, texel % MADE_WIDTH, texel / MADE_WIDTH, &x, &y);
            uint8_t *map = s->maps + 4 * (y * MADE_ATLAS + x);
            map[0] = tile < MADE_LIGHTS ? s->shadow[tile * MADE_TEXELS + texel] : 0;
            map[1] = s->gain[tile * MADE_TEXELS + texel];
            memcpy(map + 2, s->shift + 2 * (tile * MADE_TEXELS + texel), 2);
        }
    }
    for (uint32_t centre = 0; centre < MADE_CENTRES; ++centre) {
        for (uint32_t light = 0; light < MADE_LIGHTS; ++light) {
            btf_ref_centre(out_paper, centre, light, &x, &y);
            memcpy(s->maps + 4 * (y * MADE_ATLAS + x), s->centre + 4 * (centre * MADE_LIGHTS + light), 3);
        }
    }
}

/** Both layouts of the same material, and every way to ask, give the same bits. */
static void test_ways_agree(void **state) {
    (void)state;
    static made_storage storage;
    btf_ref_material tight, paper;
    uint32_t random = 33;
    for (uint32_t round = 0; round < 48; ++round) {
        make_material(round, round | 1, round % 3 ? ALL_EFFECTS : round % 32, 0, &storage, &tight);
        copy_to_atlas(&tight, &storage, &paper);
        for (int i = 0; i < 200; ++i) {
            float l[3], v[3], rgb[4][3];
            random_direction(&random, l);
            random_direction(&random, v);
            uint32_t column = random_below(&random, MADE_WIDTH), row = random_below(&random, MADE_HEIGHT);
            btf_ref_options o = {.effects = random_bits(&random) >> 8, .components = (uint32_t)i % 10};
            o.interpolation = i & 1;
            int32_t ql[2], qv[2];
            btf_ref_project(l, ql);
            btf_ref_project(v, qv);
            btf_ref_neighbours lights = btf_ref_lookup(tight.light_table, tight.light_grid, ql);
            btf_ref_neighbours views = btf_ref_lookup(tight.view_table, tight.view_grid, qv);
            /* within the texel, away from its borders */
            float u = ((float)column + 0.4f) / MADE_WIDTH, w = 1 - ((float)row + 0.6f) / MADE_HEIGHT;
            btf_ref_evaluate_texel(&tight, &o, column, row, l, v, rgb[0]);
            btf_ref_evaluate_texel(&paper, &o, column, row, l, v, rgb[1]);
            btf_ref_evaluate(&paper, &o, u, w, l, v, rgb[2]);
            btf_ref_evaluate_neighbours(&tight, &o, column, row, &lights, &views, l, v, rgb[3]);
            for (int k = 1; k < 4; ++k)
                for (int c = 0; c < 3; ++c)
                    assert_bits(rgb[k][c], rgb[0][c]);
        }
    }
}

/** Legal files of extreme parameters, any bits as arguments: finite and not negative. */
static void test_finite(void **state) {
    (void)state;
    static made_storage storage;
    btf_ref_material m;
    uint32_t random = 77, lit = 0, evaluations = 0;
    for (uint32_t round = 0; round < 250; ++round) {
        make_material(round, round, round % 2 ? ALL_EFFECTS : round / 2 % 32, round % 5 != 0, &storage, &m);
        if (round % 7 == 3)
            make_points(round, round % 5 != 0, &storage, &m);
        for (int i = 0; i < 4000; ++i) {
            float l[3], v[3], rgb[3];
            for (int k = 0; k < 3; ++k) {
                uint32_t a = random_bits(&random), b = random_bits(&random);
                if (i % 4 != 0) { /* magnitudes to 2; upwards */
                    a = (a & 0x80000000u) | (a & 0x7FFFFFFFu) % 0x40000001u;
                    b = (b & 0x80000000u) | (b & 0x7FFFFFFFu) % 0x40000001u;
                    if (k == 2) {
                        a = 0x33800000u + a % 0x0C800001u;
                        b = 0x33800000u + b % 0x0C800001u;
                    }
                }
                l[k] = float_of(a);
                v[k] = float_of(b);
            }
            btf_ref_options o = {.effects = UINT32_MAX, .components = UINT32_MAX};
            o.interpolation = i >> 2 & 1;
            o.filter = (i & 63) == 0 ? BTF_REF_BILINEAR : BTF_REF_TEXEL;
            uint32_t u = random_bits(&random), w = random_bits(&random);
            btf_ref_evaluate(&m, &o, float_of(u), float_of(w), l, v, rgb);
            ++evaluations;
            lit += rgb[0] > 0;
            for (int c = 0; c < 3; ++c) {
                uint32_t bits = bits_of(rgb[c]);
                if (bits >= 0x7F800000u || (bits != 0 && bits < 0x00800000u))
                    fail_msg("round %u, %d: channel %d is %08X", round, i, c, bits);
            }
        }
    }
    print_message("%u of %u are lit\n", lit, evaluations);
    assert_int_equal(evaluations, 1000000);
    assert_true(lit > evaluations / 10);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_lambertian), cmocka_unit_test(test_lobes),
        cmocka_unit_test(test_packed_points), cmocka_unit_test(test_lists),
        cmocka_unit_test(test_shadow),     cmocka_unit_test(test_shift_and_gain),
        cmocka_unit_test(test_hidden),     cmocka_unit_test(test_centre_index),
        cmocka_unit_test(test_two_views),  cmocka_unit_test(test_residual),
        cmocka_unit_test(test_clamps),     cmocka_unit_test(test_horizon),
        cmocka_unit_test(test_filter),     cmocka_unit_test(test_against_double),
        cmocka_unit_test(test_ways_agree), cmocka_unit_test(test_finite),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
