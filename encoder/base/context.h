/* The surroundings that every stage of the encoder is handed besides its data: where messages and progress
 * go, how many threads and how much memory it may use, and whether the user wants it to stop.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_CONTEXT_H
#define OPENBTF_ENCODER_CONTEXT_H

#include <openbtf/result.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct progress;            /* decoder/toolkit/progress.h */
struct enc_checkpoint;      /* data/checkpoint.h */
struct enc_ranks;           /* ranks.h */
struct enc_extent_listener; /* data/extent.h */

/* The fewest bytes, besides the samples, in which a method can encode data of this size. */
typedef uint64_t (*enc_least_memory)(int width, int height, int n_views, int n_lights, int threads);

typedef struct enc_context {
    btf_log log;
    struct progress *progress;                  /* may be NULL: no progress shown */
    int threads;                                /* OpenMP threads, >= 1 */
    size_t memory;                              /* bytes the working set may take, 0 = unbounded */
    struct enc_checkpoint *checkpoint;          /* where stages keep their results; NULL: nowhere */
    const struct enc_extent_listener *listener; /* is told the extent of the data read; NULL: none */
    enc_least_memory least_memory; /* of the method that will encode; data for which it exceeds `memory` are
                                      refused. NULL: no data are */
    struct enc_ranks *ranks;       /* the ranks that share the work; NULL: this process is alone */
} enc_context;

/* printf-style message to context->log; does nothing without a callback. context may be NULL. */
void enc_log(const enc_context *context, btf_log_level level, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* enc_log at level error, then returns `result`: `return enc_fail(context, BTF_ERROR_IO, "...")`. */
btf_result enc_fail(const enc_context *context, btf_result result, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* Makes *io_result, which threads share, the worse of itself and the result of one of them. Which one is
 * worse does not depend on which thread comes first: the user's stop comes before all errors, and of errors
 * the one that the user can do most about, an error in a file before a lack of memory, and that before a
 * fault of the program. Nothing else may write *io_result meanwhile. */
void enc_keep_worse(btf_result *io_result, btf_result mine);

/* True once the user asked to stop (SIGINT, SIGTERM). Long loops test it once an iteration and return
 * BTF_ERROR_INTERRUPTED. */
bool enc_cancelled(const enc_context *context);

/* How many threads may each hold `bytes` in half of the allowed memory, the other half being for the
 * samples: 1 to context->threads. */
int enc_memory_threads(const enc_context *context, uint64_t bytes);

#endif
