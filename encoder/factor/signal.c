/* Bi-cross-validation (Owen and Perry 2009). See signal.h.
 *
 * With D the samples of the rows and columns that stay, A those that are left out of both, B the left-out
 * rows at the columns that stay, C the other way round, and D = U S V^T: A is predicted by (B V) S^-1 (U^T
 * C), component by component, so that one decomposition serves all ranks.
 *
 * SPDX-License-Identifier: MIT
 */
#include "signal.h"

#include "encoder/base/stage.h"
#include "encoder/math/symmetric.h"
#include "rows.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { LEFT_OUT = 4 /* one row and column of so many */ };

static btf_result no_memory(const enc_factor_matrix *m) {
    return enc_fail(m->context, BTF_ERROR_MEMORY, "factors: out of memory for cross-validation");
}

/* The spiked model (Benaych-Georges and Nadakuditi 2012).
 * ------------------------------------------------------------------------------------------------ */

double enc_signal_share(double x2, double rows, double columns, bool left_out) {
    const double beta = fmin(rows, columns) / fmax(rows, columns), x4 = x2 * x2;
    if (x4 <= beta) {
        return -1; /* the component is noise alone */
    }
    const double y2 = (x2 + 1) * (x2 + beta) / x2;
    const double of_short = (x4 - beta) / (x4 + beta * x2), of_long = (x4 - beta) / (x4 + x2);
    const double met = sqrt(x2 / y2 * of_short * of_long); /* x cu cv / y */
    if (!left_out) {
        return 2 * met - 1;
    }
    return (2 * x2 * met - (x2 * of_long + beta) * (x2 * of_short + 1) / y2) / y2;
}

/* The share of a component at the full size, given that a block shows `share` at left-out samples. */
static double full_share(double share, double rows, double columns, double all_rows, double all_columns) {
    double low = sqrt(fmin(rows, columns) / fmax(rows, columns)), high = 1e12;
    if (share >= enc_signal_share(high, rows, columns, true)) {
        return 1;
    }
    for (int i = 0; i < 80; i++) {
        const double middle = sqrt(low * high);
        if (enc_signal_share(middle, rows, columns, true) < share) {
            low = middle;
        } else {
            high = middle;
        }
    }
    return enc_signal_share(low * fmin(all_rows, all_columns) / fmin(rows, columns), all_rows, all_columns,
                            false);
}

/* Averages runs so that gain over energy does not rise, by pooling adjacent violators (Ayer et al. 1955). */
static bool pool(size_t n, const double *gain, const double *energy, double *out) {
    double *gains = malloc((2 * n + 1) * sizeof *gains), *energies = gains + n;
    size_t *sizes = malloc((n + 1) * sizeof *sizes), runs = 0, at = 0;
    const bool room = gains && sizes;
    for (size_t j = 0; j < n && room; j++) {
        gains[runs] = gain[j];
        energies[runs] = energy[j];
        sizes[runs++] = 1;
        while (runs > 1 && gains[runs - 1] * energies[runs - 2] >= gains[runs - 2] * energies[runs - 1]) {
            gains[runs - 2] += gains[runs - 1];
            energies[runs - 2] += energies[runs - 1];
            sizes[runs - 2] += sizes[runs - 1];
            runs--;
        }
    }
    for (size_t r = 0; r < runs; r++) {
        for (size_t i = 0; i < sizes[r]; i++) {
            out[at++] = gains[r] / energies[r];
        }
    }
    free(gains);
    free(sizes);
    return room;
}

/* Blocks.
 * ------------------------------------------------------------------------------------------------ */

typedef struct blocks {
    const enc_factor_matrix *all;
    enc_factor_matrix kept, left_out; /* rows */
    uint32_t *rows;                   /* of both */
    uint8_t *column_left_out;         /* [column] */
    size_t columns_left_out;
    enc_factor_set first, second, of_rows; /* [rank][column] twice, [rank][row] */
    double *squares[ENC_FACTOR_CHANNELS];  /* [rank] of the singular values of the block kept */
} blocks;

static bool is_left_out(size_t i, uint32_t seed) {
    uint64_t x = (i + 1) * 0x9e3779b97f4a7c15u + seed;
    x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9u;
    x = (x ^ x >> 27) * 0x94d049bb133111ebu;
    return (x ^ x >> 31) % LEFT_OUT == 0;
}

static void choose_rows(blocks *b) {
    const size_t texels = b->all->texels;
    const size_t count = texels < ENC_SIGNAL_MOST_TEXELS ? texels : ENC_SIGNAL_MOST_TEXELS;
    size_t n[2] = {0, 0};
    for (int out = 0; out < 2; out++) {
        for (size_t i = 0; i < count; i++) {
            const size_t texel = (size_t)((double)i * (double)texels / (double)count);
            if (is_left_out(texel, 1) == (out == 1)) {
                b->rows[n[0] + n[1]] = (uint32_t)texel;
                n[out]++;
            }
        }
    }
    b->kept.texels = n[0];
    b->left_out.texels = n[1];
    b->kept.list = b->rows;
    b->left_out.list = b->rows + n[0];
}

static bool create(const enc_factor_matrix *m, const enc_components components[3], const bool asked[3],
                   blocks *b) {
    *b = (blocks){.all = m, .kept = *m, .left_out = *m};
    b->rows = malloc(m->texels * sizeof *b->rows);
    b->column_left_out = malloc(m->columns);
    if (!b->rows || !b->column_left_out) {
        return false;
    }
    choose_rows(b);
    for (size_t i = 0; i < m->columns; i++) {
        b->column_left_out[i] = is_left_out(i, 2);
        b->columns_left_out += b->column_left_out[i];
    }
    bool room = true;
    for (int c = 0; c < ENC_FACTOR_CHANNELS && room; c++) {
        size_t rank = components[c].rank < b->kept.texels ? components[c].rank : b->kept.texels;
        const size_t columns = m->columns - b->columns_left_out;
        rank = rank < columns ? rank : columns;
        b->first.rank[c] = b->second.rank[c] = b->of_rows.rank[c] = rank;
        if (!asked[c]) {
            b->first.rank[c] = b->second.rank[c] = b->of_rows.rank[c] = 0;
        } else if (rank > 0) {
            b->first.factor[c] = enc_gemm_alloc(rank * m->columns);
            b->second.factor[c] = enc_gemm_alloc(rank * m->columns);
            b->of_rows.factor[c] = enc_gemm_alloc(rank * b->kept.texels);
            b->squares[c] = malloc(rank * sizeof(double));
            room = b->first.factor[c] && b->second.factor[c] && b->of_rows.factor[c] && b->squares[c];
        }
    }
    return room;
}

static void clear(blocks *b) {
    for (int c = 0; c < ENC_FACTOR_CHANNELS; c++) {
        free(b->first.factor[c]);
        free(b->second.factor[c]);
        free(b->of_rows.factor[c]);
        free(b->squares[c]);
    }
    free(b->rows);
    free(b->column_left_out);
}

/* Copies rows [rank][column], with 0 at the columns that are not of the kind: left out, or kept. */
static void copy_columns(const blocks *b, size_t rank, const float *from, bool left_out, float *to) {
    const size_t columns = b->all->columns;
#pragma omp parallel for schedule(static) num_threads(b->all->context->threads)
    for (size_t j = 0; j < rank; j++) {
        for (size_t i = 0; i < columns; i++) {
            to[j * columns + i] = b->column_left_out[i] == left_out ? from[j * columns + i] : 0.0f;
        }
    }
}

/* From first = U0^T of the rows kept, at all columns: second = V^T, first = S^-1 U^T C. */
static bool decompose(blocks *b, int c) {
    const size_t rank = b->first.rank[c], columns = b->all->columns;
    const int threads = b->all->context->threads;
    double *gram = malloc(rank * rank * sizeof *gram);
    float *turn = malloc(rank * rank * sizeof *turn);
    bool done = gram && turn;
    if (done) {
        copy_columns(b, rank, b->first.factor[c], false, b->second.factor[c]);
        enc_gram_rows(threads, rank, columns, b->second.factor[c], gram);
        done = enc_eigen_symmetric(rank, gram, b->squares[c]);
    }
    for (size_t i = 0; i < (done ? rank : 0); i++) {
        const double square = b->squares[c][i];
        const double inverse = square > 1e-11 * b->squares[c][0] ? 1 / sqrt(square) : 0;
        for (size_t j = 0; j < rank; j++) {
            turn[i * rank + j] = (float)(gram[i * rank + j] * inverse);
        }
    }
    if (done) {
        copy_columns(b, rank, b->first.factor[c], true, b->first.factor[c]);
        done =
            enc_rows_turn(threads, rank, rank, turn, columns, b->second.factor[c], b->second.factor[c]) &&
            enc_rows_turn(threads, rank, rank, turn, columns, b->first.factor[c], b->first.factor[c]);
    }
    free(gram);
    free(turn);
    return done;
}

/* Fits components to the block that is kept. The search starts from the components of all samples; that
 * those have seen the left-out samples changes its result in second order only. */
static btf_result fit(blocks *b, const enc_components components[3]) {
    const enc_factor_matrix *m = &b->kept;
    for (int c = 0; c < ENC_FACTOR_CHANNELS; c++) {
        copy_columns(b, b->first.rank[c], components[c].w, false, b->first.factor[c]);
    }
    btf_result result = enc_factor_times_w(m, &b->first, &b->of_rows);
    for (int c = 0; c < ENC_FACTOR_CHANNELS && result == BTF_OK; c++) {
        const size_t rank = b->first.rank[c];
        result = rank == 0 || enc_components_orthonormalise(m, rank, m->texels, b->of_rows.factor[c])
                     ? BTF_OK
                     : no_memory(m);
    }
    if (result == BTF_OK) {
        result = enc_factor_times_u(m, &b->of_rows, &b->first);
    }
    for (int c = 0; c < ENC_FACTOR_CHANNELS && result == BTF_OK; c++) {
        result = b->first.rank[c] == 0 || decompose(b, c) ? BTF_OK : no_memory(m);
    }
    return result;
}

/* Finds the gains at left-out samples, component by component: 2 p_i A q_i - |p_i q_i|^2 - 2 sum over j < i
 * of (p_i p_j) (q_i q_j), with p = B V and q = S^-1 U^T C; product: p A at left-out columns. */
static bool find_gains(const blocks *b, int c, const float *product, double *gain) {
    const size_t rank = b->first.rank[c], columns = b->all->columns;
    const int threads = b->all->context->threads;
    const float *q = b->first.factor[c];
    double *p_gram = malloc(2 * rank * rank * sizeof *p_gram), *q_gram = p_gram + rank * rank;
    if (p_gram) {
        enc_gram_rows(threads, rank, b->left_out.texels, b->of_rows.factor[c], p_gram);
        enc_gram_rows(threads, rank, columns, q, q_gram);
        for (size_t i = 0; i < rank; i++) {
            double sum = 0;
            for (size_t k = 0; k < columns; k++) {
                sum += (double)product[i * columns + k] * q[i * columns + k];
            }
            gain[i] = 2 * sum - p_gram[i * rank + i] * q_gram[i * rank + i];
            for (size_t j = 0; j < i; j++) {
                gain[i] -= 2 * p_gram[i * rank + j] * q_gram[i * rank + j];
            }
        }
    }
    free(p_gram);
    return p_gram != NULL;
}

/* Finds the shares of a channel's components from the gains at left-out samples. */
static bool find_shares(const blocks *b, int c, size_t found, const double *gain, enc_signal *out) {
    const size_t rank = b->first.rank[c];
    const double rows = (double)b->kept.texels, columns = (double)(b->all->columns - b->columns_left_out);
    const double scale = (double)b->left_out.texels * (double)b->columns_left_out /
                         (rows * columns); /* from the samples kept to those left out */
    double *energy = malloc((rank + 1) * sizeof *energy);
    for (size_t j = 0; j < rank && energy; j++) {
        energy[j] = scale * fmax(b->squares[c][j], 1e-30);
    }
    const bool room = energy && pool(rank, gain, energy, out->share[c]);
    for (size_t j = 0; j < rank && room; j++) {
        out->share[c][j] =
            full_share(out->share[c][j], rows, columns, (double)b->all->texels, (double)b->all->columns);
        out->rank[c] += out->share[c][j] > 0;
    }
    for (size_t j = rank; j < found && room; j++) {
        out->share[c][j] = rank > 0 ? fmin(out->share[c][rank - 1], 0) : 0;
    }
    free(energy);
    return room;
}

static btf_result judge(blocks *b, const enc_components components[3], const bool asked[3],
                        enc_signal *out) {
    const enc_factor_matrix *m = &b->left_out;
    double floor[ENC_FACTOR_CHANNELS];
    for (int c = 0; c < ENC_FACTOR_CHANNELS; c++) {
        free(b->of_rows.factor[c]);
        b->of_rows.factor[c] = enc_gemm_alloc(b->of_rows.rank[c] * m->texels);
        if (!b->of_rows.factor[c]) {
            return no_memory(m);
        }
    }
    btf_result result = enc_factor_times_w(m, &b->second, &b->of_rows);
    if (result == BTF_OK) {
        result = enc_factor_times_u(m, &b->of_rows, &b->second);
    }
    for (int c = 0; c < ENC_FACTOR_CHANNELS && result == BTF_OK; c++) {
        if (!asked[c]) {
            continue;
        }
        double *gain = malloc((b->first.rank[c] + 1) * sizeof *gain);
        const bool room = gain && find_gains(b, c, b->second.factor[c], gain) &&
                          find_shares(b, c, components[c].rank, gain, out);
        result = room ? BTF_OK : no_memory(m);
        free(gain);
        /* the floor is the error of the components that gain, so that the others are cut off before it */
        b->of_rows.rank[c] = b->first.rank[c] =
            out->rank[c] < b->first.rank[c] ? out->rank[c] : b->first.rank[c];
    }
    if (result == BTF_OK) {
        result = enc_factor_residual(m, &b->of_rows, &b->first, b->column_left_out, floor);
    }
    for (int c = 0; c < ENC_FACTOR_CHANNELS && result == BTF_OK; c++) {
        if (asked[c]) {
            out->floor[c] = floor[c] * (double)b->all->texels * (double)b->all->columns /
                            ((double)m->texels * (double)b->columns_left_out);
        }
    }
    return result;
}

/* Whether the data are too small to predict left-out samples: detail looks like noise then, and such data
 * take few bytes anyway. */
static bool is_small(const enc_factor_matrix *m) {
    return m->texels * m->columns < ENC_SIGNAL_LEAST_SAMPLES || m->texels < 4 * LEFT_OUT ||
           m->columns < 4 * LEFT_OUT;
}

/* Makes room for the shares of the channels asked for. */
static bool begin(const enc_components components[3], const bool asked[3], enc_signal *io) {
    bool room = true;
    for (int c = 0; c < ENC_FACTOR_CHANNELS; c++) {
        if (asked[c]) {
            free(io->share[c]);
            io->share[c] = malloc((components[c].rank + 1) * sizeof(double));
            io->rank[c] = 0;
            room = room && io->share[c];
        }
    }
    return room;
}

btf_result enc_signal_find(const enc_factor_matrix *m, const enc_components components[3],
                           const bool asked[3], enc_signal *io) {
    blocks b;
    bool room = begin(components, asked, io);
    if (room && is_small(m)) {
        for (int c = 0; c < ENC_FACTOR_CHANNELS; c++) {
            const double *energy = components[c].energy;
            for (size_t j = 0;
                 asked[c] && j < components[c].rank && energy[j] > ENC_COMPONENTS_ROUNDING * energy[0]; j++) {
                io->share[c][j] = 1;
                io->rank[c] = j + 1;
            }
        }
        return BTF_OK;
    }
    room = create(m, components, asked, &b) && room;
    btf_result result = room ? BTF_OK : no_memory(m);
    if (room) {
        enc_stage_begin(m->context, "cross-validate", 2 * b.kept.texels + 3 * b.left_out.texels);
        result = fit(&b, components);
        if (result == BTF_OK) {
            result = judge(&b, components, asked, io);
        }
        enc_stage_end(m->context);
    }
    clear(&b);
    return result;
}

void enc_signal_clear(enc_signal *s) {
    for (int c = 0; c < ENC_FACTOR_CHANNELS; c++) {
        free(s->share[c]);
    }
    *s = (enc_signal){0};
}
