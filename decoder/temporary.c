/* OpenBTF: the temporary file that becomes an output. See temporary.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "temporary.h"

#include <ctype.h>
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

static atomic_uint serial;

bool btfi_is_temporary_of(const char *entry, const char *name, size_t length) {
    if (entry[0] != '.' || strncmp(entry + 1, name, length) != 0 || entry[1 + length] != '.') {
        return false;
    }
    const char *p = entry + length + 2;
    for (int part = 0; part < 2; part++) {
        if (!isdigit((unsigned char)*p)) {
            return false;
        }
        while (isdigit((unsigned char)*p)) {
            p++;
        }
        if (part == 0 && *p++ != '-') {
            return false;
        }
    }
    return strcmp(p, ".tmp") == 0;
}

static void remove_stale(const char *directory, const char *name, size_t length) {
    DIR *listing = opendir(directory);
    if (!listing) {
        return;
    }
    for (struct dirent *entry; (entry = readdir(listing));) {
        if (!btfi_is_temporary_of(entry->d_name, name, length)) {
            continue;
        }
        const int fd = openat(dirfd(listing), entry->d_name, O_RDWR | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
        if (fd < 0) {
            continue;
        }
        if (flock(fd, LOCK_EX | LOCK_NB) == 0) {
            unlinkat(dirfd(listing), entry->d_name, 0);
        }
        close(fd);
    }
    closedir(listing);
}

/* Creates and locks a new file. Between the two steps another process may take it for a stale one and hold
 * the lock until it has removed it: the lock is waited for, and the name checked once it is held. */
static int create_locked(char *buffer, size_t size, const char *directory, const char *name,
                         size_t length) {
    for (int attempt = 0; attempt < 100; attempt++) {
        snprintf(buffer, size, "%s/.%.*s.%ld-%u.tmp", directory, (int)length, name, (long)getpid(),
                 atomic_fetch_add(&serial, 1));
        const int fd = open(buffer, O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
        if (fd < 0) {
            if (errno == EEXIST) {
                continue;
            }
            return -1;
        }
        struct stat status;
        while (flock(fd, LOCK_EX) != 0 && errno == EINTR)
            ;
        if (fstat(fd, &status) == 0 && status.st_nlink > 0) {
            return fd;
        }
        close(fd);
    }
    errno = EEXIST;
    return -1;
}

int btfi_temporary_create(const char *path, char **out_path) {
    *out_path = NULL;
    const char *slash = strrchr(path, '/');
    const char *name = slash ? slash + 1 : path;
    if (!*name) {
        errno = EISDIR;
        return -1;
    }
    char *directory = !slash ? strdup(".") : strndup(path, slash == path ? 1 : (size_t)(slash - path));
    const size_t length = strnlen(name, BTFI_TEMPORARY_NAME_BYTES), size = strlen(path) + 64;
    char *buffer = malloc(size);
    int fd = -1, error = ENOMEM;
    if (directory && buffer) {
        remove_stale(directory, name, length);
        fd = create_locked(buffer, size, directory, name, length);
        error = errno;
    }
    free(directory);
    if (fd < 0) {
        free(buffer);
        errno = error;
        return -1;
    }
    *out_path = buffer;
    return fd;
}
