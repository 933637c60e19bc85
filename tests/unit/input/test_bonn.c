/* Bonn's binary .btf files (encoder/input/bonn): every kind and form against values computed here from the same factors
 * in double precision, by the published layout; a file written byte by byte; crops, sizes, fewer components, memory
 * bounds; every truncation and contradiction is refused with a message that names it.
 *
 * SPDX-License-Identifier: MIT
 */
#include "tests/support/bonn_files.h"
#include "encoder/input/bonn/colour.h"
#include "encoder/input/bonn/decode.h"
#include "encoder/input/reader.h"
#include "tests/support/image_files.h"
#include "tests/support/messages.h"
#include "tests/support/temporary.h"
#include "tests/support/test.h"

#include <unistd.h>

enum { W = 7, H = 5, VIEWS = 4, LIGHTS = 6, K = 3 };
/* Directions that are not in paper order, with azimuths below and above 180. */
static const double views[VIEWS][2] = {{30, 120}, {0, 0}, {75, 240}, {30, 0}};
static const double lights[LIGHTS][2] = {{15, 90}, {0, 0}, {45, 7.5}, {75, 345}, {60, 10}, {15, 270}};
static const int view_order[VIEWS] = {1, 3, 0, 2}, light_order[LIGHTS] = {1, 0, 5, 2, 4, 3};

static enc_context context = {.log = {keep_message, NULL}, .threads = 2};

static int set_up(void **state) {
    forget_messages();
    context.memory = 0;
    context.threads = 2;
    return make_temporary_file(state);
}

/* Numbers that a half holds exactly, positive and negative, different for all arguments. */
static double number(int a, int b, int c, int d) {
    const unsigned hash = (unsigned)a * 2654435761u ^ (unsigned)b * 2246822519u ^
                          (unsigned)c * 3266489917u ^ (unsigned)d * 668265263u;
    return ((hash >> 13) % 257) / 256.0;
}
static double direction(int view, int light, int channel, unsigned k) {
    return number(view + 1, light + 10, channel + 100, (int)k + 1);
}
static double texel(int x, int y, int channel, int view, unsigned k) {
    return number(x + 3, y + 50, channel + 7 * view + 200, (int)k + 11) - (k == 0 ? 0.0 : 0.25);
}
static double average(int view, int light, int channel, int x, int y) {
    return 0.5 + number(view + 2, light + 30, channel + 9, 40 * x + y);
}
static double sample(int view, int light, int channel, int x, int y) {
    return number(view + 5, 10 * light + channel, x + 60, y + 70);
}

static bonn_spec spec_of(bonn_form form, const char *signature) {
    /* clang-format off */
    return (bonn_spec){
        .form = form, .signature = signature, .meta_version = 4, .cosine = true, .width = W, .height = H,
        .n_views = VIEWS, .n_lights = LIGHTS, .views = views, .lights = lights, .scalar = {2, 4, 8},
        .components = {K, K + 1, K - 1}, .lines_per_chunk = 2, .compression = 0, .direction = direction,
        .texel = texel, .average = average, .sample = sample,
    };
    /* clang-format on */
}

/* The radiance that the file codes for its view and light, with at most `most` components. */
static void coded(const bonn_spec *s, int v, int l, int x, int y, unsigned most, double out[3]) {
    for (int c = 0; c < 3; c++) {
        const bool pvf = s->form == BONN_PVF || s->form == BONN_PVF_LEGACY;
        const unsigned k = s->form == BONN_DFMF ? s->components[c] : s->components[0];
        const bool on_left =
            s->form == BONN_FMF || pvf; /* the channel is told apart on the left side alone */
        out[c] = pvf ? (s->swapped ? average(v, 0, c, x, y) : average(v, l, c, 0, 0)) : 0.0;
        if (s->form == BONN_BDI) {
            const bool there = s->compression != 2 || !s->mask || s->mask[y * s->width + x];
            out[c] = there ? sample(v, l, c, x, y) : 0.0;
            continue;
        }
        for (unsigned i = 0; i < k && i < most; i++) {
            out[c] += direction(v, l, on_left && s->swapped ? 0 : c, i) *
                      texel(x, y, on_left && !s->swapped ? 0 : c, pvf ? v : 0, i);
        }
    }
}

static enc_data *read_spec(const bonn_spec *s, const enc_read_options *options) {
    enc_data *data = NULL;
    assert_true(bonn_write(temporary_file, s));
    const btf_result result = enc_read(&context, temporary_file, options, &data);
    if (result != BTF_OK) {
        fail_msg("%s: result %d: %s", s->signature, (int)result, all_messages);
    }
    return data;
}

/* Compares every sample with coded(), clamped, after `decode` (may be NULL). */
static void check_all(const bonn_spec *s, const enc_data *data, unsigned most, void (*decode)(double[3])) {
    const size_t stride = enc_data_texel_stride(data);
    float *buffer = malloc(stride * sizeof *buffer),
          *view = malloc((size_t)W * H * LIGHTS * 3 * sizeof *view);
    assert_non_null(buffer);
    assert_non_null(view);
    for (int v = 0; v < VIEWS; v++) {
        assert_int_equal(enc_data_view(&context, data, v, view), BTF_OK);
        for (int t = 0; t < W * H; t++) {
            const float *samples;
            assert_int_equal(enc_data_texels(&context, data, (size_t)t, 1, buffer, &samples), BTF_OK);
            for (int l = 0; l < LIGHTS; l++) {
                double expected[3];
                coded(s, view_order[v], light_order[l], t % W, t / W, most, expected);
                if (decode) {
                    decode(expected);
                }
                for (int c = 0; c < 3; c++) {
                    const double want = fmax(
                        expected[c] * (s->cosine ? 1.0 : cos(lights[light_order[l]][0] * M_PI / 180)), 0);
                    const double got = (double)samples[(v * 3 + c) * LIGHTS + l];
                    if (fabs(got - want) > 2e-6 * (1.0 + fabs(want))) {
                        fail_msg("%s: view %d light %d channel %d texel %d: %.9g, expected %.9g",
                                 s->signature, v, l, c, t, got, want);
                    }
                    assert_true(samples[(v * 3 + c) * LIGHTS + l] == view[(l * W * H + t) * 3 + c]);
                }
            }
        }
    }
    free(buffer);
    free(view);
}

static void check_spec(const bonn_spec *s, unsigned most, void (*decode)(double[3])) {
    for (int small = 0; small < 2; small++) { /* kept in memory, and made when asked for */
        enc_read_options options = {.components = most == UINT32_MAX ? 0 : (int)most};
        context.memory = small ? 4096 : 0;
        enc_data *data = read_spec(s, &options);
        assert_int_equal(data->width, W);
        assert_int_equal(data->height, H);
        assert_int_equal(data->n_views, VIEWS);
        assert_int_equal(data->n_lights, LIGHTS);
        assert_true((data->samples == NULL) == (small == 1));
        assert_int_equal(data->top_view, 0);
        for (int i = 0; i < LIGHTS; i++) {
            assert_float_equal(data->lights[i].theta, lights[light_order[i]][0], 1e-9);
            assert_float_equal(data->lights[i].phi, lights[light_order[i]][1], 1e-9);
        }
        check_all(s, data, most, decode);
        enc_data_destroy(&data);
    }
    context.memory = 0;
}

TEST_WITH(test_dfmf, set_up, remove_temporary_file) {
    for (int swapped = 0; swapped < 2; swapped++) {
        bonn_spec s = spec_of(BONN_DFMF, "!DFMF08FCR");
        s.swapped = swapped;
        check_spec(&s, UINT32_MAX, NULL);
        check_spec(&s, 2, NULL);
        s.rotations = 2;
        for (s.meta_version = 1; s.meta_version < 4; s.meta_version++) {
            s.cosine = s.meta_version > 1;
            check_spec(&s, UINT32_MAX, NULL);
        }
    }
}

TEST_WITH(test_fmf, set_up, remove_temporary_file) {
    static const char *const signatures[] = {"!FMF12FCER", "!FMF06FCR", "!FMF06FC"};
    for (int i = 0; i < 3; i++) {
        for (int swapped = 0; swapped < 2; swapped++) {
            bonn_spec s = spec_of(BONN_FMF, signatures[i]);
            s.swapped = swapped;
            s.scalar[0] = i == 0 ? 8 : 2;
            s.header_version = 2;
            s.height_rows = 3;
            s.height_columns = 2;
            check_spec(&s, UINT32_MAX, NULL);
            check_spec(&s, 1, NULL);
        }
    }
}

static void undo_logarithm(double v[3]) {
    for (int c = 0; c < 3; c++) {
        v[c] = exp(v[c]) - 1e-5;
    }
}

TEST_WITH(test_fmf_logarithm, set_up, remove_temporary_file) {
    bonn_spec s = spec_of(BONN_FMF, "!FMF12FCER");
    s.header_version = 1;
    s.logarithm = 1;
    check_spec(&s, UINT32_MAX, undo_logarithm);
}

TEST_WITH(test_pvf, set_up, remove_temporary_file) {
    for (int form = 0; form < 3; form++) {
        for (int swapped = 0; swapped < 2; swapped++) {
            bonn_spec s = form == 0   ? spec_of(BONN_PVF, "!PVF06FCR")
                          : form == 1 ? spec_of(BONN_PVF, "!PVF06FC")
                                      : spec_of(BONN_PVF_LEGACY, "!PVF06FC");
            s.swapped = swapped;
            s.cosine = form < 2; /* the legacy form has no such flag */
            check_spec(&s, UINT32_MAX, NULL);
            check_spec(&s, 2, NULL);
        }
    }
}

TEST_WITH(test_bdi, set_up, remove_temporary_file) {
    unsigned char mask[W * H];
    for (int i = 0; i < W * H; i++) {
        mask[i] = i % 4 != 2;
    }
    for (unsigned compression = 0; compression < 3; compression++) {
        for (unsigned lines = 1; lines <= 7; lines += 3) {
            bonn_spec s = spec_of(BONN_BDI, "!BDIF06R2!");
            s.compression = compression;
            s.lines_per_chunk = lines;
            s.mask = compression == 2 ? mask : NULL;
            s.rotations = 1;
            check_spec(&s, UINT32_MAX, NULL);
            assert_true((strstr(all_messages, "9 of 35 texels are missing") != NULL) == (compression == 2));
        }
    }
}

/* The colour models, against numbers worked out on paper. */
TEST_WITH(test_colour_models, set_up, remove_temporary_file) {
    static const float mean[3] = {0.1f, 0.2f, 0.3f}, matrix[9] = {1, 2, 3, 4, 5, 6, 7, 8, 9};
    const float y = logf(0.5f + 1e-5f);
    const struct {
        int model;
        float in[3], out[3];
    } cases[] = {
        {0, {0.1f, 0.2f, 0.3f}, {0.1f, 0.2f, 0.3f}},
        {1, {0.5f, 0.1f, 0.2f}, {0.727966f, 0.344415f, 0.703211f}},
        {2, {100, 0, 0}, {1, 1, 1}},
        {2, {50, 0, 0}, {0.184187f, 0.184187f, 0.184187f}}, /* (66/116)^3 */
        {2, {53.2408f, 80.0925f, 67.2032f}, {1, 0, 0}},     /* red of Rec. 709 */
        {3, {1, 0, 2}, {15.1f, 18.2f, 21.3f}},
        {4, {0.5f, 0.1f, 0.2f}, {0.4f, 0.7f, 0.2f}},
        {9, {y, 0.1f, 0.2f}, {0.727966f, 0.344415f, 0.703211f}},
        {10, {y, 0, -logf(20000.0f)}, {0.272034f, 0.61612f, 0.5f}}, /* V = -0.2 */
        {11, {y, 0.2f, 0.4f}, {0.727970f, 0.344411f, 0.703215f}},
        {12, {y, y, y}, {0.5f, 0.5f, 0.5f}},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        float s[3] = {cases[i].in[0], cases[i].in[1], cases[i].in[2]};
        enc_bonn_colour(cases[i].model, mean, matrix, 1, 1, s);
        for (int c = 0; c < 3; c++) {
            if (fabsf(s[c] - cases[i].out[c]) >
                2e-4f * (1.0f + fabsf(cases[i].out[c])) * (cases[i].model == 2 ? 5 : 1)) {
                fail_msg("model %d channel %d: %.7g, expected %.7g", cases[i].model, c, (double)s[c],
                         (double)cases[i].out[c]);
            }
        }
    }
}

/* One texel, one view, two lights, one component a channel, byte by byte. */
TEST_WITH(test_by_hand, set_up, remove_temporary_file) {
    unsigned char bytes[600];
    size_t n = 0;
#define TEXT(t) (memcpy(bytes + n, t, strlen(t)), n += strlen(t))
#define U32(v)                                                                                             \
    (bytes[n] = (v)&255, bytes[n + 1] = (v) >> 8 & 255, bytes[n + 2] = (v) >> 16 & 255,                    \
     bytes[n + 3] = (unsigned)(v) >> 24, n += 4)
    memset(bytes, 0, sizeof bytes);
    TEXT("!DFMF08FCR");
    U32(268); /* 4 + 4 + 240 + 16 + 4 */
    U32(2);
    n += 240 + 16;
    U32(1); /* cosine included */
    U32(1); /* views */
    U32(0), U32(0);
    U32(2); /* lights */
    U32(0), U32(0);
    U32(0x3F060A92), U32(0x3FC90FDB); /* 30 degrees, 90 degrees */
    U32(1), U32(1), U32(0);           /* 1x1, no rotation */
    U32(1), U32(11);                  /* components, model */
    n += 12 + 36;
    for (int c = 0; c < 3; c++) {
        bytes[n++] = 2;
        U32(1), U32(2), U32(1);
        static const unsigned halfs[3][4] = {
            /* singular value, two directions, texel: 1, (0, -0.6934), 1: Y = 1 and 0.5 */
            {0x3C00, 0x0000, 0xB98C, 0x3C00},
            /* 1, (0, 0.5), 0.5: U / Y = 0 and 0.25 */
            {0x3C00, 0x0000, 0x3800, 0x3800},
            /* 1, (0.25, 0), 2: V / Y = 0.5 and 0 */
            {0x3C00, 0x3400, 0x0000, 0x4000},
        };
        for (int i = 0; i < 4; i++, n += 2) {
            bytes[n] = halfs[c][i] & 255;
            bytes[n + 1] = (unsigned char)(halfs[c][i] >> 8);
        }
    }
#undef TEXT
#undef U32
    write_whole_file(temporary_file, bytes, n);
    const enc_read_options options = {0};
    enc_data *data = NULL;
    if (enc_read(&context, temporary_file, &options, &data) != BTF_OK) {
        fail_msg("%s", all_messages);
    }
    /* -0.6934 is -0.693359375 as a half: exp gives 0.499894 */
    static const float expected[2][3] = {{1.569905f, 0.709695f, 0.99999f},
                                         {0.499884f, 0.450564f, 0.753850f}};
    for (int l = 0; l < 2; l++) {
        for (int c = 0; c < 3; c++) {
            assert_float_equal(data->samples[c * 2 + l], expected[l][c], 2e-5);
        }
    }
    assert_float_equal(data->lights[1].theta, 30.0, 1e-9);
    assert_float_equal(data->lights[1].phi, 90.0, 1e-9);
    enc_data_destroy(&data);
}

/* Crop, size, flip and blocks of memory against the whole. */
TEST_WITH(test_parts, set_up, remove_temporary_file) {
    const bonn_spec s = spec_of(BONN_DFMF, "!DFMF08FCR");
    enc_read_options options = {0};
    enc_data *whole = read_spec(&s, &options);
    const size_t stride = enc_data_texel_stride(whole);
    for (int small = 0; small < 2; small++) {
        context.memory = small ? 1024 : 0;
        options = (enc_read_options){.crop = {2, 1, 4, 3}, .flip_v = true};
        enc_data *part = read_spec(&s, &options);
        float *buffer = malloc(12 * stride * sizeof *buffer);
        const float *samples;
        assert_int_equal(enc_data_texels(&context, part, 0, 12, buffer, &samples), BTF_OK);
        for (size_t y = 0; y < 3; y++) {
            for (size_t x = 0; x < 4; x++) {
                assert_memory_equal(samples + (y * 4 + x) * stride,
                                    whole->samples + ((3 - y) * W + 2 + x) * stride,
                                    stride * sizeof(float));
            }
        }
        enc_data_destroy(&part);
        /* to half the size: the mean of 2 x 1.5 texels */
        options = (enc_read_options){.crop = {0, 0, 6, 3}, .size = {3, 2}};
        part = read_spec(&s, &options);
        assert_int_equal(enc_data_texels(&context, part, 0, 6, buffer, &samples), BTF_OK);
        for (size_t i = 0; i < stride; i++) {
            const float *w = whole->samples + i;
#define AT(x, y) (double)w[((y)*W + (x)) * stride]
            /* clamping comes after the filter, so only where nothing was clamped is this the expected value */
            const double mean = (AT(2, 0) + AT(3, 0) + 0.5 * (AT(2, 1) + AT(3, 1))) / 3.0;
            if (AT(2, 0) > 0 && AT(3, 0) > 0 && AT(2, 1) > 0 && AT(3, 1) > 0) {
                assert_float_equal((double)samples[stride + i], mean, 1e-5);
            }
#undef AT
        }
        enc_data_destroy(&part);
        free(buffer);
    }
    enc_data_destroy(&whole);
}

static void expect_refusal(const char *what, const enc_read_options *options, btf_result expected,
                           const char *words) {
    enc_data *data = NULL;
    forget_messages();
    const btf_result result = enc_read(&context, temporary_file, options, &data);
    assert_null(data);
    if (result != expected || !strstr(all_messages, words)) {
        fail_msg("%s: result %d, expected %d; message \"%s\" lacks \"%s\"", what, (int)result,
                 (int)expected, all_messages, words);
    }
}

TEST_WITH(test_contradictions, set_up, remove_temporary_file) {
    const enc_read_options options = {0};
    const struct {
        size_t at; /* byte of the DFMF file below, without rotations and of meta version 1 */
        uint32_t value;
        btf_result result;
        const char *words;
    } cases[] = {
        {10, 999, BTF_ERROR_BAD_FILE, "field metaSize"},
        {14, 5, BTF_ERROR_UNSUPPORTED, "field metaVersion"},
        {274, 0, BTF_ERROR_BAD_FILE, "field view count"},
        {274, 300, BTF_ERROR_UNSUPPORTED, "field view count"},
        {278, 0x7FC00000, BTF_ERROR_BAD_FILE, "theta of a view"},
        {278, 0x40000000, BTF_ERROR_BAD_FILE, "theta of view 0 is 114.59"},
        {346, 7, BTF_ERROR_UNSUPPORTED, "differs from the first view's: 7"},
    };
    bonn_spec s = spec_of(BONN_DFMF, "!DFMF08FCR");
    s.meta_version = 1;
    assert_true(bonn_write(temporary_file, &s));
    size_t size;
    unsigned char *bytes = read_whole_file(temporary_file, &size);
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        unsigned char kept[4];
        memcpy(kept, bytes + cases[i].at, 4);
        for (int b = 0; b < 4; b++) {
            bytes[cases[i].at + (size_t)b] = (unsigned char)(cases[i].value >> 8 * b);
        }
        write_whole_file(temporary_file, bytes, size);
        expect_refusal("patched", &options, cases[i].result, cases[i].words);
        memcpy(bytes + cases[i].at, kept, 4);
    }
    bytes = realloc(bytes, size + 1);
    bytes[size] = 0;
    write_whole_file(temporary_file, bytes, size + 1);
    expect_refusal("longer", &options, BTF_ERROR_BAD_FILE, "end of file");
    free(bytes);

    s.model = 5;
    assert_true(bonn_write(temporary_file, &s));
    expect_refusal("spectral model", &options, BTF_ERROR_UNSUPPORTED, "field colour model");
    s = spec_of(BONN_DFMF, "!DFMF08FCR");
    s.channels = 4;
    assert_true(bonn_write(temporary_file, &s));
    expect_refusal("four channels", &options, BTF_ERROR_UNSUPPORTED, "field channel count");
    s = spec_of(BONN_FMF, "!FMF12FCER");
    s.header_version = 3;
    assert_true(bonn_write(temporary_file, &s));
    expect_refusal("header version", &options, BTF_ERROR_UNSUPPORTED, "field header version");
    s = spec_of(BONN_BDI, "!BDIF06R2!");
    s.compression = 3;
    assert_true(bonn_write(temporary_file, &s));
    expect_refusal("compression", &options, BTF_ERROR_UNSUPPORTED, "field compression");
    const enc_read_options crop = {.crop = {4, 0, 4, 1}};
    s = spec_of(BONN_DFMF, "!DFMF08FCR");
    assert_true(bonn_write(temporary_file, &s));
    expect_refusal("crop", &crop, BTF_ERROR_USAGE, "7x5");
    const enc_read_options strict = {.strict = true};
    s.model = 1;
    assert_true(bonn_write(temporary_file, &s));
    expect_refusal("negative", &strict, BTF_ERROR_BAD_FILE, "below 0");
}

static double broken_texel(int x, int y, int channel, int view, unsigned k) {
    return x == 3 && y == 2 && channel == 1 && k == 0 ? NAN : texel(x, y, channel, view, k);
}
static double broken_direction(int view, int light, int channel, unsigned k) {
    return view == 2 && light == 1 && k == 1 ? INFINITY : direction(view, light, channel, k);
}

TEST_WITH(test_not_finite, set_up, remove_temporary_file) {
    const enc_read_options options = {0};
    bonn_spec s = spec_of(BONN_DFMF, "!DFMF08FCR");
    s.texel = broken_texel;
    assert_true(bonn_write(temporary_file, &s));
    expect_refusal("texel", &options, BTF_ERROR_BAD_FILE, "column 3, row 2");
    s.texel = texel;
    s.direction = broken_direction;
    assert_true(bonn_write(temporary_file, &s));
    expect_refusal("direction", &options, BTF_ERROR_BAD_FILE, "view 2, light 1: number 1 is not finite");
}

/* Cut short anywhere, a file is refused: no crash, no BTF. */
TEST_WITH(test_truncated, set_up, remove_temporary_file) {
    const enc_read_options options = {0};
    context.threads = 1;
    const struct {
        bonn_form form;
        const char *signature;
    } kinds[] = {{BONN_DFMF, "!DFMF08FCR"},
                 {BONN_FMF, "!FMF12FCER"},
                 {BONN_PVF, "!PVF06FCR"},
                 {BONN_PVF_LEGACY, "!PVF06FC"},
                 {BONN_BDI, "!BDIF06R2!"}};
    for (size_t i = 0; i < sizeof kinds / sizeof kinds[0]; i++) {
        bonn_spec s = spec_of(kinds[i].form, kinds[i].signature);
        s.width = 2;
        s.height = 1;
        s.header_version = 2;
        assert_true(bonn_write(temporary_file, &s));
        size_t size;
        unsigned char *bytes = read_whole_file(temporary_file, &size);
        for (size_t length = 11; length < size; length += length < 700 ? 1 : 17) {
            write_whole_file(temporary_file, bytes, length);
            expect_refusal(kinds[i].signature, &options, BTF_ERROR_BAD_FILE, "field ");
        }
        free(bytes);
    }
}

/* A damaged file is either refused or read as finite samples. */
TEST_WITH(test_damaged, set_up, remove_temporary_file) {
    const enc_read_options options = {0};
    context.threads = 1;
    bonn_spec s = spec_of(BONN_BDI, "!BDIF06R2!");
    s.width = 2;
    s.height = 2;
    for (int kind = 0; kind < 3; kind++) {
        if (kind == 1) {
            s.compression = 1;
        }
        if (kind == 2) {
            s = spec_of(BONN_PVF, "!PVF06FCR");
            s.width = 2;
            s.height = 2;
        }
        assert_true(bonn_write(temporary_file, &s));
        size_t size;
        unsigned char *bytes = read_whole_file(temporary_file, &size);
        for (size_t at = 0; at < size; at += at < 560 ? 1 : 7) {
            const unsigned char kept = bytes[at];
            bytes[at] ^= at % 2 ? 0xFF : 0x81;
            write_whole_file(temporary_file, bytes, size);
            bytes[at] = kept;
            enc_data *data = NULL;
            forget_messages();
            if (enc_read(&context, temporary_file, &options, &data) == BTF_OK) {
                const size_t n = enc_data_texel_stride(data) * enc_data_texel_count(data);
                for (size_t i = 0; i < n; i++) {
                    assert_true(isfinite(data->samples[i]) && data->samples[i] >= 0.0f);
                }
            } else {
                assert_true(all_messages[0] != '\0');
            }
            enc_data_destroy(&data);
        }
        free(bytes);
    }
}

TEST_WITH(test_cosine_option, set_up, remove_temporary_file) {
    bonn_spec s = spec_of(BONN_DFMF, "!DFMF08FCR");
    enc_read_options options = {.cosine = ENC_COSINE_MISSING};
    enc_data *missing = read_spec(&s, &options);
    options.cosine = ENC_COSINE_INCLUDED;
    enc_data *included = read_spec(&s, &options);
    for (size_t i = 0; i < enc_data_texel_stride(missing); i++) {
        const double cosine = cos(missing->lights[i % LIGHTS].theta * M_PI / 180);
        assert_float_equal((double)missing->samples[i], (double)included->samples[i] * cosine, 1e-6);
    }
    enc_data_destroy(&missing);
    enc_data_destroy(&included);
}

RUN_TESTS(NULL, NULL)
