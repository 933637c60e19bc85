/* Scratch files (see scratch.h).
 *
 * SPDX-License-Identifier: MIT
 */
#include "scratch.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/statvfs.h>
#include <unistd.h>

btf_result enc_scratch_folder(const enc_context *context, uint64_t size, const char **out_folder) {
    const char *folder = getenv("TMPDIR");
    if (!folder || !*folder)
        folder = "/var/tmp";
    struct statvfs space;
    if (statvfs(folder, &space) != 0)
        return enc_fail(context, BTF_ERROR_IO, "scratch file: %s (set TMPDIR): %s", folder,
                        strerror(errno));
    const double available = (double)space.f_bavail * (double)space.f_frsize;
    if (available < (double)size)
        return enc_fail(
            context, BTF_ERROR_IO,
            "scratch file: %.2f GB needed in %s, %.2f GB free (set TMPDIR, or allow more --memory)",
            (double)size * 1e-9, folder, available * 1e-9);
    *out_folder = folder;
    return BTF_OK;
}

btf_result enc_scratch_open(const enc_context *context, const char *what, uint64_t size, int *out_fd) {
    const char *folder;
    const btf_result result = enc_scratch_folder(context, size, &folder);
    if (result != BTF_OK)
        return result;
    const size_t length = strlen(folder) + sizeof "/btf-scratch-XXXXXX";
    char *path = malloc(length);
    if (!path)
        return BTF_ERROR_MEMORY;
    strcpy(path, folder);
    strcat(path, "/btf-scratch-XXXXXX");
    const int fd = mkostemp(path, O_CLOEXEC);
    if (fd >= 0)
        unlink(path);
    free(path);
    if (fd < 0 || ftruncate(fd, (off_t)size) != 0) {
        const int error = errno;
        if (fd >= 0)
            close(fd);
        return enc_fail(context, BTF_ERROR_IO, "scratch file: cannot create one of %.2f GB in %s: %s",
                        (double)size * 1e-9, folder, strerror(error));
    }
    enc_log(context, BTF_LOG_INFO, "%s: %.2f GB exceed the share of %.2f GB of memory: scratch file in %s",
            what, (double)size * 1e-9, (double)context->memory * 1e-9, folder);
    *out_fd = fd;
    return BTF_OK;
}

btf_result enc_scratch_read(const enc_context *context, int fd, uint64_t offset, size_t size,
                            void *buffer) {
    char *p = buffer;
    while (size > 0) {
        const ssize_t n = pread(fd, p, size, (off_t)offset);
        if (n < 0 && errno == EINTR)
            continue;
        if (n <= 0)
            return enc_fail(context, BTF_ERROR_IO, "scratch file: reading %zu bytes at %llu failed: %s",
                            size, (unsigned long long)offset, n < 0 ? strerror(errno) : "end of file");
        p += n;
        offset += (uint64_t)n;
        size -= (size_t)n;
    }
    return BTF_OK;
}

btf_result enc_scratch_write(const enc_context *context, int fd, uint64_t offset, size_t size,
                             const void *buffer) {
    const char *p = buffer;
    while (size > 0) {
        const ssize_t n = pwrite(fd, p, size, (off_t)offset);
        if (n < 0 && errno == EINTR)
            continue;
        if (n <= 0)
            return enc_fail(context, BTF_ERROR_IO, "scratch file: writing %zu bytes at %llu failed: %s",
                            size, (unsigned long long)offset, strerror(errno));
        p += n;
        offset += (uint64_t)n;
        size -= (size_t)n;
    }
    return BTF_OK;
}
