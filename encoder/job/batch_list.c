/* Lists of inputs. See batch.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "batch.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>

enum { LONGEST = 4096 };

static bool ends_with(const char *text, const char *end) {
    const size_t a = strlen(text), b = strlen(end);
    return a > b && strcasecmp(text + a - b, end) == 0;
}

bool enc_batch_is(const char *path) {
    struct stat status;
    return (ends_with(path, ".txt") || ends_with(path, ".list")) && stat(path, &status) == 0 &&
           !S_ISDIR(status.st_mode);
}

/* "folder/WOOL.zip" and "folder/WOOL/" to "WOOL"; malloc'ed. */
static char *name_of(const char *input) {
    static const char *const extensions[] = {".tar.gz", ".tar.xz", ".tar.bz2", ".tar.zst", ".tgz",
                                             ".zip",    ".tar",    ".7z",      ".btf"};
    size_t end = strlen(input);
    while (end > 1 && input[end - 1] == '/')
        end--;
    size_t begin = end;
    while (begin > 0 && input[begin - 1] != '/')
        begin--;
    char *name = strndup(input + begin, end - begin);
    for (size_t i = 0; name && i < sizeof extensions / sizeof extensions[0]; i++) {
        if (ends_with(name, extensions[i])) {
            name[strlen(name) - strlen(extensions[i])] = '\0';
            break;
        }
    }
    return name;
}

static char *beside(const char *list, size_t folder_length, const char *name) {
    char *path = malloc(folder_length + strlen(name) + 2);
    if (path)
        sprintf(path, "%.*s/%s", (int)folder_length, list, name);
    return path;
}

/* Takes a line, without spaces at either end. */
static btf_result add(const enc_context *context, enc_batch *batch, const char *list, size_t line,
                      const char *text) {
    const char *slash = strrchr(list, '/');
    char **inputs = realloc(batch->inputs, (batch->count + 1) * sizeof *inputs);
    if (inputs)
        batch->inputs = inputs;
    char **names = inputs ? realloc(batch->names, (batch->count + 1) * sizeof *names) : NULL;
    if (!names)
        return BTF_ERROR_MEMORY;
    batch->names = names;
    char *input = text[0] == '/' || !slash ? strdup(text) : beside(list, (size_t)(slash - list), text);
    char *name = name_of(text);
    if (!input || !name) {
        free(input);
        free(name);
        return BTF_ERROR_MEMORY;
    }
    inputs[batch->count] = input;
    names[batch->count++] = name;
    if (name[0] == '\0' || strcmp(name, ".") == 0 || strcmp(name, "..") == 0)
        return enc_fail(context, BTF_ERROR_BAD_FILE, "%s: line %zu: %s names no material", list, line,
                        text);
    for (size_t i = 0; i + 1 < batch->count; i++)
        if (strcmp(names[i], name) == 0)
            return enc_fail(context, BTF_ERROR_BAD_FILE,
                            "%s: line %zu: %s and %s would both become %s.btf.exr", list, line, inputs[i],
                            input, name);
    return BTF_OK;
}

btf_result enc_batch_read(const enc_context *context, const char *path, enc_batch *out_batch) {
    char line[LONGEST];
    btf_result result = BTF_OK;
    *out_batch = (enc_batch){0};
    FILE *file = fopen(path, "r");
    if (!file)
        return enc_fail(context, BTF_ERROR_IO, "%s: %s", path, strerror(errno));
    for (size_t number = 1; result == BTF_OK && fgets(line, sizeof line, file); number++) {
        char *begin = line + strspn(line, " \t\r\n");
        size_t length = strlen(begin);
        if (strlen(line) + 1 == sizeof line) {
            result = enc_fail(context, BTF_ERROR_BAD_FILE, "%s: line %zu is longer than %d bytes", path,
                              number, LONGEST - 2);
            break;
        }
        while (length > 0 && strchr(" \t\r\n", begin[length - 1]))
            begin[--length] = '\0';
        if (length > 0 && begin[0] != '#')
            result = add(context, out_batch, path, number, begin);
    }
    if (result == BTF_OK && ferror(file))
        result = enc_fail(context, BTF_ERROR_IO, "%s: %s", path, strerror(errno));
    fclose(file);
    if (result == BTF_OK && out_batch->count == 0)
        result = enc_fail(context, BTF_ERROR_BAD_FILE, "%s: lists no input", path);
    if (result != BTF_OK)
        enc_batch_clear(out_batch);
    return result;
}

void enc_batch_clear(enc_batch *batch) {
    for (size_t i = 0; i < batch->count; i++) {
        free(batch->inputs[i]);
        free(batch->names[i]);
    }
    free(batch->inputs);
    free(batch->names);
    *batch = (enc_batch){0};
}
