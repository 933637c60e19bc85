/* Ranks that encode together, as `mpirun -n N btf-encode` starts them.
 *
 * Every rank runs the whole encode on a copy of the model. Only heavy loops are split, each rank taking a
 * slice of their items, and what they found is exchanged afterwards, so that all hold the same again. What
 * an item gives must not depend on the split, and sums over items are taken in the order of one process:
 * then every rank has the bits that one process would have.
 *
 * The functions below that take a `result` are met by all ranks in the same order, from the thread that
 * runs the encode and outside of parallel regions. They begin with enc_ranks_agree: a rank that fails
 * leaves by the next of them, wherever it stands, and takes the others along. All of them accept a context
 * without ranks, or NULL: a process that is alone.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_RANKS_H
#define OPENBTF_ENCODER_RANKS_H

#include "context.h"
#include <stdint.h>

/* Carries the messages. `bounds` are bytes: rank r has bounds[r] .. bounds[r + 1]. */
typedef struct enc_transport {
    int rank, size;
    int node_ranks; /* of them on this machine */
    void *user;
    /* Replaces every rank's value by the least of all. */
    void (*least)(void *user, uint64_t *io_value);
    /* Fills in the array on every rank: rank r holds the bytes within its bounds, and receives the
     * others. */
    void (*gather)(void *user, void *array, const size_t *bounds);
    /* Sends to each rank r the bytes of `send` within its bounds; the bytes that r sends arrive in `receive` within
     * its bounds there. */
    void (*exchange)(void *user, const void *send, const size_t *send_bounds, void *receive,
                     const size_t *receive_bounds);
    void (*sum)(void *user, uint64_t *values, size_t count);
    void (*broadcast)(void *user, void *bytes, size_t size); /* from rank 0 */
} enc_transport;

typedef struct enc_ranks enc_ranks;

/* The transport is copied. NULL when out of memory. */
enc_ranks *enc_ranks_create(const enc_transport *transport);
void enc_ranks_destroy(enc_ranks **ranks);

/* The log for a rank's messages in place of `log`: rank 0 writes to `log` at once; the other ranks hold back
 * their errors, and enc_ranks_agree writes them there when they are why the ranks leave. */
btf_log enc_ranks_log(enc_ranks *ranks, btf_log log);

/* Begins a job: forgets the error that ended the last one, if any, and counts the traffic anew. */
void enc_ranks_begin(const enc_context *context);

int enc_ranks_own(const enc_context *context);
int enc_ranks_count(const enc_context *context);
/* Ranks on this machine. */
int enc_ranks_node_ranks(const enc_context *context);
/* Whether this rank writes the outputs: rank 0. */
bool enc_ranks_leads(const enc_context *context);

/* This rank's slice of `count` items: first .. end - 1. */
void enc_ranks_range(const enc_context *context, size_t count, size_t *out_first, size_t *out_end);
/* The slice of a given rank. Slices follow one another, and their lengths differ by one item at most. */
void enc_ranks_range_of(const enc_context *context, int rank, size_t count, size_t *out_first,
                        size_t *out_end);

/* Returns the result of all ranks: BTF_OK, or the result of the lowest rank that failed; BTF_ERROR_INTERRUPTED
 * where a rank was asked to stop. After a failure further calls return the same at once, until enc_ranks_begin. */
btf_result enc_ranks_agree(const enc_context *context, btf_result result);
/* Whether `holds` is true on every rank; false where a rank failed. */
bool enc_ranks_all(const enc_context *context, bool holds);

/* Completes array [count] of items of `item_bytes` on every rank, each having filled its slice alone. */
btf_result enc_ranks_gather(const enc_context *context, btf_result result, void *array, size_t item_bytes,
                            size_t count);
/* Completes such an array of which rank r has filled items bounds[r] .. bounds[r + 1] - 1. */
btf_result enc_ranks_gather_bounds(const enc_context *context, btf_result result, void *array,
                                   size_t item_bytes, const size_t *bounds);
/* Hands floats send_bounds[r] .. send_bounds[r + 1] - 1 of `send` to rank r, which finds them in its
 * `receive`, within the receive_bounds that it has for this rank. */
btf_result enc_ranks_exchange(const enc_context *context, btf_result result, const float *send,
                              const size_t *send_bounds, float *receive, const size_t *receive_bounds);
/* Replaces each value by its sum over all ranks. */
btf_result enc_ranks_sum(const enc_context *context, btf_result result, uint64_t *values, size_t count);
/* Copies the bytes of rank 0 to all ranks. */
btf_result enc_ranks_broadcast(const enc_context *context, btf_result result, void *bytes, size_t size);

/* The traffic between the ranks in one stage. */
typedef struct enc_ranks_volume {
    const char *stage;
    uint64_t received, sent; /* bytes of this rank; what all ranks get counts as sent once */
    uint64_t meetings;       /* of all ranks */
    double waited, moved;    /* seconds spent waiting for other ranks, and in messages */
} enc_ranks_volume;

/* Counts the traffic that follows under this stage. */
void enc_ranks_stage(enc_ranks *ranks, const char *stage);
/* Stages in order; owned by the ranks object. *out_count is 0 for a process that is alone. */
const enc_ranks_volume *enc_ranks_volumes(const enc_context *context, size_t *out_count);

#endif
