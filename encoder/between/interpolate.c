/* Weights of samples in a direction between them. See interpolate.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "interpolate.h"

#include <openbtf/reference.h>

#include <math.h>
#include <openbtf/material.h>
#include <stdlib.h>
#include <string.h>

struct enc_interpolator {
    enc_interpolation kind;
    int count;
    btf_material *tables; /* of one texel: what holds the decoder's table of these directions */
    const uint16_t *table;
    uint32_t grid;
    int size;           /* of the spline's system: count + 3, or 0 */
    double (*place)[2]; /* [count] in the stereographic plane */
    double *factors;    /* [size][size]: L and U of the system, rows as `row` has them */
    int *row;           /* [size] */
};

/* A material of one texel with these directions as views: the decoder's own triangulation and table. */
static btf_result make_tables(const enc_context *context, const enc_direction *directions, int count,
                              enc_interpolator *out) {
    static const int8_t texel[4] = {0};
    static const float scales[4] = {1, 0, 0, 0}, pole[3] = {0, 0, 1};
    float xyz[ENC_MAX_DIRECTIONS][3];
    for (int i = 0; i < count; i++)
        memcpy(xyz[i], directions[i].xyz, sizeof xyz[i]);
    btf_material_desc desc = {.struct_size = sizeof desc,
                              .info = {.struct_size = sizeof desc.info,
                                       .layout = BTF_LAYOUT_TIGHT,
                                       .domain = BTF_DOMAIN_LINEAR,
                                       .colour = BTF_COLOUR_NONE,
                                       .width = 1,
                                       .height = 1,
                                       .n_views = (uint32_t)count,
                                       .n_lights = 1,
                                       .levels = 1,
                                       .effects = BTF_EFFECT_RESIDUAL,
                                       .components = 1,
                                       .radiance_scale = 1,
                                       .shadow_scale = 1,
                                       .gain_scale = 1,
                                       .centre_scale = 1},
                              .views = xyz[0],
                              .lights = pole};
    int8_t *none = calloc((size_t)count * 3, 4);
    desc.texture[BTF_TEXTURE_RESIDUAL_TEXELS] = texel;
    desc.texture[BTF_TEXTURE_RESIDUAL_DIRECTIONS] = none;
    desc.texture[BTF_TEXTURE_RESIDUAL_SCALES] = scales;
    const btf_result result =
        none ? btf_material_create(&desc, context ? &context->log : NULL, &out->tables) : BTF_ERROR_MEMORY;
    free(none);
    if (result == BTF_OK) {
        out->table = btf_material_texture(out->tables, BTF_TEXTURE_VIEW_TABLE).data;
        out->grid = btf_material_views(out->tables).grid;
    }
    return result;
}

/* Stereographic projection, not quantised. */
static void place(const float xyz[3], double out[2]) {
    out[0] = xyz[0] / (1.0 + xyz[2]);
    out[1] = xyz[1] / (1.0 + xyz[2]);
}

/* The kernel of thin plates, r^2 log r. */
static double kernel(const double a[2], const double b[2]) {
    const double x = a[0] - b[0], y = a[1] - b[1], square = x * x + y * y;
    return square > 0 ? 0.5 * square * log(square) : 0.0;
}

/* The spline's values at `at` as a combination of its coefficients: kernels around the samples, then 1, x
 * and y. */
static void basis(const enc_interpolator *s, const double at[2], double *out) {
    for (int i = 0; i < s->count; i++)
        out[i] = kernel(at, s->place[i]);
    out[s->count] = 1;
    out[s->count + 1] = at[0];
    out[s->count + 2] = at[1];
}

/* L U of the matrix in place, with exchanges of rows. False for a singular one. */
static bool factorise(int n, double *a, int *row) {
    for (int i = 0; i < n; i++)
        row[i] = i;
    for (int k = 0; k < n; k++) {
        int pivot = k;
        for (int i = k + 1; i < n; i++)
            if (fabs(a[row[i] * n + k]) > fabs(a[row[pivot] * n + k]))
                pivot = i;
        const int swap = row[k];
        row[k] = row[pivot];
        row[pivot] = swap;
        const double *top = a + row[k] * n;
        if (!(fabs(top[k]) > 1e-10))
            return false;
        for (int i = k + 1; i < n; i++) {
            double *line = a + row[i] * n;
            line[k] /= top[k];
            for (int j = k + 1; j < n; j++)
                line[j] -= line[k] * top[j];
        }
    }
    return true;
}

static void solve(int n, const double *a, const int *row, const double *right, double *out) {
    for (int i = 0; i < n; i++) {
        out[i] = right[row[i]];
        for (int j = 0; j < i; j++)
            out[i] -= a[row[i] * n + j] * out[j];
    }
    for (int i = n - 1; i >= 0; i--) {
        for (int j = i + 1; j < n; j++)
            out[i] -= a[row[i] * n + j] * out[j];
        out[i] /= a[row[i] * n + i];
    }
}

/* The symmetric system whose solution for basis(d) begins with the weights of the samples at d. */
static btf_result make_spline(const enc_context *context, const char *name, const enc_direction *directions,
                              enc_interpolator *out) {
    const int n = out->count + 3;
    out->place = malloc((size_t)out->count * sizeof *out->place);
    out->factors = calloc((size_t)n * (size_t)n, sizeof *out->factors);
    out->row = malloc((size_t)n * sizeof *out->row);
    if (!out->place || !out->factors || !out->row)
        return BTF_ERROR_MEMORY;
    for (int i = 0; i < out->count; i++)
        place(directions[i].xyz, out->place[i]);
    for (int i = 0; i < out->count; i++) {
        basis(out, out->place[i], out->factors + i * n);
        for (int j = 0; j < 3; j++)
            out->factors[(out->count + j) * n + i] = out->factors[i * n + out->count + j];
    }
    out->size = n;
    if (!factorise(n, out->factors, out->row))
        return enc_fail(
            context, BTF_ERROR_UNSUPPORTED,
            "%d %s are too few for a thin-plate spline, or lie in one line: three that do not are "
            "needed",
            out->count, name);
    return BTF_OK;
}

btf_result enc_interpolator_create(const enc_context *context, const char *name,
                                   const enc_direction *directions, int count, enc_interpolation kind,
                                   enc_interpolator **out_interpolator) {
    enc_interpolator *made = calloc(1, sizeof *made);
    btf_result result = made ? BTF_OK : BTF_ERROR_MEMORY;
    *out_interpolator = NULL;
    if (made) {
        made->kind = kind;
        made->count = count;
    }
    if (result == BTF_OK && kind != ENC_INTERPOLATE_SPLINE)
        result = make_tables(context, directions, count, made);
    else if (result == BTF_OK && count > 1) /* of a single sample, the weight is 1 */
        result = make_spline(context, name, directions, made);
    if (result != BTF_OK)
        enc_interpolator_destroy(&made);
    *out_interpolator = made;
    return result == BTF_ERROR_MEMORY
               ? enc_fail(context, result, "interpolation of %d %s: out of memory", count, name)
               : result;
}

void enc_interpolator_destroy(enc_interpolator **interpolator) {
    if (!interpolator || !*interpolator)
        return;
    btf_material_close(&(*interpolator)->tables);
    free((*interpolator)->place);
    free((*interpolator)->factors);
    free((*interpolator)->row);
    free(*interpolator);
    *interpolator = NULL;
}

static void table_weights(const enc_interpolator *s, const float to[3], enc_weights *out) {
    int32_t q[2];
    btf_ref_project(to, q);
    btf_ref_neighbours near = btf_ref_lookup(s->table, s->grid, q);
    if (s->kind == ENC_INTERPOLATE_NEAREST)
        near = btf_ref_nearest(near);
    out->count = 0;
    for (int i = 0; i < 3; i++) {
        if (near.weight[i] == 0)
            continue;
        out->index[out->count] = near.index[i];
        out->weight[out->count++] = (float)near.weight[i] * 0x1p-12f;
    }
}

static void spline_weights(const enc_interpolator *s, const float to[3], enc_weights *out) {
    double at[2], right[259], x[259];
    out->count = s->count;
    for (int i = 0; i < s->count; i++)
        out->index[i] = (uint32_t)i;
    if (s->size == 0) {
        out->weight[0] = 1;
        return;
    }
    place(to, at);
    basis(s, at, right);
    solve(s->size, s->factors, s->row, right, x);
    for (int i = 0; i < s->count; i++)
        out->weight[i] = (float)x[i];
}

void enc_interpolator_weights(const enc_interpolator *interpolator, const float to[3], enc_weights *out) {
    if (interpolator->kind == ENC_INTERPOLATE_SPLINE)
        spline_weights(interpolator, to, out);
    else
        table_weights(interpolator, to, out);
}

double enc_nearest_angle(const enc_direction *directions, int count, const float to[3]) {
    double least = HUGE_VAL; /* of the chord, which small angles do not lose their digits in */
    for (int i = 0; i < count; i++) {
        double square = 0;
        for (int axis = 0; axis < 3; axis++) {
            const double step = (double)directions[i].xyz[axis] - to[axis];
            square += step * step;
        }
        least = fmin(least, square);
    }
    return 2 * asin(fmin(sqrt(least) / 2, 1)) * 180 / 3.14159265358979323846;
}
