/* Fuzz target: a material from bytes. A material that opens must decode to finite values, and must come back from a
 * save bit for bit.
 *
 * SPDX-License-Identifier: MIT
 */
#include "fuzz.h"

#include <openbtf/reference.h>
#include "decoder/toolkit/reference_view.h"

#include <math.h>
#include <string.h>

static int messages;

static void count_message(void *user, btf_log_level level, const char *message) {
    (void)user;
    (void)level;
    messages += message[0] != 0;
}

static void decode_some(const btf_material *material) {
    static const float directions[][3] = {
        {0, 0, 1}, {0.6f, 0, 0.8f}, {-0.48f, 0.64f, 0.6f}, {0.1f, -0.99f, 0.1f}};
    enum { COUNT = sizeof directions / sizeof *directions };
    btf_material_info info = {.struct_size = sizeof info};
    FUZZ_CHECK(btf_material_get_info(material, &info) == BTF_OK);
    FUZZ_CHECK(info.levels >= 1 && info.levels <= BTF_MAX_LEVELS);
    btf_ref_material views[BTF_MAX_LEVELS];
    for (uint32_t level = 0; level < info.levels; level++) {
        reference_view(material, level, &views[level]);
    }
    for (int i = 0; i < COUNT * COUNT; i++) {
        const btf_ref_options options = {i % 3 ? BTF_EFFECT_ALL : (uint32_t)i, i % 5 ? UINT32_MAX : 1,
                                         i % 2 ? BTF_REF_LINEAR : BTF_REF_NEAREST,
                                         i % 7 == 0   ? BTF_REF_TEXEL
                                         : i % 7 == 1 ? BTF_REF_STEEP
                                                      : BTF_REF_BILINEAR};
        float rgb[3];
        btf_ref_evaluate(&views[(uint32_t)i % info.levels], &options, 0.31f * (float)i, -0.17f * (float)i,
                         directions[i / COUNT], directions[i % COUNT], rgb);
        for (int c = 0; c < 3; c++) {
            FUZZ_CHECK(isfinite(rgb[c]) && rgb[c] >= 0);
        }
    }
}

/* Saves the material, opens the copy and saves that: the same bytes. */
static void save_twice(const btf_material *material, const btf_log *log) {
    void *first = NULL, *second = NULL;
    size_t first_size, second_size;
    btf_material *copy = NULL;
    FUZZ_CHECK(btf_material_save_memory(material, log, &first, &first_size) == BTF_OK);
    FUZZ_CHECK(btf_material_open_memory(first, first_size, log, &copy) == BTF_OK);
    FUZZ_CHECK(btf_material_save_memory(copy, log, &second, &second_size) == BTF_OK);
    FUZZ_CHECK(first_size == second_size && memcmp(first, second, first_size) == 0);
    btf_material_close(&copy);
    btf_free(first);
    btf_free(second);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    const btf_log log = {count_message, NULL};
    btf_material *material = NULL;
    messages = 0;
    const btf_result result = btf_material_open_memory(data, size, &log, &material);
    FUZZ_CHECK((result == BTF_OK) == (material != NULL));
    FUZZ_CHECK(messages == (result != BTF_OK));
    if (material) {
        decode_some(material);
        save_twice(material, &log);
    }
    btf_material_close(&material);
    return 0;
}

#ifdef FUZZING_BUILD_MODE_UNSAFE_FOR_PRODUCTION
size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max_size, unsigned seed);
size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max_size, unsigned seed) {
    return fuzz_mutate_exr(data, size, max_size, seed);
}
#endif
