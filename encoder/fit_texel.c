/* The fit of one texel: the Gram matrix of the samples turned into a small least-squares problem with the
 * colours eliminated, Ceres as its solver, and the choice among starts and simpler models.
 *
 * SPDX-License-Identifier: MIT
 */
#include "fit.h"
#include "ceres_bridge.h"
#include "fit_gram.h"
#include <assert.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    MAX_TERMS = 1 + ENC_MAX_LOBES,          /* diffuse term and lobes */
    MAX_PARAMETERS = 1 + 4 * ENC_MAX_LOBES, /* rho_d (one colour only), then (Cx, Cy, Cz, ln n) a lobe */
    MAX_COLUMNS = ENC_GRAM_MAX_COLUMNS,
};

struct enc_fit_workspace {
    size_t max_samples;
    float *memory;    /* seven padded arrays */
    float *arrays[7]; /* product x, y, z, multiplier, target R, G, B */
};

/* A solution in the scale of the search. RGB lobes have their shapes scaled to a largest base of 1 over the
 * samples, so that a weight is a peak; the solver's own (Cx, Cy, Cz) are `peak` times that. */
typedef struct solution {
    double cost;
    double diffuse;                 /* rho_d; one colour only */
    double peak[ENC_MAX_LOBES];     /* RGB lobes only */
    double shape[ENC_MAX_LOBES][4]; /* Cx, Cy, Cz, n */
    double colour[3]
                 [1 + ENC_MAX_LOBES]; /* RGB lobes: diffuse term, lobe weights; one colour: [c][0] = C_c */
} solution;

/* One texel under way. */
typedef struct problem {
    enc_gram_samples samples;
    int lobes;
    bool rgb;
    double scale;                /* targets were divided by this */
    double diffuse_colour[3];    /* the best model without lobes */
    double diffuse_cost, energy; /* its cost; sum of squared targets */
    int evaluations;
    solution best; /* of the start under way */
    double gram[MAX_COLUMNS * MAX_COLUMNS];
} problem;

/* Starting shapes, lobes apart from each other (prototype: identical or azimuth-symmetric ones never part
 * or part slowly). The first set has a mirror lobe and two slanted ones. */
static const double start_shapes[ENC_FIT_MAX_STARTS][ENC_MAX_LOBES][4] = {
    {{-1.0, -1.0, 1.0, 8}, {0.8, -0.3, 0.6, 2}, {-0.3, 0.8, 0.6, 2}, {0.5, 0.5, 0.7, 3}},
    {{-0.9, -0.9, 0.9, 30}, {0.7, 0.7, 0.7, 4}, {-0.5, -0.5, 0.9, 1}, {0.3, -0.8, 0.6, 2}},
    {{0.9, 0.9, 0.9, 12}, {-0.8, 0.3, 0.6, 2}, {0.3, -0.8, 0.6, 2}, {-0.9, -0.9, 0.9, 20}},
    {{-0.7, -0.7, 0.9, 3}, {0.2, 0.2, 1.1, 6}, {0.6, -0.6, 0.5, 1}, {-0.6, 0.6, 0.5, 1}},
};
static const double start_diffuse = 0.8;

btf_result enc_fit_workspace_create(size_t max_samples, enc_fit_workspace **out_workspace) {
    *out_workspace = NULL;
    const size_t padded = (max_samples + ENC_GRAM_BLOCK - 1) / ENC_GRAM_BLOCK * ENC_GRAM_BLOCK;
    if (max_samples == 0 || max_samples > SIZE_MAX / 64) {
        return BTF_ERROR_USAGE;
    }
    enc_fit_workspace *workspace = malloc(sizeof *workspace);
    float *memory = aligned_alloc(64, 7 * padded * sizeof *memory);
    if (workspace == NULL || memory == NULL) {
        free(workspace);
        free(memory);
        return BTF_ERROR_MEMORY;
    }
    workspace->max_samples = max_samples;
    workspace->memory = memory;
    for (size_t i = 0; i < 7; i++) {
        workspace->arrays[i] = memory + i * padded;
    }
    *out_workspace = workspace;
    return BTF_OK;
}

void enc_fit_workspace_destroy(enc_fit_workspace **workspace) {
    if (*workspace != NULL) {
        free((*workspace)->memory);
        free(*workspace);
        *workspace = NULL;
    }
}

/* Copies the samples in, roots of the weights multiplied in and targets scaled to at most 1, and solves the
 * model without lobes. Returns false when all targets are 0. */
static bool load_samples(enc_fit_workspace *workspace, const enc_fit_samples *samples, problem *p) {
    assert(samples->n > 0 && samples->n <= workspace->max_samples);
    float largest = 0;
    for (int c = 0; c < 3; c++) {
        for (size_t i = 0; i < samples->n; i++) {
            if (samples->target[c][i] > largest && (samples->weight == NULL || samples->weight[i] > 0)) {
                largest = samples->target[c][i];
            }
        }
    }
    if (largest == 0) {
        return false;
    }
    const size_t n = samples->n;
    const size_t padded = (n + ENC_GRAM_BLOCK - 1) / ENC_GRAM_BLOCK * ENC_GRAM_BLOCK;
    const double inverse = 1.0 / (double)largest;
    float *const *array = workspace->arrays;
    double aa = 0, at[3] = {0}, tt[3] = {0};
    for (size_t i = 0; i < n; i++) {
        const float root = samples->weight == NULL ? 1.0f : sqrtf(samples->weight[i]);
        const float multiplier = root * samples->multiplier[i];
        array[3][i] = multiplier;
        aa += (double)multiplier * (double)multiplier;
        for (int c = 0; c < 3; c++) {
            const float target = root * (float)((double)samples->target[c][i] * inverse);
            array[4 + c][i] = target;
            at[c] += (double)multiplier * (double)target;
            tt[c] += (double)target * (double)target;
        }
    }
    for (int k = 0; k < 3; k++) {
        memcpy(array[k], samples->product[k], n * sizeof(float));
    }
    for (int k = 0; k < 7; k++) {
        memset(array[k] + n, 0, (padded - n) * sizeof(float));
    }
    p->samples = (enc_gram_samples){
        .n = n,
        .product = {array[0], array[1], array[2]},
        .multiplier = array[3],
        .target = {array[4], array[5], array[6]},
    };
    p->scale = (double)largest;
    p->diffuse_cost = 0;
    p->energy = 0;
    for (int c = 0; c < 3; c++) {
        p->diffuse_colour[c] = aa > 0 ? at[c] / aa : 0;
        p->diffuse_cost += tt[c] - p->diffuse_colour[c] * at[c];
        p->energy += tt[c];
    }
    return true;
}

/* colour[c][t] of the Gram point: what the model multiplies the diffuse term and the lobes with. */
static double term_colour(const problem *p, const solution *at, int c, int t) {
    if (p->rgb) {
        return at->colour[c][t];
    }
    return t == 0 ? at->colour[c][0] * at->diffuse : at->colour[c][0];
}

/* The Gram matrix at `at`; shapes and colours are rounded to float in `at` too, so that what follows is
 * computed for the point evaluated. */
static void accumulate(problem *p, solution *at) {
    enc_gram_point point = {0};
    for (int j = 0; j < p->lobes; j++) {
        for (int k = 0; k < 4; k++) {
            point.shape[j][k] = (float)at->shape[j][k];
            at->shape[j][k] = (double)point.shape[j][k];
        }
    }
    for (int c = 0; c < 3; c++) {
        for (int t = 0; t <= p->lobes; t++) {
            point.colour[c][t] = (float)term_colour(p, at, c, t);
        }
    }
    enc_gram_accumulate(&p->samples, p->lobes, &point, p->gram);
    p->evaluations++;
}

/* row = G v for v a lobe's value: (Cx, Cy, Cz) on its first three columns (t >= 1), or the diffuse column.
 */
static void term_row(const problem *p, const solution *at, int t, double *row) {
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
static double row_dot_term(const solution *at, const double *row, int t) {
    if (t == 0) {
        return row[0];
    }
    const double *shape = at->shape[t - 1];
    return shape[0] * row[4 * t] + shape[1] * row[4 * t + 1] + shape[2] * row[4 * t + 2];
}

/* Column of the Gram matrix and factor of parameter i of lobe parameters (after rho_d, if there is one):
 * d/dC = n * column, d/d(ln n) = n * column. */
static int lobe_column(int i) {
    return 4 + i;
}

/* One colour. With g = rho_d + sum_j p_j (times the multiplier), channel c is C_c g - y_c; the best C_c is
 * linear in y, so it is eliminated (variable projection; Golub and Pereyra 1973, with the derivative of
 * Kaufman 1975): residual f_c = C_c g - y_c, derivative C_c (I - g g^T / g^T g) dg. */
static void normal_one_colour(const problem *p, solution *at, double *normal) {
    const int columns = enc_gram_columns(p->lobes), size = 1 + 4 * p->lobes;
    double g[MAX_COLUMNS], row[MAX_COLUMNS];
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
    int column[MAX_PARAMETERS];
    double factor[MAX_PARAMETERS];
    column[0] = 0;
    factor[0] = 1;
    for (int i = 1; i < size; i++) {
        column[i] = lobe_column(i - 1);
        factor[i] = at->shape[(i - 1) / 4][3];
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

/* x over the terms of `set`, the rest 0: the minimum of x^T m x / 2 - b^T x there. */
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

/* Minimum of x^T m x / 2 - b^T x over x >= 0 (Lawson and Hanson 1974). Returns the set of terms in use. */
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

/* Scales the shapes of RGB lobes to a largest base of 1. The scale of a lobe is its weight's to say, so
 * that derivatives need no term for it: the projection takes it out. */
static void scale_to_peak(const problem *p, solution *at) {
    for (int j = 0; j < p->lobes; j++) {
        double *shape = at->shape[j];
        const float cx = (float)shape[0], cy = (float)shape[1], cz = (float)shape[2];
        const float *px = p->samples.product[0], *py = p->samples.product[1], *pz = p->samples.product[2];
        float peak = ENC_GRAM_MIN_BASE;
#pragma omp simd reduction(max : peak)
        for (size_t i = 0; i < p->samples.n; i++) {
            const float base = cx * px[i] + cy * py[i] + cz * pz[i];
            peak = base > peak ? base : peak;
        }
        at->peak[j] = (double)peak;
        for (int k = 0; k < 3; k++) {
            shape[k] /= at->peak[j];
        }
    }
}

/* RGB lobes: channel c is sum_t x_ct V_t - y_c with V_0 the diffuse term and V_j the lobes; the x_ct >= 0
 * are eliminated as above, channel by channel. */
static void normal_rgb(const problem *p, solution *at, double *normal) {
    const int columns = enc_gram_columns(p->lobes), size = 4 * p->lobes, terms = 1 + p->lobes;
    double rows[MAX_TERMS][MAX_COLUMNS], m[MAX_TERMS][MAX_TERMS];
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
                right[t] += m[t][s] * (double)(float)at->colour[c][s];
            }
        }
        const unsigned set = solve_nonnegative(m, right, terms, x);
        double cost = p->gram[(1 + c) * columns + 1 + c];
        for (int t = 0; t < terms; t++) {
            step[t] = x[t] - (double)(float)at->colour[c][t];
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
        double derivative[MAX_PARAMETERS][MAX_TERMS] = {{0}}, factor[MAX_PARAMETERS];
        for (int i = 0; i < size; i++) {
            double b[MAX_TERMS];
            for (int t = 0; t < terms; t++) {
                b[t] = rows[t][lobe_column(i)];
            }
            solve_subset(m, b, terms, set, derivative[i]);
            factor[i] = x[1 + i / 4] * at->shape[i / 4][3] / (i % 4 < 3 ? at->peak[i / 4] : 1);
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
static double residual_energy(const problem *p) {
    const int columns = enc_gram_columns(p->lobes);
    return p->gram[columns + 1] + p->gram[2 * columns + 2] + p->gram[3 * columns + 3];
}

/* enc_ceres_evaluate: residuals are taken at the best colours so far, where they are small, so that the
 * cost does not come out of a difference of large float sums; where a far step makes it one all the same,
 * they are taken again at the colours just found. */
static void evaluate(void *user, const double *parameters, double *out_normal) {
    problem *p = user;
    solution at = p->best;
    const double *lobe = parameters;
    if (!p->rgb) {
        at.diffuse = *lobe++;
    }
    for (int j = 0; j < p->lobes; j++, lobe += 4) {
        memcpy(at.shape[j], lobe, 3 * sizeof *lobe);
        at.shape[j][3] = exp(lobe[3]);
    }
    if (p->rgb) {
        scale_to_peak(p, &at);
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

/* One descent from p->best (shapes, rho_d; colours 0 or good ones), whose cost is not looked at. */
static btf_result descend(problem *p, const enc_fit_options *options) {
    double parameters[MAX_PARAMETERS], lower[MAX_PARAMETERS], upper[MAX_PARAMETERS];
    int size = 0;
    if (!p->rgb) {
        lower[0] = 0;
        upper[0] = fmax(1e3, p->best.diffuse);
        parameters[size++] = p->best.diffuse;
    }
    for (int j = 0; j < p->lobes; j++) {
        for (int k = 0; k < 4; k++, size++) {
            const double value = p->best.shape[j][k];
            parameters[size] = k < 3 ? value : log(value);
            lower[size] = k < 3 ? fmin(-ENC_FIT_MAX_C, value) : log(fmin(ENC_FIT_MIN_N, value));
            upper[size] = k < 3 ? fmax(ENC_FIT_MAX_C, value) : log(fmax(ENC_FIT_MAX_N, value));
        }
    }
    const enc_ceres_options solver = {
        .parameters = size,
        .lower = lower,
        .upper = upper,
        .tolerance = options->tolerance,
        .max_evaluations = options->max_evaluations,
        .trust_region_radius = 1e4,
    };
    p->best.cost = DBL_MAX;
    enc_ceres_summary summary;
    return enc_ceres_minimize(&solver, evaluate, p, parameters, &summary) ? BTF_OK : BTF_ERROR_MEMORY;
}

/* The fixed start `index`. */
static void fixed_start(problem *p, int index) {
    memset(&p->best, 0, sizeof p->best);
    memcpy(p->best.shape, start_shapes[index], sizeof p->best.shape);
    p->best.diffuse = start_diffuse;
}

/* The caller's parameters in the scale of the search: one colour is moved so that the larger of rho_d and
 * the lobes is about 1, the way a fit leaves it. Lobes that are 0 start small in a fixed shape. */
static void given_start(problem *p, const float *start) {
    memset(&p->best, 0, sizeof p->best);
    const float *shapes = start + (p->rgb ? 3 + 3 * p->lobes : 4);
    double size = p->rgb ? 1 : fmax((double)start[3], 1e-6);
    bool dead[ENC_MAX_LOBES];
    for (int j = 0; j < p->lobes; j++) {
        const float *shape = shapes + 4 * j;
        const double c = fmax(fmax(fabs((double)shape[0]), fabs((double)shape[1])), fabs((double)shape[2]));
        dead[j] = !(c > 0 && shape[3] > 0);
        if (!dead[j] && !p->rgb) {
            size = fmax(size, pow(c, (double)shape[3]));
        }
    }
    size = fmin(fmax(size, 1e-30), 1e30);
    for (int j = 0; j < p->lobes; j++) {
        for (int k = 0; k < 4; k++) {
            const double value = dead[j] ? start_shapes[0][j][k] : (double)shapes[4 * j + k];
            const double factor = dead[j] ? 0.5 : pow(size, -1 / fmax((double)shapes[4 * j + 3], 1e-3));
            p->best.shape[j][k] = k < 3 ? value * factor : value;
        }
    }
    p->best.diffuse = p->rgb ? 0 : (double)start[3] / size;
    for (int c = 0; c < 3; c++) {
        for (int t = 0; t <= p->lobes; t++) {
            p->best.colour[c][t] = p->rgb   ? (double)start[3 * t + c] / p->scale
                                   : t == 0 ? (double)start[c] * size / p->scale
                                            : 0;
        }
    }
}

/* Sets a lobe to 0 whose loss costs next to nothing once the diffuse term is solved anew. True when one was
 * found. */
static bool drop_idle_lobe(problem *p) {
    const int columns = enc_gram_columns(p->lobes);
    solution *at = &p->best;
    accumulate(p, at);
    const double ee = p->gram[0];
    for (int t = 1; t <= p->lobes; t++) {
        double *shape = at->shape[t - 1];
        double row[MAX_COLUMNS], cost = 0, bend = 0, slope = 0, step[3] = {0};
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

/* A parameter as the file may hold it: 0, or of magnitude 2^-24 .. 2^24. */
static float storable(double value) {
    const double magnitude = fabs(value);
    if (!(magnitude >= 0x1p-24)) {
        return 0;
    }
    return (float)copysign(fmin(magnitude, 0x1p24), value);
}

/* One colour: max(C) = 1, its scale goes into rho_d and the lobes. */
static void store_one_colour(const problem *p, const solution *at, float *out) {
    const double largest = fmax(fmax(at->colour[0][0], at->colour[1][0]), at->colour[2][0]);
    const double factor = largest * p->scale;
    if (!(factor > 0)) {
        return;
    }
    for (int c = 0; c < 3; c++) {
        out[c] = storable(at->colour[c][0] / largest);
    }
    out[3] = storable(at->diffuse * factor);
    bool any = out[3] != 0;
    for (int j = 0; j < p->lobes; j++) {
        const double *shape = at->shape[j];
        float *lobe = out + 4 + 4 * j;
        const double grow = shape[3] > 0 ? pow(factor, 1 / shape[3]) : 0;
        for (int k = 0; k < 3; k++) {
            lobe[k] = storable(shape[k] * grow);
        }
        const bool dead = lobe[0] == 0 && lobe[1] == 0 && lobe[2] == 0;
        lobe[3] = dead ? 0 : storable(shape[3]);
        any = any || !dead;
    }
    if (!any) {
        memset(out, 0, sizeof *out * enc_sbrdf_stride(p->lobes, false));
    }
}

/* RGB lobes. */
static void store_rgb(const problem *p, const solution *at, float *out) {
    for (int c = 0; c < 3; c++) {
        out[c] = storable(at->colour[c][0] * p->scale);
    }
    for (int j = 0; j < p->lobes; j++) {
        const double *shape = at->shape[j];
        float *lobe = out + 3 + 3 * p->lobes + 4 * j;
        bool any = false;
        for (int c = 0; c < 3 && shape[3] > 0; c++) {
            out[3 + 3 * j + c] = storable(at->colour[c][1 + j] * p->scale);
            any = any || out[3 + 3 * j + c] != 0;
        }
        for (int k = 0; any && k < 4; k++) {
            lobe[k] = storable(shape[k]);
        }
    }
}

btf_result enc_fit_texel(enc_fit_workspace *workspace, const enc_fit_samples *samples,
                         const enc_fit_options *options, const float *start, int starts,
                         float *out_parameters, enc_fit_result *out_result) {
    assert(options->lobes >= 1 && options->lobes <= ENC_MAX_LOBES);
    assert(starts >= 0 && starts <= ENC_FIT_MAX_STARTS && (start != NULL || starts > 0));
    memset(out_parameters, 0, sizeof *out_parameters * enc_sbrdf_stride(options->lobes, options->rgb));
    *out_result = (enc_fit_result){0};
    problem p = {.lobes = options->lobes, .rgb = options->rgb};
    if (!load_samples(workspace, samples, &p)) {
        return BTF_OK;
    }
    solution best = {.cost = DBL_MAX};
    for (int s = start != NULL ? -1 : 0; s < starts; s++) {
        if (s < 0) {
            given_start(&p, start);
        } else {
            fixed_start(&p, s);
        }
        const btf_result result = descend(&p, options);
        if (result != BTF_OK) {
            return result;
        }
        if (p.best.cost < best.cost) {
            best = p.best;
        }
    }
    if (!(best.cost < p.diffuse_cost * (1 - 1e-6))) {
        memset(&best, 0, sizeof best);
        best.cost = fmax(p.diffuse_cost, 0);
        best.diffuse = 1;
        for (int c = 0; c < 3; c++) {
            best.colour[c][0] = p.diffuse_colour[c];
        }
        out_result->diffuse = true;
        out_result->dead_lobes = p.lobes;
    } else {
        p.best = best;
        while (drop_idle_lobe(&p)) {
            out_result->dead_lobes++;
        }
        best = p.best;
    }
    if (p.rgb) {
        store_rgb(&p, &best, out_parameters);
    } else {
        store_one_colour(&p, &best, out_parameters);
    }
    out_result->cost = best.cost * p.scale * p.scale;
    out_result->evaluations = p.evaluations;
    return BTF_OK;
}
