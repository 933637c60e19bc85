/* Named stages of an encode. See stage.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "stage.h"

#include "decoder/toolkit/progress.h"
#include "ranks.h"

void enc_stage_begin(const enc_context *context, const char *name, size_t total) {
    if (context && context->progress) {
        progress_begin(context->progress, name, total);
    }
    if (context && context->progress && context->ranks) {
        enc_ranks_stage(context->ranks, name);
    }
}

void enc_stage_step(const enc_context *context, size_t steps) {
    if (context && context->progress) {
        progress_step(context->progress, steps);
    }
}

void enc_stage_end(const enc_context *context) {
    if (context && context->progress) {
        progress_end(context->progress);
    }
    if (context && context->progress && context->ranks) {
        enc_ranks_stage(context->ranks, "between");
    }
}
