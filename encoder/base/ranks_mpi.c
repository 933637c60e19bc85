/* The ranks of a process that mpirun started: MPI (see ranks_mpi.h).
 *
 * SPDX-License-Identifier: MIT
 */
#include "ranks_mpi.h"

#include "decoder/toolkit/output.h"
#include "decoder/toolkit/progress.h"

#include <mpi.h>
#include <sched.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { EAGER_TESTS = 2000, NAP = 50000 /* ns */ };

static const double patience = 5.0; /* seconds that ranks which were asked to stop wait for one another */
static size_t limit = (size_t)1 << 30;
static bool initialised;

void enc_mpi_set_limit(size_t bytes) {
    limit = bytes > 0 ? bytes : (size_t)1 << 30;
}

/* Waits without taking the core from the ranks that still work. A dead rank never comes: once this process
 * is asked to stop, it waits for some seconds more, then ends all ranks. */
static void wait_for(MPI_Request *request) {
    const struct timespec nap = {0, NAP};
    double asked = 0.0;
    int done = 0;
    for (unsigned i = 0;; i++) {
        MPI_Test(request, &done, MPI_STATUS_IGNORE);
        if (done) {
            return;
        }
        if (i < EAGER_TESTS) {
            continue;
        }
        nanosleep(&nap, NULL);
        if (!progress_cancelled()) {
            continue;
        }
        if (asked == 0.0) {
            asked = progress_clock();
        }
        if (progress_clock() - asked > patience) {
            output_remove_all();
            MPI_Abort(MPI_COMM_WORLD, btf_result_exit_code(BTF_ERROR_INTERRUPTED));
        }
    }
}

static void least(void *user, uint64_t *io_value) {
    const uint64_t mine = *io_value;
    MPI_Request request;
    (void)user;
    MPI_Iallreduce(&mine, io_value, 1, MPI_UINT64_T, MPI_MIN, MPI_COMM_WORLD, &request);
    wait_for(&request);
}

/* MPI counts bytes with an int: larger transfers go piece by piece. */
static void broadcast_pieces(char *bytes, size_t size, int root) {
    for (size_t at = 0; at < size; at += limit) {
        const size_t piece = size - at < limit ? size - at : limit;
        MPI_Bcast(bytes + at, (int)piece, MPI_BYTE, root, MPI_COMM_WORLD);
    }
}

static void broadcast(void *user, void *bytes, size_t size) {
    (void)user;
    broadcast_pieces(bytes, size, 0);
}

/* The counts and displacements that MPI_Allgatherv takes, of all ranks; false when out of memory. */
static bool make_counts(int size, const size_t *bounds, int **out_counts) {
    int *counts = malloc(2 * (size_t)size * sizeof *counts);
    for (int r = 0; r < size && counts; r++) {
        counts[r] = (int)(bounds[r + 1] - bounds[r]);
        counts[size + r] = (int)(bounds[r] - bounds[0]);
    }
    *out_counts = counts;
    return counts;
}

static void no_memory(void) {
    output_remove_all();
    MPI_Abort(MPI_COMM_WORLD, btf_result_exit_code(BTF_ERROR_MEMORY));
}

static void gather(void *user, void *array, const size_t *bounds) {
    int size, *counts;
    (void)user;
    MPI_Comm_size(MPI_COMM_WORLD, &size);
    if (bounds[size] - bounds[0] > limit) {
        for (int r = 0; r < size; r++) {
            broadcast_pieces((char *)array + bounds[r], bounds[r + 1] - bounds[r], r);
        }
        return;
    }
    if (!make_counts(size, bounds, &counts)) {
        no_memory();
    }
    MPI_Allgatherv(MPI_IN_PLACE, 0, MPI_DATATYPE_NULL, (char *)array + bounds[0], counts, counts + size,
                   MPI_BYTE, MPI_COMM_WORLD);
    free(counts);
}

/* Exchanges piece by piece. There are as many turns as ranks; in each, a rank sends to one other and
 * receives from one. */
static void exchange_pieces(const char *send, const size_t *from, char *receive, const size_t *to) {
    int size, rank;
    MPI_Comm_size(MPI_COMM_WORLD, &size);
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    for (int turn = 0; turn < size; turn++) {
        const int there = (rank + turn) % size, here = (rank + size - turn) % size;
        const size_t out = from[there + 1] - from[there], in = to[here + 1] - to[here];
        for (size_t at = 0; at < out || at < in; at += limit) {
            const size_t left_out = at < out ? out - at : 0, left_in = at < in ? in - at : 0;
            MPI_Sendrecv(send + from[there] + (left_out ? at : 0),
                         (int)(left_out < limit ? left_out : limit), MPI_BYTE,
                         left_out ? there : MPI_PROC_NULL, 0, receive + to[here] + (left_in ? at : 0),
                         (int)(left_in < limit ? left_in : limit), MPI_BYTE, left_in ? here : MPI_PROC_NULL,
                         0, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
        }
    }
}

static void exchange(void *user, const void *send, const size_t *send_bounds, void *receive,
                     const size_t *receive_bounds) {
    (void)user;
    exchange_pieces(send, send_bounds, receive, receive_bounds);
}

static void sum(void *user, uint64_t *values, size_t count) {
    (void)user;
    MPI_Allreduce(MPI_IN_PLACE, values, (int)count, MPI_UINT64_T, MPI_SUM, MPI_COMM_WORLD);
}

/* Whether a launcher of OpenMPI, MPICH or Slurm started this process. */
static bool is_launched(void) {
    return getenv("OMPI_COMM_WORLD_SIZE") || getenv("PMI_SIZE") || getenv("PMIX_RANK");
}

/* Gives this rank its part of the machine's cores and memory, whether the ranks are bound to cores of their
 * own or may run on all. */
static void take_share(MPI_Comm node, int node_ranks, enc_mpi_share *io_share) {
    cpu_set_t mine, all;
    CPU_ZERO(&mine);
    if (sched_getaffinity(0, sizeof mine, &mine) != 0) {
        CPU_SET(0, &mine);
    }
    MPI_Allreduce(&mine, &all, (int)sizeof mine, MPI_BYTE, MPI_BOR, node);
    int count = CPU_COUNT(&mine), total;
    MPI_Allreduce(&count, &total, 1, MPI_INT, MPI_SUM, node);
    const int threads = (int)((long)count * CPU_COUNT(&all) / total);
    io_share->threads = threads > 0 ? threads : 1;
    io_share->memory /= (uint64_t)node_ranks;
}

btf_result enc_mpi_start(btf_log log, enc_ranks **out_ranks, enc_mpi_share *io_share) {
    enc_transport transport = {
        .least = least, .gather = gather, .exchange = exchange, .sum = sum, .broadcast = broadcast};
    int provided;
    MPI_Comm node;
    *out_ranks = NULL;
    if (!is_launched()) {
        return BTF_OK;
    }
    MPI_Init_thread(NULL, NULL, MPI_THREAD_FUNNELED, &provided);
    initialised = true;
    MPI_Comm_size(MPI_COMM_WORLD, &transport.size);
    MPI_Comm_rank(MPI_COMM_WORLD, &transport.rank);
    if (transport.size == 1) {
        return BTF_OK;
    }
    const enc_context context = {.log = log};
    if (provided < MPI_THREAD_FUNNELED) {
        return enc_fail(&context, BTF_ERROR_UNSUPPORTED,
                        "this MPI library does not support programs with threads (MPI_THREAD_FUNNELED)");
    }
    MPI_Comm_split_type(MPI_COMM_WORLD, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &node);
    MPI_Comm_size(node, &transport.node_ranks);
    take_share(node, transport.node_ranks, io_share);
    MPI_Comm_free(&node);
    *out_ranks = enc_ranks_create(&transport);
    if (!*out_ranks) {
        no_memory();
    }
    return BTF_OK;
}

void enc_mpi_stop(enc_ranks **ranks) {
    enc_ranks_destroy(ranks);
    if (initialised) {
        MPI_Finalize();
    }
    initialised = false;
}
