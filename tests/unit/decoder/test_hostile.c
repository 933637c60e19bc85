/* Hostile files: every prefix, every byte changed, random damage. Nothing may crash, hang or leak; a file that opens
 * must decode to finite values. Runs under the sanitizers too; light runs change each byte in one of the ways, in turn.
 *
 * SPDX-License-Identifier: MIT
 */
#include <openbtf/reference.h>
#include "tests/support/random_material.h"
#include "tests/support/refusals.h"
#include "decoder/toolkit/reference_view.h"
#include "tests/support/test.h"

static saved save_small(btf_layout layout) {
    random_state r = {31};
    btf_material_desc desc = random_material_desc(2, 2, 4, 3, layout, BTF_EFFECT_VERSION_1);
    desc.info.half_float = layout == BTF_LAYOUT_TIGHT;
    desc.info.lobes = 1;
    desc.info.components = 2;
    desc.info.centres = 5;
    desc.info.source = "small";
    desc.info.levels = layout == BTF_LAYOUT_TIGHT ? 2 : 1;
    const btf_level_error errors[1] = {{0, 30, 28, 100}};
    desc.level_errors = errors;
    desc.level_error_count = 1;
    saved s;
    s.data = random_material_save(&r, &desc, &s.size);
    return s;
}

static saved files[2];

static int setup(void **state) {
    (void)state;
    files[0] = save_small(BTF_LAYOUT_PAPER);
    files[1] = save_small(BTF_LAYOUT_TIGHT);
    return 0;
}

static int teardown(void **state) {
    (void)state;
    btf_free(files[0].data);
    btf_free(files[1].data);
    return 0;
}

/* Decodes a few points of a material that opened. */
static void use_material(const btf_material *material) {
    static const float directions[4][3] = {
        {0, 0, 1}, {0.6f, 0, 0.8f}, {-0.48f, 0.64f, 0.6f}, {0.1f, -0.99f, 0.1f}};
    btf_material_info info = accepted_info(material);
    btf_ref_material first, last;
    reference_view(material, 0, &first);
    reference_view(material, info.levels - 1, &last);
    const btf_ref_options options = {BTF_EFFECT_ALL, UINT32_MAX, BTF_REF_LINEAR, BTF_REF_BILINEAR};
    for (int l = 0; l < 4; l++) {
        for (int v = 0; v < 4; v++) {
            float rgb[3];
            btf_ref_evaluate((l + v) % 2 ? &last : &first, &options, 0.3f * (float)l, 0.4f * (float)v,
                             directions[l], directions[v], rgb);
            for (int c = 0; c < 3; c++) {
                assert_true(isfinite(rgb[c]) && rgb[c] >= 0);
            }
        }
    }
}

/* Opens bytes from a buffer of exactly their size, so that a sanitizer notices a read beyond them. */
static bool opens(const uint8_t *data, size_t size) {
    btf_material *material = NULL;
    uint8_t *exact = malloc(size ? size : 1);
    assert_non_null(exact);
    memcpy(exact, data, size);
    message_count = 0;
    btf_result result = btf_material_open_memory(exact, size, &log_keep, &material);
    free(exact);
    assert_true((result == BTF_OK) == (material != NULL));
    assert_true(result == BTF_OK || result == BTF_ERROR_BAD_FILE || result == BTF_ERROR_UNSUPPORTED ||
                result == BTF_ERROR_MEMORY);
    assert_true(result == BTF_OK || message_count == 1);
    if (material) {
        use_material(material);
    }
    btf_material_close(&material);
    return result == BTF_OK;
}

TEST(test_prefixes) {
    for (int f = 0; f < 2; f++) {
        for (size_t size = 0; size < files[f].size; size++) {
            if (opens(files[f].data, size)) {
                print_error("file %d: a prefix of %zu of %zu bytes opens\n", f, size, files[f].size);
                fail();
            }
        }
        assert_true(opens(files[f].data, files[f].size));
    }
}

TEST(test_flipped_bytes) {
    static const uint8_t masks[] = {0xFF, 0x01, 0x80};
    for (int f = 0; f < 2; f++) {
        uint8_t *copy = malloc(files[f].size);
        assert_non_null(copy);
        memcpy(copy, files[f].data, files[f].size);
        size_t opened = 0;
        for (size_t m = 0; m < sizeof masks; m++) {
            for (size_t i = 0; i < files[f].size; i++) {
                if (light_run() && i % 3 != m) {
                    continue;
                }
                copy[i] ^= masks[m];
                opened += opens(copy, files[f].size);
                copy[i] ^= masks[m];
            }
        }
        print_message("file %d: %zu of %zu flips still open\n", f, opened, files[f].size * sizeof masks);
        free(copy);
    }
}

/* Several bytes at once: overwritten, swapped with others, runs of one value. */
TEST(test_random_damage) {
    random_state r = {32};
    const int rounds = light_run() ? 1000 : 4000;
    for (int f = 0; f < 2; f++) {
        uint8_t *copy = malloc(files[f].size);
        assert_non_null(copy);
        for (int round = 0; round < rounds; round++) {
            memcpy(copy, files[f].data, files[f].size);
            uint32_t size = (uint32_t)files[f].size, changes = 1 + random_below(&r, 6);
            for (uint32_t c = 0; c < changes; c++) {
                uint32_t at = random_below(&r, size), run = 1 + random_below(&r, 12);
                run = run < size - at ? run : size - at;
                uint32_t from = random_below(&r, size - run + 1);
                switch (random_below(&r, 3)) {
                case 0:
                    memset(copy + at, (int)random_below(&r, 256), run);
                    break;
                case 1:
                    memmove(copy + at, copy + from, run);
                    break;
                default:
                    copy[at] = (uint8_t)(copy[at] + 1);
                }
            }
            opens(copy, files[f].size);
        }
        free(copy);
    }
}

/* Integers that changing a single byte rarely gives, at every offset of the header. */
TEST(test_extreme_integers) {
    static const uint32_t values[] = {0, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFF, 0x40000000};
    const size_t header = files[1].size < 6000 ? files[1].size : 6000;
    uint8_t *copy = malloc(files[1].size);
    assert_non_null(copy);
    for (size_t v = 0; v < sizeof values / sizeof *values; v++) {
        for (size_t i = 0; i + 4 <= header; i++) {
            if (light_run() && i % 5 != v) {
                continue;
            }
            memcpy(copy, files[1].data, files[1].size);
            memcpy(copy + i, &values[v], 4);
            opens(copy, files[1].size);
        }
    }
    free(copy);
}

RUN_TESTS(setup, teardown)
