/* A mutator for PNG: makes any change and then the checksums right, without which libpng would read no further.
 *
 * SPDX-License-Identifier: MIT
 */
#include "fuzz.h"

#include <zlib.h>

size_t LLVMFuzzerMutate(uint8_t *data, size_t size, size_t max_size);

size_t fuzz_mutate_png(uint8_t *data, size_t size, size_t max_size, unsigned seed) {
    size = LLVMFuzzerMutate(data, size, max_size);
    if (seed % 8 == 0) {
        return size;
    }
    for (size_t at = 8; at + 12 <= size;) {
        const uint32_t length = (uint32_t)data[at] << 24 | (uint32_t)data[at + 1] << 16 |
                                (uint32_t)data[at + 2] << 8 | data[at + 3];
        if (length > size - at - 12) {
            break;
        }
        const uint32_t sum = (uint32_t)crc32(0, data + at + 4, length + 4);
        uint8_t *out = data + at + 8 + length;
        for (int i = 0; i < 4; i++) {
            out[i] = (uint8_t)(sum >> (24 - 8 * i));
        }
        at += 12 + (size_t)length;
    }
    return size;
}
