/* What every stage of the encoder is handed besides its data: where messages and progress go, how
 * many threads and how much memory it may use, and whether the user wants it to stop.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_CONTEXT_H
#define OPENBTF_ENCODER_CONTEXT_H

#include <openbtf/result.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct progress;         /* decoder/toolkit/progress.h */
struct enc_checkpoint;   /* checkpoint.h */
struct enc_ranks;        /* ranks.h */
struct enc_announcement; /* announce.h */

/* Whose least need of memory is asked for before data are read. */
typedef enum enc_need { ENC_NEED_UNKNOWN = 0, ENC_NEED_JOINT = 1, ENC_NEED_PAPER = 2 } enc_need;

typedef struct enc_context {
    btf_log log;
    struct progress *progress;                   /* may be NULL: no progress shown */
    int threads;                                 /* OpenMP threads, >= 1 */
    size_t memory;                               /* bytes the working set may take, 0 = unbounded */
    struct enc_checkpoint *checkpoint;           /* where stages keep what they found; NULL: nowhere */
    const struct enc_announcement *announcement; /* who is told what will be read; NULL: nobody */
    enc_need need;         /* data that take more by this method are refused; unknown: none are */
    struct enc_ranks *ranks; /* the ranks that share the work; NULL: this process is alone */
} enc_context;

/* printf-style message to context->log; does nothing without a callback. context may be NULL. */
void enc_log(const enc_context *context, btf_log_level level, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* enc_log at level error, then returns `result`: `return enc_fail(context, BTF_ERROR_IO, "...")`. */
btf_result enc_fail(const enc_context *context, btf_result result, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* True once the user asked to stop (SIGINT, SIGTERM). Long loops test it once an iteration and return
 * BTF_ERROR_INTERRUPTED. */
bool enc_cancelled(const enc_context *context);

/* Threads that may each hold `bytes`, in half of the allowed memory, the other half being the data's: 1 to
 * context->threads. */
int enc_memory_threads(const enc_context *context, uint64_t bytes);

#endif
