/* Ranks that encode together (see ranks.h).
 *
 * SPDX-License-Identifier: MIT
 */
#include "ranks.h"

#include "decoder/toolkit/progress.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_STAGES = 32, HELD_BYTES = 4096 };

struct enc_ranks {
    enc_transport transport;
    btf_log log;
    btf_result failed;     /* the error on which the ranks stopped */
    char held[HELD_BYTES]; /* errors of a rank other than 0, a line each */
    size_t held_length;
    enc_ranks_volume volumes[MOST_STAGES];
    char names[MOST_STAGES][32];
    size_t n_volumes;
    enc_ranks_volume *volume; /* of the present stage */
    size_t *bounds;           /* [2][size + 1] of a transfer, in bytes */
};

static enc_ranks *ranks_of(const enc_context *context) {
    return context ? context->ranks : NULL;
}

static void begin(enc_ranks *ranks) {
    ranks->failed = BTF_OK;
    ranks->held_length = 0;
    ranks->n_volumes = 0;
    enc_ranks_stage(ranks, "start");
}

enc_ranks *enc_ranks_create(const enc_transport *transport) {
    enc_ranks *ranks = calloc(1, sizeof *ranks);
    size_t *bounds = calloc(2 * ((size_t)transport->size + 1), sizeof *bounds);
    if (!ranks || !bounds) {
        free(ranks);
        free(bounds);
        return NULL;
    }
    ranks->transport = *transport;
    ranks->bounds = bounds;
    begin(ranks);
    return ranks;
}

void enc_ranks_destroy(enc_ranks **ranks) {
    if (!ranks || !*ranks) {
        return;
    }
    free((*ranks)->bounds);
    free(*ranks);
    *ranks = NULL;
}

static void hold(void *user, btf_log_level level, const char *message) {
    enc_ranks *ranks = user;
    const size_t length = strlen(message) + 1;
    if (level != BTF_LOG_ERROR || length > HELD_BYTES - ranks->held_length) {
        return;
    }
    memcpy(ranks->held + ranks->held_length, message, length);
    ranks->held_length += length;
}

btf_log enc_ranks_log(enc_ranks *ranks, btf_log log) {
    ranks->log = log;
    return ranks->transport.rank == 0 ? log : (btf_log){hold, ranks};
}

static void show_held(enc_ranks *ranks, btf_result result) {
    char text[HELD_BYTES + 32];
    if (ranks->transport.rank == 0 || !ranks->log.callback || result == BTF_ERROR_INTERRUPTED) {
        return;
    }
    if (ranks->held_length == 0) {
        hold(ranks, BTF_LOG_ERROR, btf_result_text(result));
    }
    for (const char *line = ranks->held; line < ranks->held + ranks->held_length;
         line += strlen(line) + 1) {
        snprintf(text, sizeof text, "rank %d: %s", ranks->transport.rank, line);
        ranks->log.callback(ranks->log.user, BTF_LOG_ERROR, text);
    }
}

void enc_ranks_begin(const enc_context *context) {
    if (ranks_of(context)) {
        begin(context->ranks);
    }
}

int enc_ranks_own(const enc_context *context) {
    const enc_ranks *ranks = ranks_of(context);
    return ranks ? ranks->transport.rank : 0;
}

int enc_ranks_count(const enc_context *context) {
    const enc_ranks *ranks = ranks_of(context);
    return ranks ? ranks->transport.size : 1;
}

int enc_ranks_node_ranks(const enc_context *context) {
    const enc_ranks *ranks = ranks_of(context);
    return ranks ? ranks->transport.node_ranks : 1;
}

bool enc_ranks_leads(const enc_context *context) {
    return enc_ranks_own(context) == 0;
}

void enc_ranks_range_of(const enc_context *context, int rank, size_t count, size_t *out_first,
                        size_t *out_end) {
    const size_t size = (size_t)enc_ranks_count(context), r = (size_t)rank;
    const size_t each = count / size, more = count % size; /* the first `more` ranks have one more */
    *out_first = r * each + (r < more ? r : more);
    *out_end = *out_first + each + (r < more);
}

void enc_ranks_range(const enc_context *context, size_t count, size_t *out_first, size_t *out_end) {
    enc_ranks_range_of(context, enc_ranks_own(context), count, out_first, out_end);
}

btf_result enc_ranks_agree(const enc_context *context, btf_result result) {
    enc_ranks *ranks = ranks_of(context);
    if (!ranks) {
        return result;
    }
    if (ranks->failed != BTF_OK) {
        return ranks->failed;
    }
    if (result == BTF_OK && enc_cancelled(context)) {
        result = BTF_ERROR_INTERRUPTED;
    }
    const uint64_t rank = (uint64_t)ranks->transport.rank;
    const double start = progress_clock();
    uint64_t worst = result == BTF_OK ? UINT64_MAX : rank << 8 | (uint64_t)result;
    ranks->transport.least(ranks->transport.user, &worst);
    ranks->volume->waited += progress_clock() - start;
    ranks->volume->meetings++;
    if (worst == UINT64_MAX) {
        return BTF_OK;
    }
    ranks->failed = (btf_result)(worst & 255);
    if (worst >> 8 == rank) {
        show_held(ranks, ranks->failed);
    }
    return ranks->failed;
}

bool enc_ranks_all(const enc_context *context, bool holds) {
    enc_ranks *ranks = ranks_of(context);
    if (!ranks) {
        return holds;
    }
    if (enc_ranks_agree(context, BTF_OK) != BTF_OK) {
        return false;
    }
    uint64_t least = holds;
    ranks->transport.least(ranks->transport.user, &least);
    return least != 0;
}

btf_result enc_ranks_gather_bounds(const enc_context *context, btf_result result, void *array,
                                   size_t item_bytes, const size_t *bounds) {
    enc_ranks *ranks = ranks_of(context);
    result = enc_ranks_agree(context, result);
    if (!ranks || result != BTF_OK) {
        return result;
    }
    const int size = ranks->transport.size, rank = ranks->transport.rank;
    for (int r = 0; r <= size; r++) {
        ranks->bounds[r] = bounds[r] * item_bytes;
    }
    const size_t mine = ranks->bounds[rank + 1] - ranks->bounds[rank];
    const double start = progress_clock();
    ranks->transport.gather(ranks->transport.user, array, ranks->bounds);
    ranks->volume->moved += progress_clock() - start;
    ranks->volume->sent += mine;
    ranks->volume->received += ranks->bounds[size] - ranks->bounds[0] - mine;
    return BTF_OK;
}

btf_result enc_ranks_gather(const enc_context *context, btf_result result, void *array, size_t item_bytes,
                            size_t count) {
    enc_ranks *ranks = ranks_of(context);
    if (!ranks) {
        return result;
    }
    size_t *bounds = ranks->bounds + ranks->transport.size + 1, first;
    bounds[0] = 0;
    for (int r = 0; r < ranks->transport.size; r++) {
        enc_ranks_range_of(context, r, count, &first, &bounds[r + 1]);
    }
    return enc_ranks_gather_bounds(context, result, array, item_bytes, bounds);
}

btf_result enc_ranks_exchange(const enc_context *context, btf_result result, const float *send,
                              const size_t *send_bounds, float *receive, const size_t *receive_bounds) {
    enc_ranks *ranks = ranks_of(context);
    result = enc_ranks_agree(context, result);
    if (!ranks || result != BTF_OK) {
        return result;
    }
    const int size = ranks->transport.size, rank = ranks->transport.rank;
    size_t *from = ranks->bounds, *to = from + size + 1;
    for (int r = 0; r <= size; r++) {
        from[r] = send_bounds[r] * sizeof(float);
        to[r] = receive_bounds[r] * sizeof(float);
    }
    const double start = progress_clock();
    ranks->transport.exchange(ranks->transport.user, send, from, receive, to);
    ranks->volume->moved += progress_clock() - start;
    ranks->volume->sent += from[size] - from[0] - (from[rank + 1] - from[rank]);
    ranks->volume->received += to[size] - to[0] - (to[rank + 1] - to[rank]);
    return BTF_OK;
}

btf_result enc_ranks_sum(const enc_context *context, btf_result result, uint64_t *values, size_t count) {
    enc_ranks *ranks = ranks_of(context);
    result = enc_ranks_agree(context, result);
    if (!ranks || result != BTF_OK) {
        return result;
    }
    const double start = progress_clock();
    ranks->transport.sum(ranks->transport.user, values, count);
    ranks->volume->moved += progress_clock() - start;
    ranks->volume->sent += count * sizeof *values;
    ranks->volume->received += count * sizeof *values;
    return BTF_OK;
}

btf_result enc_ranks_broadcast(const enc_context *context, btf_result result, void *bytes, size_t size) {
    enc_ranks *ranks = ranks_of(context);
    result = enc_ranks_agree(context, result);
    if (!ranks || result != BTF_OK || size == 0) {
        return result;
    }
    const double start = progress_clock();
    ranks->transport.broadcast(ranks->transport.user, bytes, size);
    ranks->volume->moved += progress_clock() - start;
    *(ranks->transport.rank == 0 ? &ranks->volume->sent : &ranks->volume->received) += size;
    return BTF_OK;
}

void enc_ranks_stage(enc_ranks *ranks, const char *stage) {
    size_t i = 0;
    while (i < ranks->n_volumes && strcmp(ranks->names[i], stage) != 0) {
        i++;
    }
    if (i == MOST_STAGES) {
        i--;
    }
    if (i == ranks->n_volumes) {
        snprintf(ranks->names[i], sizeof ranks->names[i], "%s", stage);
        ranks->volumes[ranks->n_volumes++] = (enc_ranks_volume){.stage = ranks->names[i]};
    }
    ranks->volume = &ranks->volumes[i];
}

const enc_ranks_volume *enc_ranks_volumes(const enc_context *context, size_t *out_count) {
    const enc_ranks *ranks = ranks_of(context);
    *out_count = ranks ? ranks->n_volumes : 0;
    return ranks ? ranks->volumes : NULL;
}
