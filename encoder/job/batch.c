/* Many encodes, one after the other. See batch.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "batch.h"

#include "decoder/toolkit/output.h"
#include "decoder/toolkit/progress.h"
#include "encoder/base/ranks.h"
#include "job.h"

#include <stdlib.h>
#include <string.h>

static char *join(const char *folder, const char *name, const char *extension) {
    char *path = malloc(strlen(folder) + strlen(name) + strlen(extension) + 2);
    if (path)
        sprintf(path, "%s/%s%s", folder, name, extension);
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

/* What became of an input. */
typedef struct outcome {
    bool tried;
    btf_result result;
    double seconds;
} outcome;

static void print_summary(const enc_batch *batch, const outcome *outcomes, FILE *summary) {
    size_t done = 0, failed = 0;
    for (size_t i = 0; i < batch->count; i++) {
        const outcome *o = &outcomes[i];
        if (!o->tried)
            continue;
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
    if (item > batch->count)
        return enc_fail(context, BTF_ERROR_USAGE, "item %zu: the list has %zu", item, batch->count);
    outcome *outcomes = calloc(batch->count, sizeof *outcomes);
    btf_result result = outcomes ? make_folder(context, job->output) : BTF_ERROR_MEMORY;
    if (result == BTF_OK)
        result = make_folder(context, job->checkpoint);
    if (result == BTF_OK)
        result = make_folder(context, job->report);
    if (result == BTF_OK)
        result = make_folder(context, job->pictures);
    result = enc_ranks_agree(context, result);
    btf_result first = result;
    for (size_t i = 0; i < batch->count && result == BTF_OK; i++) {
        if (item > 0 && i + 1 != item)
            continue;
        const double begin = progress_clock();
        outcomes[i].tried = true;
        outcomes[i].result = run_one(context, job, batch->inputs[i], batch->names[i]);
        outcomes[i].seconds = progress_clock() - begin;
        if (first == BTF_OK)
            first = outcomes[i].result;
        if (outcomes[i].result == BTF_ERROR_INTERRUPTED)
            result = first = BTF_ERROR_INTERRUPTED;
    }
    if (outcomes && summary && enc_ranks_leads(context))
        print_summary(batch, outcomes, summary);
    free(outcomes);
    return first;
}
