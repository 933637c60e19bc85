/* Fuzz target: bytes as an environment map, Radiance or OpenEXR, from which as many lights are made as its last byte
 * says, rotated and scaled. An accepted map must give lights that can be summed.
 *
 * SPDX-License-Identifier: MIT
 */
#include "fuzz.h"

#include "decoder/tools/render/environment.h"

static int messages;

static void count_message(void *user, btf_log_level level, const char *message) {
    (void)user;
    messages += level == BTF_LOG_ERROR && message[0] != 0;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    const btf_log log = {count_message, NULL};
    const int count = 1 << (size ? data[size - 1] % 9 : 0);
    light_list list = {0};
    messages = 0;
    const btf_result result =
        light_list_read_environment(&list, fuzz_file(data, size), NULL, count, 1.7 * count, 0.5, &log);
    FUZZ_CHECK(messages == (result != BTF_OK));
    FUZZ_CHECK(list.count <= (size_t)count && (result == BTF_OK || list.count == 0));
    for (size_t i = 0; i < list.count; i++) {
        const light *l = &list.lights[i];
        FUZZ_CHECK(!l->is_point && fabs(vec_length(l->at) - 1) < 1e-6);
        for (int c = 0; c < 3; c++) {
            FUZZ_CHECK(l->colour[c] >= 0 && isfinite(l->colour[c]));
        }
    }
    light_list_clear(&list);
    return 0;
}

#ifdef FUZZING_BUILD_MODE_UNSAFE_FOR_PRODUCTION
size_t LLVMFuzzerMutate(uint8_t *data, size_t size, size_t max_size);
size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max_size, unsigned seed);
/* Changes OpenEXR files by their structure, Radiance files, which have none, by libFuzzer's own mutator. */
size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max_size, unsigned seed) {
    return size >= 2 && data[0] == '#' && data[1] == '?' ? LLVMFuzzerMutate(data, size, max_size)
                                                         : fuzz_mutate_exr(data, size, max_size, seed);
}
#endif
