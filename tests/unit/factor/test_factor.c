/* The factors of format 2: they recover planted components, keep to their budget, fill their units, and are packed into
 * words as FORMAT.md says. This file has a decoder of its own for that, in double precision.
 *
 * SPDX-License-Identifier: MIT
 */
#include "encoder/factor/factor.h"
#include "encoder/factor/pack.h"
#include "tests/support/test.h"
#include "tests/support/uniform.h"

static const enc_context one = {.threads = 1}, two = {.threads = 2};

/* --- a decoder written from FORMAT.md --- */

static const int bits_w[5] = {8, 4, 4, 2, 2}, bits_u[5] = {8, 8, 4, 4, 2}, in_word[5] = {4, 8, 8, 16, 16};
static const int tier_of[5] = {0, 1, 1, 2, 2}, texels_of[5] = {1, 2, 1, 2, 1};

static int field(uint32_t word, int bit, int bits) {
    return (int)(word >> bit & ((1u << bits) - 1));
}

static int level_w(int class, int i, const uint32_t *texel, int word) {
    const int code = field(texel[word], bits_w[class] * i, bits_w[class]);
    return class == 0 ? (int8_t)code : 2 * code - (bits_w[class] == 4 ? 15 : 3);
}

/* texel: the first texel of u of the unit; pitch: from one to the next. */
static int level_u(int class, int i, const uint32_t *texel, size_t pitch, int word) {
    int bit = 0, at = 0;
    switch (class) {
    case 0:
        return (int8_t)field(texel[word], 8 * i, 8);
    case 1:
        bit = 8 * (i % 4 % 2) + 16 * (1 - i / 4);
        at = i % 4 >= 2;
        break;
    case 2:
        bit = 4 * (i ^ 4);
        break;
    case 3:
        bit = 4 * (i % 8 % 4) + 16 * (1 - i / 8);
        at = i % 8 >= 4;
        break;
    default:
        bit = 8 * (3 - i / 4) + 2 * (i % 4);
    }
    const int bits = bits_u[class];
    return 2 * field(texel[(size_t)at * pitch + (size_t)word], bit, bits) - ((1 << bits) - 1);
}

/* The channel of a word of a class: 0 Y, 1 C1, 2 C2. */
static int channel_of(const uint32_t class[3], uint32_t word) {
    return word < class[1] ? 1 : word < class[1] + class[2] ? 2 : 0;
}

/* The integer dot product of one word of a unit. */
static int dot(const enc_factors *f, int class, size_t unit, size_t u_texel, int word, size_t texel,
               size_t column) {
    const size_t texels = (size_t)f->width * (size_t)f->height,
                 columns = (size_t)f->n_views * (size_t)f->n_lights;
    const uint32_t *w = f->directions + (unit * columns + column) * 4;
    const uint32_t *u = f->texels + (u_texel * texels + texel) * 4;
    int sum = 0;
    for (int i = 0; i < in_word[class]; i++) {
        sum += level_w(class, i, w, word) * level_u(class, i, u, texels * 4, word);
    }
    return sum;
}

/* Radiance of a sample by the first n_units units. */
static void decode(const enc_factors *f, int n_units, size_t texel, size_t column, double rgb[3]) {
    const size_t view = column / (size_t)f->n_lights;
    double sums[3] = {0};
    size_t unit = 0, u_texel = 0;
    for (int k = 0; k < 5; k++) {
        for (uint32_t n = 0; n < f->classes[k][0] && (int)unit < n_units; n++) {
            for (int word = 0; word < 4; word++) {
                const int c = channel_of(f->classes[k], 4 * n + (uint32_t)word);
                sums[c] += (double)dot(f, k, unit, u_texel, word, texel, column) *
                           f->scales[unit * 4 + (size_t)word] *
                           f->views[(view * 3 + (size_t)tier_of[k]) * 3 + (size_t)c];
            }
            unit++;
            u_texel += (size_t)texels_of[k];
        }
    }
    const double root[3] = {sums[0] + sums[1] + sums[2], sums[0] - 2 * sums[2],
                            sums[0] - sums[1] + sums[2]};
    for (int i = 0; i < 3; i++) {
        rgb[i] = root[i] > 0 ? root[i] * root[i] : 0;
    }
}

/* Mean squared error over all samples, clipped to [0, 1]. */
static double error_of(const enc_data *data, const enc_factors *f, int n_units) {
    const size_t texels = enc_data_texel_count(data), lights = (size_t)data->n_lights;
    const size_t columns = (size_t)data->n_views * lights;
    double sum = 0;
    for (size_t t = 0; t < texels; t++) {
        for (size_t c = 0; c < columns; c++) {
            double rgb[3];
            decode(f, n_units, t, c, rgb);
            for (size_t i = 0; i < 3; i++) {
                const double was =
                    data->samples[((t * columns + c / lights * lights) * 3) + i * lights + c % lights];
                const double e = fmin(was, 1) - fmin(rgb[i], 1);
                sum += e * e;
            }
        }
    }
    return sum / (double)(3 * texels * columns);
}

/* --- data --- */

static enc_data *empty(const enc_context *context, int width, int height, int views, int lights) {
    enc_direction directions[64];
    directions[0] = enc_direction_from_angles(0, 0);
    for (int i = 1; i < 64; i++) {
        directions[i] = enc_direction_from_angles(15 + i, i * 7);
    }
    enc_data *data = NULL;
    assert_int_equal(enc_data_create(context, width, height, views, directions, lights, directions, &data),
                     BTF_OK);
    return data;
}

enum { MOST_TERMS = 160 };

/* Samples whose square roots are sums of `terms` products of falling size plus `noise`; `tint` is the share of a
 * product that differs between channels. */
static void fill(enc_data *data, size_t terms, float tint, float noise) {
    const size_t texels = enc_data_texel_count(data), lights = (size_t)data->n_lights;
    const size_t columns = (size_t)data->n_views * lights;
    float *u = malloc(terms * texels * sizeof *u), *w = malloc(terms * columns * sizeof *w);
    float colour[MOST_TERMS][3];
    uint32_t state = 11;
    assert_true(u && w && terms <= MOST_TERMS);
    for (size_t j = 0; j < terms; j++) {
        const float size = j == 0 ? 0.5f : 0.25f / (float)(j + 1);
        for (size_t i = 0; i < texels; i++) {
            u[j * texels + i] = size * (j == 0 ? 1 + 0.2f * uniform(&state) : 2 * uniform(&state) - 1);
        }
        for (size_t i = 0; i < columns; i++) {
            w[j * columns + i] = j == 0 ? 0.8f + 0.4f * uniform(&state) : 2 * uniform(&state) - 1;
        }
        for (size_t c = 0; c < 3; c++) {
            colour[j][c] = 1 + tint * (2 * uniform(&state) - 1);
        }
    }
    for (size_t t = 0; t < texels; t++) {
        for (size_t i = 0; i < columns; i++) {
            for (size_t c = 0; c < 3; c++) {
                float root = noise * (uniform(&state) - 0.5f);
                for (size_t j = 0; j < terms; j++) {
                    root += colour[j][c] * u[j * texels + t] * w[j * columns + i];
                }
                data->samples[(t * columns + i / lights * lights) * 3 + c * lights + i % lights] =
                    root > 0 ? root * root : 0;
            }
        }
    }
    free(u);
    free(w);
}

static enc_data *textured(int side, int views, size_t terms, float tint, float noise) {
    enc_data *data = empty(&two, side, side, views, views);
    fill(data, terms, tint, noise);
    return data;
}

static uint64_t units(const enc_data *data, double n) {
    return enc_factor_least_budget(data->width, data->height, data->n_views, data->n_lights) +
           (uint64_t)((n - 1) * 16 *
                      (double)(enc_data_texel_count(data) + (size_t)data->n_views * (size_t)data->n_lights +
                               1));
}

/* Encodes, and checks what holds for all data: bytes, classes, scales, and that the packed words decode to
 * what the encoder measured. */
static enc_factors *encode(const enc_context *context, const enc_data *data, uint64_t budget, int sweeps) {
    const enc_factor_options options = {.budget = budget, .sweeps = sweeps, .measure = true};
    enc_factors *f = NULL;
    assert_int_equal(enc_factor_encode(context, data, &options, &f), BTF_OK);
    const uint64_t bytes = 16 * ((uint64_t)f->n_units * (size_t)(f->n_views * f->n_lights) +
                                 (uint64_t)f->n_u_texels * enc_data_texel_count(data) +
                                 (uint64_t)(f->n_units + 3 * f->n_views));
    assert_true(f->bytes == bytes && bytes <= budget);
    int n_units = 0, n_texels = 0;
    for (int k = 0; k < 5; k++) {
        const uint32_t chroma = f->classes[k][1] + f->classes[k][2];
        assert_true(chroma <= 4 * f->classes[k][0]);
        for (uint32_t n = 0; n < f->classes[k][0]; n++, n_units++) {
            const float *scale = f->scales + 4 * n_units;
            const bool pure = k > 0 && 4 * n >= chroma;
            for (int word = 0; word < 4; word++) {
                assert_true(!pure || scale[word] == scale[0]);
                assert_true(k == 0 || scale[word] > 0); /* all words are in use */
                assert_true(scale[word] == 0 || (scale[word] >= 0x1p-24f && scale[word] <= 0x1p24f));
            }
            n_texels += texels_of[k];
        }
    }
    assert_int_equal(f->n_units, n_units);
    assert_int_equal(f->n_u_texels, n_texels);
    assert_in_range(n_units, 1, 256);
    assert_in_range(n_texels, 1, 256);
    for (int i = 0; i < 9 * f->n_views; i++) {
        assert_true(f->views[i] == 0 || (f->views[i] >= 0x1p-24f && f->views[i] <= 0x1p24f));
    }
    return f;
}

/* --- cases --- */

/* The encoder's measured error is that of the packed words. */
TEST(test_words_decode_to_what_was_measured) {
    enc_data *data = textured(16, 13, 60, 0.3f, 0.05f);
    bool seen[5] = {false};
    for (double n = 1; n < 8; n += 1.4) {
        enc_factors *f = encode(&two, data, units(data, n), 2);
        const double error = error_of(data, f, f->n_units);
        assert_true(fabs(error - f->error.linear) <= 1e-4 * error + 1e-12);
        for (int k = 0; k < 5; k++) {
            seen[k] = seen[k] || f->classes[k][0] > 0;
        }
        enc_factors_destroy(&f);
    }
    assert_true(seen[0] && seen[2] && seen[4]);
    enc_data_destroy(&data);
}

enum { SIDE = 5, TEXELS = SIDE * SIDE, VIEWS = 3, LIGHTS = 7, COLUMNS = VIEWS * LIGHTS };

static int random_level(uint32_t *state, int class, int top) {
    const int steps = class == 0 ? top * 2 + 1 : top + 1;
    const int at = (int)(uniform(state) * (float)steps);
    return class == 0 ? at - top : 2 * at - top;
}

/* Random levels of components in places of their own, all classes and channels. */
static void randomise(enc_factor_codes *codes, int c, uint32_t *state) {
    enc_factor_channel *channel = &codes->channel[c];
    for (size_t j = 0; j < channel->rank; j++) {
        const int k = channel->place[j].class;
        const size_t tier = (size_t)tier_of[k];
        channel->step_u[j] = 0.5f;
        channel->step_w[j] = 0.25f;
        for (size_t i = 0; i < TEXELS; i++) {
            channel->u[j * TEXELS + i] = 0.5f * (float)random_level(state, k, enc_factor_classes[k].top_u);
        }
        for (size_t i = 0; i < COLUMNS; i++) {
            channel->w[j * COLUMNS + i] = 0.25f * enc_factor_view(codes, i / LIGHTS, tier, c) *
                                          (float)random_level(state, k, enc_factor_classes[k].top_w);
        }
    }
}

/* A plan with all classes, words of all channels, mixed and pure units: unpacking gives what was packed. */
TEST(test_every_class_round_trips) {
    static const enc_factor_plan plan = {{{5, 2, 1}, {6, 1, 1}, {9, 2, 1}, {2, 1, 1}, {7, 0, 1}}};
    static const float axis[3] = {0.57735027f, 0.70710678f, 0.40824829f};
    enc_data *data = empty(&one, SIDE, SIDE, VIEWS, LIGHTS);
    const enc_factor_matrix matrix = enc_factor_matrix_of(&one, data);
    enc_components components[3] = {{0}};
    enc_factor_codes codes;
    uint32_t seed = 3;
    for (int c = 0; c < 3; c++) {
        components[c].rank = 400;
        components[c].u = enc_gemm_alloc(components[c].rank * TEXELS);
        components[c].w = enc_gemm_alloc(components[c].rank * COLUMNS);
    }
    assert_int_equal(enc_factor_codes_create(&matrix, &plan, components, &codes), BTF_OK);
    for (int i = 0; i < VIEWS * 9; i++) {
        codes.view[i] = 0.5f + uniform(&seed);
    }
    for (int c = 0; c < 3; c++) {
        randomise(&codes, c, &seed);
    }
    enc_factors f = {
        .width = SIDE, .height = SIDE, .n_views = VIEWS, .n_lights = LIGHTS, .views = codes.view};
    f.n_units = (int)enc_factor_all_units(&plan);
    for (int k = 0; k < 5; k++) {
        f.classes[k][0] = enc_factor_units(&plan, k);
        f.classes[k][1] = plan.words[k][1];
        f.classes[k][2] = plan.words[k][2];
    }
    f.texels = calloc(enc_factor_u_texels(&plan) * TEXELS * 4, sizeof *f.texels);
    f.directions = calloc((size_t)f.n_units * COLUMNS * 4, sizeof *f.directions);
    f.scales = calloc((size_t)f.n_units * 4, sizeof *f.scales);
    enc_factor_pack(&two, &codes, f.texels, f.directions, f.scales);
    for (size_t t = 0; t < TEXELS; t++) {
        for (size_t i = 0; i < COLUMNS; i++) {
            double rgb[3], sums[3] = {0};
            for (int c = 0; c < 3; c++) {
                for (size_t j = 0; j < codes.channel[c].rank; j++) {
                    sums[c] += (double)codes.channel[c].u[j * TEXELS + t] *
                               codes.channel[c].w[j * COLUMNS + i] * axis[c];
                }
            }
            decode(&f, f.n_units, t, i, rgb);
            const double root[3] = {sums[0] + sums[1] + sums[2], sums[0] - 2 * sums[2],
                                    sums[0] - sums[1] + sums[2]};
            for (int c = 0; c < 3; c++) {
                const double expected = root[c] > 0 ? root[c] * root[c] : 0;
                assert_true(fabs(rgb[c] - expected) <= 1e-4 * (fabs(expected) + 100));
            }
        }
    }
    free(f.texels);
    free(f.directions);
    free(f.scales);
    enc_factor_codes_clear(&codes);
    for (int c = 0; c < 3; c++) {
        enc_components_clear(&components[c]);
    }
    enc_data_destroy(&data);
}

static void assert_same(const enc_factors *a, const enc_factors *b) {
    const size_t texels = (size_t)(a->width * a->height), columns = (size_t)(a->n_views * a->n_lights);
    assert_memory_equal(a->classes, b->classes, sizeof a->classes);
    assert_memory_equal(a->texels, b->texels, (size_t)a->n_u_texels * texels * 16);
    assert_memory_equal(a->directions, b->directions, (size_t)a->n_units * columns * 16);
    assert_memory_equal(a->scales, b->scales, (size_t)a->n_units * 16);
    assert_memory_equal(a->views, b->views, (size_t)a->n_views * 36);
    assert_true(a->error.linear == b->error.linear && a->error.srgb == b->error.srgb);
}

/* Data of few components come back almost as they were. */
TEST_OF_NUMBERS(test_recovers) {
    static const enc_context five = {.threads = 5};
    enc_data *data = textured(16, 9, 6, 0.2f, 0);
    enc_factors *f = encode(&two, data, units(data, 2.1), ENC_FACTOR_SWEEPS);
    assert_true(f->classes[0][0] == 2);
    /* the unit's free codes make up for the rounding of the six components, which alone leaves 52 / 54 dB */
    assert_true(f->components[0] == 16 && f->error.linear < 1e-6 && f->error.srgb < 1e-6);
    enc_factors *of_five = encode(&five, data, units(data, 2.1), ENC_FACTOR_SWEEPS);
    assert_same(f, of_five);
    enc_factors_destroy(&f);
    enc_factors_destroy(&of_five);
    enc_data_destroy(&data);
}

/* The budget is filled with units; a larger one gives less error; descent reduces the error. */
TEST_OF_NUMBERS(test_budget_is_kept_and_used) {
    enc_data *data = textured(16, 13, 120, 0.3f, 0.1f);
    const uint64_t unit = units(data, 2) - units(data, 1);
    double before = 1;
    for (double n = 1; n < 7; n += 0.7) {
        enc_factors *f = encode(&two, data, units(data, n), 1),
                    *plain = encode(&two, data, units(data, n), 0);
        assert_true(units(data, n) - f->bytes < unit);
        assert_true(f->error.linear <= before * 1.001);
        assert_true(f->error.linear < plain->error.linear);
        before = f->error.linear;
        enc_factors_destroy(&f);
        enc_factors_destroy(&plain);
    }
    enc_data_destroy(&data);
}

/* Each further unit that a decoder takes reduces the error. */
TEST_OF_NUMBERS(test_prefix_is_monotone) {
    enc_data *data = textured(16, 13, 120, 0.3f, 0.1f);
    enc_factors *f = encode(&two, data, units(data, 6), ENC_FACTOR_SWEEPS);
    double before = error_of(data, f, 0);
    assert_true(f->n_units >= 4);
    for (int n = 1; n <= f->n_units; n++) {
        const double error = error_of(data, f, n);
        assert_true(error < before);
        before = error;
    }
    enc_factors_destroy(&f);
    enc_data_destroy(&data);
}

/* The same bits from 1, 2 and 5 threads, and of samples that lie in a scratch file. */
TEST_OF_NUMBERS(test_threads_and_storage_do_not_matter) {
    static const enc_context five = {.threads = 5}, small = {.threads = 2, .memory = 700000};
    enc_data *data = textured(16, 13, 60, 0.3f, 0.05f);
    enc_data *stored = empty(&small, 16, 16, 13, 13);
    assert_null(stored->samples);
    assert_int_equal(enc_data_store_texels(&small, stored, 0, 256, data->samples), BTF_OK);
    assert_int_equal(enc_data_complete(&small, stored, BTF_OK), BTF_OK);
    enc_factors *f = encode(&one, data, units(data, 4.5), 3);
    enc_factors *others[] = {encode(&two, data, units(data, 4.5), 3),
                             encode(&five, data, units(data, 4.5), 3),
                             encode(&small, stored, units(data, 4.5), 3)};
    for (int i = 0; i < 3; i++) {
        assert_same(f, others[i]);
        enc_factors_destroy(&others[i]);
    }
    enc_factors_destroy(&f);
    enc_data_destroy(&data);
    enc_data_destroy(&stored);
}

static enc_factors *encode_from(enc_components basis[3], const enc_data *data, uint64_t budget,
                                enc_factor_match match) {
    const enc_factor_options options = {
        .budget = budget, .sweeps = 2, .measure = true, .match = match, .gain = true, .basis = basis};
    enc_factors *f = NULL;
    assert_int_equal(enc_factor_encode(&two, data, &options, &f), BTF_OK);
    return f;
}

/* Components of a first encode can be used in others. With the same budget the result is the same; with less it is
 * nearly that of its own components. Match, which changes components, leaves those that were handed in as they are. */
TEST_OF_NUMBERS(test_components_serve_other_budgets) {
    enc_data *data = textured(10, 8, 30, 0.3f, 0.05f);
    enc_components basis[3] = {{0}};
    enc_factors *own = encode(&two, data, units(data, 6), 2), *less = encode(&two, data, units(data, 3), 2);
    enc_factors *first = encode_from(basis, data, units(data, 6), ENC_FACTOR_NO_MATCH),
                *matched = encode_from(basis, data, units(data, 5), ENC_FACTOR_MATCH),
                *again = encode_from(basis, data, units(data, 6), ENC_FACTOR_NO_MATCH),
                *small = encode_from(basis, data, units(data, 3), ENC_FACTOR_NO_MATCH);
    assert_true(matched->shift != NULL);
    assert_same(own, first);
    assert_same(own, again);
    printf("own components %.2f dB, those of twice the budget %.2f dB\n", -10 * log10(less->error.srgb),
           -10 * log10(small->error.srgb));
    assert_true(small->bytes <= units(data, 3));
    assert_true(log10(small->error.srgb / less->error.srgb) < 0.005); /* 0.05 dB */
    enc_factors *all[] = {own, less, first, matched, again, small};
    for (size_t i = 0; i < sizeof all / sizeof all[0]; i++) {
        enc_factors_destroy(&all[i]);
    }
    for (int c = 0; c < 3; c++) {
        enc_components_clear(&basis[c]);
    }
    enc_data_destroy(&data);
}

/* Grey data take no words of chroma, and the bytes saved reduce the error. */
TEST(test_grey) {
    enc_data *grey = textured(12, 9, 60, 0, 0), *tinted = textured(12, 9, 60, 0.5f, 0);
    enc_factors *f = encode(&two, grey, units(grey, 3), 2), *g = encode(&two, tinted, units(grey, 3), 2);
    for (int k = 0; k < 5; k++) {
        assert_int_equal(f->classes[k][1] + f->classes[k][2], 0);
    }
    assert_true(f->components[1] == 0 && f->components[2] == 0 && g->components[1] > 0 &&
                g->components[2] > 0);
    assert_true(f->error.linear < g->error.linear);
    enc_factors_destroy(&f);
    enc_factors_destroy(&g);
    enc_data_destroy(&grey);
    enc_data_destroy(&tinted);
}

static void fill_constant(enc_data *data, float value) {
    const size_t count = enc_data_texel_count(data) * enc_data_texel_stride(data);
    for (size_t i = 0; i < count; i++) {
        data->samples[i] = value;
    }
}

/* Constant data take one unit however large the budget, and black data one of zeros. */
TEST(test_constant_and_black) {
    enc_data *data = empty(&two, 6, 5, 4, 3);
    for (int black = 0; black < 2; black++) {
        fill_constant(data, black ? 0 : 0.3f);
        enc_factors *f = encode(&two, data, 1000000, 3);
        assert_int_equal(f->n_units, 1);
        assert_true(f->error.linear < 1e-7);
        assert_true(!black || (f->error.linear == 0 && f->scales[0] == 0));
        enc_factors_destroy(&f);
    }
    enc_data_destroy(&data);
}

/* One view, one light, one texel, and fewer texels than components: nothing fails, and a large budget gives all
 * components that exist. */
TEST(test_small_sizes) {
    static const int sizes[][4] = {
        {16, 16, 1, 20}, {16, 16, 20, 1}, {1, 1, 12, 12}, {4, 3, 20, 20}, {20, 1, 1, 1}};
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        enc_data *data = empty(&two, sizes[i][0], sizes[i][1], sizes[i][2], sizes[i][3]);
        fill(data, 30, 0.3f, 0.1f);
        enc_factors *f = encode(&two, data, 10000000, ENC_FACTOR_SWEEPS);
        assert_true(f->error.linear < 1e-4);
        assert_true(fabs(error_of(data, f, f->n_units) - f->error.linear) < 1e-9);
        enc_factors_destroy(&f);
        f = encode(&two, data, enc_factor_least_budget(sizes[i][0], sizes[i][1], sizes[i][2], sizes[i][3]),
                   1);
        assert_int_equal(f->n_units, 1);
        enc_factors_destroy(&f);
        enc_data_destroy(&data);
    }
}

/* Samples above 1 are kept as they are. */
TEST_OF_NUMBERS(test_highlights) {
    enc_data *data = empty(&two, 4, 4, 5, 5);
    fill_constant(data, 400.0f);
    enc_factors *f = encode(&two, data, 100000, 2);
    double rgb[3];
    decode(f, f->n_units, 3, 7, rgb);
    for (int i = 0; i < 3; i++) {
        assert_true(fabs(rgb[i] - 400) < 4);
    }
    enc_factors_destroy(&f);
    enc_data_destroy(&data);
}

/* Highlights up to a hundred times as bright as the rest, in few texels under few lights, are fitted by their roots
 * without clipping. Both they and the rest are recovered. The error clips both sides at 1. */
TEST_OF_NUMBERS(test_highlights_among_others) {
    enc_data *data = textured(16, 9, 12, 0.2f, 0);
    for (size_t t = 0; t < 256; t++) {
        for (size_t i = 0; i < 81 * 3; i++) { /* [view][channel][light] */
            const size_t view = i / 27, light = i % 9, at = t * 243 + i;
            const float lobe = t % 16 == 3 && view == light && view < 3 ? 1.0f + 0.5f * (float)(t / 16) : 0;
            const float root = sqrtf(data->samples[at]) + lobe;
            data->samples[at] = root * root;
        }
    }
    enc_factors *f = encode(&two, data, units(data, 3), ENC_FACTOR_SWEEPS);
    double worst = 0, brightest = 0;
    for (size_t t = 3; t < 256; t += 16) {
        for (size_t i = 0; i < 3; i++) {
            double rgb[3];
            const double was = data->samples[t * 243 + i * 27 + i];
            decode(f, f->n_units, t, i * 9 + i, rgb);
            worst = fmax(worst, fabs(rgb[0] / was - 1));
            brightest = fmax(brightest, was);
        }
    }
    print_message("brightest %.1f, off by %.1f %% at most; clipped to 1: %.2f dB\n", brightest, 100 * worst,
                  -10 * log10(f->error.linear));
    assert_true(brightest > 50 && worst < 0.01 && f->error.linear < 1e-5);
    assert_true(fabs(error_of(data, f, f->n_units) / f->error.linear - 1) < 1e-3);
    enc_factors_destroy(&f);
    enc_data_destroy(&data);
}

/* A black view gets factors of 0, or codes whose sum is 0, and the others are as accurate as without it. */
TEST(test_black_view) {
    enc_data *data = textured(12, 9, 20, 0.2f, 0);
    for (size_t t = 0; t < 144; t++) {
        memset(data->samples + t * enc_data_texel_stride(data) + 4 * 27, 0, 27 * sizeof(float));
    }
    enc_factors *f = encode(&two, data, units(data, 4), 3);
    assert_true(f->error.linear < 1e-4);
    for (size_t i = 0; i < 9; i++) {
        double rgb[3];
        decode(f, f->n_units, 5, 4 * 9 + i, rgb);
        assert_true(rgb[0] < 1e-4 && rgb[1] < 1e-4 && rgb[2] < 1e-4);
    }
    enc_factors_destroy(&f);
    enc_data_destroy(&data);
}

TEST(test_too_small_a_budget) {
    enc_data *data = textured(8, 5, 10, 0.3f, 0);
    const enc_factor_options options = {.budget = units(data, 1) - 1};
    enc_factors *f = (enc_factors *)&f;
    assert_int_equal(enc_factor_encode(&two, data, &options, &f), BTF_ERROR_USAGE);
    assert_null(f);
    enc_data_destroy(&data);
}

RUN_TESTS(NULL, NULL)
