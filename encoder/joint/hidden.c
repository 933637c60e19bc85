/* Cluster centres in competition with sources. See hidden.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "hidden.h"

#include "encoder/math/kmeans.h"

#include <math.h>
#include <openbtf/material.h>
#include <stdlib.h>
#include <string.h>

enum {
    CANDIDATES = 24, /* of the worst points, for each centre */
    LLOYD = 5,       /* iterations of the first clustering */
    ROUNDS = 3,      /* of assigning points and moving centres */
};

static const uint64_t seed = 20;

void joint_hidden_clear(joint_hidden *centres) {
    free(centres->codes);
    free(centres->point);
    free(centres->centre);
    free(centres->error);
    *centres = (joint_hidden){0};
}

static btf_result no_memory(const joint_rows *rows, size_t count) {
    return enc_fail(rows->context, BTF_ERROR_MEMORY, "joint: out of memory for %zu centres", count);
}

/* The worst points, and what they are. */
typedef struct worst_points {
    const joint_rows *rows;
    size_t n, stride;
    uint32_t *point; /* [n] ascending */
    float *row;      /* [n][stride] */
    float *error;    /* [n] under the best source */
    float *square;   /* [n] distance to the nearest centre */
    uint32_t *index; /* [n] nearest centre */
    uint32_t *slot;  /* [view * texels] position among them, UINT32_MAX for others */
    float *centre;   /* [count][stride] */
} worst_points;

static void worst_points_clear(worst_points *c) {
    free(c->point);
    free(c->row);
    free(c->error);
    free(c->square);
    free(c->index);
    free(c->slot);
    free(c->centre);
}

static int compare_floats(const void *a, const void *b) {
    const float x = *(const float *)a, y = *(const float *)b;
    return (x < y) - (x > y);
}

static bool is_in(void *user, size_t view, size_t texel) {
    const worst_points *c = user;
    return c->slot[view * c->rows->texels + texel] != UINT32_MAX;
}

static void take_row(void *user, size_t view, size_t texel, const float *row) {
    const worst_points *c = user;
    const uint32_t at = c->slot[view * c->rows->texels + texel];
    memcpy(c->row + at * c->stride, row, c->rows->row * sizeof(float));
}

/* The `most` points of largest error, and their rows. */
static btf_result worst_points_init(const joint_rows *rows, const float *errors, size_t most, size_t count,
                                    worst_points *c) {
    const size_t points = rows->texels * rows->views;
    float *sorted = malloc(points * sizeof *sorted);
    *c = (worst_points){
        .rows = rows, .stride = enc_kmeans_stride(rows->row), .slot = malloc(points * sizeof *c->slot)};
    if (most > points)
        most = points;
    c->point = malloc(most * sizeof *c->point);
    c->row = calloc(most * c->stride, sizeof *c->row);
    c->error = malloc(most * sizeof *c->error);
    c->square = malloc(most * sizeof *c->square);
    c->index = calloc(most, sizeof *c->index);
    c->centre = calloc(count * c->stride, sizeof *c->centre);
    const bool ok =
        sorted && c->slot && c->point && c->row && c->error && c->square && c->index && c->centre;
    if (ok) {
        memcpy(sorted, errors, points * sizeof *sorted);
        qsort(sorted, points, sizeof *sorted, compare_floats);
        for (size_t i = 0; i < points; i++) {
            const bool in = c->n < most && errors[i] >= sorted[most - 1] && errors[i] > 0.0f;
            c->slot[i] = in ? (uint32_t)c->n : UINT32_MAX;
            if (in) {
                c->point[c->n] = (uint32_t)i;
                c->error[c->n++] = errors[i];
            }
        }
    }
    free(sorted);
    return ok ? joint_rows_pick(rows, is_in, take_row, c) : no_memory(rows, count);
}

/* Centres become the means of the points that gain by them; one that nobody takes restarts at the point
 * that has the largest error left. */
static bool move_centres(worst_points *c, size_t count) {
    double *sum = calloc(count * (c->stride + 1), sizeof *sum), *members = sum + count * c->stride;
    if (!sum)
        return false;
    for (size_t i = 0; i < c->n; i++) {
        if (!(c->square[i] < c->error[i]))
            continue;
        members[c->index[i]] += 1.0;
        for (size_t p = 0; p < c->rows->row; p++)
            sum[c->index[i] * c->stride + p] += c->row[i * c->stride + p];
    }
    for (size_t k = 0; k < count; k++) {
        float *centre = c->centre + k * c->stride;
        for (size_t p = 0; p < c->rows->row && members[k] > 0.0; p++)
            centre[p] = (float)(sum[k * c->stride + p] / members[k]);
        if (members[k] > 0.0)
            continue;
        size_t worst = 0;
        for (size_t i = 1; i < c->n; i++)
            if (fminf(c->square[i], c->error[i]) > fminf(c->square[worst], c->error[worst]))
                worst = i;
        memcpy(centre, c->row + worst * c->stride, c->stride * sizeof *centre);
        c->square[worst] = 0.0f;
    }
    free(sum);
    return true;
}

/* Rounds centres to codes; they become what the codes decode to, in the fitted domain. */
static void round_off(const worst_points *c, size_t count, joint_hidden *out) {
    const size_t lights = c->rows->row / 3;
    float largest = 0.0f;
    for (size_t i = 0; i < count; i++)
        for (size_t p = 0; p < c->rows->row; p++)
            largest = fmaxf(largest, c->centre[i * c->stride + p]);
    out->scale = fmaxf((c->rows->root ? largest : sqrtf(largest)) / 255.0f, 0x1p-20f);
    for (size_t i = 0; i < count; i++)
        for (size_t p = 0; p < c->rows->row; p++) {
            float *value = c->centre + i * c->stride + p;
            const float code = rintf((c->rows->root ? *value : sqrtf(*value)) / out->scale);
            const float root = (code > 255.0f ? 255.0f : code) * out->scale;
            out->codes[(i * lights + p % lights) * 3 + p / lights] =
                (uint8_t)(code > 255.0f ? 255.0f : code);
            *value = c->rows->root ? root : root * root;
        }
}

/* The points that gain by the centres of the codes. */
static void take_members(const worst_points *c, joint_hidden *out) {
    for (size_t i = 0; i < c->n; i++) {
        const float *a = c->row + i * c->stride, *b = c->centre + c->index[i] * c->stride;
        double square = 0.0;
        for (size_t p = 0; p < c->rows->row; p++)
            square += (double)(a[p] - b[p]) * (a[p] - b[p]);
        if (!(square < c->error[i]))
            continue;
        out->point[out->n_points] = c->point[i];
        out->centre[out->n_points] = (uint16_t)c->index[i];
        out->error[out->n_points++] = (float)square;
        out->saved += c->error[i] - square;
    }
}

static btf_result cluster(worst_points *c, size_t count, joint_hidden *out) {
    size_t changed;
    btf_result result = enc_kmeans(c->n, c->stride, c->row, count, LLOYD, seed, false, c->centre, c->index);
    for (int round = 0; round <= ROUNDS && result == BTF_OK; round++) {
        result =
            enc_kmeans_nearest(c->n, c->stride, c->row, count, c->centre, c->index, c->square, &changed);
        if (result == BTF_OK && round < ROUNDS && !move_centres(c, count))
            result = BTF_ERROR_MEMORY;
    }
    out->count = count;
    out->codes = malloc(count * c->rows->row);
    out->point = malloc(c->n * sizeof *out->point);
    out->centre = malloc(c->n * sizeof *out->centre);
    out->error = malloc(c->n * sizeof *out->error);
    if (result == BTF_OK && out->codes && out->point && out->centre && out->error) {
        round_off(c, count, out);
        take_members(c, out);
        return BTF_OK;
    }
    return result == BTF_OK || result == BTF_ERROR_MEMORY ? no_memory(c->rows, count) : result;
}

btf_result joint_hidden_find(joint_fit *fit, size_t count, joint_hidden *out_centres) {
    const joint_rows *rows = fit->rows;
    worst_points c = {0};
    *out_centres = (joint_hidden){0};
    btf_result result = joint_fit_point_errors(fit);
    if (result == BTF_OK)
        result = worst_points_init(rows, fit->model.point_error, count * CANDIDATES, count, &c);
    free(fit->model.point_error);
    fit->model.point_error = NULL;
    if (count > c.n)
        count = c.n;
    if (result == BTF_OK && count > 0)
        result = cluster(&c, count, out_centres);
    if (result != BTF_OK)
        joint_hidden_clear(out_centres);
    worst_points_clear(&c);
    return result;
}

btf_result joint_hidden_apply(joint_fit *fit, joint_hidden *centres) {
    const size_t points = fit->rows->texels * fit->rows->views;
    joint_model *model = &fit->model;
    model->centre = calloc(points, sizeof *model->centre);
    model->centre_error = calloc(points, sizeof *model->centre_error);
    if (!model->centre || !model->centre_error)
        return no_memory(fit->rows, centres->count);
    for (size_t i = 0; i < centres->n_points; i++) {
        const size_t point = centres->point[i];
        model->gain[point] = 0;
        model->centre[point] = centres->centre[i];
        model->centre_error[point] = centres->error[i];
    }
    fit->effects |= BTF_EFFECT_HIDDEN;
    fit->n_centres = centres->count;
    fit->centre_scale = centres->scale;
    fit->centre_codes = centres->codes;
    centres->codes = NULL;
    joint_hidden_clear(centres);
    return BTF_OK;
}

/* Centres that the budget holds beside r->best with k components. */
static size_t centres_that_fit(const joint_run *r, size_t k) {
    joint_shape shape = joint_fit_shape(&r->best);
    shape.components = k;
    shape.effects |= BTF_EFFECT_HIDDEN;
    const uint64_t bytes = joint_bytes(r->rows.data, &shape);
    const uint64_t each = 4 * (uint64_t)r->rows.data->n_lights;
    const uint64_t most = bytes < r->budget ? (r->budget - bytes) / each : 0;
    /* one block of FORMAT.md section 3: nothing is rounded up */
    return (size_t)(most < JOINT_MOST_CENTRES ? most : JOINT_MOST_CENTRES);
}

/* r->best without its last four components, in the principal basis that it is in. */
static btf_result shorten(joint_run *r) {
    joint_fit shorter = {0};
    joint_fit_release(&r->best);
    const btf_result result =
        joint_fit_start(&r->best, r->best.model.k - JOINT_LAYER, r->best.effects, &shorter);
    if (result == BTF_OK) {
        joint_fit_clear(&r->best);
        r->best = shorter;
    } else {
        joint_fit_clear(&shorter);
    }
    return result;
}

/* The squared error that the last four components explain; brings r->best into its principal basis. */
static btf_result last_energy(joint_run *r, double *out_energy) {
    const size_t k = r->best.model.k;
    double *energy = malloc((k + 1) * sizeof *energy);
    if (!energy)
        return enc_fail(r->rows.context, BTF_ERROR_MEMORY, "joint: out of memory for %zu components", k);
    const btf_result result = joint_principal_basis(&r->rows, &r->best.model, energy);
    *out_energy = 0.0;
    for (size_t j = k - JOINT_LAYER; j < k && result == BTF_OK; j++)
        *out_energy += energy[j];
    joint_fit_release(&r->best);
    free(energy);
    return result;
}

/* Notes what centres would do; whether they are worth it. */
static bool worth_it(joint_run *r, const joint_hidden *centres, size_t k, double error) {
    joint_shape shape = joint_fit_shape(&r->best);
    shape.components = k;
    shape.effects |= BTF_EFFECT_HIDDEN;
    shape.centres = centres->count;
    const double gain = 10.0 * log10(r->best.error / fmax(error, 1e-30));
    const bool worth = centres->count > 0 && (!r->options->choose || gain >= r->options->effect_tolerance);
    joint_run_note(r, &shape, error, worth ? "best so far" : "left out");
    return worth;
}

btf_result joint_try_hidden(joint_run *r) {
    const uint32_t needed = BTF_EFFECT_SHIFT | BTF_EFFECT_GAIN;
    const size_t k = r->best.model.k, beside = centres_that_fit(r, k),
                 more = k > JOINT_LAYER ? centres_that_fit(r, k - JOINT_LAYER) : 0;
    joint_hidden few = {0}, many = {0};
    double lost = 0.0;
    btf_result result = BTF_OK;
    if (!(r->options->effects & BTF_EFFECT_HIDDEN) || (r->best.effects & needed) != needed ||
        r->best.error <= r->enough)
        return BTF_OK;
    if (beside > 0)
        result = joint_hidden_find(&r->best, beside, &few);
    if (result == BTF_OK && more > beside)
        result = joint_hidden_find(&r->best, more, &many);
    if (result == BTF_OK && more > beside)
        result = last_energy(r, &lost);
    const bool forced = !r->options->choose && few.count == 0 && many.count > 0;
    if (result == BTF_OK && (many.saved - lost > few.saved || forced)) {
        if (worth_it(r, &many, k - JOINT_LAYER, r->best.error + lost - many.saved)) {
            result = joint_hidden_apply(&r->best, &many);
            if (result == BTF_OK)
                result = shorten(r);
        }
    } else if (result == BTF_OK && few.count > 0) {
        if (worth_it(r, &few, k, r->best.error - few.saved))
            result = joint_hidden_apply(&r->best, &few);
    }
    joint_hidden_clear(&few);
    joint_hidden_clear(&many);
    if (result == BTF_OK && (r->best.effects & BTF_EFFECT_HIDDEN))
        result = joint_fit_round(&r->best);
    joint_fit_release(&r->best);
    return result;
}
