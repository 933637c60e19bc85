/* The evaluator of the library against the reference decoder, bit for bit: every variant of the conformance tests,
 * random and extreme arguments, with the portable loops and with those for this machine's instructions.
 *
 * SPDX-License-Identifier: MIT
 */
#include "decoder/evaluate/prepared.h"
#include "decoder/evaluate/kernels.h"
#include "decoder/toolkit/reference_view.h"
#include "tests/conformance/cases.h"
#include "tests/conformance/synthetic.h"
#include "tests/conformance/variant.h"
#include "tests/support/test.h"

#include <openbtf/evaluate.h>
#include <openbtf/reference.h>

enum { MOST = 512 };

static uint64_t evaluated; /* in all */
static bool is_long;

/* A material, and what the evaluator and the reference need to decode it. */
typedef struct subject {
    const char *name;
    btf_material *material;
    btf_material_info info;
    btf_evaluator *evaluator;
    btf_ref_material levels[BTF_MAX_LEVELS];
} subject;

/* Arguments, and the radiance that the reference gives for them. */
typedef struct batch {
    size_t count;
    float inputs[MOST][CASE_WORDS]; /* u, v, light, view */
    uint32_t texels[MOST][2];
    int32_t levels[MOST];
    float expected[MOST][3], rgb[MOST][3];
} batch;

static void open_subject(const char *name, btf_material *material, subject *out) {
    *out = (subject){.name = name, .material = material, .info = {.struct_size = sizeof out->info}};
    assert_int_equal(btf_material_get_info(material, &out->info), BTF_OK);
    assert_int_equal(btf_evaluator_create(material, NULL, &out->evaluator), BTF_OK);
    for (uint32_t i = 0; i < out->info.levels; i++) {
        reference_view(material, i, &out->levels[i]);
    }
}

static void close_subject(subject *s) {
    btf_evaluator_destroy(&s->evaluator);
    assert_null(s->evaluator);
    btf_material_close(&s->material);
}

static uint32_t clamped_level(const subject *s, int32_t level) {
    return level < 0 ? 0 : (uint32_t)level < s->info.levels ? (uint32_t)level : s->info.levels - 1;
}

/* Half of the arguments share light, view and level with those before, so that groups of all sizes occur. */
static void draw(random_state *r, const subject *s, size_t count, batch *b) {
    b->count = count;
    for (size_t i = 0; i < count; i++) {
        uint32_t words[CASE_WORDS];
        case_make(r, s->material, words);
        memcpy(b->inputs[i], words, sizeof words);
        b->levels[i] = (int32_t)random_below(r, s->info.levels + 2) - 1;
        b->texels[i][0] = random_below(r, 3 * s->info.width);
        b->texels[i][1] = random_below(r, 3 * s->info.height);
        if (i > 0 && random_below(r, 8) > 2) {
            memcpy(b->inputs[i] + 2, b->inputs[i - 1] + 2, 6 * sizeof(float));
            b->levels[i] = random_below(r, 8) ? b->levels[i - 1] : b->levels[i];
            if (random_below(r, 8) == 0) { /* but for one number */
                b->inputs[i][2 + random_below(r, 6)] *= 0.875f;
            }
        }
    }
}

static bool is_finite(float x) {
    return (bits_of_float(x) & 0x7F800000u) != 0x7F800000u;
}

/* Texels or texture coordinates. */
static void decode_by_reference(const subject *s, const btf_ref_options *options, bool texels, batch *b) {
    for (size_t i = 0; i < b->count; i++) {
        const btf_ref_material *m = &s->levels[clamped_level(s, b->levels[i])];
        const float *in = b->inputs[i];
        if (texels) {
            btf_ref_evaluate_texel(m, options, b->texels[i][0] % m->width, b->texels[i][1] % m->height,
                                   in + 2, in + 5, b->expected[i]);
        } else {
            btf_ref_evaluate(m, options, in[0], in[1], in + 2, in + 5, b->expected[i]);
        }
        for (int c = 0; c < 3; c++) {
            assert_true(is_finite(b->expected[i][c]));
        }
    }
}

static void compare(const subject *s, const batch *b, const char *how) {
    for (size_t i = 0; i < b->count; i++) {
        if (memcmp(b->rgb[i], b->expected[i], sizeof b->rgb[i]) == 0) {
            continue;
        }
        const float *in = b->inputs[i];
        fail_msg("%s, %s: evaluation %zu of %zu, level %d: (%a, %a, %a), the reference (%a, %a, %a), of u, "
                 "v %a, %a, "
                 "light %a %a %a, view %a %a %a",
                 s->name, how, i, b->count, (int)b->levels[i], (double)b->rgb[i][0], (double)b->rgb[i][1],
                 (double)b->rgb[i][2], (double)b->expected[i][0], (double)b->expected[i][1],
                 (double)b->expected[i][2], (double)in[0], (double)in[1], (double)in[2], (double)in[3],
                 (double)in[4], (double)in[5], (double)in[6], (double)in[7]);
    }
}

static void check_batch(const subject *s, const btf_evaluate_options *options,
                        const btf_ref_options *reference, batch *b) {
    static const char *const names[] = {"the loops for every machine", "the loops for this machine"};
    btf_evaluations of = {.struct_size = sizeof of,
                          .count = b->count,
                          .uv = b->inputs[0],
                          .lights = b->inputs[0] + 2,
                          .views = b->inputs[0] + 5,
                          .levels = b->levels,
                          .stride = CASE_WORDS,
                          .rgb = b->rgb[0]};
    for (int texels = 0; texels < 2; texels++) {
        decode_by_reference(s, reference, texels, b);
        of.uv = texels ? NULL : b->inputs[0];
        of.texels = texels ? b->texels[0] : NULL;
        for (int isa = BTFI_ISA_BASE; isa <= BTFI_ISA_AVX2; isa++) {
            s->evaluator->kernels = btfi_kernels_of((btfi_isa)isa);
            memset(b->rgb, 0xFF, sizeof b->rgb);
            assert_int_equal(btf_evaluate_many(s->evaluator, options, &of), BTF_OK);
            compare(s, b, names[isa]);
            evaluated += b->count;
        }
    }
}

static void check_variant(const variant *v, uint64_t seed, size_t count) {
    btf_material *material = NULL;
    subject s;
    static batch b;
    random_state r = {seed};
    const btf_result result = synthetic_create(&v->spec, NULL, &material);
    assert_int_equal(result, BTF_OK);
    open_subject(v->name, material, &s);
    const btf_ref_options reference = variant_reference_options(&v->shader);
    const btf_evaluate_options options = {.struct_size = sizeof options,
                                          .leave_out = v->shader.leave_out,
                                          .components = v->shader.components,
                                          .interpolation = v->shader.interpolation,
                                          .filter = v->shader.filter};
    for (size_t done = 0; done < count; done += b.count) {
        draw(&r, &s, count - done < MOST ? count - done : MOST, &b);
        check_batch(&s, &options, &reference, &b);
    }
    close_subject(&s);
}

TEST(test_all_variants) {
    static variant list[VARIANT_MAX];
    const size_t count = variant_pairwise(1, list);
    assert_true(count > 100);
    for (size_t i = 0; i < count; i++) {
        check_variant(&list[i], 7 * i + 1, is_long ? 8192 : 48);
    }
    printf("%llu evaluations\n", (unsigned long long)evaluated);
}

/* Heights so far apart that one of the three views is hidden as far as possible (its weight is at the lower clamp)
 * while another is not. The variants rarely have this. */
TEST(test_occlusion) {
    for (int deep = 0; deep < 2; deep++) {
        const synthetic_spec spec = {.seed = 11,
                                     .width = 16,
                                     .height = 16,
                                     .n_views = 37,
                                     .n_lights = 21,
                                     .layout = BTF_LAYOUT_TIGHT,
                                     .colour = BTF_COLOUR_RGB,
                                     .lobes = 2,
                                     .effects = BTF_EFFECT_GAIN | BTF_EFFECT_RELIEF,
                                     .levels = 1,
                                     .relief = deep ? SYNTHETIC_HIGH : SYNTHETIC_GENTLE};
        const btf_ref_options everything = {BTF_EFFECT_ALL, UINT32_MAX, BTF_REF_LINEAR, BTF_REF_TEXEL};
        const btf_evaluate_options same = {.struct_size = sizeof same};
        static batch b;
        btf_material *material = NULL;
        subject s;
        random_state r = {17};
        assert_int_equal(synthetic_create(&spec, NULL, &material), BTF_OK);
        open_subject(deep ? "high relief" : "relief", material, &s);
        draw(&r, &s, MOST, &b);
        for (size_t i = 0; i < MOST; i++) {
            const double phi = random_between(&r, 0, 6.28), sine = random_between(&r, 0.2, 0.98);
            const float view[3] = {(float)(sine * cos(phi)), (float)(sine * sin(phi)),
                                   (float)sqrt(1 - sine * sine)},
                        light[3] = {0.36f, -0.48f, 0.8f};
            b.inputs[i][0] = (float)random_between(&r, 0, 1);
            b.inputs[i][1] = (float)random_between(&r, 0, 1);
            memcpy(b.inputs[i] + 2, light, sizeof light);
            memcpy(b.inputs[i] + 5, view, sizeof view);
            b.levels[i] = 0;
        }
        check_batch(&s, &same, &everything, &b);
        close_subject(&s);
    }
}

/* Packed arrays, and one light or view for all, give the same results as a full array of arguments. */
TEST(test_layouts) {
    static variant list[VARIANT_MAX];
    static batch b;
    static float uv[MOST][2], lights[MOST][3], views[MOST][3];
    btf_material *material = NULL;
    subject s;
    random_state r = {5};
    variant_pairwise(1, list);
    assert_int_equal(synthetic_create(&list[0].spec, NULL, &material), BTF_OK);
    open_subject(list[0].name, material, &s);
    const btf_ref_options everything = {BTF_EFFECT_ALL, UINT32_MAX, BTF_REF_LINEAR, BTF_REF_TEXEL};
    for (uint32_t fixed = 0; fixed < 4; fixed++) {
        draw(&r, &s, MOST, &b);
        for (size_t i = 0; i < MOST; i++) {
            b.levels[i] = 0;
            const float light[3] = {0.3f, -0.2f, 0.9f}, view[3] = {-0.5f, 0.1f, 0.8f};
            memcpy(fixed & BTF_FIXED_LIGHT ? b.inputs[i] + 2 : lights[i],
                   fixed & BTF_FIXED_LIGHT ? light : b.inputs[i] + 2, sizeof light);
            memcpy(fixed & BTF_FIXED_VIEW ? b.inputs[i] + 5 : views[i],
                   fixed & BTF_FIXED_VIEW ? view : b.inputs[i] + 5, sizeof view);
            memcpy(lights[i], b.inputs[i] + 2, sizeof light);
            memcpy(views[i], b.inputs[i] + 5, sizeof view);
            memcpy(uv[i], b.inputs[i], sizeof uv[i]);
        }
        decode_by_reference(&s, &everything, false, &b);
        const btf_evaluations of = {.struct_size = sizeof of,
                                    .count = MOST,
                                    .uv = uv[0],
                                    .lights = lights[0],
                                    .views = views[0],
                                    .fixed = fixed,
                                    .rgb = b.rgb[0]};
        assert_int_equal(btf_evaluate_many(s.evaluator, NULL, &of), BTF_OK);
        compare(&s, &b, "packed");
    }
    close_subject(&s);
}

/* Refusals leave the output as it was. */
TEST(test_refusals) {
    static variant list[VARIANT_MAX];
    btf_material *material = NULL;
    subject s;
    float in[8] = {0.5f, 0.5f, 0, 0, 1, 0, 0, 1}, rgb[3] = {7, 7, 7};
    uint32_t texel[2] = {0, 0};
    variant_pairwise(1, list);
    assert_int_equal(synthetic_create(&list[0].spec, NULL, &material), BTF_OK);
    open_subject(list[0].name, material, &s);
    btf_evaluator *none = s.evaluator;
    assert_int_equal(btf_evaluator_create(NULL, NULL, &none), BTF_ERROR_USAGE);
    assert_null(none);
    assert_int_equal(btf_evaluator_create(material, NULL, NULL), BTF_ERROR_USAGE);
    btf_evaluator_destroy(NULL);
    btf_evaluator_destroy(&none);

    const btf_evaluations good = {
        .struct_size = sizeof good, .count = 1, .uv = in, .lights = in + 2, .views = in + 5, .rgb = rgb};
    const btf_evaluate_options way = {.struct_size = sizeof way};
    btf_evaluations bad[8];
    btf_evaluate_options bad_way[3] = {way, way, way};
    for (int i = 0; i < 8; i++) {
        bad[i] = good;
    }
    bad[0].struct_size = 3;
    bad[1].uv = NULL;
    bad[2].texels = texel;
    bad[3].lights = NULL;
    bad[4].views = NULL;
    bad[5].rgb = NULL;
    bad[6].fixed = 4;
    bad_way[0].struct_size = 3;
    bad_way[1].interpolation = (btf_interpolation)2;
    bad_way[2].filter = (btf_filter)3;
    for (int i = 0; i < 7; i++) {
        assert_int_equal(btf_evaluate_many(s.evaluator, &way, &bad[i]), BTF_ERROR_USAGE);
    }
    for (int i = 0; i < 3; i++) {
        assert_int_equal(btf_evaluate_many(s.evaluator, &bad_way[i], &good), BTF_ERROR_USAGE);
    }
    assert_int_equal(btf_evaluate_many(NULL, &way, &good), BTF_ERROR_USAGE);
    assert_int_equal(btf_evaluate_many(s.evaluator, &way, NULL), BTF_ERROR_USAGE);
    assert_true(rgb[0] == 7 && rgb[1] == 7 && rgb[2] == 7);
    bad[7].count = 0;
    bad[7].uv = NULL;
    assert_int_equal(btf_evaluate_many(s.evaluator, &way, &bad[7]), BTF_OK);
    assert_int_equal(btf_evaluate_many(s.evaluator, &way, &good), BTF_OK);
    assert_true(rgb[0] != 7);
    close_subject(&s);
}

int main(int argc, char **argv) {
    is_long = argc == 2 && strcmp(argv[1], "--long") == 0;
    return run_listed("tests", NULL, NULL);
}
