/* Alternation over SBRDF times shadow (see joint_front.h).
 *
 * SPDX-License-Identifier: MIT
 */
#include "joint_front.h"
#include "fit.h"
#include "joint_search.h"

#include <assert.h>
#include <math.h>
#include <openbtf/material.h>
#include <stdlib.h>
#include <string.h>

enum { FIRST_STARTS = 2, SHADOW_MAX = 255 };

static const float shadow_scale = 2.0f / SHADOW_MAX; /* range 0 .. 2 */
static const double shift_tolerance = 1e-6;          /* of a point's energy, as for low-rank sources */

/* Everything the rounds change, and what they share. */
typedef struct front {
    const joint_rows *rows;
    const joint_front_options *options;
    joint_gains gains;
    enc_sbrdf *sbrdf;
    uint8_t *shadow; /* [texel][light] code */
    uint32_t *match; /* [view][texel] */
    uint8_t *gain;   /* [view][texel] */
    uint32_t *start; /* [view][texel + 1]: points of a source, as in order */
    uint32_t *order; /* [view][texel] */
    float *light[3]; /* [light] components of the directions */
    double error;
} front;

static btf_result no_memory(const front *f) {
    return enc_fail(f->rows->context, BTF_ERROR_MEMORY, "joint: out of memory for %zu sources",
                    f->rows->texels);
}

static void front_clear(front *f) {
    enc_sbrdf_destroy(&f->sbrdf);
    free(f->shadow);
    free(f->match);
    free(f->gain);
    free(f->start);
    free(f->order);
    free(f->light[0]);
}

static btf_result front_init(const joint_rows *rows, const joint_front_options *options, front *f) {
    const size_t texels = rows->texels, points = texels * rows->views, lights = rows->row / 3;
    const bool gain = options->effects & BTF_EFFECT_GAIN;
    *f = (front){.rows = rows,
                 .options = options,
                 .gains = {BTF_GAIN_SCALE, gain ? 1 : BTF_GAIN_ONE, gain ? 255 : BTF_GAIN_ONE},
                 .shadow = malloc(texels * lights),
                 .match = malloc(points * sizeof(uint32_t)),
                 .gain = malloc(points),
                 .start = malloc(rows->views * (texels + 1) * sizeof(uint32_t)),
                 .order = malloc(points * sizeof(uint32_t)),
                 .light = {malloc(3 * lights * sizeof(float))}};
    if (!f->shadow || !f->match || !f->gain || !f->start || !f->order || !f->light[0])
        return no_memory(f);
    f->light[1] = f->light[0] + lights;
    f->light[2] = f->light[1] + lights;
    for (size_t l = 0; l < lights; l++)
        for (int axis = 0; axis < 3; axis++)
            f->light[axis][l] = rows->data->lights[l].xyz[axis];
    memset(f->shadow, 128, texels * lights); /* 1, to a code */
    memset(f->gain, BTF_GAIN_ONE, points);
    for (size_t i = 0; i < points; i++)
        f->match[i] = (uint32_t)(i % texels);
    return enc_sbrdf_create(texels, options->lobes, options->rgb, &f->sbrdf);
}

static float shadow_of(const front *f, size_t source, size_t light) {
    return f->options->effects & BTF_EFFECT_SHADOW
               ? (float)f->shadow[source * (f->rows->row / 3) + light] * shadow_scale
               : 1.0f;
}

/* out [row] = m(l) * SBRDF, without the shadow. */
static void evaluate(const front *f, size_t source, size_t view, float *out) {
    const size_t lights = f->rows->row / 3;
    enc_sbrdf_evaluate(f->sbrdf, source, f->rows->data->views[view].xyz, (int)lights, f->light[0],
                       f->light[1], f->light[2], out);
    for (size_t p = 0; p < f->rows->row; p++)
        out[p] *= f->rows->multiplier[p];
}

/* Lists the points of every source. */
static void invert(front *f) {
    const size_t texels = f->rows->texels;
#pragma omp parallel for num_threads(f->rows->context->threads)
    for (size_t view = 0; view < f->rows->views; view++) {
        uint32_t *start = f->start + view * (texels + 1), *order = f->order + view * texels;
        const uint32_t *match = f->match + view * texels;
        memset(start, 0, (texels + 1) * sizeof *start);
        for (size_t x = 0; x < texels; x++)
            start[match[x] + 1]++;
        for (size_t s = 0; s < texels; s++)
            start[s + 1] += start[s];
        for (size_t x = 0; x < texels; x++)
            order[start[match[x]]++] = (uint32_t)x;
        memmove(start + 1, start, texels * sizeof *start);
        start[0] = 0;
    }
}

/* Scratch of one thread. */
typedef struct worker {
    float *target; /* [view][row] gain-weighted mean of the rows that refer to a source */
    float *weight; /* [view] sum of squared gains */
    float *texel;  /* samples of one texel, where they do not lie in memory */
    float *row;
    float *planes; /* [8][view * light]: product x, y, z, multiplier, target R, G, B, weight */
    double *sums;  /* [2][light] */
    enc_fit_workspace *fit;
} worker;

static void worker_clear(worker *w) {
    free(w->target);
    free(w->weight);
    free(w->texel);
    free(w->row);
    free(w->planes);
    free(w->sums);
    enc_fit_workspace_destroy(&w->fit);
}

static btf_result worker_init(const front *f, worker *w) {
    const size_t views = f->rows->views, row = f->rows->row, lights = row / 3;
    *w = (worker){.target = malloc(views * row * sizeof(float)),
                  .weight = malloc(views * sizeof(float)),
                  .texel = malloc(views * row * sizeof(float)),
                  .row = malloc(row * sizeof(float)),
                  .planes = malloc(8 * views * lights * sizeof(float)),
                  .sums = malloc(2 * lights * sizeof(double))};
    if (!w->target || !w->weight || !w->texel || !w->row || !w->planes || !w->sums)
        return no_memory(f);
    return enc_fit_workspace_create(views * lights, &w->fit);
}

/* Targets and weights of one source. */
static btf_result gather(const front *f, size_t source, worker *w) {
    const size_t texels = f->rows->texels, row = f->rows->row;
    memset(w->target, 0, f->rows->views * row * sizeof *w->target);
    for (size_t view = 0; view < f->rows->views; view++) {
        const uint32_t *start = f->start + view * (texels + 1) + source;
        float *target = w->target + view * row, weight = 0.0f;
        for (uint32_t i = start[0]; i < start[1]; i++) {
            const size_t x = f->order[view * texels + i];
            const float gain = (float)f->gain[view * texels + x] * f->gains.step;
            const btf_result result = joint_rows_one(f->rows, x, view, w->texel, w->row);
            if (result != BTF_OK)
                return result;
            weight += gain * gain;
            for (size_t p = 0; p < row; p++)
                target[p] += gain * w->row[p];
        }
        w->weight[view] = weight;
        for (size_t p = 0; p < row && weight > 0.0f; p++)
            target[p] /= weight;
    }
    return BTF_OK;
}

/* The least-squares shadow of every light: sum of weight * target * model over sum of weight * model^2. */
static void solve_shadow(front *f, size_t source, worker *w) {
    const size_t row = f->rows->row, lights = row / 3;
    double *above = w->sums, *below = above + lights;
    memset(w->sums, 0, 2 * lights * sizeof *w->sums);
    for (size_t view = 0; view < f->rows->views; view++) {
        const double weight = w->weight[view];
        if (!(weight > 0.0))
            continue;
        evaluate(f, source, view, w->row);
        for (size_t p = 0; p < row; p++) {
            above[p % lights] += weight * w->target[view * row + p] * w->row[p];
            below[p % lights] += weight * (double)w->row[p] * w->row[p];
        }
    }
    for (size_t l = 0; l < lights; l++)
        if (below[l] > 1e-12) {
            const double code = rint(above[l] / below[l] / shadow_scale);
            f->shadow[source * lights + l] = (uint8_t)(code > SHADOW_MAX ? SHADOW_MAX
                                                       : code > 0.0      ? code
                                                                         : 0.0);
        }
}

static btf_result fit_source(front *f, size_t source, bool first, worker *w) {
    const size_t views = f->rows->views, lights = f->rows->row / 3, plane = views * lights;
    const size_t stride = enc_sbrdf_stride(f->sbrdf->lobes, f->sbrdf->rgb);
    float parameters[3 + 7 * ENC_MAX_LOBES + 4], *present = f->sbrdf->values + source * stride;
    float *planes[8];
    size_t n = 0;
    for (int i = 0; i < 8; i++)
        planes[i] = w->planes + (size_t)i * plane;
    for (size_t view = 0; view < views; view++)
        for (size_t l = 0; l < lights && w->weight[view] > 0.0f; l++, n++) {
            for (int axis = 0; axis < 3; axis++) {
                planes[axis][n] = f->light[axis][l] * f->rows->data->views[view].xyz[axis];
                planes[4 + axis][n] = w->target[view * f->rows->row + (size_t)axis * lights + l];
            }
            planes[3][n] = f->rows->multiplier[l] * shadow_of(f, source, l);
            planes[7][n] = w->weight[view];
        }
    if (n == 0)
        return BTF_OK;
    const enc_fit_samples samples = {
        n, {planes[0], planes[1], planes[2]}, planes[3], {planes[4], planes[5], planes[6]}, planes[7]};
    enc_fit_options options = enc_fit_options_default();
    enc_fit_result fitted;
    options.lobes = f->sbrdf->lobes;
    options.rgb = f->sbrdf->rgb;
    options.square_root = f->rows->root;
    const btf_result result = enc_fit_texel(w->fit, &samples, &options, first ? NULL : present,
                                            first ? FIRST_STARTS : 0, parameters, &fitted);
    if (result == BTF_OK)
        memcpy(present, parameters, stride * sizeof *present);
    return result;
}

/* Steps 2 and 3 of a round, or the first fit: each source to all of its points. */
static btf_result solve_sources(front *f, bool first) {
    const bool shadow = f->options->effects & BTF_EFFECT_SHADOW;
    btf_result result = BTF_OK;
    invert(f);
#pragma omp parallel num_threads(f->rows->context->threads)
    {
        worker w;
        btf_result mine = worker_init(f, &w);
#pragma omp for schedule(dynamic, 8)
        for (size_t source = 0; source < f->rows->texels; source++) {
            if (mine == BTF_OK)
                mine = enc_cancelled(f->rows->context) ? BTF_ERROR_INTERRUPTED : gather(f, source, &w);
            if (mine == BTF_OK && shadow && !first)
                solve_shadow(f, source, &w);
            if (mine == BTF_OK)
                mine = fit_source(f, source, first, &w);
            if (mine == BTF_OK && shadow)
                solve_shadow(f, source, &w);
        }
        worker_clear(&w);
        if (mine != BTF_OK) {
#pragma omp critical(joint_front)
            result = mine;
        }
    }
    return result;
}

/* Sources and queries of one view in full, [texel][row]. */
static btf_result load_view(const front *f, size_t view, float *c, float *z) {
    const size_t row = f->rows->row, lights = row / 3;
    btf_result result = BTF_OK;
#pragma omp parallel num_threads(f->rows->context->threads)
    {
        float *texel = malloc(f->rows->views * row * sizeof *texel);
        btf_result mine = texel ? BTF_OK : no_memory(f);
#pragma omp for schedule(dynamic, 64)
        for (size_t x = 0; x < f->rows->texels; x++) {
            if (mine == BTF_OK)
                mine = joint_rows_one(f->rows, x, view, texel, c + x * row);
            evaluate(f, x, view, z + x * row);
            for (size_t p = 0; p < row; p++)
                z[x * row + p] *= shadow_of(f, x, p % lights);
        }
        free(texel);
        if (mine != BTF_OK) {
#pragma omp critical(joint_front)
            result = mine;
        }
    }
    return result;
}

/* Sources (with `search`) and gains of all points, and the error that remains. */
static btf_result choose(front *f, bool search) {
    const size_t texels = f->rows->texels;
    const joint_search options = {.width = f->rows->data->width,
                                  .height = f->rows->data->height,
                                  .k = f->rows->row,
                                  .gains = f->gains,
                                  .reach = JOINT_REACH,
                                  .tolerance = shift_tolerance,
                                  .tile = f->rows->tile,
                                  .threads = f->rows->context->threads};
    float *c = enc_gemm_alloc(texels * f->rows->row), *z = enc_gemm_alloc(texels * f->rows->row);
    double *value = malloc(texels * sizeof *value), error = f->rows->total;
    btf_result result = c && z && value ? BTF_OK : no_memory(f);
    for (size_t view = 0; view < f->rows->views && result == BTF_OK; view++) {
        const size_t first = view * texels;
        result = enc_cancelled(f->rows->context) ? BTF_ERROR_INTERRUPTED : load_view(f, view, c, z);
        if (result == BTF_OK && search && (f->options->effects & BTF_EFFECT_SHIFT))
            result = joint_search_view(&options, c, f->rows->energy + first, z, f->match + first,
                                       f->gain + first, value);
        else if (result == BTF_OK)
            joint_search_gains(&options, c, z, f->match + first, f->gain + first, value);
        for (size_t x = 0; x < texels && result == BTF_OK; x++)
            error -= value[x];
    }
    f->error = error;
    free(c);
    free(z);
    free(value);
    return result;
}

static btf_result hand_over(front *f, enc_solution *out) {
    const joint_rows *rows = f->rows;
    const size_t texels = rows->texels, points = texels * rows->views, lights = rows->row / 3;
    *out = (enc_solution){.width = rows->data->width,
                          .height = rows->data->height,
                          .n_views = rows->data->n_views,
                          .n_lights = rows->data->n_lights,
                          .domain = rows->root ? BTF_DOMAIN_SQRT : BTF_DOMAIN_LINEAR,
                          .effects = f->options->effects,
                          .radiance_scale = rows->scale,
                          .shadow_scale = shadow_scale,
                          .gain_scale = BTF_GAIN_SCALE,
                          .centre_scale = 1.0f / 255.0f};
    if (out->effects & BTF_EFFECT_SHADOW) {
        out->shadow = malloc(texels * lights);
        for (size_t i = 0; out->shadow && i < texels * lights; i++)
            out->shadow[i] = f->shadow[i % texels * lights + i / texels];
    }
    if (out->effects & BTF_EFFECT_SHIFT) {
        out->shift = malloc(2 * points);
        for (size_t i = 0; out->shift && i < points; i++) {
            int dx, dy;
            const bool fits =
                joint_shift(out->width, out->height, (uint32_t)(i % texels), f->match[i], &dx, &dy);
            assert(fits);
            (void)fits;
            out->shift[2 * i] = (int8_t)dx;
            out->shift[2 * i + 1] = (int8_t)dy;
        }
    }
    if (out->effects & BTF_EFFECT_GAIN) {
        out->gain = f->gain;
        f->gain = NULL;
    }
    out->sbrdf = f->sbrdf;
    f->sbrdf = NULL;
    if (((out->effects & BTF_EFFECT_SHADOW) && !out->shadow) ||
        ((out->effects & BTF_EFFECT_SHIFT) && !out->shift)) {
        enc_solution_clear(out);
        return no_memory(f);
    }
    return BTF_OK;
}

btf_result joint_front_fit(const joint_rows *rows, const joint_front_options *options, double *history,
                           int *out_count, enc_solution *out_solution) {
    front f;
    btf_result result = front_init(rows, options, &f);
    *out_count = 0;
    *out_solution = (enc_solution){0};
    if (result == BTF_OK)
        result = solve_sources(&f, true);
    if (result == BTF_OK)
        result = choose(&f, false);
    history[(*out_count)++] = f.error;
    for (int i = 0; i < options->rounds && result == BTF_OK; i++) {
        const double before = f.error;
        result = choose(&f, true);
        if (result == BTF_OK)
            result = solve_sources(&f, false);
        if (result == BTF_OK)
            result = choose(&f, false);
        history[(*out_count)++] = f.error;
        enc_stage_step(rows->context, 1);
        if (before - f.error < options->tolerance * before)
            break;
    }
    if (result == BTF_OK)
        result = hand_over(&f, out_solution);
    front_clear(&f);
    return result;
}
