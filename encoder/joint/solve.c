/* Least squares of low-rank sources. See solve.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "solve.h"

#include "encoder/base/ranks.h"
#include "encoder/math/linear.h"

#include <math.h>
#include <openbtf/material.h>
#include <stdlib.h>
#include <string.h>

static btf_result out_of_memory(const joint_rows *rows, size_t k) {
    return enc_fail(rows->context, BTF_ERROR_MEMORY,
                    "joint: out of memory for %zu components of %zu points", k, rows->texels * rows->views);
}

enum {
    SOURCES = 96,           /* sources that one task of joint_solve_u handles: a multiple of ENC_GEMM_M */
    WINDOW_BYTES = 64 << 20 /* of what the ranks exchange at once */
};

/* Weight of the present value in each solve, against the trace: keeps what the data do not determine, and
 * since it pulls towards a point that is already there, never raises the error. */
static const double proximal = 1e-7;

/* Everything that the tasks of joint_solve_u share. */
typedef struct u_step {
    const joint_rows *rows;
    const joint_projection *projection;
    float *packed_gram; /* [view][k * k] gram of v, packed as columns */
    const joint_rounding *rounding;
    size_t first, end; /* sources that this process solves */
    float *weights;    /* [source - first][view] sum of squared gains of a source's points */
    float *right;      /* [source - first][k] sum of gain * lower * c over them */
    /* of the view at hand */
    uint32_t *start,
        *order;          /* points by source: of s they are order[start[s]] .. order[start[s + 1] - 1] */
    float *packed_lower; /* lower, packed as rows */
    float *packed_basis; /* the basis of v, packed as rows; with a front */
} u_step;

/* Lists the points of every source in one view, ascending. */
static void invert_view(const joint_model *model, size_t view, uint32_t *start, uint32_t *order) {
    const size_t texels = model->texels;
    const uint32_t *match = model->match + view * texels;
    memset(start, 0, (texels + 1) * sizeof *start);
    for (size_t x = 0; x < texels; x++)
        start[match[x] + 1]++;
    for (size_t s = 0; s < texels; s++)
        start[s + 1] += start[s];
    for (size_t x = 0; x < texels; x++)
        order[start[match[x]]++] = (uint32_t)x;
    for (size_t s = texels; s > 0; s--)
        start[s] = start[s - 1];
    start[0] = 0;
}

/* Floats of scratch that one task takes. */
static size_t u_scratch(const joint_model *model) {
    const size_t k = model->k;
    return SOURCES * (model->views + k + k + k * k + (model->front ? 2 * model->row + k : 0));
}

/* Where the sums of a task's sources go: weights [source], right-hand sides [source][k], each with a pitch.
 */
typedef struct u_sums {
    float *weights, *right;
    size_t weights_pitch, right_pitch;
    bool accumulate; /* of the right-hand sides */
} u_sums;

/* sums[s] -= weight of source first + s * its front in the basis of v. scratch: SOURCES * (2 * row + k)
 * floats. */
static void subtract_fronts(const u_step *step, const joint_model *model, size_t view, size_t first,
                            size_t count, const u_sums *out, float *sums, float *scratch) {
    const size_t k = model->k, row = model->row;
    float *fronts = scratch, *packed = fronts + SOURCES * row, *within = packed + SOURCES * row;
    for (size_t s = 0; s < count; s++)
        if (out->weights[s * out->weights_pitch] > 0.0f)
            joint_front_row(step->rows, model->front, first + s, view, fronts + s * row);
        else
            memset(fronts + s * row, 0, row * sizeof *fronts);
    enc_gemm_pack_rows(count, row, fronts, row, ENC_GEMM_M, packed);
    enc_gemm_multiply(step->rows->tile, count, k, row, packed, step->packed_basis, within, k, 0);
    for (size_t s = 0; s < count; s++)
        for (size_t j = 0; j < k; j++)
            sums[s * k + j] -= out->weights[s * out->weights_pitch] * within[s * k + j];
}

/* u^T gram u - 2 right^T u: the error of a source's points but for a constant. */
static double quadratic(size_t k, const float *gram, const float *right, const float *u) {
    double sum = 0.0;
    for (size_t i = 0; i < k; i++)
        sum += (enc_dot(k, gram + i * k, u) - 2.0 * right[i]) * u[i];
    return sum;
}

/* Makes `count` factors from the one of this number on 0, and their codes. */
static void set_to_zero(const joint_rounding *rounding, size_t first, size_t count, float *factors) {
    memset(factors + first, 0, count * sizeof *factors);
    if (rounding)
        memset(rounding->codes + first, 0, count * sizeof *rounding->codes);
}

/* One source from its Gram matrix and right-hand side. The prior draws u to 0, unless that would raise the
 * error; a source without points stays. Where no pull makes the matrix definite (factors out of a damaged
 * checkpoint, whose products leave the range of floats), u is 0. system: k * k + k doubles of scratch. */
static void solve_source(const u_step *step, joint_model *model, size_t source, const float *gram,
                         const float *right, double *system) {
    const size_t k = model->k;
    double *a = system, *x = system + k * k, trace = 0.0;
    float *u = model->u + source * k, solution[JOINT_MAX_COMPONENTS];
    for (size_t i = 0; i < k; i++)
        trace += gram[i * k + i];
    const double before = quadratic(k, gram, right, u);
    double prior = trace > 0.0 ? model->prior : 0.0, pull = proximal * trace / (double)k + 1e-30;
    for (;;) {
        for (size_t i = 0; i < k * k; i++)
            a[i] = gram[i];
        for (size_t i = 0; i < k; i++) {
            a[i * k + i] += pull + prior;
            x[i] = right[i] + pull * u[i];
        }
        if (!enc_cholesky(k, a)) { /* rounding of the Gram matrix left a negative pivot */
            pull *= 16.0;
            if (isfinite(pull))
                continue;
            set_to_zero(step->rounding, source * k, k, model->u);
            return;
        }
        enc_lower_solve(k, a, x, 1);
        enc_upper_solve(k, a, x, 1);
        for (size_t i = 0; i < k; i++)
            solution[i] = (float)x[i];
        if (prior == 0.0 || quadratic(k, gram, right, solution) <= before)
            break;
        prior = 0.0;
    }
    if (step->rounding)
        enc_round_to_lattice(k, a, step->rounding->step, x, step->rounding->codes + source * k);
    for (size_t i = 0; i < k; i++)
        u[i] = (float)x[i];
}

/* The points of one view, of `count` <= SOURCES sources from `first` on. */
static void gather_sources(const u_step *step, const joint_model *model, size_t view, const float *c,
                           size_t first, size_t count, const u_sums *out, float *scratch) {
    const size_t k = model->k, texels = model->texels, dims = step->projection->dims;
    float *sums = scratch, *packed_sums = sums + SOURCES * k;
    const uint32_t *start = step->start + first;
    const uint8_t *code = model->gain + view * texels;
    memset(sums, 0, SOURCES * k * sizeof *sums);
    for (size_t s = 0; s < count; s++) {
        float weight = 0.0f;
        for (uint32_t i = start[s]; i < start[s + 1]; i++) {
            const float gain = (float)code[step->order[i]] * model->gains.step;
            const float *from = c + step->order[i] * dims;
            weight += gain * gain;
            for (size_t j = 0; j < k; j++)
                sums[s * k + j] += gain * from[j];
        }
        out->weights[s * out->weights_pitch] = weight;
    }
    if (model->front)
        subtract_fronts(step, model, view, first, count, out, sums, packed_sums + SOURCES * k);
    enc_gemm_pack_rows(count, k, sums, k, ENC_GEMM_M, packed_sums);
    enc_gemm_multiply(step->rows->tile, count, k, k, packed_sums, step->packed_lower, out->right,
                      out->right_pitch, out->accumulate);
}

/* Makes ready for gather_sources of one view; *out_c is its coordinates. */
static btf_result prepare_view(u_step *step, const joint_model *model, size_t view, const float **out_c) {
    const joint_rows *rows = step->rows;
    const size_t k = model->k, dims = step->projection->dims;
    const btf_result result = joint_coordinates_view(rows->context, step->projection->c, view, out_c);
    if (result != BTF_OK)
        return result;
    invert_view(model, view, step->start, step->order);
    enc_gemm_pack_rows(k, k, step->projection->lower + view * k * k, k, ENC_GEMM_N, step->packed_lower);
    if (model->front)
        enc_gemm_pack_rows(k, rows->row, step->projection->basis + view * dims * rows->row, rows->row,
                           ENC_GEMM_N, step->packed_basis);
    return BTF_OK;
}

static btf_result gather_views(u_step *step, const joint_model *model, float *scratch) {
    const size_t k = model->k, views = model->views, texels = model->texels;
    btf_result result = BTF_OK;
    for (size_t view = 0; view < views && result == BTF_OK; view++) {
        const float *c;
        result = prepare_view(step, model, view, &c);
        if (result != BTF_OK)
            break;
#pragma omp parallel for schedule(dynamic, 4) num_threads(step->rows->context->threads)
        for (size_t first = 0; first < texels; first += SOURCES) {
            const size_t count = texels - first < SOURCES ? texels - first : SOURCES;
            const u_sums out = {step->weights + first * views + view, step->right + first * k, views, k,
                                true};
            gather_sources(step, model, view, c, first, count, &out,
                           scratch + enc_thread_index() * u_scratch(model));
        }
    }
    return result;
}

/* The exchange of the ranks in one turn: the sums of `window` sources of every rank, by
 * those who have the views. */
typedef struct u_exchange {
    size_t at, window;       /* of each rank's sources: the turn's are from `at` on */
    size_t begin, end;       /* this rank's views */
    float *send;             /* [rank][view - begin][source of that rank][k + 1], the weight last */
    float *receive;          /* [view][source of this rank][k + 1] */
    size_t *sent, *received; /* [rank + 1] bounds, in floats */
} u_exchange;

static size_t least_of(size_t a, size_t b) {
    return a < b ? a : b;
}

/* The sources of a rank whose turn it is. */
static void sources_of_turn(const u_step *step, const u_exchange *e, int rank, size_t *out_first,
                            size_t *out_count) {
    size_t first, end;
    enc_ranks_range_of(step->rows->context, rank, step->rows->texels, &first, &end);
    *out_first = least_of(first + e->at, end);
    *out_count = least_of(e->window, end - *out_first);
}

/* Sums of this rank's views for the sources of all. */
static btf_result fill_turn(u_step *step, const joint_model *model, u_exchange *e, float *scratch) {
    const enc_context *context = step->rows->context;
    const size_t pitch = model->k + 1;
    btf_result result = BTF_OK;
    for (size_t view = e->begin; view < e->end && result == BTF_OK; view++) {
        const float *c;
        result = prepare_view(step, model, view, &c);
        for (int rank = 0; rank < enc_ranks_count(context) && result == BTF_OK; rank++) {
            size_t first, count;
            sources_of_turn(step, e, rank, &first, &count);
            float *to = e->send + e->sent[rank] + (view - e->begin) * count * pitch;
#pragma omp parallel for schedule(dynamic, 4) num_threads(context->threads)
            for (size_t s = 0; s < count; s += SOURCES) {
                float *sums = to + s * pitch;
                const u_sums out = {sums + model->k, sums, pitch, pitch, false};
                gather_sources(step, model, view, c, first + s, least_of(SOURCES, count - s), &out,
                               scratch + enc_thread_index() * u_scratch(model));
            }
        }
    }
    return result;
}

/* Adds what came for this rank's sources, view by view as one process does. */
static void take_turn(const u_step *step, const joint_model *model, const u_exchange *e) {
    const size_t k = model->k, views = model->views;
    size_t first, count;
    sources_of_turn(step, e, enc_ranks_own(step->rows->context), &first, &count);
#pragma omp parallel for num_threads(step->rows->context->threads)
    for (size_t s = 0; s < count; s++) {
        float *restrict right = step->right + (first + s - step->first) * k;
        for (size_t view = 0; view < views; view++) {
            const float *restrict from = e->receive + (view * count + s) * (k + 1);
            for (size_t j = 0; j < k; j++)
                right[j] += from[j];
            step->weights[(first + s - step->first) * views + view] = from[k];
        }
    }
}

static void set_bounds(const u_step *step, const joint_model *model, u_exchange *e) {
    const enc_context *context = step->rows->context;
    size_t first, mine, count, begin, end;
    sources_of_turn(step, e, enc_ranks_own(context), &first, &mine);
    e->sent[0] = e->received[0] = 0;
    for (int rank = 0; rank < enc_ranks_count(context); rank++) {
        sources_of_turn(step, e, rank, &first, &count);
        enc_ranks_range_of(context, rank, model->views, &begin, &end);
        e->sent[rank + 1] = e->sent[rank] + (e->end - e->begin) * count * (model->k + 1);
        e->received[rank + 1] = e->received[rank] + (end - begin) * mine * (model->k + 1);
    }
}

/* gather_views for the ranks: each has the coordinates of its views, and solves its sources. */
static btf_result exchange_views(u_step *step, const joint_model *model, float *scratch) {
    const enc_context *context = step->rows->context;
    const size_t size = (size_t)enc_ranks_count(context), pitch = model->k + 1;
    const size_t longest = (model->texels + size - 1) / size;
    const size_t most = WINDOW_BYTES / (model->views * pitch * sizeof(float));
    u_exchange e = {.window = least_of(longest, most > SOURCES ? most : SOURCES)};
    joint_rows_views(step->rows, &e.begin, &e.end);
    e.sent = malloc(2 * (size + 1) * sizeof *e.sent);
    e.received = e.sent + size + 1;
    e.send = enc_gemm_alloc((e.end - e.begin) * size * e.window * pitch);
    e.receive = enc_gemm_alloc(model->views * e.window * pitch);
    btf_result result = e.sent && e.send && e.receive ? BTF_OK : out_of_memory(step->rows, model->k);
    for (e.at = 0; e.at < longest && result == BTF_OK; e.at += e.window) {
        set_bounds(step, model, &e);
        result = fill_turn(step, model, &e, scratch);
        result = enc_ranks_exchange(context, result, e.send, e.sent, e.receive, e.received);
        if (result == BTF_OK)
            take_turn(step, model, &e);
    }
    free(e.sent);
    free(e.send);
    free(e.receive);
    return result;
}

static void solve_sources(const u_step *step, joint_model *model, size_t first, float *scratch,
                          double *system) {
    const size_t k = model->k, views = model->views, at = first - step->first;
    const size_t count = least_of(SOURCES, step->end - first);
    float *packed_weights = scratch, *gram = packed_weights + SOURCES * views;
    enc_gemm_pack_rows(count, views, step->weights + at * views, views, ENC_GEMM_M, packed_weights);
    enc_gemm_multiply(step->rows->tile, count, k * k, views, packed_weights, step->packed_gram, gram, k * k,
                      0);
    for (size_t s = 0; s < count; s++)
        solve_source(step, model, first + s, gram + s * k * k, step->right + (at + s) * k, system);
}

/* gram [view][k * k] of v, packed as columns. */
static btf_result pack_gram(const joint_rows *rows, const joint_projection *projection, size_t k,
                            float *gram, float *packed_gram) {
    size_t begin, end;
    joint_rows_views(rows, &begin, &end);
#pragma omp parallel for schedule(dynamic) num_threads(rows->context->threads)
    for (size_t view = begin; view < end; view++) {
        const float *lower = projection->lower + view * k * k;
        for (size_t i = 0; i < k; i++)
            for (size_t j = 0; j < k; j++) {
                double sum = 0.0;
                for (size_t p = 0; p <= (i < j ? i : j); p++)
                    sum += (double)lower[i * k + p] * lower[j * k + p];
                gram[(view * k + i) * k + j] = (float)sum;
            }
    }
    const btf_result result = joint_rows_gather(rows, BTF_OK, gram, k * k * sizeof *gram);
    if (result == BTF_OK)
        enc_gemm_pack_columns(k * k, rows->views, gram, k * k, ENC_GEMM_N, packed_gram);
    return result;
}

/* The sources that the ranks have solved, to all. */
static btf_result share_sources(const u_step *step, joint_model *model, btf_result result) {
    const enc_context *context = step->rows->context;
    result = enc_ranks_gather(context, result, model->u, model->k * sizeof *model->u, model->texels);
    if (step->rounding)
        result = enc_ranks_gather(context, result, step->rounding->codes, model->k, model->texels);
    return result;
}

btf_result joint_solve_u(const joint_rows *rows, const joint_projection *projection,
                         const joint_rounding *rounding, joint_model *model) {
    const size_t k = model->k, views = model->views, texels = model->texels;
    const size_t threads = (size_t)rows->context->threads, panels = enc_gemm_panels(k, ENC_GEMM_N);
    u_step step = {.rows = rows,
                   .projection = projection,
                   .packed_gram = enc_gemm_alloc(enc_gemm_panels(k * k, ENC_GEMM_N) * ENC_GEMM_N * views),
                   .rounding = rounding,
                   .start = malloc((texels + 1) * sizeof(uint32_t)),
                   .order = malloc(texels * sizeof(uint32_t)),
                   .packed_lower = enc_gemm_alloc(panels * ENC_GEMM_N * k),
                   .packed_basis = enc_gemm_alloc(model->front ? panels * ENC_GEMM_N * model->row : 0)};
    enc_ranks_range(rows->context, texels, &step.first, &step.end);
    step.weights = malloc((step.end - step.first + 1) * views * sizeof(float));
    step.right = calloc((step.end - step.first + 1) * k, sizeof(float));
    float *gram = enc_gemm_alloc(views * k * k);
    float *scratch = enc_gemm_alloc(threads * u_scratch(model));
    double *system = malloc(threads * (k * k + k) * sizeof *system);
    btf_result result = BTF_OK;
    if (!step.packed_gram || !step.weights || !step.right || !step.start || !step.order ||
        !step.packed_lower || !step.packed_basis || !gram || !scratch || !system) {
        result = out_of_memory(rows, k);
        goto fail;
    }
    result = pack_gram(rows, projection, k, gram, step.packed_gram);
    if (result == BTF_OK)
        result = enc_ranks_count(rows->context) > 1 ? exchange_views(&step, model, scratch)
                                                    : gather_views(&step, model, scratch);
    if (result != BTF_OK)
        goto fail;
#pragma omp parallel for schedule(dynamic) num_threads(rows->context->threads)
    for (size_t first = step.first; first < step.end; first += SOURCES) {
        const size_t thread = enc_thread_index();
        solve_sources(&step, model, first, scratch + thread * u_scratch(model),
                      system + thread * (k * k + k));
    }
    result = share_sources(&step, model, result);
fail:
    free(step.packed_gram);
    free(step.weights);
    free(step.right);
    free(step.start);
    free(step.order);
    free(step.packed_lower);
    free(step.packed_basis);
    free(gram);
    free(scratch);
    free(system);
    return result;
}

/* The data of a pass that gathers the right-hand sides of v. */
typedef struct v_pass {
    const joint_rows *rows;
    const joint_model *model;
    float *right;   /* [view][k][row] sum of gain * u * row */
    float *gram;    /* [view][k][k] sum of gain^2 * u * u^T */
    float *scratch; /* [thread] */
    size_t scratch_pitch;
    const joint_rounding *rounding;
} v_pass;

static void gather_block(void *user, size_t view, size_t first, size_t count, const float *block) {
    const v_pass *pass = user;
    const joint_model *model = pass->model;
    const size_t k = model->k, row = model->row;
    const size_t k_left = enc_gemm_panels(k, ENC_GEMM_M) * ENC_GEMM_M;
    const size_t row_right = enc_gemm_panels(row, ENC_GEMM_N) * ENC_GEMM_N;
    float *left = pass->scratch + enc_thread_index() * pass->scratch_pitch;
    float *right = left + JOINT_BLOCK * k_left, *scaled = right + JOINT_BLOCK * row_right;
    float *rest = scaled + JOINT_BLOCK * k, front[3 * ENC_MAX_DIRECTIONS];
    const uint32_t *match = model->match + view * model->texels + first;
    const uint8_t *code = model->gain + view * model->texels + first;
    for (size_t i = 0; i < count; i++) {
        const float gain = (float)code[i] * model->gains.step;
        for (size_t j = 0; j < k; j++)
            scaled[i * k + j] = gain * model->u[match[i] * k + j];
        if (!model->front)
            continue;
        joint_front_row(pass->rows, model->front, match[i], view, front);
        for (size_t p = 0; p < row; p++)
            rest[i * row + p] = block[i * row + p] - gain * front[p];
    }
    block = model->front ? rest : block;
    enc_gemm_pack_columns(k, count, scaled, k, ENC_GEMM_M, left);
    enc_gemm_pack_columns(row, count, block, row, ENC_GEMM_N, right);
    enc_gemm_multiply(pass->rows->tile, k, row, count, left, right, pass->right + view * k * row, row, 1);
    enc_gemm_pack_columns(k, count, scaled, k, ENC_GEMM_N, right);
    enc_gemm_multiply(pass->rows->tile, k, k, count, left, right, pass->gram + view * k * k, k, 1);
}

/* Solves and, if asked, rounds v of one view. Components are taken in reverse, so that the first ones,
 * which matter most, are rounded first and those behind them absorb what that costs. */
static bool solve_view(const v_pass *pass, joint_model *model, size_t view) {
    const size_t k = model->k, row = model->row;
    double *a = malloc((k * k + k * row + 2 * k) * sizeof *a), trace = 0.0;
    int8_t codes[JOINT_MAX_COMPONENTS];
    if (!a)
        return false;
    double *x = a + k * k, *column = x + k * row, *step = column + k;
    float *v = model->v + view * k * row;
    for (size_t i = 0; i < k; i++)
        trace += pass->gram[(view * k + i) * k + i];
    for (double pull = proximal * trace / (double)k + 1e-30;;
         pull *= 16.0) { /* until no pivot is negative */
        for (size_t i = 0; i < k; i++) {
            for (size_t j = 0; j < k; j++)
                a[i * k + j] = pass->gram[(view * k + k - 1 - i) * k + k - 1 - j];
            a[i * k + i] += pull;
            for (size_t p = 0; p < row; p++)
                x[i * row + p] =
                    pass->right[(view * k + k - 1 - i) * row + p] + pull * v[(k - 1 - i) * row + p];
        }
        if (enc_cholesky(k, a))
            break;
        if (!isfinite(pull)) { /* as in solve_source */
            set_to_zero(pass->rounding, view * k * row, k * row, model->v);
            free(a);
            return true;
        }
    }
    enc_lower_solve(k, a, x, row);
    enc_upper_solve(k, a, x, row);
    for (size_t p = 0; p < row && pass->rounding; p++) {
        for (size_t i = 0; i < k; i++) {
            column[i] = x[i * row + p];
            step[i] = pass->rounding->step[k - 1 - i] * pass->rows->multiplier[p];
        }
        enc_round_to_lattice(k, a, step, column, codes);
        for (size_t i = 0; i < k; i++) {
            x[i * row + p] = column[i];
            pass->rounding->codes[(view * k + k - 1 - i) * row + p] = codes[i];
        }
    }
    for (size_t i = 0; i < k; i++)
        for (size_t p = 0; p < row; p++)
            v[(k - 1 - i) * row + p] = (float)x[i * row + p];
    free(a);
    return true;
}

btf_result joint_solve_v(const joint_rows *rows, const joint_rounding *rounding, joint_model *model) {
    const size_t k = model->k, row = model->row, threads = (size_t)rows->context->threads;
    v_pass pass = {.rows = rows,
                   .model = model,
                   .rounding = rounding,
                   .scratch_pitch = JOINT_BLOCK * (enc_gemm_panels(k, ENC_GEMM_M) * ENC_GEMM_M +
                                                   (enc_gemm_panels(row, ENC_GEMM_N) + 4) * ENC_GEMM_N +
                                                   2 * k + (model->front ? row : 0))};
    pass.right = calloc(rows->views * k * row, sizeof(float));
    pass.gram = calloc(rows->views * k * k, sizeof(float));
    pass.scratch = enc_gemm_alloc(threads * pass.scratch_pitch);
    size_t begin, end;
    joint_rows_views(rows, &begin, &end);
    bool ok = pass.right && pass.gram && pass.scratch;
    btf_result result = ok ? joint_rows_pass(rows, gather_block, &pass) : BTF_OK;
    if (ok && result == BTF_OK)
#pragma omp parallel for schedule(dynamic) num_threads(rows->context->threads)
        for (size_t view = begin; view < end; view++)
            if (!solve_view(&pass, model, view)) {
#pragma omp atomic write
                ok = false;
            }
    free(pass.right);
    free(pass.gram);
    free(pass.scratch);
    if (!ok)
        result = out_of_memory(rows, k);
    result = joint_rows_gather(rows, result, model->v, k * row * sizeof *model->v);
    if (rounding)
        result = joint_rows_gather(rows, result, rounding->codes, k * row);
    return result;
}
