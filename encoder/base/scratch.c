/* Scratch files. See scratch.h.
 *
 * Ranks of one machine see each other's writes at once. Those of several see them through a network file
 * system: every rank then writes through a descriptor that cannot read, so that its machine keeps no pages
 * of the file that others write to, and opens the file anew to read.
 *
 * SPDX-License-Identifier: MIT
 */
#include "scratch.h"

#include "ranks.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

btf_result enc_scratch_folder(const enc_context *context, uint64_t size, const char **out_folder) {
    const char *folder = getenv("TMPDIR");
    if (!folder || !*folder) {
        folder = "/var/tmp";
    }
    struct statvfs space;
    if (statvfs(folder, &space) != 0) {
        return enc_fail(context, BTF_ERROR_IO, "scratch file: %s (set TMPDIR): %s", folder,
                        strerror(errno));
    }
    const double available = (double)space.f_bavail * (double)space.f_frsize;
    if (available < (double)size) {
        return enc_fail(context, BTF_ERROR_IO,
                        "scratch file: %.2f GB are needed in %s, where %.2f GB are free (set TMPDIR to "
                        "another folder, or give more by option memory)",
                        (double)size * 1e-9, folder, available * 1e-9);
    }
    *out_folder = folder;
    return BTF_OK;
}

btf_result enc_scratch_open(const enc_context *context, const char *what, uint64_t size, int *out_fd) {
    const char *folder;
    const btf_result result = enc_scratch_folder(context, size, &folder);
    if (result != BTF_OK) {
        return result;
    }
    const size_t length = strlen(folder) + sizeof "/btf-scratch-XXXXXX";
    char *path = malloc(length);
    if (!path) {
        return BTF_ERROR_MEMORY;
    }
    strcpy(path, folder);
    strcat(path, "/btf-scratch-XXXXXX");
    const int fd = mkostemp(path, O_CLOEXEC);
    if (fd >= 0) {
        unlink(path);
    }
    free(path);
    if (fd < 0 || ftruncate(fd, (off_t)size) != 0) {
        const int error = errno;
        if (fd >= 0) {
            close(fd);
        }
        return enc_fail(context, BTF_ERROR_IO, "scratch file: cannot create one of %.2f GB in %s: %s",
                        (double)size * 1e-9, folder, strerror(error));
    }
    enc_log(context, BTF_LOG_INFO,
            "%s: %.2f GB are more than half of the memory allowed, %.2f GB: they are kept in a scratch file in %s",
            what, (double)size * 1e-9, (double)context->memory * 1e-9, folder);
    *out_fd = fd;
    return BTF_OK;
}

btf_result enc_scratch_read(const enc_context *context, int fd, uint64_t offset, size_t size,
                            void *buffer) {
    char *p = buffer;
    while (size > 0) {
        const ssize_t n = pread(fd, p, size, (off_t)offset);
        if (n < 0 && errno == EINTR) {
            continue;
        }
        if (n <= 0) {
            return enc_fail(context, BTF_ERROR_IO, "scratch file: reading %zu bytes at %llu failed: %s",
                            size, (unsigned long long)offset, n < 0 ? strerror(errno) : "end of file");
        }
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
        if (n < 0 && errno == EINTR) {
            continue;
        }
        if (n <= 0) {
            return enc_fail(context, BTF_ERROR_IO, "scratch file: writing %zu bytes at %llu failed: %s",
                            size, (unsigned long long)offset, strerror(errno));
        }
        p += n;
        offset += (uint64_t)n;
        size -= (size_t)n;
    }
    return BTF_OK;
}

static const char prefix[] = "btf-scratch-";

static bool on_one_machine(const enc_context *context) {
    return enc_ranks_node_ranks(context) == enc_ranks_count(context);
}

static void host_name(char name[64]) {
    if (gethostname(name, 64) != 0) {
        strcpy(name, "host");
    }
    name[63] = '\0';
}

/* Removes scratch files whose process, on this machine, no longer runs. */
static void remove_stale(const char *folder) {
    char host[64], begin[96];
    host_name(host);
    const int length = snprintf(begin, sizeof begin, "%s%s-", prefix, host);
    DIR *open = opendir(folder);
    for (const struct dirent *entry; open && (entry = readdir(open));) {
        char *end;
        if (strncmp(entry->d_name, begin, (size_t)length) != 0) {
            continue;
        }
        const long process = strtol(entry->d_name + length, &end, 10);
        if (*end == '-' && process > 0 && kill((pid_t)process, 0) != 0 && errno == ESRCH) {
            unlinkat(dirfd(open), entry->d_name, 0);
        }
    }
    if (open) {
        closedir(open);
    }
}

/* Rank 0's part of opening a shared file: makes a file of that size which has a name. */
static btf_result make_file(const enc_context *context, const char *what, uint64_t size,
                            char path[PATH_MAX]) {
    const char *folder;
    char host[64];
    btf_result result = enc_scratch_folder(context, size, &folder);
    if (result != BTF_OK) {
        return result;
    }
    remove_stale(folder);
    host_name(host);
    const int length = snprintf(path, PATH_MAX, "%s/%s%s-%ld-XXXXXX", folder, prefix, host, (long)getpid());
    const int fd = length < PATH_MAX ? mkostemp(path, O_CLOEXEC) : -1;
    if (fd < 0 || ftruncate(fd, (off_t)size) != 0) {
        const int error = length < PATH_MAX ? errno : ENAMETOOLONG;
        result = enc_fail(context, BTF_ERROR_IO, "scratch file: cannot create one of %.2f GB in %s: %s",
                          (double)size * 1e-9, folder, strerror(error));
        if (fd >= 0) {
            unlink(path);
        }
        path[0] = '\0';
    } else {
        enc_log(context, BTF_LOG_INFO, "%s: %.2f GB in a scratch file in %s that %d ranks share", what,
                (double)size * 1e-9, folder, enc_ranks_count(context));
    }
    if (fd >= 0) {
        close(fd);
    }
    return result;
}

/* Opens the file that rank 0 made; a wrong size means that this machine has another folder of the same
 * name. */
static btf_result open_file(const enc_context *context, const char *path, int flags, uint64_t size,
                            int *out_fd) {
    struct stat status;
    char host[64];
    *out_fd = open(path, flags | O_CLOEXEC);
    if (*out_fd >= 0 && (size == 0 || (fstat(*out_fd, &status) == 0 && (uint64_t)status.st_size == size))) {
        return BTF_OK;
    }
    const int error = *out_fd < 0 ? errno : ENOENT;
    if (*out_fd >= 0) {
        close(*out_fd);
    }
    *out_fd = -1;
    host_name(host);
    return enc_fail(
        context, BTF_ERROR_IO,
        "scratch file: %s of rank 0 cannot be opened on %s: %s (set TMPDIR to a folder that all "
        "nodes share)",
        path, host, strerror(error));
}

btf_result enc_scratch_open_shared(const enc_context *context, const char *what, uint64_t size, int *out_fd,
                                   char **out_path) {
    char path[PATH_MAX] = "";
    const bool one = on_one_machine(context);
    btf_result result = BTF_OK;
    *out_fd = -1;
    *out_path = NULL;
    if (enc_ranks_leads(context)) {
        result = make_file(context, what, size, path);
    }
    result = enc_ranks_broadcast(context, result, path, sizeof path);
    if (result == BTF_OK) {
        result = open_file(context, path, one ? O_RDWR : O_WRONLY, size, out_fd);
    }
    if (result == BTF_OK && !one && !(*out_path = strdup(path))) {
        result = BTF_ERROR_MEMORY;
    }
    result = enc_ranks_agree(context, result);
    if (enc_ranks_leads(context) && path[0] && (one || result != BTF_OK)) {
        unlink(path);
    }
    if (result != BTF_OK) {
        if (*out_fd >= 0) {
            close(*out_fd);
        }
        free(*out_path);
        *out_fd = -1;
        *out_path = NULL;
    }
    return result;
}

btf_result enc_scratch_written(const enc_context *context, btf_result result, int *io_fd, char **io_path) {
    if (*io_path && result == BTF_OK && fsync(*io_fd) != 0) {
        result = enc_fail(context, BTF_ERROR_IO, "scratch file: %s: %s", *io_path, strerror(errno));
    }
    result = enc_ranks_agree(context, result);
    if (result != BTF_OK || !*io_path) {
        return result;
    }
    close(*io_fd);
    result = enc_ranks_agree(context, open_file(context, *io_path, O_RDONLY, 0, io_fd));
    if (!enc_ranks_leads(context)) {
        free(*io_path);
        *io_path = NULL;
    }
    return result;
}
