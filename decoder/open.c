/* OpenBTF: opens a material by the name of its file: reads the file whole, and names it in every message.
 *
 * SPDX-License-Identifier: MIT
 */
#include <openbtf/material.h>

#include "result.h"
#include <errno.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

/* Reads the whole file into *out_data, which the caller frees. */
static btf_result read_file(const char *path, const btf_log *log, uint8_t **out_data, size_t *out_size) {
    FILE *file = fopen(path, "rb");
    if (!file) {
        return btfi_fail(log, BTF_ERROR_IO, "%s: %s", path, strerror(errno));
    }
    uint8_t *data = NULL;
    size_t size = 0, capacity = 0, wanted = 1 << 16;
    struct stat status;
    if (fstat(fileno(file), &status) == 0 && S_ISREG(status.st_mode) && status.st_size > 0 &&
        (uintmax_t)status.st_size < SIZE_MAX / 2) {
        wanted = (size_t)status.st_size + 1; /* one byte more, so that the end is met without growing */
    }
    btf_result result = BTF_OK;
    for (;;) {
        if (size == capacity) {
            capacity = capacity ? 2 * capacity : wanted;
            uint8_t *grown = realloc(data, capacity);
            if (!grown) {
                result =
                    btfi_fail(log, BTF_ERROR_MEMORY, "%s: out of memory for %zu bytes", path, capacity);
                break;
            }
            data = grown;
        }
        size_t count = fread(data + size, 1, capacity - size, file);
        size += count;
        if (count == 0) {
            if (ferror(file)) {
                result = btfi_fail(log, BTF_ERROR_IO, "%s: %s", path, strerror(errno));
            }
            break;
        }
    }
    fclose(file);
    if (result) {
        free(data);
        data = NULL;
    }
    *out_data = data;
    *out_size = size;
    return result;
}

/* The caller's log, and the file whose name is put before each message. */
typedef struct named_log {
    const btf_log *log;
    const char *path;
} named_log;

static void log_with_name(void *user, btf_log_level level, const char *message) {
    const named_log *named = user;
    char text[1400];
    snprintf(text, sizeof text, "%.300s: %s", named->path, message);
    if (named->log && named->log->callback) {
        named->log->callback(named->log->user, level, text);
    }
}

btf_result btf_material_open(const char *path, const btf_log *log, btf_material **out_material) {
    uint8_t *data = NULL;
    size_t size = 0;
    *out_material = NULL;
    btf_result result = read_file(path, log, &data, &size);
    if (result) {
        return result;
    }
    named_log named = {log, path};
    result = btf_material_open_memory(data, size, &(btf_log){log_with_name, &named}, out_material);
    free(data);
    return result;
}
