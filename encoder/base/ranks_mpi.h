/* The ranks of a process that mpirun started.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_RANKS_MPI_H
#define OPENBTF_ENCODER_RANKS_MPI_H

#include "ranks.h"

/* The part of its machine that a rank takes, where options do not say. */
typedef struct enc_mpi_share {
    int threads;     /* cores of this rank: of those that the ranks here may run on together, its part */
    uint64_t memory; /* bytes: half of the machine's, divided by the ranks here */
} enc_mpi_share;

/* Joins the ranks that were started together. *out_ranks is NULL for a process that is alone, and MPI is
 * not even initialised where no launcher started it. Errors, logged: BTF_ERROR_UNSUPPORTED (several ranks,
 * and this program was built without MPI, or MPI without threads), BTF_ERROR_MEMORY. */
btf_result enc_mpi_start(btf_log log, enc_ranks **out_ranks, enc_mpi_share *io_share);
/* Leaves them, as every rank does at its end; destroys the object. */
void enc_mpi_stop(enc_ranks **ranks);

/* The largest transfer that is one message, in bytes; 0: what MPI's int holds. For tests. */
void enc_mpi_set_limit(size_t bytes);

#endif
