/* Normal equations of the Lafortune fit by variable projection. See normal_equations.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "normal_equations.h"
#include <math.h>
#include <string.h>

enum { MAX_TERMS = 1 + ENC_MAX_LOBES }; /* diffuse term and lobes */

/* colour[c][t] of the Gram point: what the model multiplies the diffuse term and the lobes with. */
static double term_colour(const enc_fit_problem *p, const enc_fit_solution *at, int c, int t) {
    if (p->rgb) {
        return at->colour[c][t];
    }
    return t == 0 ? at->colour[c][0] * at->diffuse : at->colour[c][0];
}

/* Makes the Gram matrix at `at`. Shapes and the weights of RGB lobes are rounded to float in `at` too, so
 * that what follows is computed for the very point that the samples were evaluated at. They are read back
 * after the call: GCC 12 at -O3 with AVX-512 drops the rounding of (double)(float)x where it sees both
 * conversions. */
static void accumulate(enc_fit_problem *p, enc_fit_solution *at) {
    enc_gram_point point = {0};
    for (int j = 0; j < p->lobes; j++) {
        for (int k = 0; k < 4; k++) {
            point.shape[j][k] = (float)at->shape[j][k];
        }
    }
    for (int c = 0; c < 3; c++) {
        for (int t = 0; t <= p->lobes; t++) {
            point.colour[c][t] = (float)term_colour(p, at, c, t);
        }
    }
    enc_gram_accumulate(&p->samples, p->lobes, &point, p->gram);
    p->evaluations++;
    for (int j = 0; j < p->lobes; j++) {
        for (int k = 0; k < 4; k++) {
            at->shape[j][k] = (double)point.shape[j][k];
        }
    }
    for (int c = 0; c < 3 && p->rgb; c++) {
        for (int t = 0; t <= p->lobes; t++) {
            at->colour[c][t] = (double)point.colour[c][t];
        }
    }
}

/* row = G v for v a lobe's value: (Cx, Cy, Cz) on its first three columns (t >= 1), or the diffuse column. */
static void term_row(const enc_fit_problem *p, const enc_fit_solution *at, int t, double *row) {
    const int columns = enc_gram_columns(p->lobes);
    if (t == 0) {
        memcpy(row, p->gram, sizeof *row * (size_t)columns);
        return;
    }
    const double *shape = at->shape[t - 1];
    const double *gram = p->gram + (4 * t) * columns;
    for (int b = 0; b < columns; b++) {
        row[b] = shape[0] * gram[b] + shape[1] * gram[columns + b] + shape[2] * gram[2 * columns + b];
    }
}

/* Dot product of a row of term_row with a term's value. */
static double row_dot_term(const enc_fit_solution *at, const double *row, int t) {
    if (t == 0) {
        return row[0];
    }
    const double *shape = at->shape[t - 1];
    return shape[0] * row[4 * t] + shape[1] * row[4 * t + 1] + shape[2] * row[4 * t + 2];
}

/* Column of the Gram matrix of lobe parameter i (after rho_d, if there is one). */
static int lobe_column(int i) {
    return 4 + i;
}

double enc_fit_overshoot(const enc_gram_samples *samples, const double shape[4], double *out_peak) {
    const float c[3] = {(float)shape[0], (float)shape[1], (float)shape[2]};
    *out_peak = (double)enc_gram_peak(samples, c);
    return log(fmax(fmax(fmax(fabs(shape[0]), fabs(shape[1])), shape[2]) / *out_peak, 1));
}

/* Natural logarithm of the largest value that a lobe of one colour may have at a sample: below 2^40, where
 * powers are cut off, so that no lobe looks flat to the solver without being flat. */
static const double most_peak = 27;

/* Takes lobe j's (Cx, Cy, Cz, ln n) from the solver: n is lowered where the lobe would tower over its own
 * samples elsewhere, or over the range of floats at them, and RGB lobes are scaled to a largest base of 1.
 * The weight carries that scale, so that derivatives need no term for it: the projection takes it out. */
static void take_lobe(const enc_fit_problem *p, const double *lobe, int j, enc_fit_solution *at) {
    double *shape = at->shape[j], peak;
    memcpy(shape, lobe, 3 * sizeof *lobe);
    const double n = exp(lobe[3]), overshoot = enc_fit_overshoot(&p->samples, shape, &peak);
    double most = n * overshoot > p->overshoot[j] ? p->overshoot[j] / overshoot : n;
    if (!p->rgb && most * log(peak) > most_peak) {
        most = most_peak / log(peak);
    }
    at->held[j] = most < n;
    shape[3] = most;
    at->peak[j] = p->rgb ? peak : 1;
    for (int k = 0; k < 3; k++) {
        shape[k] /= at->peak[j];
    }
}

/* d(model) / d(parameter i of the lobes) = factor * column lobe_column(i), for a lobe of weight 1. */
static double lobe_factor(const enc_fit_solution *at, int i) {
    const int j = i / 4;
    if (i % 4 < 3) {
        return at->shape[j][3] / at->peak[j];
    }
    return at->held[j] ? 0 : at->shape[j][3];
}

/* One colour. With g = rho_d + sum_j p_j (times the multiplier), channel c is C_c g - y_c; the best C_c is
 * linear in y, so it is eliminated (variable projection; Golub and Pereyra 1973, with the derivative of
 * Kaufman 1975): residual f_c = C_c g - y_c, derivative C_c (I - g g^T / g^T g) dg. */
static void normal_one_colour(const enc_fit_problem *p, enc_fit_solution *at, double *normal) {
    const int columns = enc_gram_columns(p->lobes), size = 1 + 4 * p->lobes;
    double g[ENC_GRAM_MAX_COLUMNS], row[ENC_GRAM_MAX_COLUMNS];
    for (int b = 0; b < columns; b++) {
        g[b] = at->diffuse * p->gram[b];
    }
    for (int t = 1; t <= p->lobes; t++) {
        term_row(p, at, t, row);
        for (int b = 0; b < columns; b++) {
            g[b] += row[b];
        }
    }
    double gg = at->diffuse * g[0];
    for (int t = 1; t <= p->lobes; t++) {
        gg += row_dot_term(at, g, t);
    }
    double cost = 0, colours = 0, step[3] = {0};
    for (int c = 0; c < 3; c++) {
        const double gr = g[1 + c], rr = p->gram[(1 + c) * columns + 1 + c];
        step[c] = gg > 1e-20 ? -gr / gg : 0;
        step[c] = fmax(step[c], -at->colour[c][0]);
        at->colour[c][0] += step[c];
        cost += fmax(rr + step[c] * (2 * gr + step[c] * gg), 0);
        colours += at->colour[c][0] * at->colour[c][0];
    }
    at->cost = cost;
    const double projection = gg > 1e-20 ? 1 / gg : 0;
    int column[ENC_FIT_MAX_PARAMETERS];
    double factor[ENC_FIT_MAX_PARAMETERS];
    column[0] = 0;
    factor[0] = 1;
    for (int i = 1; i < size; i++) {
        column[i] = lobe_column(i - 1);
        factor[i] = lobe_factor(at, i - 1);
    }
    for (int i = 0; i < size; i++) {
        const double *gram = p->gram + column[i] * columns;
        double right = 0;
        for (int k = 0; k < size; k++) {
            normal[i * (size + 1) + k] = colours * factor[i] * factor[k] *
                                         (gram[column[k]] - g[column[i]] * g[column[k]] * projection);
        }
        for (int c = 0; c < 3; c++) {
            right += at->colour[c][0] * (gram[1 + c] + step[c] * g[column[i]]);
        }
        normal[i * (size + 1) + size] = normal[size * (size + 1) + i] = factor[i] * right;
    }
    normal[size * (size + 1) + size] = cost;
}

/* Solves the symmetric positive system a x = b of `n` unknowns in place by Cholesky; unknowns whose pivot
 * is lost in rounding become 0. */
static void solve_positive(double a[MAX_TERMS][MAX_TERMS], double *b, int n) {
    bool lost[MAX_TERMS];
    for (int i = 0; i < n; i++) {
        const double diagonal = a[i][i];
        for (int k = 0; k < i; k++) {
            if (!lost[k]) {
                a[i][i] -= a[i][k] * a[i][k];
            }
        }
        lost[i] = !(a[i][i] > 1e-9 * diagonal);
        if (lost[i]) {
            b[i] = 0;
            continue;
        }
        a[i][i] = sqrt(a[i][i]);
        for (int r = i + 1; r < n; r++) {
            for (int k = 0; k < i; k++) {
                if (!lost[k]) {
                    a[r][i] -= a[r][k] * a[i][k];
                }
            }
            a[r][i] /= a[i][i];
        }
        for (int k = 0; k < i; k++) {
            if (!lost[k]) {
                b[i] -= a[i][k] * b[k];
            }
        }
        b[i] /= a[i][i];
    }
    for (int i = n - 1; i >= 0; i--) {
        if (lost[i]) {
            continue;
        }
        for (int r = i + 1; r < n; r++) {
            if (!lost[r]) {
                b[i] -= a[r][i] * b[r];
            }
        }
        b[i] /= a[i][i];
    }
}

/* Finds x with terms of `set` alone, the rest 0, at the minimum of x^T m x / 2 - b^T x. */
static void solve_subset(double m[MAX_TERMS][MAX_TERMS], const double *b, int n, unsigned set, double *x) {
    double a[MAX_TERMS][MAX_TERMS], r[MAX_TERMS];
    int index[MAX_TERMS], count = 0;
    for (int i = 0; i < n; i++) {
        x[i] = 0;
        if (set >> i & 1) {
            index[count++] = i;
        }
    }
    for (int i = 0; i < count; i++) {
        r[i] = b[index[i]];
        for (int k = 0; k < count; k++) {
            a[i][k] = m[index[i]][index[k]];
        }
    }
    solve_positive(a, r, count);
    for (int i = 0; i < count; i++) {
        x[index[i]] = r[i];
    }
}

/* Finds the minimum of x^T m x / 2 - b^T x over x >= 0 (Lawson and Hanson 1974). Returns the set of terms
 * in use. */
static unsigned solve_nonnegative(double m[MAX_TERMS][MAX_TERMS], const double *b, int n, double *x) {
    unsigned set = 0;
    memset(x, 0, sizeof *x * (size_t)n);
    for (int round = 0; round < 4 * n; round++) {
        int entering = -1;
        double most = 0;
        for (int i = 0; i < n; i++) {
            double pull = b[i];
            for (int k = 0; k < n; k++) {
                pull -= m[i][k] * x[k];
            }
            pull = m[i][i] > 0 ? pull / sqrt(m[i][i]) : 0;
            if (!(set >> i & 1) && pull > fmax(most, 1e-9 * fabs(b[i]) / sqrt(fmax(m[i][i], 1e-300)))) {
                most = pull;
                entering = i;
            }
        }
        if (entering < 0) {
            break;
        }
        set |= 1u << entering;
        for (int inner = 0; inner < n; inner++) {
            double y[MAX_TERMS], part = 1;
            int leaving = -1;
            solve_subset(m, b, n, set, y);
            for (int i = 0; i < n; i++) {
                if ((set >> i & 1) && y[i] <= 0 && x[i] / fmax(x[i] - y[i], 1e-300) < part) {
                    part = x[i] / fmax(x[i] - y[i], 1e-300);
                    leaving = i;
                }
            }
            for (int i = 0; i < n; i++) {
                x[i] += part * (y[i] - x[i]);
            }
            if (leaving < 0) {
                break;
            }
            x[leaving] = 0;
            set &= ~(1u << leaving);
        }
    }
    return set;
}

/* RGB lobes: channel c is sum_t x_ct V_t - y_c with V_0 the diffuse term and V_j the lobes; the x_ct >= 0
 * are eliminated as above, channel by channel. */
static void normal_rgb(const enc_fit_problem *p, enc_fit_solution *at, double *normal) {
    const int columns = enc_gram_columns(p->lobes), size = 4 * p->lobes, terms = 1 + p->lobes;
    double rows[MAX_TERMS][ENC_GRAM_MAX_COLUMNS], m[MAX_TERMS][MAX_TERMS];
    for (int t = 0; t < terms; t++) {
        term_row(p, at, t, rows[t]);
    }
    for (int t = 0; t < terms; t++) {
        for (int s = 0; s < terms; s++) {
            m[t][s] = row_dot_term(at, rows[t], s);
        }
    }
    memset(normal, 0, sizeof *normal * (size_t)((size + 1) * (size + 1)));
    at->cost = 0;
    for (int c = 0; c < 3; c++) {
        double right[MAX_TERMS], x[MAX_TERMS], step[MAX_TERMS];
        for (int t = 0; t < terms; t++) {
            right[t] = -rows[t][1 + c];
            for (int s = 0; s < terms; s++) {
                right[t] += m[t][s] * at->colour[c][s];
            }
        }
        const unsigned set = solve_nonnegative(m, right, terms, x);
        double cost = p->gram[(1 + c) * columns + 1 + c];
        for (int t = 0; t < terms; t++) {
            step[t] = x[t] - at->colour[c][t];
            at->colour[c][t] = x[t];
        }
        for (int t = 0; t < terms; t++) {
            double half = 2 * rows[t][1 + c];
            for (int s = 0; s < terms; s++) {
                half += m[t][s] * step[s];
            }
            cost += step[t] * half;
        }
        at->cost += fmax(cost, 0);

        /* Projected out: q[i] = M^-1 (V^T column_i) over the terms in use. */
        double derivative[ENC_FIT_MAX_PARAMETERS][MAX_TERMS] = {{0}}, factor[ENC_FIT_MAX_PARAMETERS];
        for (int i = 0; i < size; i++) {
            double b[MAX_TERMS];
            for (int t = 0; t < terms; t++) {
                b[t] = rows[t][lobe_column(i)];
            }
            solve_subset(m, b, terms, set, derivative[i]);
            factor[i] = x[1 + i / 4] * lobe_factor(at, i);
        }
        for (int i = 0; i < size; i++) {
            if (factor[i] == 0) {
                continue;
            }
            const double *gram = p->gram + lobe_column(i) * columns;
            for (int k = 0; k < size; k++) {
                double value = gram[lobe_column(k)];
                for (int t = 0; t < terms; t++) {
                    value -= rows[t][lobe_column(i)] * derivative[k][t];
                }
                normal[i * (size + 1) + k] += factor[i] * factor[k] * value;
            }
            double value = gram[1 + c];
            for (int t = 0; t < terms; t++) {
                value += step[t] * rows[t][lobe_column(i)];
            }
            normal[i * (size + 1) + size] += factor[i] * value;
        }
    }
    for (int i = 0; i < size; i++) {
        normal[size * (size + 1) + i] = normal[i * (size + 1) + size];
    }
    normal[size * (size + 1) + size] = at->cost;
}

/* Sum of the squared residuals at the colours that they were taken at. */
static double residual_energy(const enc_fit_problem *p) {
    const int columns = enc_gram_columns(p->lobes);
    return p->gram[columns + 1] + p->gram[2 * columns + 2] + p->gram[3 * columns + 3];
}

/* Takes residuals at the best colours so far, where they are small, so that the cost is no difference of
 * large float sums; where a far step makes it one all the same, takes them again at the colours just
 * found. */
void enc_fit_evaluate(void *user, const double *parameters, double *out_normal) {
    enc_fit_problem *p = user;
    enc_fit_solution at = p->best;
    const double *lobe = parameters;
    if (!p->rgb) {
        at.diffuse = *lobe++;
    }
    for (int j = 0; j < p->lobes; j++, lobe += 4) {
        take_lobe(p, lobe, j, &at);
    }
    for (int pass = 0; pass < 3; pass++) {
        accumulate(p, &at);
        const double before = residual_energy(p);
        if (p->rgb) {
            normal_rgb(p, &at, out_normal);
        } else {
            normal_one_colour(p, &at, out_normal);
        }
        if (before < 100 * at.cost + 1e-12 * p->energy) {
            break;
        }
    }
    if (at.cost < p->best.cost) {
        p->best = at;
    }
}

bool enc_fit_drop_idle_lobe(enc_fit_problem *p) {
    const int columns = enc_gram_columns(p->lobes);
    enc_fit_solution *at = &p->best;
    accumulate(p, at);
    const double ee = p->gram[0];
    for (int t = 1; t <= p->lobes; t++) {
        double *shape = at->shape[t - 1];
        double row[ENC_GRAM_MAX_COLUMNS], cost = 0, bend = 0, slope = 0, step[3] = {0};
        term_row(p, at, t, row);
        const double pp = row_dot_term(at, row, t);
        for (int c = 0; c < 3; c++) {
            const double w = term_colour(p, at, c, t);
            const double part =
                p->gram[1 + c] - w * row[0]; /* diffuse column . (residual without the lobe) */
            cost += p->gram[(1 + c) * columns + 1 + c] - 2 * w * row[1 + c] + w * w * pp;
            if (p->rgb && ee > 0) {
                step[c] = fmax(-part / ee, -at->colour[c][0]);
                cost += step[c] * (2 * part + step[c] * ee);
            }
            slope += at->colour[c][0] * part;
            bend += at->colour[c][0] * at->colour[c][0] * ee;
        }
        double diffuse_step = 0;
        if (!p->rgb && bend > 0) {
            diffuse_step = fmax(-slope / bend, -at->diffuse);
            cost += diffuse_step * (2 * slope + diffuse_step * bend);
        }
        if (shape[3] > 0 && !(cost > at->cost * (1 + 1e-6) + 1e-10 * p->energy)) {
            memset(shape, 0, 4 * sizeof *shape);
            at->diffuse += diffuse_step;
            for (int c = 0; c < 3; c++) {
                at->colour[c][0] += step[c];
            }
            at->cost = fmax(cost, 0);
            return true;
        }
    }
    return false;
}
