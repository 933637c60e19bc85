/* Least squares of low-rank sources (see joint_sources.h).
 *
 * SPDX-License-Identifier: MIT
 */
#include "joint_sources.h"
#include "joint_linear.h"

#include <openbtf/material.h>

#include <stdlib.h>
#include <string.h>

static btf_result out_of_memory(const joint_rows *rows, size_t k) {
    return enc_fail(rows->context, BTF_ERROR_MEMORY,
                    "joint: out of memory for %zu components of %zu points", k, rows->texels * rows->views);
}

btf_result joint_model_init(const joint_rows *rows, size_t k, joint_model *out_model) {
    const size_t points = rows->texels * rows->views;
    *out_model = (joint_model){.texels = rows->texels,
                               .views = rows->views,
                               .row = rows->row,
                               .k = k,
                               .u = calloc(rows->texels * k, sizeof(float)),
                               .v = calloc(rows->views * k * rows->row, sizeof(float)),
                               .match = malloc(points * sizeof(uint32_t)),
                               .gain = malloc(points),
                               .gains = {BTF_GAIN_SCALE, BTF_GAIN_ONE, BTF_GAIN_ONE}};
    if (!out_model->u || !out_model->v || !out_model->match || !out_model->gain)
        return out_of_memory(rows, k);
    memset(out_model->gain, BTF_GAIN_ONE, points);
    for (size_t i = 0; i < points; i++)
        out_model->match[i] = (uint32_t)(i % rows->texels);
    return BTF_OK;
}

void joint_model_clear(joint_model *model) {
    free(model->u);
    free(model->v);
    free(model->match);
    free(model->gain);
    *model = (joint_model){0};
}

btf_result joint_projection_init(const joint_rows *rows, size_t k, joint_projection *out_projection) {
    *out_projection = (joint_projection){.basis = enc_gemm_alloc(rows->views * k * rows->row),
                                         .lower = enc_gemm_alloc(rows->views * k * k)};
    btf_result result = out_projection->basis && out_projection->lower ? BTF_OK : BTF_ERROR_MEMORY;
    if (result == BTF_OK)
        result = joint_points_create(rows->context, rows->views, rows->texels * k, &out_projection->c);
    return result == BTF_ERROR_MEMORY ? out_of_memory(rows, k) : result;
}

void joint_projection_clear(joint_projection *projection) {
    free(projection->basis);
    free(projection->lower);
    joint_points_destroy(&projection->c);
    *projection = (joint_projection){0};
}

/* What a projection pass needs. */
typedef struct project_pass {
    const joint_rows *rows;
    joint_projection *projection;
    size_t k, packed_pitch;
    float *packed;  /* [view] packed basis */
    float *scratch; /* [thread] packed rows, then coordinates */
    size_t scratch_pitch;
    btf_result result; /* of storing */
} project_pass;

static void project_block(void *user, size_t view, size_t first, size_t count, const float *block) {
    project_pass *pass = user;
    const size_t row = pass->rows->row;
    float *left = pass->scratch + enc_thread_index() * pass->scratch_pitch, *c = left + JOINT_BLOCK * row;
    enc_gemm_pack_rows(count, row, block, row, ENC_GEMM_M, left);
    enc_gemm_multiply(pass->rows->tile, count, pass->k, row, left, pass->packed + view * pass->packed_pitch, c,
                      pass->k, 0);
    const btf_result result = joint_points_store(pass->rows->context, pass->projection->c, view,
                                                 first * pass->k, count * pass->k, c);
    if (result != BTF_OK) {
#pragma omp atomic write
        pass->result = result;
    }
}

btf_result joint_project(const joint_rows *rows, const joint_model *model, joint_projection *projection) {
    const size_t k = model->k, row = rows->row, threads = (size_t)rows->context->threads;
    project_pass pass = {.rows = rows,
                         .projection = projection,
                         .k = k,
                         .packed_pitch = enc_gemm_panels(k, ENC_GEMM_N) * ENC_GEMM_N * row,
                         .scratch_pitch = JOINT_BLOCK * (row + k)};
    pass.packed = enc_gemm_alloc(rows->views * pass.packed_pitch);
    pass.scratch = enc_gemm_alloc(threads * pass.scratch_pitch);
    btf_result result = BTF_OK;
    bool ok = pass.packed && pass.scratch;
    if (ok)
#pragma omp parallel for schedule(dynamic) num_threads(rows->context->threads)
        for (size_t view = 0; view < rows->views; view++) {
            float *basis = projection->basis + view * k * row;
            if (!joint_orthonormal_rows(k, row, model->v + view * k * row, basis,
                                        projection->lower + view * k * k)) {
#pragma omp atomic write
                ok = false;
            }
            enc_gemm_pack_rows(k, row, basis, row, ENC_GEMM_N, pass.packed + view * pass.packed_pitch);
        }
    result = ok ? joint_rows_pass(rows, project_block, &pass) : out_of_memory(rows, k);
    if (result == BTF_OK)
        result = pass.result;
    free(pass.packed);
    free(pass.scratch);
    return result;
}

/* z[texel] = lower^T u[texel]: the sources of one view in the basis of its projection. */
static void sources_of_view(const joint_rows *rows, size_t k, const float *u, const float *lower,
                            float *packed_lower, float *scratch, float *z) {
    enc_gemm_pack_columns(k, k, lower, k, ENC_GEMM_N, packed_lower);
#pragma omp parallel for num_threads(rows->context->threads)
    for (size_t first = 0; first < rows->texels; first += JOINT_BLOCK) {
        const size_t count = rows->texels - first < JOINT_BLOCK ? rows->texels - first : JOINT_BLOCK;
        float *left = scratch + enc_thread_index() * JOINT_BLOCK * k;
        enc_gemm_pack_rows(count, k, u + first * k, k, ENC_GEMM_M, left);
        enc_gemm_multiply(rows->tile, count, k, k, left, packed_lower, z + first * k, k, 0);
    }
}

btf_result joint_choose(const joint_rows *rows, const joint_projection *projection, bool search,
                        double tolerance, joint_model *model, double *out_error) {
    const size_t k = model->k, texels = rows->texels, threads = (size_t)rows->context->threads;
    const joint_search options = {.width = rows->data->width,
                                  .height = rows->data->height,
                                  .k = k,
                                  .gains = model->gains,
                                  .reach = JOINT_REACH,
                                  .tolerance = tolerance,
                                  .tile = rows->tile,
                                  .threads = rows->context->threads};
    float *z = enc_gemm_alloc(texels * k);
    float *lower = enc_gemm_alloc(enc_gemm_panels(k, ENC_GEMM_N) * ENC_GEMM_N * k);
    float *scratch = enc_gemm_alloc(threads * JOINT_BLOCK * k);
    double *value = malloc(texels * sizeof *value);
    double error = rows->total;
    btf_result result = z && lower && scratch && value ? BTF_OK : out_of_memory(rows, k);
    for (size_t view = 0; view < rows->views && result == BTF_OK; view++) {
        const size_t first = view * texels;
        const float *c;
        result = enc_cancelled(rows->context)
                     ? BTF_ERROR_INTERRUPTED
                     : joint_points_view(rows->context, projection->c, view, &c);
        if (result != BTF_OK)
            break;
        sources_of_view(rows, k, model->u, projection->lower + view * k * k, lower, scratch, z);
        if (search && model->shift)
            result = joint_search_view(&options, c, rows->energy + first, z, model->match + first,
                                       model->gain + first, value);
        else
            joint_search_gains(&options, c, z, model->match + first, model->gain + first, value);
        if (result != BTF_OK)
            result = out_of_memory(rows, k);
        for (size_t x = 0; x < texels && result == BTF_OK; x++)
            error -= value[x];
    }
    *out_error = error;
    free(z);
    free(lower);
    free(scratch);
    free(value);
    return result;
}

enum { SOURCES = 96 }; /* sources that one task of joint_solve_u handles: a multiple of ENC_GEMM_M */

/* Weight of the present value in each solve, against the trace: keeps what the data do not determine, and
 * since it pulls towards a point that is already there, never raises the error. */
static const double proximal = 1e-7;

/* Everything that the tasks of joint_solve_u share. */
typedef struct u_step {
    const joint_rows *rows;
    const joint_projection *projection;
    float *packed_gram;     /* [view][k * k] gram of v, packed as columns */
    const joint_rounding *rounding;
    float *weights;         /* [texel][view] sum of squared gains of a source's points */
    float *right;           /* [texel][k] sum of gain * lower * c over them */
    /* of the view at hand */
    uint32_t *start, *order; /* points by source: of s they are order[start[s]] .. order[start[s + 1] - 1] */
    float *packed_lower;     /* lower, packed as rows */
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
static size_t u_scratch(size_t k, size_t views) {
    return SOURCES * (views + k + k + k * k);
}

/* u^T gram u - 2 right^T u: the error of a source's points but for a constant. */
static double quadratic(size_t k, const float *gram, const float *right, const float *u) {
    double sum = 0.0;
    for (size_t i = 0; i < k; i++) {
        double product = -2.0 * right[i];
        for (size_t j = 0; j < k; j++)
            product += (double)gram[i * k + j] * u[j];
        sum += product * u[i];
    }
    return sum;
}

/* One source from its Gram matrix and right-hand side. The prior draws u to 0, unless that would raise the
 * error; a source without points stays. system: k * k + k doubles of scratch. */
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
        if (!joint_cholesky(k, a)) { /* rounding of the Gram matrix left a negative pivot */
            pull *= 16.0;
            continue;
        }
        joint_lower_solve(k, a, x, 1);
        joint_upper_solve(k, a, x, 1);
        for (size_t i = 0; i < k; i++)
            solution[i] = (float)x[i];
        if (prior == 0.0 || quadratic(k, gram, right, solution) <= before)
            break;
        prior = 0.0;
    }
    if (step->rounding)
        joint_round_to_lattice(k, a, step->rounding->step, x, step->rounding->codes + source * k);
    for (size_t i = 0; i < k; i++)
        u[i] = (float)x[i];
}

/* Adds the points of one view to weights and right-hand sides of a task's sources. */
static void gather_sources(const u_step *step, const joint_model *model, size_t view, const float *c,
                           size_t first, float *scratch) {
    const size_t k = model->k, views = model->views, texels = model->texels;
    const size_t count = texels - first < SOURCES ? texels - first : SOURCES;
    float *sums = scratch, *packed_sums = sums + SOURCES * k;
    const uint32_t *start = step->start + first;
    const uint8_t *code = model->gain + view * texels;
    memset(sums, 0, SOURCES * k * sizeof *sums);
    for (size_t s = 0; s < count; s++) {
        float weight = 0.0f;
        for (uint32_t i = start[s]; i < start[s + 1]; i++) {
            const float gain = (float)code[step->order[i]] * model->gains.step;
            const float *from = c + step->order[i] * k;
            weight += gain * gain;
            for (size_t j = 0; j < k; j++)
                sums[s * k + j] += gain * from[j];
        }
        step->weights[(first + s) * views + view] = weight;
    }
    enc_gemm_pack_rows(count, k, sums, k, ENC_GEMM_M, packed_sums);
    enc_gemm_multiply(step->rows->tile, count, k, k, packed_sums, step->packed_lower, step->right + first * k,
                      k, 1);
}

static btf_result gather_views(u_step *step, const joint_model *model, float *scratch) {
    const joint_rows *rows = step->rows;
    const size_t k = model->k;
    for (size_t view = 0; view < rows->views; view++) {
        const float *c;
        const btf_result result = joint_points_view(rows->context, step->projection->c, view, &c);
        if (result != BTF_OK)
            return result;
        invert_view(model, view, step->start, step->order);
        enc_gemm_pack_rows(k, k, step->projection->lower + view * k * k, k, ENC_GEMM_N, step->packed_lower);
#pragma omp parallel for schedule(dynamic, 4) num_threads(rows->context->threads)
        for (size_t first = 0; first < rows->texels; first += SOURCES)
            gather_sources(step, model, view, c, first,
                           scratch + enc_thread_index() * u_scratch(k, rows->views));
    }
    return BTF_OK;
}

static void solve_sources(const u_step *step, joint_model *model, size_t first, float *scratch,
                          double *system) {
    const size_t k = model->k, views = model->views, texels = model->texels;
    const size_t count = texels - first < SOURCES ? texels - first : SOURCES;
    float *packed_weights = scratch, *gram = packed_weights + SOURCES * views;
    enc_gemm_pack_rows(count, views, step->weights + first * views, views, ENC_GEMM_M, packed_weights);
    enc_gemm_multiply(step->rows->tile, count, k * k, views, packed_weights, step->packed_gram, gram, k * k,
                      0);
    for (size_t s = 0; s < count; s++)
        solve_source(step, model, first + s, gram + s * k * k, step->right + (first + s) * k, system);
}

/* gram [view][k * k] of v, packed as columns. */
static void pack_gram(const joint_rows *rows, const joint_projection *projection, size_t k, float *gram,
                      float *packed_gram) {
#pragma omp parallel for schedule(dynamic) num_threads(rows->context->threads)
    for (size_t view = 0; view < rows->views; view++) {
        const float *lower = projection->lower + view * k * k;
        for (size_t i = 0; i < k; i++)
            for (size_t j = 0; j < k; j++) {
                double sum = 0.0;
                for (size_t p = 0; p <= (i < j ? i : j); p++)
                    sum += (double)lower[i * k + p] * lower[j * k + p];
                gram[(view * k + i) * k + j] = (float)sum;
            }
    }
    enc_gemm_pack_columns(k * k, rows->views, gram, k * k, ENC_GEMM_N, packed_gram);
}

btf_result joint_solve_u(const joint_rows *rows, const joint_projection *projection,
                         const joint_rounding *rounding, joint_model *model) {
    const size_t k = model->k, views = model->views, texels = model->texels;
    const size_t threads = (size_t)rows->context->threads;
    u_step step = {.rows = rows,
                   .projection = projection,
                   .packed_gram = enc_gemm_alloc(enc_gemm_panels(k * k, ENC_GEMM_N) * ENC_GEMM_N * views),
                   .rounding = rounding,
                   .weights = malloc(texels * views * sizeof(float)),
                   .right = calloc(texels * k, sizeof(float)),
                   .start = malloc((texels + 1) * sizeof(uint32_t)),
                   .order = malloc(texels * sizeof(uint32_t)),
                   .packed_lower = enc_gemm_alloc(enc_gemm_panels(k, ENC_GEMM_N) * ENC_GEMM_N * k)};
    float *gram = enc_gemm_alloc(views * k * k);
    float *scratch = enc_gemm_alloc(threads * u_scratch(k, views));
    double *system = malloc(threads * (k * k + k) * sizeof *system);
    btf_result result = BTF_OK;
    if (!step.packed_gram || !step.weights || !step.right || !step.start || !step.order || !step.packed_lower ||
        !gram || !scratch || !system) {
        result = out_of_memory(rows, k);
        goto fail;
    }
    pack_gram(rows, projection, k, gram, step.packed_gram);
    result = gather_views(&step, model, scratch);
    if (result != BTF_OK)
        goto fail;
#pragma omp parallel for schedule(dynamic) num_threads(rows->context->threads)
    for (size_t first = 0; first < texels; first += SOURCES) {
        const size_t thread = enc_thread_index();
        solve_sources(&step, model, first, scratch + thread * u_scratch(k, views),
                      system + thread * (k * k + k));
    }
fail:
    free(step.packed_gram);
    free(step.weights);
    free(step.right);
    free(step.start);
    free(step.order);
    free(step.packed_lower);
    free(gram);
    free(scratch);
    free(system);
    return result;
}

/* What a pass that gathers the right-hand sides of v needs. */
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
    const uint32_t *match = model->match + view * model->texels + first;
    const uint8_t *code = model->gain + view * model->texels + first;
    for (size_t i = 0; i < count; i++) {
        const float gain = (float)code[i] * model->gains.step;
        for (size_t j = 0; j < k; j++)
            scaled[i * k + j] = gain * model->u[match[i] * k + j];
    }
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
        if (joint_cholesky(k, a))
            break;
    }
    joint_lower_solve(k, a, x, row);
    joint_upper_solve(k, a, x, row);
    for (size_t p = 0; p < row && pass->rounding; p++) {
        for (size_t i = 0; i < k; i++) {
            column[i] = x[i * row + p];
            step[i] = pass->rounding->step[k - 1 - i] * pass->rows->multiplier[p];
        }
        joint_round_to_lattice(k, a, step, column, codes);
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
                   .scratch_pitch =
                       JOINT_BLOCK * (enc_gemm_panels(k, ENC_GEMM_M) * ENC_GEMM_M +
                                      (enc_gemm_panels(row, ENC_GEMM_N) + 4) * ENC_GEMM_N + 2 * k)};
    pass.right = calloc(rows->views * k * row, sizeof(float));
    pass.gram = calloc(rows->views * k * k, sizeof(float));
    pass.scratch = enc_gemm_alloc(threads * pass.scratch_pitch);
    bool ok = pass.right && pass.gram && pass.scratch;
    btf_result result = ok ? joint_rows_pass(rows, gather_block, &pass) : BTF_OK;
    if (ok && result == BTF_OK)
#pragma omp parallel for schedule(dynamic) num_threads(rows->context->threads)
        for (size_t view = 0; view < rows->views; view++)
            if (!solve_view(&pass, model, view)) {
#pragma omp atomic write
                ok = false;
            }
    free(pass.right);
    free(pass.gram);
    free(pass.scratch);
    return ok ? result : out_of_memory(rows, k);
}
