/* Messages, progress and cancellation for the stages of the encoder.
 *
 * SPDX-License-Identifier: MIT
 */
#include "context.h"

#include "decoder/toolkit/progress.h"
#include "ranks.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

static void log_va(const enc_context *context, btf_log_level level, const char *format, va_list arguments) {
    if (!context || !context->log.callback)
        return;
    char text[512];
    va_list again;
    va_copy(again, arguments);
    const int length = vsnprintf(text, sizeof text, format, arguments);
    char *longer = NULL;
    if (length >= (int)sizeof text && (longer = malloc((size_t)length + 1)))
        vsnprintf(longer, (size_t)length + 1, format, again);
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

void enc_stage_begin(const enc_context *context, const char *name, size_t total) {
    if (context && context->progress)
        progress_begin(context->progress, name, total);
    if (context && context->progress && context->ranks)
        enc_ranks_stage(context->ranks, name);
}

void enc_stage_step(const enc_context *context, size_t steps) {
    if (context && context->progress)
        progress_step(context->progress, steps);
}

void enc_stage_end(const enc_context *context) {
    if (context && context->progress)
        progress_end(context->progress);
    if (context && context->progress && context->ranks)
        enc_ranks_stage(context->ranks, "between");
}

bool enc_cancelled(const enc_context *context) {
    (void)context;
    return progress_cancelled();
}
