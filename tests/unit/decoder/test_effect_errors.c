/* The table of effect errors: measured on data whose errors are known integrals, stored, read back, refused.
 *
 * SPDX-License-Identifier: MIT
 */
#include "decoder/toolkit/between.h"
#include "decoder/toolkit/reference_view.h"
#include "encoder/report/effect_errors.h"
#include "encoder/report/metrics.h"
#include "tests/support/random_material.h"
#include "tests/support/test.h"

enum { SIDE = 16, TEXELS = SIDE * SIDE, RINGS = 3, DIRECTIONS = 1 + 8 + 16 };

/* Theta 0, 30, 60 with 1, 8, 16 azimuths. */
static void make_directions(enc_direction out[DIRECTIONS]) {
    int n = 0;
    out[n++] = enc_direction_from_angles(0, 0);
    for (int i = 0; i < 8; i++) {
        out[n++] = enc_direction_from_angles(30, 45 * i);
    }
    for (int i = 0; i < 16; i++) {
        out[n++] = enc_direction_from_angles(60, 22.5 * i);
    }
}

/* A Lambertian of albedo 0.5, seen from every view with a gain of a half. */
static btf_material *make_material(const enc_direction *directions) {
    static float sbrdf[2][TEXELS][4], xyz[DIRECTIONS][3];
    static uint8_t gain[DIRECTIONS][TEXELS];
    for (int t = 0; t < TEXELS; t++) {
        memcpy(sbrdf[0][t], (float[4]){1, 1, 1, 0.5f}, sizeof sbrdf[0][t]);
    }
    memset(gain, 64, sizeof gain);
    for (int i = 0; i < DIRECTIONS; i++) {
        memcpy(xyz[i], directions[i].xyz, sizeof xyz[i]);
    }
    btf_material_desc desc = {.struct_size = sizeof desc, .views = xyz[0], .lights = xyz[0]};
    desc.info = (btf_material_info){.struct_size = sizeof desc.info,
                                    .width = SIDE,
                                    .height = SIDE,
                                    .n_views = DIRECTIONS,
                                    .n_lights = DIRECTIONS,
                                    .layout = BTF_LAYOUT_TIGHT,
                                    .lobes = 1,
                                    .effects = BTF_EFFECT_GAIN,
                                    .radiance_scale = 1,
                                    .shadow_scale = 1,
                                    .gain_scale = BTF_GAIN_SCALE,
                                    .centre_scale = 1};
    desc.texture[BTF_TEXTURE_SBRDF] = sbrdf;
    desc.texture[BTF_TEXTURE_GAIN] = gain;
    btf_material *material = NULL;
    assert_int_equal(btf_material_create(&desc, NULL, &material), BTF_OK);
    return material;
}

static enc_data *make_data(const enc_context *context, const enc_direction *directions) {
    enc_data *data = NULL;
    assert_int_equal(
        enc_data_create(context, SIDE, SIDE, DIRECTIONS, directions, DIRECTIONS, directions, &data),
        BTF_OK);
    const size_t stride = enc_data_texel_stride(data);
    float *samples = malloc(stride * sizeof *samples);
    assert_non_null(samples);
    for (size_t i = 0; i < stride; i++) {
        samples[i] = 0.25f * directions[i % DIRECTIONS].xyz[2];
    }
    for (size_t t = 0; t < TEXELS; t++) {
        assert_int_equal(enc_data_store_texels(context, data, t, 1, samples), BTF_OK);
    }
    free(samples);
    return data;
}

/* A material with the values that the encoder measured of it. */
static btf_material *with_all(const enc_effect_tables *tables, const float *between, size_t between_count,
                              btf_result expected) {
    enc_direction directions[DIRECTIONS];
    make_directions(directions);
    btf_material *plain = make_material(directions), *made = NULL;
    float xyz[DIRECTIONS][3];
    for (int i = 0; i < DIRECTIONS; i++) {
        memcpy(xyz[i], directions[i].xyz, sizeof xyz[i]);
    }
    btf_material_desc desc = {.struct_size = sizeof desc,
                              .views = xyz[0],
                              .lights = xyz[0],
                              .effect_errors = tables->errors,
                              .effect_error_count = tables->error_count,
                              .effect_differences = tables->differences,
                              .effect_difference_count = tables->difference_count,
                              .between_errors = between,
                              .between_error_count = between_count};
    desc.info = (btf_material_info){.struct_size = sizeof desc.info};
    assert_int_equal(btf_material_get_info(plain, &desc.info), BTF_OK);
    desc.texture[BTF_TEXTURE_SBRDF] = btf_material_texture(plain, BTF_TEXTURE_SBRDF).data;
    desc.texture[BTF_TEXTURE_GAIN] = btf_material_texture(plain, BTF_TEXTURE_GAIN).data;
    assert_int_equal(btf_material_create(&desc, NULL, &made), expected);
    btf_material_close(&plain);
    return made;
}

static btf_material *with_tables(const float *values, size_t count, const float *between,
                                 size_t between_count, btf_result expected) {
    const enc_effect_tables tables = {.errors = (float *)(uintptr_t)values, .error_count = count};
    return with_all(&tables, between, between_count, expected);
}

static btf_material *with_measured(const enc_effect_tables *tables) {
    return with_all(tables, NULL, 0, BTF_OK);
}

static btf_material *with_errors(const float *values, size_t count, btf_result expected) {
    return with_tables(values, count, NULL, 0, expected);
}

static const float *find_row(const btf_effect_errors *e, uint32_t effects, int nearest) {
    for (uint32_t r = 0; r < e->row_count; r++) {
        const float *row = e->rows + (size_t)r * e->row_stride;
        if (row[0] == (float)effects && row[2] == (float)nearest) {
            return row;
        }
    }
    fail_msg("no row for effects %u", effects);
    return NULL;
}

/* Mean over a band of the square of (0.5 - 0.25) cos(theta), uniform in solid angle: cos is uniform. */
static double lambert_error(double low, double high) {
    const double a = cos(high * M_PI / 180), b = cos(low * M_PI / 180);
    return 0.0625 * (b * b + a * b + a * a) / 3;
}

TEST(errors_are_the_integrals) {
    const enc_context context = {.threads = 2}, alone = {.threads = 1};
    enc_direction directions[DIRECTIONS];
    make_directions(directions);
    enc_data *data = make_data(&context, directions);
    btf_material *material = make_material(directions), *back = NULL;
    enc_effect_tables tables, again;
    assert_int_equal(enc_effect_errors(&context, data, material, &tables), BTF_OK);
    assert_int_equal(enc_effect_errors(&alone, data, material, &again), BTF_OK);
    assert_int_equal(tables.error_count, again.error_count);
    assert_memory_equal(tables.errors, again.errors, tables.error_count * sizeof *tables.errors);
    assert_int_equal(tables.difference_count, again.difference_count);
    assert_memory_equal(tables.differences, again.differences,
                        tables.difference_count * sizeof *tables.differences);

    btf_material *made = with_measured(&tables);
    void *file;
    size_t size;
    assert_int_equal(btf_material_save_memory(made, NULL, &file, &size), BTF_OK);
    assert_int_equal(btf_material_open_memory(file, size, NULL, &back), BTF_OK);
    btf_free(file);
    const btf_effect_errors e = btf_material_effect_errors(back);
    assert_int_equal(e.view_bands, RINGS);
    assert_int_equal(e.light_bands, RINGS);
    static const float limits[RINGS + 1] = {0, 15, 45, 60};
    assert_memory_equal(e.view_limits, limits, sizeof limits);
    assert_memory_equal(e.light_limits, limits, sizeof limits);
    assert_int_equal(e.row_count, 10); /* with gain and without; five kinds */
    const float *full = find_row(&e, BTF_EFFECT_GAIN, 0), *without = find_row(&e, 0, 0),
                *exact = find_row(&e, BTF_EFFECT_GAIN, 2);
    assert_true(full[4] == (float)(TEXELS * (2 * 16 + DIRECTIONS)));
    assert_true(without[4] == (float)(TEXELS * 2 * 16));
    for (int v = 0; v < RINGS; v++) {
        for (int l = 0; l < RINGS; l++) {
            const int at = 5 + 2 * (v * RINGS + l);
            const double expected = lambert_error(limits[l], limits[l + 1]);
            print_message("view band %d, light band %d: full %.1e, without gain %.5f, expected %.5f\n", v,
                          l, (double)full[at], (double)without[at], expected);
            assert_true(full[at] < 4e-4); /* the chord of a cosine between samples 30 degrees apart */
            assert_true(exact[at] < 1e-10f);
            assert_true(fabs(without[at] / expected - 1) < 0.1); /* the chord again */
            assert_true(without[at + 1] > 0.5f * without[at] && without[at + 1] < 2 * without[at]);
        }
    }
    /* Differences to the full decode: 0 in its own rows, the whole gain in the rows without gain, no rows at
     * samples. */
    const btf_effect_errors d = btf_material_effect_differences(back);
    assert_true(d.view_bands == RINGS && d.row_count == 8 && d.row_stride == e.row_stride);
    const float *same = find_row(&d, BTF_EFFECT_GAIN, 0), *changed = find_row(&d, 0, 0);
    assert_non_null(find_row(&d, BTF_EFFECT_GAIN, 1));
    for (uint32_t r = 0; r < d.row_count; r++) {
        assert_true(d.rows[(size_t)r * d.row_stride + 2] != 2);
    }
    for (int i = 5; i < (int)d.row_stride; i++) {
        assert_true(same[i] == 0);
        /* the error against the data differs from it by no more than the chord */
        assert_true(fabsf(changed[i] - without[i]) < 0.15f * without[i]);
    }
    enc_effect_tables_clear(&tables);
    enc_effect_tables_clear(&again);
    assert_true(tables.errors == NULL && tables.difference_count == 0);
    btf_material_close(&material);
    btf_material_close(&made);
    btf_material_close(&back);
    enc_data_destroy(&data);
}

static void in_band(random_state *r, const float *limits, int band, float out[3]) {
    const double low = cos(limits[band] * M_PI / 180), high = cos(limits[band + 1] * M_PI / 180);
    const double z = low + (high - low) * random_unit(r), s = sqrt(1 - z * z),
                 phi = 2 * M_PI * random_unit(r);
    out[0] = (float)(s * cos(phi));
    out[1] = (float)(s * sin(phi));
    out[2] = (float)z;
}

/* Against black data the error is the mean square of the decoded radiance. With many variants of decoding each gets few
 * samples; the full decode gets more, so that its errors are still near the truth. */
TEST(full_decodes_are_measured_finely) {
    const enc_context context = {.threads = 2};
    enc_direction directions[DIRECTIONS];
    random_state r = {3};
    make_directions(directions);
    btf_material_desc desc = random_material_desc(SIDE, SIDE, DIRECTIONS, DIRECTIONS, BTF_LAYOUT_TIGHT,
                                                  BTF_EFFECT_SHIFT | BTF_EFFECT_GAIN | BTF_EFFECT_RESIDUAL);
    for (int i = 0; i < DIRECTIONS; i++) {
        memcpy((float *)(uintptr_t)desc.views + 3 * i, directions[i].xyz, 3 * sizeof(float));
        memcpy((float *)(uintptr_t)desc.lights + 3 * i, directions[i].xyz, 3 * sizeof(float));
    }
    desc.info.colour = BTF_COLOUR_NONE;
    desc.info.lobes = 0;
    desc.info.components = 40;
    random_material_fill(&r, &desc);
    for (uint32_t k = 0; k < desc.info.components; k++) { /* mostly below 1 */
        ((float *)(uintptr_t)desc.texture[BTF_TEXTURE_RESIDUAL_SCALES])[k] = 0x1p-17f;
    }
    btf_material *material = NULL;
    assert_int_equal(btf_material_create(&desc, NULL, &material), BTF_OK);
    random_material_free(&desc);
    enc_data *black = NULL;
    assert_int_equal(
        enc_data_create(&context, SIDE, SIDE, DIRECTIONS, directions, DIRECTIONS, directions, &black),
        BTF_OK);
    enc_effect_tables tables;
    assert_int_equal(enc_effect_errors(&context, black, material, &tables), BTF_OK);
    const float *values = tables.errors, *limits = values + 2, *row = values + 4 + 2 * RINGS;
    const size_t count = tables.error_count;
    while (!(row[0] == (float)(BTF_EFFECT_SHIFT | BTF_EFFECT_GAIN | BTF_EFFECT_RESIDUAL) && row[1] == 40 &&
             row[2] == 0)) {
        row += 5 + 2 * RINGS * RINGS;
        assert_true(row < values + count);
    }
    btf_ref_material m;
    reference_view(material, 0, &m);
    const btf_ref_options all = {BTF_EFFECT_ALL, UINT32_MAX, BTF_REF_LINEAR, BTF_REF_TEXEL};
    double worst = 0, square = 0;
    for (int cell = 0; cell < RINGS * RINGS; cell++) {
        enum { SAMPLES = 20000 };
        double sum = 0;
        for (int i = 0; i < SAMPLES; i++) {
            float view[3], light[3], rgb[3];
            in_band(&r, limits, cell / RINGS, view);
            in_band(&r, limits, cell % RINGS, light);
            btf_ref_evaluate_texel(&m, &all, random_below(&r, SIDE), random_below(&r, SIDE), light, view,
                                   rgb);
            for (int c = 0; c < 3; c++) {
                sum += pow(fmin(fmax((double)rgb[c], 0), 1), 2) / 3;
            }
        }
        const double off = row[5 + 2 * cell] / (sum / SAMPLES) - 1;
        print_message("cell %d: expected %.4f, off by %+.1f %%\n", cell, sum / SAMPLES, 100 * off);
        worst = fmax(worst, fabs(off));
        square += off * off / (RINGS * RINGS);
    }
    print_message("root mean square %.2f %%\n", 100 * sqrt(square));
    assert_true(worst < 0.09 && sqrt(square) < 0.05); /* 0.28 and 0.18 without samples of its own */
    enc_effect_tables_clear(&tables);
    btf_material_close(&material);
    enc_data_destroy(&black);
}

/* A material with 32 subsets of effects, nine numbers of components and eight levels would need 6400 rows. The encoder
 * measures those of the first levels only, and a file accepts them. */
TEST(more_rows_than_a_table_has) {
    enum {
        ALL =
            BTF_EFFECT_SHADOW | BTF_EFFECT_SHIFT | BTF_EFFECT_HIDDEN | BTF_EFFECT_GAIN | BTF_EFFECT_RESIDUAL
    };
    const enc_context context = {.threads = 2};
    enc_direction directions[DIRECTIONS];
    random_state r = {3};
    make_directions(directions);
    btf_material_desc desc = random_material_desc(128, 1, DIRECTIONS, DIRECTIONS, BTF_LAYOUT_TIGHT, ALL);
    for (int i = 0; i < DIRECTIONS; i++) {
        memcpy((float *)(uintptr_t)desc.views + 3 * i, directions[i].xyz, 3 * sizeof(float));
        memcpy((float *)(uintptr_t)desc.lights + 3 * i, directions[i].xyz, 3 * sizeof(float));
    }
    desc.info.components = 64;
    desc.info.levels = 8;
    random_material_fill(&r, &desc);
    btf_material *material = NULL, *made = NULL;
    assert_int_equal(btf_material_create(&desc, NULL, &material), BTF_OK);
    enc_data *black = NULL;
    assert_int_equal(
        enc_data_create(&context, 128, 1, DIRECTIONS, directions, DIRECTIONS, directions, &black), BTF_OK);
    enc_effect_tables tables;
    assert_int_equal(enc_effect_errors(&context, black, material, &tables), BTF_OK);
    desc.effect_errors = tables.errors;
    desc.effect_error_count = tables.error_count;
    desc.effect_differences = tables.differences;
    desc.effect_difference_count = tables.difference_count;
    assert_int_equal(btf_material_create(&desc, NULL, &made), BTF_OK);
    const btf_effect_errors e = btf_material_effect_errors(made), d = btf_material_effect_differences(made);
    assert_int_equal(e.row_count, 5 * 800);
    assert_int_equal(d.row_count, (4 + 4) * 160); /* four kinds of level 0, one of each other */
    for (uint32_t i = 0; i < d.row_count; i++) {
        const float *row = d.rows + (size_t)i * d.row_stride;
        assert_true(row[3] == (i < 4 * 160 ? 0 : (float)(1 + (i - 4 * 160) / 160)) &&
                    (row[3] == 0 || row[2] == 0));
    }
    enc_effect_tables_clear(&tables);
    btf_material_close(&material);
    btf_material_close(&made);
    enc_data_destroy(&black);
    random_material_free(&desc);
}

/* Every impossible number in a table is refused. */
TEST(wrong_tables_are_refused) {
    const float good[] = {1, 2, 0, 90, 0, 30, 60, 8, 0, 0, 0, 100, 0.1f, 0.2f, 0.3f, 0.4f};
    enum { COUNT = sizeof good / sizeof *good };
    btf_material *made = with_errors(good, COUNT, BTF_OK);
    assert_int_equal(btf_material_effect_errors(made).row_count, 1);
    assert_true(btf_material_effect_errors(made).rows[5] == 0.1f);
    btf_material_close(&made);
    const struct {
        size_t index;
        float value;
    } wrong[] = {{0, 0},   {0, 17},   {1, 1.5f}, {1, NAN},   {3, 0},    {3, 91},
                 {5, 70},  {7, 1},    {7, -1},   {8, 1},     {9, 5},    {9, NAN},
                 {10, -1}, {10, NAN}, {11, -1},  {12, 1.5f}, {13, NAN}, {14, INFINITY}};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        float values[COUNT];
        memcpy(values, good, sizeof good);
        values[wrong[i].index] = wrong[i].value;
        assert_null(with_errors(values, COUNT, BTF_ERROR_USAGE));
        const enc_effect_tables differences = {.differences = values, .difference_count = COUNT};
        assert_null(with_all(&differences, NULL, 0, BTF_ERROR_USAGE));
    }
    for (size_t count = 1; count < COUNT; count++) {
        made = with_errors(good, count, count == 7 ? BTF_OK : BTF_ERROR_USAGE); /* 7: no row */
        btf_material_close(&made);
    }
}

/* A material of all effects has the most sets that are measured: 32 with relief and gloss, all else without either or both,
 * and nothing at all; each in five kinds of directions. */
TEST(all_effects_are_measured) {
    const enc_context context = {.threads = 1};
    random_state random = {5};
    enc_direction directions[3];
    btf_material_desc desc = random_material_desc(2, 2, 3, 2, BTF_LAYOUT_TIGHT, BTF_EFFECT_ALL);
    btf_material *material = NULL;
    enc_data *data = NULL;
    enc_effect_tables tables;
    random_material_fill(&random, &desc);
    for (int i = 0; i < 3; i++) {
        directions[i] = enc_direction_from_angles(20 * i, 0);
    }
    assert_int_equal(enc_data_create(&context, 2, 2, 3, directions, 2, directions, &data), BTF_OK);
    for (size_t i = 0; i < enc_data_texel_count(data) * enc_data_texel_stride(data); i++) {
        data->samples[i] = 0.5f;
    }
    assert_int_equal(btf_material_create(&desc, NULL, &material), BTF_OK);
    assert_int_equal(enc_effect_errors(&context, data, material, &tables), BTF_OK);
    const size_t views = (size_t)tables.errors[0], lights = (size_t)tables.errors[1];
    const size_t head = 4 + views + lights, length = 5 + 2 * views * lights;
    const size_t rows = (tables.error_count - head) / length;
    size_t kinds[5] = {0}, sets = 0;
    bool seen[BTF_EFFECT_ALL + 1] = {false};
    for (size_t r = 0; r < rows; r++) {
        const float *row = tables.errors + head + r * length;
        sets += !seen[(int)row[0]];
        seen[(int)row[0]] = true;
        kinds[(int)row[2]]++;
    }
    assert_int_equal(sets, 32 + 3 + 1);
    for (int k = 0; k < 5; k++) {
        assert_int_equal(kinds[k], rows / 5);
    }
    enc_effect_tables_clear(&tables);
    enc_data_destroy(&data);
    btf_material_close(&material);
    random_material_free(&desc);
}

/* The table of errors between the samples may have rows that leave out relief or gloss only where the material holds
 * it. */
static void check_rows_without_effects(void) {
    static const uint32_t effects[] = {0, BTF_EFFECT_RELIEF, BTF_EFFECT_GLOSS,
                                       BTF_EFFECT_RELIEF | BTF_EFFECT_GLOSS};
    static const struct {
        float left_out;
        uint32_t wants;
    } rows[] = {{5, BTF_EFFECT_RELIEF}, {7, BTF_EFFECT_RELIEF}, {9, BTF_EFFECT_GLOSS},
                {11, BTF_EFFECT_GLOSS}, {13, UINT32_MAX},       {15, UINT32_MAX},
                {8, UINT32_MAX}};
    for (size_t e = 0; e < sizeof effects / sizeof *effects; e++) {
        random_state random = {3};
        btf_material_desc desc =
            random_material_desc(3, 2, 3, 2, BTF_LAYOUT_TIGHT, BTF_EFFECT_SHADOW | effects[e]);
        random_material_fill(&random, &desc);
        for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
            const bool fits = rows[i].wants != UINT32_MAX && effects[e] & rows[i].wants;
            const float base = rows[i].left_out == 5 || rows[i].left_out == 9 ? 1 : 3;
            const float values[] = {1,     1,     0, 90, 0, 90, base,
                                    0.01f, 0.02f, 0, 0,  0, 0,  rows[i].left_out,
                                    0.1f,  0.04f, 0, 0,  0, 0};
            const bool tells = rows[i].left_out == 5 || rows[i].left_out == 11;
            btf_material *made = NULL;
            double gain[2];
            desc.between_errors = values;
            desc.between_error_count = sizeof values / sizeof *values;
            assert_int_equal(btf_material_create(&desc, NULL, &made), fits ? BTF_OK : BTF_ERROR_USAGE);
            for (uint32_t bit = BTF_EFFECT_RELIEF; fits && bit <= BTF_EFFECT_GLOSS; bit <<= 1) {
                const bool known = between_gain(made, bit, gain);
                assert_int_equal(known, tells && bit == rows[i].wants);
                assert_true(!known || (fabs(gain[0] - 10) < 1e-4 && fabs(gain[1] - 10 * log10(2)) < 1e-4));
            }
            btf_material_close(&made);
        }
        random_material_free(&desc);
    }
}

/* The table may have rows of coarser levels only in files of version 2, and only of levels that the material has. */
static void check_rows_of_levels(void) {
    static const struct {
        float left_out;
        /* accepted with 2 levels and gloss, which needs version 2; without gloss, in version 1, all are refused */
        bool with_gloss;
    } rows[] = {{16 + 1, true},  {16 + 3, true},  {16 + 11, true}, {16, false},     {16 + 4, false},
                {16 + 7, false}, {32 + 3, false}, {16.5f, false},  {16 + 12, false}};
    for (int gloss = 0; gloss < 2; gloss++) {
        random_state random = {3};
        btf_material_desc desc = random_material_desc(4, 4, 3, 2, BTF_LAYOUT_TIGHT,
                                                      BTF_EFFECT_SHADOW | (gloss ? BTF_EFFECT_GLOSS : 0));
        desc.info.levels = 2;
        random_material_fill(&random, &desc);
        for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
            const float values[] = {1, 1, 0, 90, 0, 90, 3, 0, 0, 0, 0, 0, 0, rows[i].left_out,
                                    0, 0, 0, 0,  0, 0};
            btf_material *made = NULL;
            desc.between_errors = values;
            desc.between_error_count = sizeof values / sizeof *values;
            assert_int_equal(btf_material_create(&desc, NULL, &made),
                             gloss && rows[i].with_gloss ? BTF_OK : BTF_ERROR_USAGE);
            btf_material_close(&made);
        }
        random_material_free(&desc);
    }
}

/* Opens a copy of the file in which the `size` bytes at `at` after the first `name` are replaced by `value`. */
static btf_material *open_changed(const void *file, size_t file_size, const char *name, size_t at,
                                  const void *value, size_t size, btf_result expected) {
    uint8_t *bytes = malloc(file_size);
    btf_material *opened = NULL;
    memcpy(bytes, file, file_size);
    uint8_t *found = memmem(bytes, file_size, name, strlen(name) + 1);
    assert_non_null(found);
    memcpy(found + at, value, size);
    assert_int_equal(btf_material_open_memory(bytes, file_size, NULL, &opened), expected);
    free(bytes);
    return opened;
}

static void check_refused(const void *file, size_t size, const char *name, size_t number, float value) {
    const size_t values = strlen(name) + 1 + sizeof "floatvector" + 4;
    assert_null(open_changed(file, size, name, values + 4 * number, &value, 4, BTF_ERROR_BAD_FILE));
}

/* A file keeps the rows of level 0 in the attribute that readers from before coarser levels know, those of coarser levels in
 * one that they pass over. */
static void check_attributes_of_levels(void) {
    static const char name[] = "openbtf.betweenErrors", level_name[] = "openbtf.levelBetweenErrors";
    static const float mixed[] = {1, 1, 0, 90, 0,    90,   16 + 3,  0, 0, 0, 0, 0.3f, 0.4f, 3,
                                  0, 0, 0, 0,  0.1f, 0.2f, 16 + 11, 0, 0, 0, 0, 0.5f, 0.6f},
                       sorted[] = {3, 0,    0,    0,       0, 0.1f, 0.2f, 16 + 3, 0,    0,   0,
                                   0, 0.3f, 0.4f, 16 + 11, 0, 0,    0,    0,      0.5f, 0.6f};
    random_state random = {3};
    btf_material_desc desc =
        random_material_desc(4, 4, 3, 2, BTF_LAYOUT_TIGHT, BTF_EFFECT_SHADOW | BTF_EFFECT_GLOSS);
    btf_material *made = NULL, *opened = NULL;
    void *bytes;
    size_t size;
    desc.info.levels = 2;
    random_material_fill(&random, &desc);
    desc.between_errors = mixed;
    desc.between_error_count = sizeof mixed / sizeof *mixed;
    assert_int_equal(btf_material_create(&desc, NULL, &made), BTF_OK);
    assert_int_equal(btf_material_save_memory(made, NULL, &bytes, &size), BTF_OK);
    assert_int_equal(btf_material_open_memory(bytes, size, NULL, &opened), BTF_OK);
    btf_between_errors e = btf_material_between_errors(opened);
    assert_true(e.row_count == 3 && e.row_stride == 7 && e.light_limits[1] == 90);
    assert_memory_equal(e.rows, sorted, sizeof sorted);
    btf_material_close(&opened);

    opened = open_changed(bytes, size, level_name, 8, "L", 1, BTF_OK); /* unknown, as to old readers */
    e = btf_material_between_errors(opened);
    assert_int_equal(e.row_count, 1);
    assert_memory_equal(e.rows, sorted, 7 * sizeof *sorted);
    btf_material_close(&opened);
    opened = open_changed(bytes, size, name, 8, "B", 1, BTF_OK);
    e = btf_material_between_errors(opened);
    assert_int_equal(e.row_count, 2);
    assert_memory_equal(e.rows, sorted + 7, 14 * sizeof *sorted);
    btf_material_close(&opened);
    check_refused(bytes, size, name, 6, 16 + 3); /* a row that older readers would refuse */
    check_refused(bytes, size, level_name, 6, 3);
    check_refused(bytes, size, level_name, 13, 32 + 3);
    check_refused(bytes, size, level_name, 11, -2);
    check_refused(bytes, size, level_name, 3, 80); /* other bands */
    btf_free(bytes);
    btf_material_close(&made);
    desc.between_error_count = 13; /* no row of level 0 */
    assert_int_equal(btf_material_create(&desc, NULL, &made), BTF_OK);
    assert_int_equal(btf_material_save_memory(made, NULL, &bytes, &size), BTF_OK);
    assert_int_equal(btf_material_open_memory(bytes, size, NULL, &opened), BTF_OK);
    e = btf_material_between_errors(opened);
    assert_int_equal(e.row_count, 1);
    assert_memory_equal(e.rows, mixed + 6, 7 * sizeof *mixed);
    btf_free(bytes);
    btf_material_close(&opened);
    btf_material_close(&made);
    random_material_free(&desc);
}

/* The table of errors between the samples: kept by a file, and refused where it cannot be. */
TEST(between_errors_are_checked) {
    const float good[] = {2,    1,    0,    20, 50,   0,    70,   1,    0.1f, 0.2f, 0.3f, 0.4f, 0.5f,
                          0.6f, 0.7f, 0.8f, 3,  0.1f, 0.2f, 0.3f, 0.4f, -1,   -1,   0,    1};
    enum { COUNT = sizeof good / sizeof *good };
    btf_material *made = with_tables(NULL, 0, good, COUNT, BTF_OK), *opened = NULL;
    void *bytes;
    size_t size;
    assert_int_equal(btf_material_save_memory(made, NULL, &bytes, &size), BTF_OK);
    assert_int_equal(btf_material_open_memory(bytes, size, NULL, &opened), BTF_OK);
    const btf_between_errors e = btf_material_between_errors(opened);
    assert_true(e.view_bands == 2 && e.light_bands == 1 && e.row_count == 2 && e.row_stride == 9);
    assert_true(e.view_limits[2] == 50 && e.light_limits[1] == 70 && e.rows[5] == 0.5f && e.rows[9] == 3);
    assert_memory_equal(e.rows, good + 7, 18 * sizeof *good);
    btf_free(bytes);
    btf_material_close(&opened);
    btf_material_close(&made);
    made = with_errors(NULL, 0, BTF_OK);
    assert_int_equal(btf_material_between_errors(made).row_count, 0);
    btf_material_close(&made);
    const struct {
        size_t index;
        float value;
    } wrong[] = {{0, 0},    {0, 17}, {1, NAN},  {3, 60},   {6, 91},  {7, 0},         {7, 4},   {7, 5},
                 {7, 1.5f}, {8, -1}, {9, 1.5f}, {11, NAN}, {12, -2}, {13, INFINITY}, {14, NAN}};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        float values[COUNT];
        memcpy(values, good, sizeof good);
        values[wrong[i].index] = wrong[i].value;
        assert_null(with_tables(NULL, 0, values, COUNT, BTF_ERROR_USAGE));
    }
    check_rows_without_effects();
    check_rows_of_levels();
    check_attributes_of_levels();
    for (size_t count = 1; count < COUNT; count++) {
        made = with_tables(NULL, 0, good, count, count == 7 || count == 16 ? BTF_OK : BTF_ERROR_USAGE);
        btf_material_close(&made);
    }
}

RUN_TESTS(NULL, NULL)
