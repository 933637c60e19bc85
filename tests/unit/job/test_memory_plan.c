/* The least memory of an encode: which limits are refused, what the message names, and that large data fit.
 *
 * SPDX-License-Identifier: MIT
 */
#include "encoder/data/data.h"
#include "encoder/job/memory.h"
#include "tests/support/messages.h"
#include "tests/support/test.h"

static btf_result create(size_t memory, enc_least_memory least) {
    const enc_context context = {
        .log = {keep_message, NULL}, .threads = 2, .memory = memory, .least_memory = least};
    const enc_direction up = enc_direction_from_angles(0, 0);
    enc_data *data = NULL;
    const btf_result result = enc_data_create(&context, 20, 10, 1, &up, 1, &up, &data);
    enc_data_destroy(&data);
    return result;
}

TEST(test_refused_below_the_least) {
    for (enc_method method = ENC_METHOD_JOINT; (int)method < ENC_METHODS; method++) {
        const enc_least_memory by_method = enc_memory_least(method);
        const size_t least = (size_t)by_method(20, 10, 1, 1, 2);
        assert_true(least > 200 * 12);
        assert_int_equal(create(least, by_method), BTF_OK);
        assert_int_equal(create(least - 1, by_method), BTF_ERROR_USAGE);
        assert_non_null(strstr(last_message, told("option memory: %zu ", least - 1)));
        assert_non_null(strstr(last_message, told("%zuK", (least + 999) / 1000)));
    }
    assert_int_equal(create(1, NULL), BTF_OK);
    assert_int_equal(create(0, enc_memory_least_joint), BTF_OK);
}

/* Data sets that must fit: UBO2003 in 2 GB, UBO2014 in 4 GB; and no overflow at the largest. */
TEST(test_large_data) {
    for (enc_method method = ENC_METHOD_JOINT; (int)method < ENC_METHODS; method++) {
        const enc_least_memory least = enc_memory_least(method);
        const uint64_t ubo2003 = least(256, 256, 81, 81, 2);
        const uint64_t ubo2014 = least(400, 400, 151, 151, 2);
        const uint64_t largest = least(16384, 16384, 256, 256, 1024);
        const uint64_t most = method == ENC_METHOD_JOINT ? 2000000000u : 1400000000u;
        printf("%s: 256x256 81x81 %.0f MB, 400x400 151x151 %.0f MB, 16384x16384 256x256 %.0f MB\n",
               enc_method_name(method), (double)ubo2003 * 1e-6, (double)ubo2014 * 1e-6,
               (double)largest * 1e-6);
        assert_true(ubo2003 < most && ubo2014 < 4000000000u);
        assert_true(least(64, 64, 81, 81, 2) < ubo2003 && ubo2003 < ubo2014);
        /* 4800 times the samples; the paper's method holds images alone, factors also what belongs to 1024
         * threads */
        assert_true(largest / ubo2014 > 1000 && largest / ubo2014 < 20000);
    }
}

TEST(test_threads) {
    enc_context context = {.threads = 8, .memory = 1000};
    assert_int_equal(enc_memory_threads(&context, 1), 8);
    assert_int_equal(enc_memory_threads(&context, 100), 5);
    assert_int_equal(enc_memory_threads(&context, 501), 1);
    assert_int_equal(enc_memory_threads(&context, 0), 8);
    context.memory = 0;
    assert_int_equal(enc_memory_threads(&context, UINT64_MAX), 8);
}

RUN_TESTS(NULL, NULL)
