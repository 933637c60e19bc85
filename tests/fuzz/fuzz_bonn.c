/* Fuzz target: one of Bonn's binary .btf files from bytes. The target opens it, prepares its factors of directions and
 * decodes a few texels.
 *
 * SPDX-License-Identifier: MIT
 */
#include "fuzz.h"

#include "encoder/input/bonn/decode.h"

#include <math.h>

enum { MOST_SAMPLES = 1 << 20 };

static void decode_some(const enc_context *context, const enc_bonn_file *file) {
    const size_t n_views = file->n_views, n_lights = file->n_lights;
    if (3 * n_views * n_lights > MOST_SAMPLES) {
        return;
    }
    int *order = malloc((n_views > n_lights ? n_views : n_lights) * sizeof *order);
    float *factor = malloc(n_lights * sizeof *factor), *out = malloc(3 * n_views * n_lights * sizeof *out);
    FUZZ_CHECK(order && factor && out);
    for (size_t i = 0; i < n_views || i < n_lights; i++) {
        order[i] = (int)i;
    }
    for (size_t i = 0; i < n_lights; i++) {
        factor[i] = 1;
    }
    enc_bonn_decoder *decoder = NULL;
    if (enc_bonn_decoder_create(context, file, order, order, factor, 0, &decoder) == BTF_OK) {
        const size_t last = (size_t)file->width * file->height - 1, texels[2] = {0, last};
        for (int i = 0; i < 2; i++) {
            if (enc_bonn_decode(context, decoder, 1, &texels[i], 0, (int)n_views, 3 * n_views * n_lights,
                                out) == BTF_OK) {
                for (size_t s = 0; s < 3 * n_views * n_lights; s++) {
                    FUZZ_CHECK(isfinite(out[s]));
                }
            }
        }
    }
    enc_bonn_decoder_destroy(&decoder);
    free(order);
    free(factor);
    free(out);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    const char *path = fuzz_file(data, size);
    const enc_context context = {.threads = 1};
    enc_bonn_file *file = NULL;
    enc_bonn_is(path);
    const btf_result result = enc_bonn_open(&context, path, &file);
    FUZZ_CHECK((result == BTF_OK) == (file != NULL));
    if (file) {
        decode_some(&context, file);
    }
    enc_bonn_close(&file);
    return 0;
}
