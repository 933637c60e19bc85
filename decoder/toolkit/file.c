/* Reads whole files, tells kinds of files apart, and formats messages. See file.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "file.h"

#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>

static void say(const btf_log *log, btf_log_level level, const char *format, va_list arguments) {
    char text[1200];
    if (!log || !log->callback) {
        return;
    }
    vsnprintf(text, sizeof text, format, arguments);
    log->callback(log->user, level, text);
}

void file_say(const btf_log *log, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    say(log, BTF_LOG_ERROR, format, arguments);
    va_end(arguments);
}

void file_warn(const btf_log *log, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    say(log, BTF_LOG_WARNING, format, arguments);
    va_end(arguments);
}

static void keep(void *user, btf_log_level level, const char *message) {
    file_kept *kept = user;
    (void)level;
    snprintf(kept->text, sizeof kept->text, "%s", message);
}

btf_log file_log_keep(file_kept *kept) {
    kept->text[0] = 0;
    return (btf_log){keep, kept};
}

bool file_is_exr(const char *path) {
    char begin[4] = "";
    struct stat status;
    if (stat(path, &status) != 0 || !S_ISREG(status.st_mode)) {
        return false;
    }
    FILE *file = fopen(path, "rb");
    const size_t size = file ? fread(begin, 1, sizeof begin, file) : 0;
    if (file) {
        fclose(file);
    }
    return size == sizeof begin && memcmp(begin, "\x76\x2f\x31\x01", sizeof begin) == 0;
}

bool file_ends_in(const char *path, const char *ending) {
    const size_t length = strlen(path), end = strlen(ending);
    return length > end && strcasecmp(path + length - end, ending) == 0;
}

btf_result file_read(const char *path, size_t most, const btf_log *log, char **out_data, size_t *out_size) {
    size_t size = 0, room = 1 << 16;
    char *data = NULL;
    btf_result result = BTF_OK;
    FILE *file = fopen(path, "rb");
    *out_data = NULL;
    *out_size = 0;
    if (!file) {
        file_say(log, "%s: %s", path, strerror(errno));
        return BTF_ERROR_IO;
    }
    do {
        room *= 2;
        char *grown = realloc(data, room);
        if (!grown) {
            file_say(log, "%s: out of memory for %zu bytes", path, room);
            result = BTF_ERROR_MEMORY;
            break;
        }
        data = grown;
        size += fread(data + size, 1, room - 1 - size, file);
        if (size > most) {
            file_say(log, "%s: the file is larger than %zu bytes, the most that is read", path, most);
            result = BTF_ERROR_UNSUPPORTED;
        }
    } while (!result && size == room - 1);
    if (!result && ferror(file)) {
        file_say(log, "%s: cannot be read: %s", path, strerror(errno));
        result = BTF_ERROR_IO;
    }
    fclose(file);
    if (result) {
        free(data);
        return result;
    }
    data[size] = '\0';
    *out_data = data;
    *out_size = size;
    return BTF_OK;
}
