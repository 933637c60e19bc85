/* Fuzz target: one image from bytes, as the encoder reads it. Built once for each format, which FUZZ_IMAGE names:
 * content of other formats is skipped, so that each format gets its own time.
 *
 * SPDX-License-Identifier: MIT
 */
#include "fuzz.h"

#include "encoder/input/image.h"

#include <string.h>

#define FUZZ_JPEG 1
#define FUZZ_PNG 2
#define FUZZ_HDR 3
#define FUZZ_EXR 4

#if FUZZ_IMAGE == FUZZ_JPEG
#define MAGIC "\xff\xd8"
#elif FUZZ_IMAGE == FUZZ_PNG
#define MAGIC "\x89PNG"
#elif FUZZ_IMAGE == FUZZ_HDR
#define MAGIC "#?"
#else
#define MAGIC "\x76\x2f\x31\x01"
#endif

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    if (size < sizeof MAGIC - 1 || memcmp(data, MAGIC, sizeof MAGIC - 1) != 0) {
        return 0;
    }
    char message[160] = "";
    enc_image image = {0};
    const btf_result result = enc_image_decode(data, size, &image, message, sizeof message);
    FUZZ_CHECK((result == BTF_OK) == (image.pixels != NULL));
    FUZZ_CHECK((result == BTF_OK) == (message[0] == '\0'));
    if (result != BTF_OK) {
        return 0;
    }
    FUZZ_CHECK(image.width > 0 && image.height > 0);
    FUZZ_CHECK((size_t)image.width <= (size_t)ENC_IMAGE_MAX_PIXELS / (size_t)image.height);
    FUZZ_CHECK(image.channels == 1 || image.channels == 3);
    FUZZ_CHECK(image.depth == 8 || image.depth == 16 || image.depth == 32);
    const size_t bytes =
        (size_t)image.width * (size_t)image.height * (size_t)image.channels * (size_t)image.depth / 8;
    uint8_t sum = 0;
    for (size_t i = 0; i < bytes; i++) { /* every byte can be read */
        sum ^= ((const uint8_t *)image.pixels)[i];
    }
    volatile uint8_t keep = sum;
    (void)keep;
    enc_image_clear(&image);
    return 0;
}

#if defined(FUZZING_BUILD_MODE_UNSAFE_FOR_PRODUCTION) && (FUZZ_IMAGE == FUZZ_PNG || FUZZ_IMAGE == FUZZ_EXR)
size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max_size, unsigned seed);
size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max_size, unsigned seed) {
    return FUZZ_IMAGE == FUZZ_PNG ? fuzz_mutate_png(data, size, max_size, seed)
                                  : fuzz_mutate_exr(data, size, max_size, seed);
}
#endif
