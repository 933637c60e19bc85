/* Helpers of all fuzz targets. Each target is one file with LLVMFuzzerTestOneInput. tests/fuzz/run.sh links it with
 * libFuzzer, the ordinary build with replay.c.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TESTS_FUZZ_H
#define OPENBTF_TESTS_FUZZ_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* Ends the process where the condition is false, also in builds without asserts. */
#define FUZZ_CHECK(condition)                                                                              \
    do {                                                                                                   \
        if (!(condition)) {                                                                                \
            fprintf(stderr, "%s:%d: not so: %s\n", __FILE__, __LINE__, #condition);                        \
            abort();                                                                                       \
        }                                                                                                  \
    } while (0)

/* Puts the bytes into a file in memory and returns its path. Every call uses the same file. */
const char *fuzz_file(const uint8_t *data, size_t size);

/* Changes data[size] in place, within max_size bytes: attributes, names, types and pixels of an OpenEXR file. Offsets
 * are adjusted, so that the code after a reader's first checks is reached. Returns the new size. */
size_t fuzz_mutate_exr(uint8_t *data, size_t size, size_t max_size, unsigned seed);
/* The same for PNG: changes any bytes, then makes the checksums right. */
size_t fuzz_mutate_png(uint8_t *data, size_t size, size_t max_size, unsigned seed);

#endif
