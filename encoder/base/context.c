/* Messages, cancellation and shares of memory. See context.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "context.h"

#include "decoder/toolkit/progress.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

static void log_va(const enc_context *context, btf_log_level level, const char *format, va_list arguments) {
    if (!context || !context->log.callback) {
        return;
    }
    char text[512];
    va_list again;
    va_copy(again, arguments);
    const int length = vsnprintf(text, sizeof text, format, arguments);
    char *longer = NULL;
    if (length >= (int)sizeof text && (longer = malloc((size_t)length + 1))) {
        vsnprintf(longer, (size_t)length + 1, format, again);
    }
    va_end(again);
/* A stage may fail on several threads at once; the callback sees one message at a time. */
#pragma omp critical(enc_log)
    context->log.callback(context->log.user, level, longer ? longer : text);
    free(longer);
}

void enc_log(const enc_context *context, btf_log_level level, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    log_va(context, level, format, arguments);
    va_end(arguments);
}

btf_result enc_fail(const enc_context *context, btf_result result, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    log_va(context, BTF_LOG_ERROR, format, arguments);
    va_end(arguments);
    return result;
}

void enc_keep_worse(btf_result *io_result, btf_result mine) {
    static const btf_result worst_first[] = {
        BTF_ERROR_INTERRUPTED, BTF_ERROR_IO,     BTF_ERROR_BAD_FILE, BTF_ERROR_USAGE,
        BTF_ERROR_UNSUPPORTED, BTF_ERROR_MEMORY, BTF_ERROR_INTERNAL, BTF_ERROR_DIFFERENT};
    if (mine == BTF_OK) {
        return;
    }
#pragma omp critical(enc_result)
    for (size_t i = 0; i < sizeof worst_first / sizeof worst_first[0]; i++) {
        if (mine == worst_first[i] || *io_result == worst_first[i]) {
/* other threads read it meanwhile, atomically, to end early */
#pragma omp atomic write
            *io_result = worst_first[i];
            break;
        }
    }
}

bool enc_cancelled(const enc_context *context) {
    (void)context;
    return progress_cancelled();
}

int enc_memory_threads(const enc_context *context, uint64_t bytes) {
    const uint64_t most = context->memory / 2 / (bytes > 0 ? bytes : 1);
    if (context->memory == 0 || most >= (uint64_t)context->threads) {
        return context->threads;
    }
    return most > 1 ? (int)most : 1;
}
