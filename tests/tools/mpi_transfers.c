/* Run by mpirun: data sent between ranks arrive, in one message or in pieces, also where some ranks have nothing to
 * send.
 *
 * SPDX-License-Identifier: MIT
 */
#include "encoder/base/ranks_mpi.h"

#include <stdio.h>
#include <stdlib.h>

enum { MOST_RANKS = 16 };

/* The number that rank `from` sends to rank `to` at place i: different for all. */
static float value(size_t from, size_t to, size_t i) {
    return (float)(1000 * from + 100 * to + i);
}

/* Rank r hands r * s * 3 floats to rank s: nothing where either is 0. */
static int exchange(const enc_context *context) {
    const size_t size = (size_t)enc_ranks_count(context), rank = (size_t)enc_ranks_own(context);
    size_t out[MOST_RANKS + 1] = {0}, in[MOST_RANKS + 1] = {0};
    int wrong = 0;
    for (size_t s = 0; s < size; s++) {
        out[s + 1] = out[s] + 3 * rank * s;
        in[s + 1] = in[s] + 3 * rank * s;
    }
    float *send = calloc(out[size] + 1, sizeof *send), *receive = calloc(in[size] + 1, sizeof *receive);
    for (size_t s = 0; s < size && send; s++) {
        for (size_t i = out[s]; i < out[s + 1]; i++) {
            send[i] = value(rank, s, i - out[s]);
        }
    }
    const btf_result result = send && receive ? BTF_OK : BTF_ERROR_MEMORY;
    wrong += enc_ranks_exchange(context, result, send, out, receive, in) != BTF_OK;
    for (size_t s = 0; s < size && receive; s++) {
        for (size_t i = in[s]; i < in[s + 1]; i++) {
            wrong += receive[i] != value(s, rank, i - in[s]);
        }
    }
    free(send);
    free(receive);
    return wrong;
}

static int check(const enc_context *context) {
    enum { ITEMS = 37 };
    const size_t rank = (size_t)enc_ranks_own(context);
    uint32_t items[ITEMS] = {0}, text[9] = {0};
    size_t first, end;
    int wrong = exchange(context);
    enc_ranks_range(context, ITEMS, &first, &end);
    for (size_t i = first; i < end; i++) {
        items[i] = (uint32_t)(7 * i + 1);
    }
    wrong += enc_ranks_gather(context, BTF_OK, items, sizeof *items, ITEMS) != BTF_OK;
    for (size_t i = 0; i < ITEMS; i++) {
        wrong += items[i] != 7 * i + 1;
    }
    for (size_t i = 0; i < 9 && rank == 0; i++) {
        text[i] = (uint32_t)(i + 11);
    }
    wrong += enc_ranks_broadcast(context, BTF_OK, text, sizeof text) != BTF_OK;
    for (size_t i = 0; i < 9; i++) {
        wrong += text[i] != i + 11;
    }
    uint64_t sums[1] = {rank};
    const size_t size = (size_t)enc_ranks_count(context);
    wrong += enc_ranks_sum(context, BTF_OK, sums, 1) != BTF_OK || sums[0] != size * (size - 1) / 2;
    return wrong;
}

int main(void) {
    static const size_t limits[] = {0, 1, 10, 64};
    enc_mpi_share share = {.threads = 1, .memory = 64};
    enc_ranks *ranks;
    int wrong = enc_mpi_start((btf_log){0}, &ranks, &share) != BTF_OK || !ranks;
    const enc_context context = {.threads = 1, .ranks = ranks};
    for (size_t i = 0; i < sizeof limits / sizeof *limits && wrong == 0; i++) {
        enc_mpi_set_limit(limits[i]);
        wrong += check(&context);
    }
    wrong += share.threads < 1 || share.memory != 64 / (uint64_t)enc_ranks_node_ranks(&context);
    if (wrong > 0) {
        fprintf(stderr, "rank %d: %d values are wrong\n", enc_ranks_own(&context), wrong);
    }
    enc_mpi_stop(&ranks);
    return wrong > 0 ? 7 : 0;
}
