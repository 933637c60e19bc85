/* The protections that keep the decoder's arithmetic exact: the self-test passes here and names what a simulated device
 * breaks, and a decoder without the protections gives other results.
 *
 * SPDX-License-Identifier: MIT
 */
#include "check.h"
#include "tests/conformance/sabotage/tamper.h"
#include "tests/support/messages.h"
#include "tests/support/test.h"
#include "variant.h"

/* Defines the run-time zero as a constant, so that compilers can optimise the protection away. */
static const char unprotected[] = "#define BTF_HAVE_PRECISE 0\n#define BTF_ZERO 0u\n";
static const char bit_casts[] = "#define BTF_HAVE_PRECISE 0\n";

/* Runs a text of the self-test; returns its bits. */
static uint32_t run_self_test(const char *preamble, const char *text) {
    static const char body[] =
        "uvec4 check(uvec4 a, uvec4 b) { return uvec4(btf_self_test(a.x ^ b.x)); }\n";
    unsigned program = gpu_program(gpu_of_group, preamble, text, body, &log_print);
    assert_int_not_equal(program, 0);
    uint32_t inputs[GPU_INPUTS] = {0}, outputs[GPU_OUTPUTS];
    assert_int_equal(gpu_run(gpu_of_group, program, 1, inputs, outputs, &log_print), BTF_OK);
    gpu_delete_program(gpu_of_group, program);
    return outputs[0];
}

TEST(passes_here) {
    uint32_t failures = 99;
    btf_gl_options options = gpu_gl_options(gpu_of_group, NULL);
    assert_int_equal(btf_gl_self_test(&options, &log_print, &failures), BTF_OK);
    assert_int_equal(failures, 0);
    assert_int_equal(run_self_test(NULL, btf_shader_self_test()), 0);
    assert_int_equal(run_self_test(bit_casts, btf_shader_self_test()), 0);
}

TEST(finds_missing_protection) {
    assert_true(run_self_test(unprotected, btf_shader_self_test()) & BTF_SELF_TEST_REASSOCIATION);
}

/* Devices that break one thing each. (Results of fused operations are written as constants, for fma() of GLSL need not
 * fuse.) */
TEST(names_what_breaks) {
    static const struct {
        btf_self_test bit;
        const char *name, *from, *to;
    } list[] = {
        {BTF_SELF_TEST_CONTRACTION, "contraction",
         "btf_add(btf_mul(vec3(a, third, a), vec3(b, three, a)), vec3(-one))",
         "uintBitsToFloat(uvec3(0x2D800000u, 0x33000000u, 0x3A000400u) ^ zero)"},
        {BTF_SELF_TEST_REASSOCIATION, "reassociation", "btf_add(btf_mul(a, b), btf_mul(a, c))",
         "btf_mul(a, btf_add(b, c))"},
        {BTF_SELF_TEST_ROUNDING, "rounding", "BTF_PRECISE float r = BTF_ROUND(a + b);",
         "BTF_PRECISE float r = intBitsToFloat(floatBitsToInt(float(a + b)) & ~1);"},
        {BTF_SELF_TEST_FLUSH, "flush", "BTF_PRECISE float r = BTF_ROUND(a * b);",
         "BTF_PRECISE float r = abs(a * b) < 1e-35 ? 0.0 : a * b;"},
        {BTF_SELF_TEST_CONVERSION, "conversion", "int(floor(x)) == -3", "int(trunc(x)) == -3"},
        {BTF_SELF_TEST_INTEGER, "integer", "(b >> 3) == -16", "int(uint(b) >> 3u) == -16"},
        {BTF_SELF_TEST_ELEMENTARY, "elementary", "0xBF38AAD4u", "0xBF38AAD5u"},
        {BTF_SELF_TEST_FACTORS, "factors", "ivec4(t + 0x8000u) >> 16", "ivec4((t + 0x8000u) >> 16u)"},
        {BTF_SELF_TEST_FACTORS, "factors", "ivec4(t + 0x8000u) >> 16", "ivec4(t) >> 16"},
        {BTF_SELF_TEST_FACTORS, "factors", "float(-most >> 5)", "float(-(most >> 5))"},
    };
    for (size_t i = 0; i < sizeof list / sizeof *list; ++i) {
        char *broken = tamper_text(btf_shader_self_test(), 0, 1, list[i].from, list[i].to);
        assert_non_null(broken);
        uint32_t failures = run_self_test(NULL, broken);
        free(broken);
        char names[120];
        btf_self_test_names(failures, names, sizeof names);
        if (!(failures & list[i].bit) || !strstr(names, list[i].name)) {
            fail_msg("%s is not found (%s)", list[i].name, names);
        }
    }
    char names[12];
    btf_self_test_names(0, names, sizeof names);
    assert_string_equal(names, "none");
    btf_self_test_names(3, names, sizeof names); /* cut, but ended */
    assert_string_equal(names, "contraction");
}

/* Bits that differ from the reference over the first variants, and evaluations. */
static uint64_t differences(const char *preamble, uint64_t *out_evaluated) {
    static variant list[VARIANT_MAX];
    enum { VARIANTS = 12, COUNT = 4000 };
    size_t count = variant_pairwise(1, list);
    assert_true(count > VARIANTS);
    check_outcome outcome = {0};
    for (int i = 0; i < VARIANTS; ++i) {
        btf_material *material = NULL;
        assert_int_equal(synthetic_create(&list[i].spec, &log_print, &material), BTF_OK);
        check_subject s = {.gpu = gpu_of_group,
                           .material = material,
                           .shader = &list[i].shader,
                           .preamble = preamble,
                           .log = &log_print};
        assert_int_equal(check_radiance(&s, 1, COUNT, &outcome), BTF_OK);
        btf_material_close(&material);
    }
    *out_evaluated = outcome.evaluated;
    return outcome.different;
}

TEST(decoder_differs_without_protection) {
    uint64_t evaluated;
    assert_int_equal(differences(NULL, &evaluated), 0);
    assert_int_equal(differences(bit_casts, &evaluated), 0);
    uint64_t different = differences(unprotected, &evaluated);
    printf("without protection %llu of %llu evaluations differ\n", (unsigned long long)different,
           (unsigned long long)evaluated);
    assert_true(different > 0);
}

RUN_TESTS(gpu_group_setup, gpu_group_teardown)
