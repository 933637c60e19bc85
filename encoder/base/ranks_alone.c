/* The ranks of a program that was built without MPI: none (see ranks_mpi.h).
 *
 * SPDX-License-Identifier: MIT
 */
#include "ranks_mpi.h"

#include <stdlib.h>

btf_result enc_mpi_start(btf_log log, enc_ranks **out_ranks, enc_mpi_share *io_share) {
    /* Set by mpirun. Without this check each of its processes would encode the same and write the same file. */
    const char *ranks = getenv("OMPI_COMM_WORLD_SIZE");
    const enc_context context = {.log = log};
    (void)io_share;
    *out_ranks = NULL;
    if (!ranks) {
        ranks = getenv("PMI_SIZE");
    }
    if (ranks && atoi(ranks) > 1) {
        return enc_fail(&context, BTF_ERROR_UNSUPPORTED,
                        "mpirun started %s ranks, but this program was built without MPI", ranks);
    }
    return BTF_OK;
}

void enc_mpi_stop(enc_ranks **ranks) {
    *ranks = NULL;
}

void enc_mpi_set_limit(size_t bytes) {
    (void)bytes;
}
