/* btf-encode: compresses a BTF into a material.
 *
 * SPDX-License-Identifier: MIT
 */
#include "decoder/toolkit/file.h"
#include "decoder/toolkit/progress.h"
#include "encoder/base/ranks_mpi.h"
#include "encoder/job/batch.h"
#include "encoder/job/job.h"
#include "encoder/job/options.h"
#include "encoder/job/predict.h"

#include <fcntl.h>
#include <omp.h>
#include <stdio.h>
#include <sys/stat.h>
#include <unistd.h>

static uint64_t machine_memory(void) {
    return (uint64_t)sysconf(_SC_PHYS_PAGES) * (uint64_t)sysconf(_SC_PAGESIZE);
}

/* Refuses an output without the ending of a material, in upper or lower case; a device or a pipe may have
 * any name. */
static btf_result check_ending(const enc_context *context, const char *output) {
    struct stat status;
    if (file_ends_in(output, ".btf.exr") ||
        (stat(output, &status) == 0 && !S_ISREG(status.st_mode) && !S_ISDIR(status.st_mode))) {
        return BTF_OK;
    }
    return enc_fail(context, BTF_ERROR_USAGE, "option --output: '%s' does not end in .btf.exr", output);
}

static btf_result run(const enc_context *context, const enc_options *options) {
    const enc_job *job = &options->job;
    enc_batch batch;
    if (options->predict) {
        return enc_batch_is(job->input) ? cli_error(&enc_program, BTF_ERROR_USAGE,
                                                    "option --predict: works on one input, not on a list")
                                        : enc_predict(context, job, options->predict, stdout);
    }
    if (!enc_batch_is(job->input)) {
        if (options->item > 0) {
            return cli_error(&enc_program, BTF_ERROR_USAGE,
                             "option --item: picks an input of a list, and %s is not a list", job->input);
        }
        const btf_result ending = check_ending(context, job->output);
        return ending == BTF_OK ? enc_job_run(context, job) : ending;
    }
    btf_result result = enc_batch_read(context, job->input, &batch);
    if (result == BTF_OK) {
        result = enc_batch_run(context, job, &batch, (size_t)options->item, job->quiet ? NULL : stdout);
        enc_batch_clear(&batch);
    }
    return result;
}

/* Opens the null device in place of a stream. Returns a copy of the stream to restore it by, -1 where that fails. */
static int silence(int stream) {
    const int before = fcntl(stream, F_DUPFD_CLOEXEC, 3), null = open("/dev/null", O_WRONLY | O_CLOEXEC);
    if (null >= 0) {
        dup2(null, stream);
        close(null);
    }
    return before;
}

/* Reads the command line; rank 0 alone reports errors of it, since all ranks have the same. */
static bool parse(int argc, char **argv, const enc_mpi_share *share, bool leads,
                  const enc_options **out_options, int *out_exit_code) {
    int errors = -1;
    if (!leads) {
        silence(STDOUT_FILENO);
        errors = silence(STDERR_FILENO);
    }
    const bool good =
        enc_options_parse(argc, argv, share->threads, share->memory, out_options, out_exit_code);
    if (errors >= 0) {
        dup2(errors, STDERR_FILENO);
        close(errors);
    }
    return good;
}

static int encode(enc_ranks *ranks, const enc_mpi_share *share, int argc, char **argv) {
    const enc_options *options;
    int exit_code;
    const enc_context alone = {.ranks = ranks};
    const bool leads = enc_ranks_leads(&alone);
    if (!parse(argc, argv, share, leads, &options, &exit_code)) {
        return exit_code;
    }
    const bool quiet = options->job.quiet;
    progress *shown = progress_create(quiet || !leads);
    const btf_log log = cli_log(&enc_program, quiet);
    const enc_context context = {.log = ranks ? enc_ranks_log(ranks, log) : log,
                                 .progress = shown,
                                 .threads = options->threads,
                                 .memory = (size_t)options->memory,
                                 .ranks = ranks};
    const btf_result result = run(&context, options);
    if (result == BTF_ERROR_INTERRUPTED && leads) {
        cli_error(&enc_program, result, "interrupted; no material was written");
    }
    progress_destroy(&shown);
    return cli_finish(&enc_program, result);
}

int main(int argc, char **argv) {
    enc_mpi_share share = {.threads = omp_get_num_procs(), .memory = machine_memory() / 2};
    enc_ranks *ranks;
    const btf_result started = enc_mpi_start(cli_log(&enc_program, false), &ranks, &share);
    const int exit_code =
        started == BTF_OK ? encode(ranks, &share, argc, argv) : btf_result_exit_code(started);
    enc_mpi_stop(&ranks);
    return exit_code;
}
