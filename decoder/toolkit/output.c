/* Writing a file so that it is either whole or absent: to a temporary name beside it, then a rename.
 *
 * SPDX-License-Identifier: MIT
 */
#include "output.h"

#include "decoder/temporary.h"

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
        if (path) {
            unlink(path);
        }
    }
}

static void on_signal(int number) {
    output_remove_all();
    signal(number, SIG_DFL);
    raise(number);
}

/* Ends the process when another process has made a mapped input shorter, so that the missing part cannot be read. */
static void on_bus_error(int number) {
    static const char text[] = "error: a file became shorter while it was read\n";
    (void)number;
    output_remove_all();
    (void)!write(STDERR_FILENO, text, sizeof text - 1);
    _exit(btf_result_exit_code(BTF_ERROR_IO));
}

/* Leaves signals as they are that somebody else handles, or that are ignored (nohup). */
static void install_handlers(void) {
    atexit(output_remove_all);
    const int numbers[] = {SIGINT, SIGTERM, SIGHUP, SIGBUS};
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++) {
        struct sigaction old;
        if (sigaction(numbers[i], NULL, &old) == 0 && !(old.sa_flags & SA_SIGINFO) &&
            old.sa_handler == SIG_DFL) {
            struct sigaction action = {.sa_handler = numbers[i] == SIGBUS ? on_bus_error : on_signal};
            sigemptyset(&action.sa_mask);
            sigaction(numbers[i], &action, NULL);
        }
    }
}

static int live_add(char *path) {
    for (int i = 0; i < MAX_LIVE; i++) {
        char *expected = NULL;
        if (atomic_compare_exchange_strong(&live[i], &expected, path)) {
            return i;
        }
    }
    return -1;
}

static void live_remove(int slot) {
    if (slot >= 0) {
        atomic_store(&live[slot], NULL);
    }
}

/* The status of the folder that a path's last name lies in, and that name; false without such a folder. */
static bool find_place(const char *path, struct stat *out_folder, const char **out_name) {
    const char *slash = strrchr(path, '/');
    *out_name = slash ? slash + 1 : path;
    char *folder = !slash ? strdup(".") : strndup(path, slash == path ? 1 : (size_t)(slash - path));
    const bool found = folder && stat(folder, out_folder) == 0;
    free(folder);
    return found;
}

bool output_is_same(const char *path, const char *other) {
    struct stat a, b;
    const char *name_a, *name_b;
    const bool there = stat(path, &a) == 0, other_there = stat(other, &b) == 0;
    if (there || other_there) {
        return there && other_there && S_ISREG(a.st_mode) && a.st_dev == b.st_dev && a.st_ino == b.st_ino;
    }
    return find_place(path, &a, &name_a) && find_place(other, &b, &name_b) && a.st_dev == b.st_dev &&
           a.st_ino == b.st_ino && strcmp(name_a, name_b) == 0;
}

btf_result output_make_folder(const char *path, btf_log log, bool *out_made) {
    const bool made = mkdir(path, 0777) == 0;
    if (out_made) {
        *out_made = made;
    }
    return made || errno == EEXIST ? BTF_OK
                                   : fail(log, "%s: cannot make the folder: %s", path, strerror(errno));
}

static void output_free(output *file) {
    if (file->stream) {
        fclose(file->stream);
    }
    if (file->temporary != file->path) {
        free(file->temporary);
    }
    free(file->path);
    free(file);
}

static atomic_bool handles_signals = true;

void output_leave_signals(void) {
    handles_signals = false;
}

btf_result output_open(const char *path, btf_log log, output **out_output) {
    static pthread_once_t once = PTHREAD_ONCE_INIT;
    if (handles_signals) {
        pthread_once(&once, install_handlers);
    }
    *out_output = NULL;

    btf_result result = BTF_ERROR_MEMORY;
    int fd = -1;
    output *file = calloc(1, sizeof *file);
    if (!file) {
        return BTF_ERROR_MEMORY;
    }
    file->log = log;
    file->slot = -1;
    struct stat status;
    const bool exists = stat(path, &status) == 0;
    const bool regular = exists && S_ISREG(status.st_mode);
    file->path = regular ? realpath(path, NULL) : strdup(path); /* a pipe has no real path */
    if (!file->path) {
        if (regular) {
            result = fail(log, "%s: cannot write: %s", path, strerror(errno));
        }
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
        fd = btfi_temporary_create(file->path, &file->temporary);
        if (fd < 0) {
            if (errno != ENOMEM) {
                result = fail(log, "%s: cannot write: %s", path, strerror(errno));
            }
            goto fail;
        }
        file->slot = live_add(file->temporary);
    }
    file->stream = fdopen(fd, "wb");
    if (!file->stream) {
        goto fail;
    }
    *out_output = file;
    return BTF_OK;

fail:
    if (fd >= 0) {
        close(fd);
        if (file->temporary != file->path) {
            unlink(file->temporary);
        }
    }
    live_remove(file->slot);
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
    if (result != BTF_OK && f->temporary != f->path) {
        unlink(f->temporary);
    }
    live_remove(f->slot);
    output_free(f);
    return result;
}

void output_abort(output **file) {
    if (!file || !*file) {
        return;
    }
    output *f = *file;
    *file = NULL;
    if (f->temporary != f->path) {
        unlink(f->temporary);
    }
    live_remove(f->slot);
    output_free(f);
}
