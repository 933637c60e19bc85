/* The ranks of a process that mpirun started.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_RANKS_MPI_H
#define OPENBTF_ENCODER_RANKS_MPI_H

#include "ranks.h"

/* The part of its machine that a rank takes unless options say otherwise. */
typedef struct enc_mpi_share {
    int threads;     /* this rank's part of the cores that the ranks of this machine may run on */
    uint64_t memory; /* bytes: half of the machine's, divided by the ranks on it */
} enc_mpi_share;

/* Joins the ranks that were started together. *out_ranks is NULL for a process that is alone, and MPI is
 * not even initialised where no launcher started it. Errors, logged: BTF_ERROR_UNSUPPORTED (several ranks,
 * and this program was built without MPI, or MPI without threads), BTF_ERROR_MEMORY. */
btf_result enc_mpi_start(btf_log log, enc_ranks **out_ranks, enc_mpi_share *io_share);
/* Ends this process's part in MPI and destroys the object. Every rank calls it before it ends. */
void enc_mpi_stop(enc_ranks **ranks);

/* Sets the largest transfer that is sent as one message, in bytes; 0: what MPI's int holds. For tests. */
void enc_mpi_set_limit(size_t bytes);

#endif
