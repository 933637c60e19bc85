/* The error that factors will have. See foresee.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "foresee.h"

#include "encoder/base/ranks.h"
#include "encoder/base/stage.h"
#include "encoder/factor/components.h"
#include "encoder/math/srgb.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    CHANNELS = ENC_FACTOR_CHANNELS,
    CHROMA_SHARE = 8,    /* luma has so many times the components of a chroma channel */
    SPARE = 32,          /* components sought beyond those wanted, which makes the wanted ones more exact */
    DECODED_TEXELS = 64, /* texels that are decoded to turn the error of roots into that of radiance */
    BISECTIONS = 50,
};

/* Share of the error of components rounded one by one that descent on their codes leaves: at 2.36 MB
 * BRICKS64 has 0.88, IMPALLA64 0.82. */
static const double descended = 0.85;

/* Share of the rounding error of 8-bit components that is left once weaker components have made up for it
 * (stop.c): measured with btf-sample flat. */
static const double strong_share = 0.15;

/* The texels that were drawn, and their components. */
typedef struct survey {
    const enc_context *context;
    enc_factor_matrix matrix; /* of these texels */
    uint32_t list[ENC_FORESEE_TEXELS];
    enc_components components[CHANNELS];
    size_t wanted[CHANNELS];  /* components */
    size_t leading[CHANNELS]; /* components whose energies count as found */
    double rest[CHANNELS];    /* energy of all components after these */
} survey;

/* Draws one texel from each run of them, each time at another place of the run, so that rows and columns
 * both vary. */
static size_t draw_texels(size_t all, uint32_t *list) {
    const size_t count = all < ENC_FORESEE_TEXELS ? all : ENC_FORESEE_TEXELS;
    for (size_t i = 0; i < count; i++) {
        const size_t run = all / count, first = i * all / count;
        list[i] = (uint32_t)(first + (i * 7) % run);
    }
    return count;
}

/* Asks for as many components as the budget may hold at 2.5 bits a factor. */
static void set_wanted(survey *s, const enc_data *data, uint64_t budget) {
    const size_t all = enc_data_texel_count(data) + s->matrix.columns;
    const double fits = (double)budget * 8 / 2.5 / (double)all;
    const size_t luma = fits < ENC_FORESEE_RANK ? (size_t)fits + 1 : ENC_FORESEE_RANK;
    s->wanted[0] = luma;
    s->wanted[1] = s->wanted[2] = luma / CHROMA_SHARE + 1;
}

static btf_result find(survey *s) {
    const size_t side = s->matrix.texels < s->matrix.columns ? s->matrix.texels : s->matrix.columns;
    size_t sought[CHANNELS];
    double sums[CHANNELS];
    enc_factor_set u = {0}, w = {0};
    uint8_t *all = malloc(s->matrix.columns);
    btf_result result = enc_ranks_agree(s->context, all ? BTF_OK : BTF_ERROR_MEMORY);
    for (int c = 0; c < CHANNELS; c++) {
        sought[c] = s->wanted[c] + SPARE < side ? s->wanted[c] + SPARE : side;
    }
    if (result == BTF_OK) {
        result = enc_components_find(&s->matrix, sought, 0, s->components);
    }
    for (int c = 0; c < CHANNELS; c++) {
        u.rank[c] = w.rank[c] = s->components[c].rank;
        u.factor[c] = s->components[c].u;
        w.factor[c] = s->components[c].w;
    }
    if (result == BTF_OK) {
        memset(all, 1, s->matrix.columns);
        result = enc_factor_residual(&s->matrix, &u, &w, all, sums);
    }
    for (int c = 0; c < CHANNELS && result == BTF_OK; c++) {
        const enc_components *found = &s->components[c];
        s->leading[c] = found->rank < s->wanted[c] ? found->rank : s->wanted[c];
        s->rest[c] = sums[c];
        for (size_t j = s->leading[c]; j < found->rank; j++) {
            s->rest[c] += found->energy[j];
        }
    }
    free(all);
    return result;
}

/* The sum of (j / from)^-power over j = from + 1 .. to; writes the terms to `out` unless it is NULL. */
static double power_sum(size_t from, size_t to, double power, double *out) {
    double sum = 0;
    for (size_t j = from + 1; j <= to; j++) {
        const double x = pow((double)j / (double)from, -power);
        sum += x;
        if (out) {
            out[j - 1] = x;
        }
    }
    return sum;
}

/* Extends the energies to `rank` components of all texels: first those that were found, then a power law
 * that begins at the last of these and sums to the rest. */
static void extend(const survey *s, int channel, double texels, size_t rank, double *out) {
    const enc_components *found = &s->components[channel];
    const size_t leading = s->leading[channel];
    double low = 0, high = 64;
    for (size_t j = 0; j < leading; j++) {
        out[j] = texels * found->energy[j];
    }
    if (leading == 0 || leading >= rank || !(s->rest[channel] > 0)) {
        return;
    }
    /* the law begins at the mean level of the last quarter, whose components differ by chance */
    const size_t first = leading - leading / 4 - 1;
    double level = 0;
    for (size_t j = first; j < leading; j++) {
        level += log(found->energy[j]) / (double)(leading - first);
    }
    const double last = fmin(exp(level), found->energy[leading - 1] * 2);
    const double wanted = s->rest[channel] / last;
    for (int i = 0; i < BISECTIONS; i++) {
        const double power = 0.5 * (low + high);
        if (power_sum(leading, rank, power, NULL) > wanted) {
            low = power;
        } else {
            high = power;
        }
    }
    const double sum = power_sum(leading, rank, high, out);
    for (size_t j = leading; j < rank; j++) {
        out[j] *= texels * s->rest[channel] / sum;
    }
}

/* Finds the energy that the plan for the budget leaves of the roots of all texels. */
static btf_result planned_error(const survey *s, const enc_data *data, uint64_t budget, double *out) {
    const size_t all = enc_data_texel_count(data), columns = s->matrix.columns;
    const size_t rank = all < columns ? all : columns;
    const double texels = (double)all / (double)s->matrix.texels;
    double *energies = calloc(CHANNELS * rank, sizeof *energies);
    enc_factor_energies planned = {.rounding = NULL};
    enc_factor_plan plan;
    if (!energies) {
        return BTF_ERROR_MEMORY;
    }
    for (int c = 0; c < CHANNELS; c++) {
        planned.rank[c] = rank;
        planned.energy[c] = energies + (size_t)c * rank;
        extend(s, c, texels, rank, energies + (size_t)c * rank);
    }
    const bool fits =
        enc_factor_allocate(&planned, all, (size_t)data->n_views, (size_t)data->n_lights, budget, &plan);
    const double all_rounded = fits ? enc_factor_plan_error(&planned, &plan, 0) : 0;
    const double weak_rounded = fits ? enc_factor_plan_error(&planned, &plan, 1) : 0;
    *out = weak_rounded + strong_share * (all_rounded - weak_rounded);
    free(energies);
    return BTF_OK; /* the encode itself refuses a budget that holds no unit, and names one that fits */
}

static double clipped(double x) {
    return x > 0 ? fmin(x, 1) : 0;
}

/* Finds the errors that the leading components leave at one texel: of roots, of radiance, of sRGB-coded
 * radiance. work: [CHANNELS][columns]. */
static btf_result decode(const survey *s, size_t at, float *samples, float *work, double out[3]) {
    static const double axis[3][CHANNELS] = {{0.57735027, 0.70710678, 0.40824829},
                                             {0.57735027, 0, -0.81649658},
                                             {0.57735027, -0.70710678, 0.40824829}};
    const size_t columns = s->matrix.columns, lights = (size_t)s->matrix.data->n_lights;
    const float *read;
    const btf_result result = enc_data_texels(s->context, s->matrix.data, s->list[at], 1, samples, &read);
    memset(work, 0, CHANNELS * columns * sizeof *work);
    for (int c = 0; c < CHANNELS && result == BTF_OK; c++) {
        const enc_components *found = &s->components[c];
        float *row = work + (size_t)c * columns;
        for (size_t j = 0; j < s->leading[c]; j++) {
            const float u = found->u[j * s->matrix.texels + at], *w = found->w + j * columns;
            for (size_t i = 0; i < columns; i++) {
                row[i] += u * w[i];
            }
        }
    }
    for (size_t i = 0; i < columns && result == BTF_OK; i++) {
        for (size_t c = 0; c < 3; c++) {
            const double value = (double)read[(i / lights * 3 + c) * lights + i % lights];
            const double truth = copysign(sqrt(fmin(fabs(value), (double)s->matrix.most)), value);
            const double root = axis[c][0] * (double)work[i] + axis[c][1] * (double)work[columns + i] +
                                axis[c][2] * (double)work[2 * columns + i];
            const double a = clipped(truth), b = clipped(root);
            const double coded = enc_srgb_encode((float)(a * a)) - enc_srgb_encode((float)(b * b));
            out[0] += (root - truth) * (root - truth);
            out[1] += (a * a - b * b) * (a * a - b * b);
            out[2] += coded * coded;
        }
    }
    return result;
}

/* Finds how large errors of radiance and of its sRGB code are for one of roots: ratios of sums of
 * squares. */
static btf_result turn(const survey *s, double *out_linear, double *out_srgb) {
    const size_t columns = s->matrix.columns, stride = 3 * columns;
    const size_t count = s->matrix.texels < DECODED_TEXELS ? s->matrix.texels : DECODED_TEXELS;
    double(*each)[3] = calloc(count, sizeof *each), sum[3] = {0, 0, 0};
    const size_t threads = (size_t)s->context->threads;
    float *work = malloc(threads * (stride + CHANNELS * columns) * sizeof *work);
    btf_result result = each && work ? BTF_OK : BTF_ERROR_MEMORY;
#pragma omp parallel for schedule(dynamic) num_threads(s->context->threads) if (result == BTF_OK)
    for (size_t i = 0; i < (each && work ? count : 0); i++) {
        float *mine = work + enc_thread_index() * (stride + CHANNELS * columns);
        const btf_result one = decode(s, i * s->matrix.texels / count, mine, mine + stride, each[i]);
        enc_keep_worse(&result, one);
    }
    for (size_t i = 0; i < count && result == BTF_OK; i++) {
        for (int k = 0; k < 3; k++) {
            sum[k] += each[i][k];
        }
    }
    *out_linear = sum[0] > 0 ? sum[1] / sum[0] : 0;
    *out_srgb = sum[0] > 0 ? sum[2] / sum[0] : 0;
    free(each);
    free(work);
    return result;
}

static btf_result foresee(survey *s, const enc_data *data, const enc_factors_settings *settings,
                          enc_fit_error *out) {
    double energy = 0, linear = 0, srgb = 0;
    set_wanted(s, data, settings->budget);
    btf_result result = find(s);
    if (result == BTF_OK) {
        result = planned_error(s, data, settings->budget, &energy);
    }
    if (result == BTF_OK) {
        result = turn(s, &linear, &srgb);
    }
    const double samples = (double)enc_data_texel_count(data) * (double)enc_data_texel_stride(data);
    const double roots = (settings->sweeps > 0 ? descended : 1) * energy / samples;
    *out = (enc_fit_error){linear * roots, srgb * roots};
    const double enough = settings->quality > 0 ? pow(10, -settings->quality / 10) : 0;
    if (out->srgb > 0 && out->srgb < enough) { /* bytes are saved until the error is that large */
        out->linear *= enough / out->srgb;
        out->srgb = enough;
    }
    return result;
}

btf_result enc_foresee_error(const enc_context *context, const enc_data *data,
                             const enc_factors_settings *settings, enc_fit_error *out_error) {
    survey *s = calloc(1, sizeof *s);
    *out_error = (enc_fit_error){0, 0};
    if (!s) {
        return enc_fail(context, BTF_ERROR_MEMORY, "out of memory");
    }
    s->context = context;
    s->matrix = enc_factor_matrix_of(context, data);
    s->matrix.texels = draw_texels(s->matrix.texels, s->list);
    s->matrix.list = s->list;
    enc_stage_begin(context, "foresee error", 3 * s->matrix.texels);
    btf_result result = enc_factor_clip(&s->matrix);
    if (result == BTF_OK) {
        result = foresee(s, data, settings, out_error);
    }
    result = enc_ranks_agree(context, result);
    enc_stage_end(context);
    for (int c = 0; c < CHANNELS; c++) {
        enc_components_clear(&s->components[c]);
    }
    free(s);
    return result == BTF_ERROR_MEMORY ? enc_fail(context, result, "out of memory") : result;
}
