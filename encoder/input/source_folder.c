/* Images in a directory and the folders below it.
 *
 * SPDX-License-Identifier: MIT
 */
#include "source_folder.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { MAX_DEPTH = 32 };

typedef struct directory_source {
    enc_source base;
    char *root;
} directory_source;

static char *join(const char *folder, const char *name) {
    const size_t length = strlen(folder);
    char *path = malloc(length + strlen(name) + 2);
    if (path) {
        strcpy(path, folder);
        if (length > 0 && folder[length - 1] != '/') {
            strcat(path, "/");
        }
        strcat(path, name);
    }
    return path;
}

static btf_result read_file(enc_source *source, size_t index, void **out_data, size_t *out_size,
                            char *message, size_t message_size) {
    btf_result result = BTF_ERROR_MEMORY;
    char *data = NULL;
    int fd = -1;
    char *path = join(((directory_source *)source)->root, source->paths[index]);
    if (!path) {
        goto done;
    }
    fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK); /* a pipe is refused, not waited for */
    struct stat status;
    if (fd < 0 || fstat(fd, &status) != 0) {
        snprintf(message, message_size, "%s", strerror(errno));
        result = BTF_ERROR_IO;
        goto done;
    }
    if (!S_ISREG(status.st_mode) || (uintmax_t)status.st_size > ENC_SOURCE_MAX_FILE) {
        snprintf(message, message_size, "not a regular file of at most %zu bytes", ENC_SOURCE_MAX_FILE);
        result = BTF_ERROR_UNSUPPORTED;
        goto done;
    }
    const size_t size = (size_t)status.st_size;
    data = malloc(size ? size : 1);
    if (!data) {
        goto done;
    }
    for (size_t have = 0; have < size;) {
        const ssize_t n = read(fd, data + have, size - have);
        if (n < 0 && errno == EINTR) {
            continue;
        }
        if (n <= 0) {
            snprintf(message, message_size, "%s", n < 0 ? strerror(errno) : "the file became shorter");
            result = BTF_ERROR_IO;
            goto done;
        }
        have += (size_t)n;
    }
    *out_data = data;
    *out_size = size;
    data = NULL;
    result = BTF_OK;
done:
    if (fd >= 0) {
        close(fd);
    }
    free(data);
    free(path);
    return result;
}

static void close_directory(enc_source *source) {
    enc_source_free_paths(source);
    free(((directory_source *)source)->root);
    free(source);
}

static int is_visible(const struct dirent *entry) {
    return entry->d_name[0] != '.';
}

static int by_bytes(const struct dirent **a, const struct dirent **b) {
    return strcmp((*a)->d_name, (*b)->d_name);
}

/* The folders that lead to a folder, from the root on. */
typedef struct folder_path {
    dev_t device[MAX_DEPTH + 1];
    ino_t number[MAX_DEPTH + 1];
    int depth;
} folder_path;

static bool leads_back(const folder_path *above, const struct stat *status) {
    for (int i = 0; i < above->depth; i++) {
        if (above->device[i] == status->st_dev && above->number[i] == status->st_ino) {
            return true;
        }
    }
    return false;
}

static btf_result list_folder(const enc_context *context, directory_source *source, const char *inside,
                              folder_path *above, size_t *n_allocated);

/* Adds a file, or the files in a folder. Entries that cannot be opened are left out with a warning. */
static btf_result add_entry(const enc_context *context, directory_source *source, const char *path,
                            const char *full, folder_path *above, size_t *n_allocated) {
    struct stat status;
    if (enc_cancelled(context)) {
        return BTF_ERROR_INTERRUPTED;
    }
    if (stat(full, &status) != 0) {
        enc_log(context, BTF_LOG_WARNING, "%s: %s", full, strerror(errno));
        return BTF_OK;
    }
    if (S_ISDIR(status.st_mode)) {
        if (leads_back(above, &status)) {
            enc_log(context, BTF_LOG_WARNING, "%s: is a folder that leads back to itself", full);
            return BTF_OK;
        }
        if (above->depth > MAX_DEPTH) {
            return enc_fail(context, BTF_ERROR_UNSUPPORTED, "%s: more than %d folders deep", full,
                            MAX_DEPTH);
        }
        above->device[above->depth] = status.st_dev;
        above->number[above->depth++] = status.st_ino;
        const btf_result result = list_folder(context, source, path, above, n_allocated);
        above->depth--;
        return result;
    }
    if (!S_ISREG(status.st_mode)) {
        enc_log(context, BTF_LOG_WARNING, "%s: is neither a file nor a folder", full);
        return BTF_OK;
    }
    bool is_image;
    const btf_result result = enc_source_add(&source->base, path, n_allocated, &is_image);
    if (result == BTF_ERROR_UNSUPPORTED) {
        enc_fail(context, result, "%s: more than %zu files", source->root, ENC_SOURCE_MAX_ENTRIES);
    }
    return result;
}

/* Adds the files of one folder and, recursively, of those in it. `inside` is its path below the root, "" at
 * the root. */
static btf_result list_folder(const enc_context *context, directory_source *source, const char *inside,
                              folder_path *above, size_t *n_allocated) {
    char *folder = join(source->root, inside);
    if (!folder) {
        return BTF_ERROR_MEMORY;
    }
    struct dirent **entries = NULL;
    const int count = scandir(folder, &entries, is_visible, by_bytes);
    btf_result result = BTF_OK;
    if (count < 0 && inside[0]) {
        enc_log(context, BTF_LOG_WARNING, "%s: %s", folder, strerror(errno));
    } else if (count < 0) {
        result = enc_fail(context, BTF_ERROR_IO, "%s: %s", folder, strerror(errno));
    }
    for (int i = 0; i < count; i++) {
        char *path = join(inside, entries[i]->d_name);
        char *full = path ? join(source->root, path) : NULL;
        if (result == BTF_OK) {
            result = full ? add_entry(context, source, path, full, above, n_allocated) : BTF_ERROR_MEMORY;
        }
        free(full);
        free(path);
        free(entries[i]);
    }
    free(entries);
    free(folder);
    return result;
}

btf_result enc_source_open_directory(const enc_context *context, const char *path,
                                     enc_source **out_source) {
    directory_source *source = calloc(1, sizeof *source);
    if (!source) {
        return BTF_ERROR_MEMORY;
    }
    source->base.read = read_file;
    source->base.close = close_directory;
    source->root = strdup(path);
    source->base.location = source->root;
    size_t n_allocated = 0;
    struct stat status;
    folder_path above = {.depth = 0};
    if (stat(path, &status) == 0) {
        above.device[0] = status.st_dev;
        above.number[0] = status.st_ino;
        above.depth = 1;
    }
    const btf_result result =
        source->root ? list_folder(context, source, "", &above, &n_allocated) : BTF_ERROR_MEMORY;
    if (result != BTF_OK) {
        close_directory(&source->base);
        return result;
    }
    *out_source = &source->base;
    return BTF_OK;
}
