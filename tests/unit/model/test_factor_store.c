/* Factors of version 2 in a solution: packing and unpacking leaves them unchanged; their levels agree with FORMAT.md's
 * table of bits; profiles agree with the reference decoder, and evaluations have its bits.
 *
 * SPDX-License-Identifier: MIT
 */
#include "decoder/toolkit/reference_view.h"
#include "encoder/data/images.h"
#include "encoder/model/decode_samples.h"
#include "encoder/model/evaluator.h"
#include "encoder/model/pack.h"
#include "encoder/model/unpack.h"
#include "tests/support/test.h"

enum { WIDTH = 7, HEIGHT = 8, VIEWS = 9, LIGHTS = 11 }; /* more texels than a block of profiles has */

static const enc_context context = {.threads = 2};

static uint64_t random_state;
static uint32_t random_bits(void) {
    random_state = random_state * 6364136223846793005u + 1442695040888963407u;
    return (uint32_t)(random_state >> 32);
}

static enc_data *make_data(void) {
    enc_direction v[VIEWS], l[LIGHTS];
    v[0] = l[0] = enc_direction_from_angles(0, 0);
    for (int i = 1; i < VIEWS; i++) {
        v[i] = enc_direction_from_angles(50, i * 40);
    }
    for (int i = 1; i < LIGHTS; i++) {
        l[i] = enc_direction_from_angles(i < 5 ? 30 : 65, i * 60 % 360 + i / 7);
    }
    enc_data *data = NULL;
    assert_int_equal(enc_data_create(&context, WIDTH, HEIGHT, VIEWS, v, LIGHTS, l, &data), BTF_OK);
    return data;
}

/* Words of random codes, of which none is -128. */
static uint32_t *random_words(size_t count) {
    uint32_t *words = malloc(count * sizeof *words);
    assert_non_null(words);
    for (size_t i = 0; i < count; i++) {
        words[i] = random_bits();
        for (int byte = 0; byte < 4; byte++) {
            if ((words[i] >> (8 * byte) & 255) == 128) {
                words[i] ^= 1u << (8 * byte);
            }
        }
    }
    return words;
}

static float random_scale(double size) {
    return (float)(size * (0.5 + random_bits() * 0x1p-32));
}

/* How a texel's shift and gain are stored beside the factors. */
typedef enum points { NONE, SHIFT_ALONE, SEPARATE, PACKED, LISTS } points;

static void add_points(enc_solution *s, points store) {
    const size_t count = (size_t)VIEWS * WIDTH * HEIGHT;
    const uint32_t effects[] = {0, BTF_EFFECT_SHIFT, BTF_EFFECT_SHIFT | BTF_EFFECT_GAIN,
                                BTF_EFFECT_SHIFT | BTF_EFFECT_GAIN, BTF_EFFECT_SHIFT | BTF_EFFECT_GAIN};
    s->effects |= effects[store];
    s->shift = calloc(count, 2);
    s->gain = calloc(count, 1);
    s->packed = store == PACKED || store == LISTS;
    s->point_entries = store == LISTS ? VIEWS : 0;
    s->gain_scale = 1.0f / 100;
    s->gain_base = s->packed ? 0.3f : 0;
    s->gain_step = s->packed ? 0.07f : 0;
    assert_true(s->shift && s->gain);
    for (size_t i = 0; i < 2 * count && store != NONE; i++) {
        s->shift[i] = (int8_t)(random_bits() % 64) - 32;
    }
    for (size_t i = 0; i < count; i++) {
        s->gain[i] = (uint8_t)(s->packed           ? random_bits() % 16
                               : store == SEPARATE ? 1 + random_bits() % 255
                                                   : BTF_GAIN_ONE);
    }
}

/* Every class, with words of chroma in mixed and in whole units. */
static enc_solution random_solution(btf_domain domain, btf_blend blend) {
    static const uint32_t classes[BTF_FACTOR_CLASSES][3] = {
        {2, 1, 2}, {2, 1, 0}, {3, 2, 3}, {1, 0, 0}, {2, 0, 1}};
    static const int top[BTF_FACTOR_CLASSES] = {127 * 127, 255 * 15, 15 * 15, 3 * 15, 3 * 3};
    enc_factor_unit units[16];
    enc_solution s = {.width = WIDTH,
                      .height = HEIGHT,
                      .n_views = VIEWS,
                      .n_lights = LIGHTS,
                      .domain = domain,
                      .effects = BTF_EFFECT_RESIDUAL,
                      .blend = blend,
                      .radiance_scale = 1.5f};
    enc_factor_store *f = &s.factors;
    memcpy(f->classes, classes, sizeof classes);
    f->units = enc_store_units(classes);
    f->layers = enc_store_layers(classes);
    assert_int_equal(f->units, 10);
    assert_int_equal(f->layers, 13);
    enc_store_list(classes, units);
    f->texels = random_words((size_t)f->layers * WIDTH * HEIGHT * 4);
    f->directions = random_words((size_t)f->units * VIEWS * LIGHTS * 4);
    f->scales = calloc(f->units, 4 * sizeof *f->scales);
    f->views = calloc(VIEWS, 12 * sizeof *f->views);
    assert_true(f->scales && f->views);
    for (uint32_t i = 0; i < f->units; i++) {
        for (int k = 0; k < 4; k++) {
            f->scales[4 * i + (uint32_t)k] =
                k > 0 && !units[i].mixed ? f->scales[4 * i] : random_scale(0.1 / top[units[i].class]);
        }
    }
    for (int i = 0; i < VIEWS * 12; i++) {
        f->views[i] = i % 4 < 3 ? random_scale(1) : 0;
    }
    f->horizon_scale = (float)(1 / cos(65 * 3.14159265358979323846 / 180));
    return s;
}

/* ---- The table of bits, read from FORMAT.md once more ---- */

/* Level of component i of a word of class `class`, whose texels of u hold first and second. */
static int u_by_table(int class, uint32_t first, uint32_t second, int i) {
    switch (class) {
    case 0:
        return (int8_t)(first >> (8 * i) & 255);
    case 1: {
        const uint32_t texel = i % 4 < 2 ? first : second;
        return 2 * (int)(texel >> (8 * (i % 2) + (i / 4 == 0 ? 16 : 0)) & 255) - 255;
    }
    case 2:
        return 2 * (int)(first >> (i < 4 ? 4 * i + 16 : 4 * i - 16) & 15) - 15;
    case 3: {
        const uint32_t texel = i % 8 < 4 ? first : second;
        return 2 * (int)(texel >> (4 * (i % 4) + (i < 8 ? 16 : 0)) & 15) - 15;
    }
    default: {
        static const int byte[4] = {24, 16, 8, 0};
        return 2 * (int)(first >> (byte[i / 4] + 2 * (i % 4)) & 3) - 3;
    }
    }
}

TEST(test_levels) {
    static const uint32_t classes[BTF_FACTOR_CLASSES][3] = {{1}, {1}, {1}, {1}, {1}};
    static const int words[BTF_FACTOR_CLASSES] = {4, 8, 8, 16, 16};
    enc_factor_unit units[BTF_FACTOR_CLASSES];
    int16_t levels[64];
    random_state = 3;
    assert_int_equal(enc_store_list(classes, units), 4 * (4 + 8 + 8 + 16 + 16));
    for (int c = 0; c < BTF_FACTOR_CLASSES; c++) {
        uint32_t *first = random_words(4), *second = random_words(4);
        assert_int_equal(units[c].word, words[c]);
        enc_store_u_levels(&units[c], first, second, levels);
        for (int n = 0; n < 4 * words[c]; n++) {
            assert_int_equal(levels[n],
                             u_by_table(c, first[n / words[c]], second[n / words[c]], n % words[c]));
        }
        enc_store_w_levels(&units[c], first, levels);
        for (int n = 0; n < 4 * words[c]; n++) {
            const uint32_t word = first[n / words[c]];
            const int i = n % words[c], bits = c == 0 ? 8 : c < 3 ? 4 : 2;
            const int code = (int)(word >> (bits * i) & ((1u << bits) - 1));
            assert_int_equal(levels[n], c == 0 ? (int8_t)code : 2 * code - ((1 << bits) - 1));
        }
        free(first);
        free(second);
    }
}

TEST(test_truncation) {
    static const uint32_t classes[BTF_FACTOR_CLASSES][3] = {
        {2, 1, 2}, {2, 1, 0}, {3, 2, 3}, {1, 0, 0}, {2, 0, 1}};
    uint32_t out[BTF_FACTOR_CLASSES][3];
    for (uint32_t units = 0; units <= 12; units++) {
        enc_store_truncate(classes, units, out);
        assert_int_equal(enc_store_units((const uint32_t(*)[3])out), units < 10 ? units : 10);
    }
    enc_store_truncate(classes, 5, out);
    const uint32_t expected[BTF_FACTOR_CLASSES][3] = {{2, 1, 2}, {2, 1, 0}, {1, 2, 2}};
    assert_memory_equal(out, expected, sizeof expected);
}

/* ---- A material of them ---- */

static void check_images(const enc_data *data, const enc_solution *s, const btf_material *material) {
    enc_sample_decoder *decoder = NULL;
    enc_reference_images reference = {.shape = data, .options = {.effects = 31, .components = UINT32_MAX}};
    const size_t count = (size_t)LIGHTS * WIDTH * HEIGHT * 3;
    float *fast = malloc(count * sizeof *fast), *exact = malloc(count * sizeof *exact), most = 0;
    assert_true(fast && exact);
    reference_view(material, 0, &reference.material);
    assert_int_equal(enc_sample_decoder_create(&context, data, s, &decoder), BTF_OK);
    const enc_decoded_samples decoded = {.decoder = decoder, .effects = 31};
    const enc_image_source source = enc_decoded_images(&decoded),
                           truth = enc_reference_image_source(&reference);
    for (int v = 0; v < VIEWS; v++) {
        assert_int_equal(source.view(source.user, v, fast), BTF_OK);
        assert_int_equal(truth.view(truth.user, v, exact), BTF_OK);
        for (size_t i = 0; i < count; i++) {
            assert_true(fabsf(fast[i] - exact[i]) <= 2e-5f * (1 + fabsf(exact[i])));
            most = fmaxf(most, exact[i]);
        }
    }
    assert_true(most > 0.01f);
    enc_sample_decoder_destroy(&decoder);
    free(fast);
    free(exact);
}

static btf_ref_neighbours look_up(const uint16_t *table, uint32_t grid, const float direction[3]) {
    int32_t q[2];
    btf_ref_project(direction, q);
    return btf_ref_lookup(table, grid, q);
}

static void random_direction(float out[3]) {
    const double z = 0.02 + 0.98 * random_bits() * 0x1p-32, phi = 6.2831853 * random_bits() * 0x1p-32;
    out[0] = (float)(sqrt(1 - z * z) * cos(phi));
    out[1] = (float)(sqrt(1 - z * z) * sin(phi));
    out[2] = (float)z;
}

/* Evaluates with other lights for each view, as gloss needs. */
static void check_apart(enc_evaluated_texel *t, const btf_ref_material *m, uint32_t texel,
                        const btf_ref_options *options, const enc_evaluated_at *given) {
    enc_evaluated_at at = *given;
    btf_ref_neighbours lights[3];
    float other[3], found[1][3], expected[3];
    for (int a = 0; a < 3; a++) {
        random_direction(other);
        lights[a] = look_up(m->light_table, m->light_grid, other);
    }
    at.lights = lights;
    at.apart = true;
    enc_evaluate(t, options, &at, &options->components, 1, found);
    btf_ref_evaluate_apart(m, options, texel % WIDTH, texel / WIDTH, lights, at.views, at.light, at.view,
                           expected);
    assert_memory_equal(found[0], expected, sizeof expected);
}

/* Evaluates all numbers of units in one call, for subsets of effects, with lights below the outermost sample too. */
static void check_evaluations(const btf_material *material) {
    static const uint32_t units[] = {UINT32_MAX, 10, 9, 8, 7, 6, 5, 4, 3, 2, 1};
    enum { COUNT = sizeof units / sizeof *units };
    enc_evaluator *e = NULL;
    int bright = 0;
    assert_int_equal(enc_evaluator_create(&context, material, 0, &e), BTF_OK);
    const btf_ref_material *m = enc_evaluator_reference(e);
    enc_evaluated_texel *t = enc_evaluated_texel_create(e, 0);
    assert_non_null(t);
    for (size_t texel = 0; texel < WIDTH * HEIGHT; texel += 5) {
        enc_evaluated_texel_move(t, texel);
        for (int n = 0; n < 40; n++) {
            float light[3], view[3], found[COUNT][3];
            random_direction(light);
            random_direction(view);
            const btf_ref_neighbours lights = look_up(m->light_table, m->light_grid, light),
                                     views = look_up(m->view_table, m->view_grid, view);
            const enc_evaluated_at at = {.lights = &lights, .views = &views, .light = light, .view = view};
            btf_ref_options options = {.effects = n % 3 == 0 ? 31 : 16 | random_bits() % 16,
                                       .interpolation = n % 4 > 0};
            enc_evaluate(t, &options, &at, units, COUNT, found);
            for (int i = 0; i < COUNT; i++) {
                float expected[3];
                options.components = units[i];
                btf_ref_evaluate_texel(m, &options, (uint32_t)texel % WIDTH, (uint32_t)texel / WIDTH, light,
                                       view, expected);
                assert_memory_equal(found[i], expected, sizeof expected);
                bright += expected[0] > 0;
            }
            check_apart(t, m, (uint32_t)texel, &options, &at);
        }
    }
    enc_evaluated_texel_destroy(&t);
    assert_true(bright > 1000);
    enc_evaluator_destroy(&e);
}

static void check(btf_domain domain, btf_blend blend, points store) {
    enc_data *data = make_data();
    enc_solution s = random_solution(domain, blend), back;
    add_points(&s, store);
    const enc_pack_options options = {.layout = BTF_LAYOUT_TIGHT, .method = "test"};
    btf_material_info info = {.struct_size = sizeof info};
    btf_material *material = NULL;
    assert_int_equal(enc_pack(&context, data, &s, &options, &material), BTF_OK);
    assert_int_equal(btf_material_get_info(material, &info), BTF_OK);
    assert_int_equal(info.version, 2);
    assert_int_equal(info.components, 10);
    assert_int_equal(info.blend, blend);
    assert_int_equal(enc_unpack(&context, material, &back), BTF_OK);
    assert_int_equal(enc_solution_components(&back), 10);
    assert_memory_equal(back.factors.classes, s.factors.classes, sizeof s.factors.classes);
    assert_memory_equal(back.factors.texels, s.factors.texels, (size_t)13 * WIDTH * HEIGHT * 16);
    assert_memory_equal(back.factors.directions, s.factors.directions, (size_t)10 * VIEWS * LIGHTS * 16);
    assert_memory_equal(back.factors.scales, s.factors.scales, 160);
    assert_memory_equal(back.factors.views, s.factors.views, VIEWS * 48);
    assert_true(back.factors.horizon_scale == s.factors.horizon_scale);
    check_images(data, &back, material);
    check_evaluations(material);
    btf_material_close(&material);
    enc_solution_clear(&back);
    enc_solution_clear(&s);
    enc_data_destroy(&data);
}

TEST(test_material) {
    random_state = 1;
    check(BTF_DOMAIN_SQRT, BTF_BLEND_RADIANCE, NONE);
    check(BTF_DOMAIN_SQRT, BTF_BLEND_ROOTS, NONE);
    check(BTF_DOMAIN_LINEAR, BTF_BLEND_RADIANCE, NONE);
    check(BTF_DOMAIN_SQRT, BTF_BLEND_RADIANCE, SHIFT_ALONE);
    check(BTF_DOMAIN_SQRT, BTF_BLEND_ROOTS, SEPARATE);
    check(BTF_DOMAIN_SQRT, BTF_BLEND_ROOTS, PACKED);
    check(BTF_DOMAIN_SQRT, BTF_BLEND_ROOTS, LISTS);
}

RUN_TESTS(NULL, NULL)
