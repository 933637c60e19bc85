/* Core seconds by stage from a written report. See stage_times.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "stage_times.h"

#include <cjson/cJSON.h>
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { REPORT_BYTES = 8 << 20 }; /* the largest file that is read; a report has some ten thousand bytes */

double enc_stage_time(const enc_stage_times *times, const char *stage) {
    for (size_t i = 0; i < times->count; i++) {
        if (strcmp(times->of[i].stage, stage) == 0) {
            return times->of[i].seconds;
        }
    }
    return NAN;
}

/* Reads the whole file and ends it with a zero; the caller frees it. */
static btf_result read_text(const enc_context *context, const char *path, char **out_text,
                            size_t *out_length) {
    FILE *file = fopen(path, "r");
    if (!file) {
        return enc_fail(context, BTF_ERROR_IO, "%s: %s", path, strerror(errno));
    }
    btf_result result = BTF_OK;
    char *text = malloc(REPORT_BYTES + 1);
    const size_t length = text ? fread(text, 1, REPORT_BYTES, file) : 0;
    if (!text) {
        result = enc_fail(context, BTF_ERROR_MEMORY, "%s: out of memory", path);
    } else if (ferror(file)) {
        result = enc_fail(context, BTF_ERROR_IO, "%s: %s", path, strerror(errno));
    } else if (length == REPORT_BYTES) {
        result =
            enc_fail(context, BTF_ERROR_BAD_FILE,
                     "%s: is not a report of btf-encode: it has %d MiB or more", path, REPORT_BYTES >> 20);
    }
    fclose(file);
    if (result != BTF_OK) {
        free(text);
        return result;
    }
    text[length] = '\0';
    *out_text = text;
    *out_length = length;
    return BTF_OK;
}

static btf_result parse(const enc_context *context, const char *path, cJSON **out_root) {
    char *text = NULL;
    size_t length = 0;
    btf_result result = read_text(context, path, &text, &length);
    if (result != BTF_OK) {
        return result;
    }
    const char *end = text;
    *out_root = cJSON_ParseWithLengthOpts(text, length + 1, &end, true);
    if (!*out_root || end != text + length) {
        int line = 1;
        for (const char *at = text; at < end && at < text + length; at++) {
            line += *at == '\n';
        }
        result = enc_fail(context, BTF_ERROR_BAD_FILE, "%s: line %d: is not JSON", path, line);
        cJSON_Delete(*out_root);
        *out_root = NULL;
    }
    free(text);
    return result;
}

/* Fails with a message that names the file, the member and what is wrong with it. */
static btf_result fail_member(const enc_context *context, const char *path, const char *name,
                              const char *member, const char *wrong) {
    return enc_fail(context, BTF_ERROR_BAD_FILE, "%s: is not a report of btf-encode: member %s%s%s %s",
                    path, name, member ? "." : "", member ? member : "", wrong);
}

static btf_result take_times(const enc_context *context, const char *path, const cJSON *root,
                             const char *name, enc_stage_times *out) {
    const cJSON *times = cJSON_GetObjectItemCaseSensitive(root, name), *time;
    out->count = 0;
    if (!times) {
        return fail_member(context, path, name, NULL, "is missing");
    }
    if (!cJSON_IsObject(times)) {
        return fail_member(context, path, name, NULL, "is not an object");
    }
    cJSON_ArrayForEach(time, times) {
        if (out->count == ENC_STAGE_TIMES) {
            return fail_member(context, path, name, NULL, "lists more stages than an encode has");
        }
        if (!cJSON_IsNumber(time) || !isfinite(time->valuedouble) || time->valuedouble < 0) {
            return fail_member(context, path, name, time->string, "is not a number of at least 0");
        }
        if (strlen(time->string) >= ENC_STAGE_NAME) {
            return fail_member(context, path, name, time->string, "has a name longer than a stage's");
        }
        strcpy(out->of[out->count].stage, time->string);
        out->of[out->count++].seconds = time->valuedouble;
    }
    return out->count > 0 ? BTF_OK : fail_member(context, path, name, NULL, "is empty");
}

static btf_result take_method(const enc_context *context, const char *path, const cJSON *root,
                              char method[ENC_STAGE_NAME]) {
    const cJSON *member = cJSON_GetObjectItemCaseSensitive(root, "method");
    if (!member) {
        return fail_member(context, path, "method", NULL, "is missing");
    }
    if (!cJSON_IsString(member) || strlen(member->valuestring) >= ENC_STAGE_NAME) {
        return fail_member(context, path, "method", NULL, "is not a method's name");
    }
    strcpy(method, member->valuestring);
    return BTF_OK;
}

btf_result enc_report_times_read(const enc_context *context, const char *path, enc_report_times *out) {
    cJSON *root = NULL;
    btf_result result = parse(context, path, &root);
    if (result == BTF_OK && !cJSON_IsObject(root)) {
        result = enc_fail(context, BTF_ERROR_BAD_FILE,
                          "%s: is not a report of btf-encode: it is not a JSON object", path);
    }
    if (result == BTF_OK) {
        result = take_method(context, path, root, out->method);
    }
    if (result == BTF_OK) {
        result = take_times(context, path, root, "core_seconds", &out->measured);
    }
    if (result == BTF_OK && isnan(enc_stage_time(&out->measured, "total"))) {
        result = fail_member(context, path, "core_seconds", "total", "is missing");
    }
    if (result == BTF_OK) {
        result = take_times(context, path, root, "predicted_core_seconds", &out->predicted);
    }
    cJSON_Delete(root);
    return result;
}
