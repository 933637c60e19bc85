/* Preloaded into a tool under test (LD_PRELOAD): sends a signal or runs a command when the tool makes its n-th call of
 * a kind. This moment does not depend on time: a signal sent after some seconds would meet another stage on a busy
 * machine, while the n-th call is the same everywhere. Set in the environment:
 *
 *     BTF_MOMENT    "N KIND [TEXT]": the N-th of these of the process, from 1:
 *                     call     before it opens a file to write, writes, renames or removes one (not stdout or stderr)
 *                     open     before it opens a file whose path holds TEXT
 *                     rename   after it renamed a file to a path that holds TEXT
 *                     print    after it printed to stderr something that holds TEXT
 *     BTF_ACTION    a signal (INT, TERM, KILL), raised in the thread that makes the call, or a command for the shell, for
 *                   which the call waits; $PPID is the tool there
 *     BTF_CALLS     a file that takes the number of calls of kind `call`, at exit
 *
 * Programs that the tool starts in turn are left alone. tests/tools/common.sh has functions for it.
 *
 * SPDX-License-Identifier: MIT
 */
/* Functions are named below as the C library has them, with and without 64 at the end: glibc must not take the one name
 * for the other. */
#undef _FILE_OFFSET_BITS

#include <dlfcn.h>
#include <fcntl.h>
#include <signal.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static long wanted;
static char kind[16], *text, *action, *calls_path;
static atomic_long calls, met;

/* The function of the same name in the libraries after this one. */
#define NEXT(name) ((__typeof__(&name))(uintptr_t)dlsym(RTLD_NEXT, #name))

__attribute__((constructor)) static void read_moment(void) {
    const char *moment = getenv("BTF_MOMENT"), *does = getenv("BTF_ACTION"), *path = getenv("BTF_CALLS");
    int rest = 0;
    if (moment && (!does || sscanf(moment, "%ld %15s %n", &wanted, kind, &rest) < 2 || wanted < 1)) {
        static const char wrong[] = "moment.c: BTF_MOMENT is not 'N KIND [TEXT]' with a BTF_ACTION\n";
        (void)!write(STDERR_FILENO, wrong, sizeof wrong - 1);
        _exit(99);
    }
    text = moment ? strdup(moment + rest) : NULL;
    action = does ? strdup(does) : NULL;
    calls_path = path ? strdup(path) : NULL;
    unsetenv("LD_PRELOAD");
    unsetenv("BTF_MOMENT");
    unsetenv("BTF_ACTION");
    unsetenv("BTF_CALLS");
}

__attribute__((destructor)) static void write_calls(void) {
    const long count = atomic_load(&calls);
    FILE *file = calls_path ? NEXT(fopen)(calls_path, "w") : NULL;
    if (file) {
        fprintf(file, "%ld\n", count);
        NEXT(fclose)(file);
    }
}

static void act(void) {
    if (strcmp(action, "INT") == 0) {
        raise(SIGINT);
    } else if (strcmp(action, "TERM") == 0) {
        raise(SIGTERM);
    } else if (strcmp(action, "KILL") == 0) {
        raise(SIGKILL);
    } else {
        (void)!system(action);
    }
}

static void happens(const char *what, const char *with) {
    if (wanted && strcmp(kind, what) == 0 && strstr(with, text) &&
        atomic_fetch_add(&met, 1) + 1 == wanted) {
        act();
    }
}

static void call(void) {
    atomic_fetch_add(&calls, 1);
    happens("call", "");
}

static void call_open(const char *path, bool writes) {
    if (writes) {
        call();
    }
    happens("open", path);
}

static bool is_file(FILE *stream) {
    return stream != stdout && stream != stderr;
}

#define OPEN(name)                                                                                         \
    int name(const char *path, int flags, ...) {                                                           \
        va_list arguments;                                                                                 \
        va_start(arguments, flags);                                                                        \
        const mode_t mode = flags & (O_CREAT | O_TMPFILE) ? va_arg(arguments, mode_t) : 0;                 \
        va_end(arguments);                                                                                 \
        call_open(path, (flags & O_ACCMODE) != O_RDONLY);                                                  \
        return NEXT(name)(path, flags, mode);                                                              \
    }
OPEN(open)
OPEN(open64)

#define OPENAT(name)                                                                                       \
    int name(int folder, const char *path, int flags, ...) {                                               \
        va_list arguments;                                                                                 \
        va_start(arguments, flags);                                                                        \
        const mode_t mode = flags & (O_CREAT | O_TMPFILE) ? va_arg(arguments, mode_t) : 0;                 \
        va_end(arguments);                                                                                 \
        call_open(path, (flags & O_ACCMODE) != O_RDONLY);                                                  \
        return NEXT(name)(folder, path, flags, mode);                                                      \
    }
OPENAT(openat)
OPENAT(openat64)

#define FOPEN(name)                                                                                        \
    FILE *name(const char *path, const char *mode) {                                                       \
        call_open(path, *mode != 'r' || strchr(mode, '+'));                                                \
        return NEXT(name)(path, mode);                                                                     \
    }
FOPEN(fopen)
FOPEN(fopen64)

#define PWRITE(name, offset_type)                                                                          \
    ssize_t name(int fd, const void *bytes, size_t size, offset_type offset) {                             \
        call();                                                                                            \
        return NEXT(name)(fd, bytes, size, offset);                                                        \
    }
PWRITE(pwrite, off_t)
PWRITE(pwrite64, off64_t)

ssize_t write(int fd, const void *bytes, size_t size) {
    if (fd > STDERR_FILENO) {
        call();
    }
    return NEXT(write)(fd, bytes, size);
}

size_t fwrite(const void *bytes, size_t size, size_t count, FILE *stream) {
    if (is_file(stream)) {
        call();
    }
    return NEXT(fwrite)(bytes, size, count, stream);
}

int fflush(FILE *stream) {
    if (stream && is_file(stream)) {
        call();
    }
    return NEXT(fflush)(stream);
}

int fclose(FILE *stream) {
    if (is_file(stream)) {
        call();
    }
    return NEXT(fclose)(stream);
}

int ftruncate(int fd, off_t size) {
    call();
    return NEXT(ftruncate)(fd, size);
}

int ftruncate64(int fd, off64_t size) {
    call();
    return NEXT(ftruncate64)(fd, size);
}

int rename(const char *from, const char *to) {
    call();
    const int result = NEXT(rename)(from, to);
    happens("rename", to);
    return result;
}

int unlink(const char *path) {
    call();
    return NEXT(unlink)(path);
}

int unlinkat(int folder, const char *path, int flags) {
    call();
    return NEXT(unlinkat)(folder, path, flags);
}

int mkdir(const char *path, mode_t mode) {
    call();
    return NEXT(mkdir)(path, mode);
}

int rmdir(const char *path) {
    call();
    return NEXT(rmdir)(path);
}

/* A tool prints a line by one call. Of a longer one only the beginning is searched for TEXT. */
int fprintf(FILE *stream, const char *format, ...) {
    char line[512];
    va_list arguments, again;
    if (is_file(stream)) {
        call();
    }
    va_start(arguments, format);
    va_copy(again, arguments);
    const int printed = vfprintf(stream, format, arguments);
    if (stream == stderr && vsnprintf(line, sizeof line, format, again) > 0) {
        happens("print", line);
    }
    va_end(again);
    va_end(arguments);
    return printed;
}
