/* Many encodes, one after the other. See batch.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "batch.h"

#include "decoder/toolkit/output.h"
#include "decoder/toolkit/progress.h"
#include "decoder/toolkit/text.h"
#include "encoder/base/ranks.h"
#include "encoder/input/bonn/file.h"
#include "job.h"

#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>

enum { LARGEST_LIST = 1 << 28 }; /* bytes */

static bool ends_with(const char *text, const char *end) {
    const size_t a = strlen(text), b = strlen(end);
    return a > b && strcasecmp(text + a - b, end) == 0;
}

/* Whether the first bytes of a file show that it is an archive, an image or a Bonn file, and so no list,
 * whatever its ending. */
static bool has_other_content(const char *path) {
    static const char *const signatures[] = {
        "PK\3\4", "PK\5\6",           "7z\xbc\xaf", "\x1f\x8b",     "\xfd\x37zXZ", "\x28\xb5\x2f\xfd",
        "BZh",    "\x76\x2f\x31\x01", "\x89PNG",    "\xff\xd8\xff", "#?RADIANCE"};
    char begin[264] = "";
    FILE *file = fopen(path, "r");
    const size_t size = file ? fread(begin, 1, sizeof begin - 1, file) : 0;
    if (file) {
        fclose(file);
    }
    for (size_t i = 0; i < sizeof signatures / sizeof *signatures; i++) {
        if (size >= strlen(signatures[i]) && memcmp(begin, signatures[i], strlen(signatures[i])) == 0) {
            return true;
        }
    }
    return (size > 262 && memcmp(begin + 257, "ustar", 5) == 0) || enc_bonn_is(path);
}

bool enc_batch_is(const char *path) {
    struct stat status;
    return (ends_with(path, ".txt") || ends_with(path, ".list")) && stat(path, &status) == 0 &&
           !S_ISDIR(status.st_mode) && !(S_ISREG(status.st_mode) && has_other_content(path));
}

/* "folder/WOOL.zip" and "folder/WOOL/" to "WOOL"; malloc'ed. */
static char *name_of(const char *input) {
    static const char *const extensions[] = {".tar.gz", ".tar.xz", ".tar.bz2", ".tar.zst", ".tgz",
                                             ".zip",    ".tar",    ".7z",      ".btf"};
    size_t end = strlen(input);
    while (end > 1 && input[end - 1] == '/') {
        end--;
    }
    size_t begin = end;
    while (begin > 0 && input[begin - 1] != '/') {
        begin--;
    }
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
    if (path) {
        sprintf(path, "%.*s/%s", (int)folder_length, list, name);
    }
    return path;
}

/* Adds the input that a line names; the line has no spaces at either end. */
static btf_result add_input(const enc_context *context, enc_batch *batch, const char *list, size_t line,
                            const char *text) {
    const char *slash = strrchr(list, '/');
    char **inputs = realloc(batch->inputs, (batch->count + 1) * sizeof *inputs);
    if (inputs) {
        batch->inputs = inputs;
    }
    char **names = inputs ? realloc(batch->names, (batch->count + 1) * sizeof *names) : NULL;
    if (!names) {
        return BTF_ERROR_MEMORY;
    }
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
    if (name[0] == '\0' || strcmp(name, ".") == 0 || strcmp(name, "..") == 0) {
        return enc_fail(context, BTF_ERROR_BAD_FILE, "%s: line %zu: '%s' gives no file name for a material",
                        list, line, text);
    }
    for (size_t i = 0; i + 1 < batch->count; i++) {
        if (strcmp(names[i], name) == 0) {
            return enc_fail(context, BTF_ERROR_BAD_FILE,
                            "%s: line %zu: %s and %s would both become %s.btf.exr", list, line, inputs[i],
                            input, name);
        }
    }
    return BTF_OK;
}

btf_result enc_batch_read(const enc_context *context, const char *path, enc_batch *out_batch) {
    text_file text;
    *out_batch = (enc_batch){0};
    btf_result result = text_read(path, LARGEST_LIST, &context->log, &text);
    if (result != BTF_OK) {
        return result;
    }
    for (char *line; result == BTF_OK && (line = text_line(&text));) {
        char *begin = line + strspn(line, " \t");
        size_t length = strlen(begin);
        while (length > 0 && strchr(" \t", begin[length - 1])) {
            begin[--length] = '\0';
        }
        if (length > 0 && begin[0] != '#') {
            result = add_input(context, out_batch, path, text.number, begin);
        }
    }
    text_free(&text);
    if (result == BTF_OK && out_batch->count == 0) {
        result = enc_fail(context, BTF_ERROR_BAD_FILE, "%s: the list names no input", path);
    }
    if (result != BTF_OK) {
        enc_batch_clear(out_batch);
    }
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

static char *join(const char *folder, const char *name, const char *extension) {
    char *path = malloc(strlen(folder) + strlen(name) + strlen(extension) + 2);
    if (path) {
        sprintf(path, "%s/%s%s", folder, name, extension);
    }
    return path;
}

static btf_result make_folder(const enc_context *context, const char *path) {
    return path && enc_ranks_leads(context) ? output_make_folder(path, context->log, NULL) : BTF_OK;
}

static btf_result run_one(const enc_context *context, const enc_job *job, const char *input,
                          const char *name) {
    enc_job one = *job;
    char *output = join(job->output, name, ".btf.exr");
    char *report = job->report ? join(job->report, name, ".json") : NULL;
    char *checkpoint = job->checkpoint ? join(job->checkpoint, name, "") : NULL;
    char *pictures = job->pictures ? join(job->pictures, name, "") : NULL;
    btf_result result = BTF_ERROR_MEMORY;
    if (output && (report || !job->report) && (pictures || !job->pictures) &&
        (checkpoint || !job->checkpoint)) {
        one.input = input;
        one.output = output;
        one.report = report;
        one.pictures = pictures;
        one.checkpoint = checkpoint;
        result = enc_job_run(context, &one);
    }
    free(output);
    free(report);
    free(pictures);
    free(checkpoint);
    return result;
}

/* How the encode of an input ended. */
typedef struct outcome {
    bool tried;
    btf_result result;
    double seconds;
} outcome;

static void print_summary(const enc_batch *batch, const outcome *outcomes, FILE *summary) {
    size_t done = 0, failed = 0;
    for (size_t i = 0; i < batch->count; i++) {
        const outcome *o = &outcomes[i];
        if (!o->tried) {
            continue;
        }
        fprintf(summary, "%-8s %8.1f s  %s%s%s\n", o->result == BTF_OK ? "ok" : "FAILED", o->seconds,
                batch->inputs[i], o->result == BTF_OK ? "" : ": ",
                o->result == BTF_OK ? "" : btf_result_text(o->result));
        done += o->result == BTF_OK;
        failed += o->result != BTF_OK;
    }
    fprintf(summary, "%zu encoded, %zu failed, %zu not tried\n", done, failed,
            batch->count - done - failed);
}

btf_result enc_batch_run(const enc_context *context, const enc_job *job, const enc_batch *batch,
                         size_t item, FILE *summary) {
    if (item > batch->count) {
        return enc_fail(context, BTF_ERROR_USAGE, "option --item: %zu, but the list has %zu inputs", item,
                        batch->count);
    }
    outcome *outcomes = calloc(batch->count, sizeof *outcomes);
    btf_result result = outcomes ? make_folder(context, job->output) : BTF_ERROR_MEMORY;
    if (result == BTF_OK) {
        result = make_folder(context, job->checkpoint);
    }
    if (result == BTF_OK) {
        result = make_folder(context, job->report);
    }
    if (result == BTF_OK) {
        result = make_folder(context, job->pictures);
    }
    result = enc_ranks_agree(context, result);
    btf_result first = result;
    for (size_t i = 0; i < batch->count && result == BTF_OK; i++) {
        if (item > 0 && i + 1 != item) {
            continue;
        }
        const double begin = progress_clock();
        outcomes[i].tried = true;
        outcomes[i].result = run_one(context, job, batch->inputs[i], batch->names[i]);
        outcomes[i].seconds = progress_clock() - begin;
        if (first == BTF_OK) {
            first = outcomes[i].result;
        }
        if (outcomes[i].result == BTF_ERROR_INTERRUPTED) { /* any other failure lets the next input begin */
            result = first = BTF_ERROR_INTERRUPTED;
        }
    }
    if (outcomes && summary && enc_ranks_leads(context)) {
        print_summary(batch, outcomes, summary);
    }
    free(outcomes);
    return first;
}
