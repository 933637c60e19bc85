/* Writing a file so that it is either whole or absent: to a temporary name beside it, then a rename.
 *
 * A temporary file is locked (flock) for as long as its writer lives, so one that can be locked is stale.
 *
 * SPDX-License-Identifier: MIT
 */
#include "output.h"

#include <ctype.h>
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <pthread.h>
#include <signal.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

enum { MAX_LIVE = 256 };

struct output {
    char *path;      /* the target */
    char *temporary; /* == path when the target is written directly */
    FILE *stream;
    btf_log log;
    int slot; /* in live[], -1 when the table was full */
};

/* The temporary files that exist now, for exit and signal handlers. */
static _Atomic(char *) live[MAX_LIVE];
static atomic_uint serial;

static btf_result fail(btf_log log, const char *format, ...) __attribute__((format(printf, 2, 3)));
static btf_result fail(btf_log log, const char *format, ...) {
    if (log.callback) {
        char text[PATH_MAX + 256];
        va_list arguments;
        va_start(arguments, format);
        vsnprintf(text, sizeof text, format, arguments);
        va_end(arguments);
        log.callback(log.user, BTF_LOG_ERROR, text);
    }
    return BTF_ERROR_IO;
}

void output_remove_all(void) {
    for (int i = 0; i < MAX_LIVE; i++) {
        const char *path = atomic_load(&live[i]);
        if (path)
            unlink(path);
    }
}

static void on_signal(int number) {
    output_remove_all();
    signal(number, SIG_DFL);
    raise(number);
}

/* Signals that somebody else handles, or that are ignored (nohup), stay as they are. */
static void install_handlers(void) {
    atexit(output_remove_all);
    const int numbers[] = {SIGINT, SIGTERM, SIGHUP};
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++) {
        struct sigaction old;
        if (sigaction(numbers[i], NULL, &old) == 0 && !(old.sa_flags & SA_SIGINFO) &&
            old.sa_handler == SIG_DFL) {
            struct sigaction action = {.sa_handler = on_signal};
            sigemptyset(&action.sa_mask);
            sigaction(numbers[i], &action, NULL);
        }
    }
}

static int live_add(char *path) {
    for (int i = 0; i < MAX_LIVE; i++) {
        char *expected = NULL;
        if (atomic_compare_exchange_strong(&live[i], &expected, path))
            return i;
    }
    return -1;
}

static void live_remove(int slot) {
    if (slot >= 0)
        atomic_store(&live[slot], NULL);
}

/* Splits a path into its directory ("." when it names none, "/" kept) and the name within it. */
static char *directory_of(const char *path, const char **out_name) {
    const char *slash = strrchr(path, '/');
    *out_name = slash ? slash + 1 : path;
    if (!slash)
        return strdup(".");
    return strndup(path, slash == path ? 1 : (size_t)(slash - path));
}

/* Whether `entry` reads ".NAME.<digits>-<digits>.tmp". */
static bool is_temporary_of(const char *entry, const char *name) {
    const size_t length = strlen(name);
    if (entry[0] != '.' || strncmp(entry + 1, name, length) != 0 || entry[1 + length] != '.')
        return false;
    const char *p = entry + length + 2;
    for (int part = 0; part < 2; part++) {
        if (!isdigit((unsigned char)*p))
            return false;
        while (isdigit((unsigned char)*p))
            p++;
        if (part == 0 && *p++ != '-')
            return false;
    }
    return strcmp(p, ".tmp") == 0;
}

static void remove_stale(const char *directory, const char *name) {
    DIR *listing = opendir(directory);
    if (!listing)
        return;
    for (struct dirent *entry; (entry = readdir(listing));) {
        if (!is_temporary_of(entry->d_name, name))
            continue;
        const int fd = openat(dirfd(listing), entry->d_name, O_RDWR | O_CLOEXEC | O_NOFOLLOW);
        if (fd < 0)
            continue;
        if (flock(fd, LOCK_EX | LOCK_NB) == 0)
            unlinkat(dirfd(listing), entry->d_name, 0);
        close(fd);
    }
    closedir(listing);
}

/* Creates and locks a new temporary file. Between the two steps another process may take it for a stale
 * one, so that the name is checked again once the lock is held. */
static int create_temporary(char *buffer, size_t size, const char *directory, const char *name) {
    for (int attempt = 0; attempt < 100; attempt++) {
        snprintf(buffer, size, "%s/.%s.%ld-%u.tmp", directory, name, (long)getpid(),
                 atomic_fetch_add(&serial, 1));
        const int fd = open(buffer, O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
        if (fd < 0) {
            if (errno == EEXIST)
                continue;
            return -1;
        }
        struct stat status;
        flock(fd, LOCK_EX | LOCK_NB);
        if (fstat(fd, &status) == 0 && status.st_nlink > 0)
            return fd;
        close(fd);
    }
    errno = EEXIST;
    return -1;
}

static void output_free(output *file) {
    if (file->stream)
        fclose(file->stream);
    if (file->temporary != file->path)
        free(file->temporary);
    free(file->path);
    free(file);
}

btf_result output_open(const char *path, btf_log log, output **out_output) {
    static pthread_once_t once = PTHREAD_ONCE_INIT;
    pthread_once(&once, install_handlers);
    *out_output = NULL;

    btf_result result = BTF_ERROR_MEMORY;
    char *directory = NULL;
    int fd = -1;
    output *file = calloc(1, sizeof *file);
    if (!file)
        return BTF_ERROR_MEMORY;
    file->log = log;
    file->slot = -1;
    struct stat status;
    const bool exists = stat(path, &status) == 0;
    const bool regular = exists && S_ISREG(status.st_mode);
    file->path = regular ? realpath(path, NULL) : strdup(path); /* a pipe has no real path */
    if (!file->path) {
        if (regular)
            result = fail(log, "%s: cannot write: %s", path, strerror(errno));
        goto fail;
    }

    if (exists && !regular) {
        file->temporary = file->path;
        fd = S_ISDIR(status.st_mode) ? -1 : open(file->path, O_WRONLY | O_CLOEXEC);
        if (fd < 0) {
            result = fail(log, "%s: cannot write: %s", path,
                          S_ISDIR(status.st_mode) ? "is a directory" : strerror(errno));
            goto fail;
        }
    } else {
        const char *name;
        directory = directory_of(file->path, &name);
        const size_t size = strlen(file->path) + 64;
        file->temporary = malloc(size);
        if (!directory || !file->temporary)
            goto fail;
        if (!*name) {
            result = fail(log, "%s: cannot write: no file name", path);
            goto fail;
        }
        remove_stale(directory, name);
        fd = create_temporary(file->temporary, size, directory, name);
        if (fd < 0) {
            result = fail(log, "%s: cannot create a file in %s: %s", path, directory, strerror(errno));
            goto fail;
        }
        file->slot = live_add(file->temporary);
    }
    file->stream = fdopen(fd, "wb");
    if (!file->stream)
        goto fail;
    free(directory);
    *out_output = file;
    return BTF_OK;

fail:
    if (fd >= 0) {
        close(fd);
        if (file->temporary != file->path)
            unlink(file->temporary);
    }
    live_remove(file->slot);
    free(directory);
    output_free(file);
    return result;
}

FILE *output_stream(output *file) {
    return file->stream;
}

const char *output_temporary_path(const output *file) {
    return file->temporary;
}

btf_result output_commit(output **file) {
    output *f = *file;
    *file = NULL;
    btf_result result = BTF_OK;
    const bool written = fflush(f->stream) == 0 && !ferror(f->stream);
    if (!written) {
        result = fail(f->log, "%s: writing failed: %s", f->path, strerror(errno));
    } else if (f->temporary != f->path && rename(f->temporary, f->path) != 0) {
        result = fail(f->log, "%s: cannot rename %s: %s", f->path, f->temporary, strerror(errno));
    }
    if (result != BTF_OK && f->temporary != f->path)
        unlink(f->temporary);
    live_remove(f->slot);
    output_free(f);
    return result;
}

void output_abort(output **file) {
    if (!file || !*file)
        return;
    output *f = *file;
    *file = NULL;
    if (f->temporary != f->path)
        unlink(f->temporary);
    live_remove(f->slot);
    output_free(f);
}
