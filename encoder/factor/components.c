/* The randomised range finder. See components.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "components.h"

#include "encoder/math/linear.h"
#include "encoder/math/symmetric.h"
#include "rows.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Energy, as a share of the first component's, below which even sums in double find nothing. Components
 * below ENC_COMPONENTS_ROUNDING are of use where data have so few that units have codes to spare: the
 * descent corrects the rounding of the strong ones with them. btf-sample flat, 32x32 texels, in 243 kB:
 * 82.5 / 83.1 dB with them, 71.8 / 72.1 without. */
#define LEAST_ENERGY 1e-20

enum { MOST_ROUNDS = 6 };
/* The deviation from which on one round of Cholesky QR does not make rows orthonormal in float. */
#define FAR 0.1

static btf_result no_memory(const enc_factor_matrix *m, size_t rank) {
    return enc_fail(m->context, BTF_ERROR_MEMORY, "factors: out of memory for %zu components", rank);
}

static void fill_random(size_t count, uint32_t seed, float *out) {
    uint64_t state = seed;
    for (size_t i = 0; i < count; i++) {
        state = state * 6364136223846793005u + 1442695040888963407u;
        out[i] = (float)(int32_t)(state >> 32) * 0x1p-31f;
    }
}

/* How far rows are from being orthonormal: the largest deviation of their Gram matrix from the identity. */
static double deviation(size_t rank, const double *gram) {
    double most = 0;
    for (size_t i = 0; i < rank * rank; i++) {
        most = fmax(most, fabs(gram[i] - (i % (rank + 1) == 0)));
    }
    return most;
}

/* Makes rows orthonormal by two rounds of Cholesky QR (Yamamoto, Nakatsukasa, Yanagisawa and Fukaya 2015),
 * whose Gram matrices are in double: the rows of a random product are almost parallel. Where the data have
 * far fewer components than rows are wanted, most rows are rounding of others, and a round or two more are
 * needed. */
bool enc_components_orthonormalise(const enc_factor_matrix *m, size_t rank, size_t count, float *x) {
    double *gram = malloc(2 * rank * rank * sizeof *gram), *inverse = gram ? gram + rank * rank : NULL;
    float *turn = malloc(rank * rank * sizeof *turn);
    bool done = gram && turn;
    bool far = true;
    for (int round = 0; (round < 2 || far) && round < MOST_ROUNDS && done; round++) {
        double trace = 0;
        enc_gram_rows(m->context->threads, rank, count, x, gram);
        far = round == 0 || deviation(rank, gram) > FAR;
        for (size_t i = 0; i < rank; i++) {
            trace += gram[i * rank + i];
        }
        memset(inverse, 0, rank * rank * sizeof *inverse);
        for (size_t i = 0; i < rank; i++) {
            gram[i * rank + i] += 1e-13 * trace + 1e-30;
            inverse[i * rank + i] = 1.0;
        }
        if (trace > 0 && enc_cholesky(rank, gram)) {
            enc_lower_solve(rank, gram, inverse, rank);
            for (size_t i = 0; i < rank * rank; i++) {
                turn[i] = (float)inverse[i];
            }
            done = enc_rows_turn(m->context->threads, rank, rank, turn, count, x, x);
        }
    }
    free(gram);
    free(turn);
    return done;
}

/* Turns orthonormal u, and w = u A, into components, by the eigenvectors of w w^T. */
static bool finish(const enc_factor_matrix *m, const float *u, const float *w, enc_components *io) {
    const size_t sought = io->sought;
    double *gram = malloc(sought * sought * sizeof *gram);
    float *turn = malloc(2 * sought * sought * sizeof *turn),
          *turn_w = turn ? turn + sought * sought : NULL;
    bool done = gram && turn;
    if (done) {
        enc_gram_rows(m->context->threads, sought, m->columns, w, gram);
        done = enc_eigen_symmetric(sought, gram, io->energy);
    }
    io->rank = 0;
    while (done && io->rank < sought && io->energy[io->rank] > LEAST_ENERGY * io->energy[0]) {
        const double root = sqrt(sqrt(io->energy[io->rank])), *row = gram + io->rank * sought;
        for (size_t p = 0; p < sought; p++) {
            turn[io->rank * sought + p] = (float)(row[p] * root);
            turn_w[io->rank * sought + p] = (float)(row[p] / root);
        }
        io->rank++;
    }
    done = done && enc_rows_turn(m->context->threads, io->rank, sought, turn, m->texels, u, io->u) &&
           enc_rows_turn(m->context->threads, io->rank, sought, turn_w, m->columns, w, io->w);
    free(gram);
    free(turn);
    return done;
}

static bool prepare(const enc_factor_matrix *m, size_t rank, uint32_t seed, enc_components *io, float **u,
                    float **w) {
    const size_t side = m->texels < m->columns ? m->texels : m->columns;
    enc_components_clear(io);
    io->sought = rank < side ? rank : side;
    io->u = enc_gemm_alloc(io->sought * m->texels);
    io->w = enc_gemm_alloc(io->sought * m->columns);
    io->energy = calloc(io->sought, sizeof *io->energy);
    *u = enc_gemm_alloc(io->sought * m->texels);
    *w = enc_gemm_alloc(io->sought * m->columns);
    if (*w) {
        fill_random(io->sought * m->columns, seed, *w);
    }
    return io->u && io->w && io->energy && *u && *w;
}

btf_result enc_components_find(const enc_factor_matrix *m, const size_t rank[3], int power_steps,
                               enc_components io[3]) {
    enc_factor_set u = {0}, w = {0};
    btf_result result = BTF_OK;
    for (int c = 0; c < 3; c++) {
        if (rank[c] > 0 && !prepare(m, rank[c], (uint32_t)(c + 1), &io[c], &u.factor[c], &w.factor[c])) {
            result = no_memory(m, rank[c]);
        }
        u.rank[c] = w.rank[c] = rank[c] > 0 ? io[c].sought : 0;
    }
    /* Subspace iteration from random w (Halko, Martinsson and Tropp 2011, algorithm 4.4), orthonormal anew
     * after each product. */
    for (int step = 0; step <= power_steps && result == BTF_OK; step++) {
        result = enc_factor_times_w(m, &w, &u);
        for (int c = 0; c < 3 && result == BTF_OK; c++) {
            result = u.rank[c] == 0 || enc_components_orthonormalise(m, u.rank[c], m->texels, u.factor[c])
                         ? BTF_OK
                         : no_memory(m, u.rank[c]);
        }
        if (result == BTF_OK) {
            result = enc_factor_times_u(m, &u, &w);
        }
        for (int c = 0; c < 3 && result == BTF_OK && step < power_steps; c++) {
            result = w.rank[c] == 0 || enc_components_orthonormalise(m, w.rank[c], m->columns, w.factor[c])
                         ? BTF_OK
                         : no_memory(m, w.rank[c]);
        }
    }
    for (int c = 0; c < 3 && result == BTF_OK; c++) {
        if (u.rank[c] > 0 && !finish(m, u.factor[c], w.factor[c], &io[c])) {
            result = no_memory(m, u.rank[c]);
        }
    }
    for (int c = 0; c < 3; c++) {
        free(u.factor[c]);
        free(w.factor[c]);
    }
    return result;
}

enc_factor_energies enc_components_energies(const enc_components components[3]) {
    enc_factor_energies e = {.rounding = NULL};
    for (int c = 0; c < 3; c++) {
        e.rank[c] = components[c].rank;
        e.energy[c] = components[c].energy;
    }
    return e;
}

btf_result enc_components_copy(const enc_factor_matrix *m, const enc_components from[3],
                               enc_components out[3]) {
    for (int c = 0; c < 3; c++) {
        const size_t rank = from[c].rank;
        out[c] = (enc_components){.rank = rank,
                                  .u = enc_gemm_alloc(rank * m->texels + 1),
                                  .w = enc_gemm_alloc(rank * m->columns + 1),
                                  .energy = malloc((rank + 1) * sizeof *out[c].energy),
                                  .sought = from[c].sought};
        if (!out[c].u || !out[c].w || !out[c].energy) {
            return no_memory(m, rank);
        }
        if (rank > 0) {
            memcpy(out[c].u, from[c].u, rank * m->texels * sizeof *out[c].u);
            memcpy(out[c].w, from[c].w, rank * m->columns * sizeof *out[c].w);
            memcpy(out[c].energy, from[c].energy, rank * sizeof *out[c].energy);
        }
    }
    return BTF_OK;
}

void enc_components_clear(enc_components *c) {
    free(c->u);
    free(c->w);
    free(c->energy);
    *c = (enc_components){0};
}
