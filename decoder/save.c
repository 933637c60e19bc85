/* OpenBTF: a material to a file: to a temporary name beside it, then renamed, so that no half file is ever
 * seen.
 *
 * SPDX-License-Identifier: MIT
 */
#include "result.h"
#include "temporary.h"
#include <errno.h>
#include <fcntl.h>
#include <openbtf/material.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static bool write_data(int fd, const uint8_t *data, size_t size) {
    while (size > 0) {
        ssize_t written = write(fd, data, size < (1u << 30) ? size : (1u << 30));
        if (written < 0 && errno == EINTR) {
            continue;
        }
        if (written <= 0) {
            errno = written == 0 ? ENOSPC : errno;
            return false;
        }
        data += written;
        size -= (size_t)written;
    }
    return true;
}

static btf_result fail_io(const btf_log *log, const char *path, int error) {
    return btfi_fail(log, BTF_ERROR_IO, "%s: %s", path, strerror(error));
}

/* Writes straight to a device or a pipe, which no file may replace. */
static btf_result write_special(const btf_log *log, const char *path, const void *data, size_t size) {
    int fd = open(path, O_WRONLY | O_CLOEXEC);
    if (fd < 0) {
        return fail_io(log, path, errno);
    }
    bool good = write_data(fd, data, size);
    int error = errno;
    if (close(fd) != 0 && good) {
        good = false;
        error = errno;
    }
    return good ? BTF_OK : fail_io(log, path, error);
}

/* Writes a regular file, or one that does not exist yet. */
static btf_result write_regular(const btf_log *log, const char *path, const void *data, size_t size) {
    char *temporary = NULL;
    const int fd = btfi_temporary_create(path, &temporary);
    if (fd < 0) {
        return fail_io(log, path, errno);
    }
    int error = 0;
    if (!write_data(fd, data, size) || (fsync(fd) != 0 && errno != EINVAL && errno != EROFS) ||
        rename(temporary, path) != 0) {
        error = errno;
        unlink(temporary);
    }
    close(fd); /* an error here is one that fsync has reported */
    free(temporary);
    return error ? fail_io(log, path, error) : BTF_OK;
}

static btf_result write_file(const btf_log *log, const char *path, const void *data, size_t size) {
    struct stat status;
    if (stat(path, &status) == 0 && S_ISDIR(status.st_mode)) {
        return fail_io(log, path, EISDIR);
    }
    if (stat(path, &status) == 0 && !S_ISREG(status.st_mode)) {
        return write_special(log, path, data, size);
    }
    char *target =
        realpath(path, NULL); /* the file that a symbolic link points to; NULL when there is none yet */
    btf_result result = write_regular(log, target ? target : path, data, size);
    free(target);
    return result;
}

btf_result btf_material_save(const btf_material *material, const char *path, const btf_log *log) {
    void *data;
    size_t size;
    btf_result result = btf_material_save_memory(material, log, &data, &size);
    if (result) {
        return result;
    }
    result = write_file(log, path, data, size);
    btf_free(data);
    return result;
}
