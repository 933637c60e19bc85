/* Fuzz target: an archive of images from bytes, listed and read through. tests/fuzz/run.sh limits files in it to 1 MiB,
 * so that inputs which unpack to a gigabyte do not take all the time.
 *
 * SPDX-License-Identifier: MIT
 */
#include "fuzz.h"

#include "encoder/input/source_archive.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    const char *path = fuzz_file(data, size);
    const enc_context context = {.threads = 1};
    enc_source *source = NULL;
    if (enc_source_open_archive(&context, path, &source) != BTF_OK) {
        return 0;
    }
    for (size_t i = 0; i < source->count; i++) {
        char message[160] = "";
        void *bytes = NULL;
        size_t length = 0;
        const btf_result result = source->read(source, i, &bytes, &length, message, sizeof message);
        FUZZ_CHECK((result == BTF_OK) == (bytes != NULL));
        FUZZ_CHECK(length <= ENC_SOURCE_MAX_FILE);
        free(bytes);
        if (result != BTF_OK) {
            break;
        }
    }
    enc_source_close(&source);
    return 0;
}
