/* The encoder's marches against the reference decoder's. Compiled with the reference's own objects, whose
 * march is hidden.
 *
 * SPDX-License-Identifier: MIT
 */
#include "encoder/relief/seen.h"
#include "reference/btf_reference_private.h"
#include "tests/support/test.h"

enum { WIDTH = 13, HEIGHT = 9, SURFACES = 200, RAYS = 200 };

static uint32_t below(uint32_t *state, uint32_t n) {
    *state = *state * 1664525u + 1013904223u;
    return (uint32_t)((uint64_t)*state * n >> 32);
}

/* Surfaces with heights up to the greatest that a file may hold, of any level; rays from all directions. */
TEST(test_marches_agree) {
    static uint8_t codes[WIDTH * HEIGHT];
    uint32_t random = 1;
    int inside = 0;
    for (int i = 0; i < SURFACES; i++) {
        const int32_t step = 1 + (int32_t)below(&random, i % 5 ? 2000 : 32767);
        const int32_t room = INT16_MAX - ((255 * step) >> 8),
                      base = room - (int32_t)below(&random, (uint32_t)room + 2000);
        const int steps = 1 + (int)below(&random, 64), level = (int)below(&random, 5);
        enc_warp w;
        for (int t = 0; t < WIDTH * HEIGHT; t++) {
            codes[t] = (uint8_t)below(&random, 256);
        }
        assert_int_equal(enc_warp_create(WIDTH, HEIGHT, level, 0, &w), BTF_OK);
        assert_int_equal(enc_warp_set_codes(&w, base, step, steps, codes), BTF_OK);
        const btf_ref_material m = {.width = WIDTH,
                                    .height = HEIGHT,
                                    .heights = codes,
                                    .relief_base = base,
                                    .relief_step = step,
                                    .relief_steps = (uint32_t)steps,
                                    .level = (uint32_t)level};
        for (int k = 0; k < RAYS; k++) {
            const int32_t at[2] = {(int32_t)below(&random, WIDTH * 256),
                                   (int32_t)below(&random, HEIGHT * 256)};
            const int32_t slope[2] = {(int32_t)below(&random, 65535) - 32767,
                                      (int32_t)below(&random, 65535) - 32767};
            const int32_t expected = btf_ref_march(&m, at, slope);
            assert_int_equal(enc_warp_march(&w, at[0], at[1], slope), expected);
            assert_int_equal(enc_seen_march(&w, at[0], at[1], slope, SIZE_MAX, 0), expected);
            inside += expected > base && expected < w.top;
        }
        enc_warp_clear(&w);
    }
    assert_true(inside > SURFACES * RAYS / 4);
}

RUN_TESTS(NULL, NULL)
