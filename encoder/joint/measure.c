/* The codes of a solution, decoded and compared with the data. See measure.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "measure.h"

#include "encoder/math/srgb.h"

#include <math.h>
#include <openbtf/material.h>
#include <stdlib.h>

enum { TABLE = 8192 }; /* steps of the sRGB curve over sqrt(L); between them it is linear to 1e-8 */

/* The data of the pass. */
typedef struct measure_pass {
    const joint_rows *rows;
    const enc_solution *solution;
    size_t pitch;   /* floats of a view's packed directions */
    float *packed;  /* [view] directions times m(l), packed */
    float *scratch; /* [thread] */
    size_t scratch_pitch;
    const float *table;
    float lights[3][ENC_MAX_DIRECTIONS]; /* components of the directions */
    joint_error *sums;                   /* [view] */
} measure_pass;

static size_t source_of(const enc_solution *s, size_t view, size_t texel) {
    if (!s->shift)
        return texel;
    const int8_t *shift = s->shift + (view * (size_t)s->width * (size_t)s->height + texel) * 2;
    int x = ((int)(texel % (size_t)s->width) + shift[0]) % s->width;
    int y = ((int)(texel / (size_t)s->width) + shift[1]) % s->height;
    x += x < 0 ? s->width : 0;
    y += y < 0 ? s->height : 0;
    return (size_t)y * (size_t)s->width + (size_t)x;
}

static float coded(const float *table, float linear) {
    if (!(linear < 1.0f))
        return 1.0f;
    const float position = sqrtf(linear) * TABLE;
    const int index = (int)position;
    return table[index] + (position - (float)index) * (table[index + 1] - table[index]);
}

static float clipped_radiance(const joint_rows *rows, float y) {
    const float linear = (rows->root ? y * y : y) * rows->scale;
    return linear < 1.0f ? linear : 1.0f;
}

/* decoded [row] += m(l) * SBRDF * shadow of one source. */
static void add_sbrdf(const measure_pass *pass, size_t view, size_t source, float *decoded) {
    const joint_rows *rows = pass->rows;
    const enc_solution *s = pass->solution;
    const size_t row = rows->row, lights = row / 3;
    float model[3 * ENC_MAX_DIRECTIONS];
    enc_sbrdf_evaluate(s->sbrdf, source, rows->data->views[view].xyz, (int)lights, pass->lights[0],
                       pass->lights[1], pass->lights[2], model);
    for (size_t p = 0; p < row; p++) {
        const float shadow =
            s->shadow ? (float)s->shadow[p % lights * rows->texels + source] * s->shadow_scale : 1.0f;
        decoded[p] += model[p] * shadow * rows->multiplier[p];
    }
}

/* decoded [row] = y of a centre. */
static void decode_centre(const joint_rows *rows, const enc_solution *s, size_t centre, float *decoded) {
    const size_t lights = rows->row / 3;
    for (size_t p = 0; p < rows->row; p++) {
        const float root =
            (float)s->centre_codes[(centre * lights + p % lights) * 3 + p / lights] * s->centre_scale;
        decoded[p] = rows->root ? root : root * root;
    }
}

static void measure_block(void *user, size_t view, size_t first, size_t count, const float *block) {
    const measure_pass *pass = user;
    const joint_rows *rows = pass->rows;
    const enc_solution *s = pass->solution;
    const size_t k = s->n_components, row = rows->row;
    float *u = pass->scratch + enc_thread_index() * pass->scratch_pitch;
    float *packed = u + JOINT_BLOCK * k, *decoded = packed + JOINT_BLOCK * k;
    joint_error *sum = pass->sums + view;
    for (size_t i = 0; i < count && k > 0; i++) {
        const int8_t *codes = s->residual_texels + source_of(s, view, first + i) * k;
        for (size_t j = 0; j < k; j++)
            u[i * k + j] = (float)codes[j] * s->residual_scales[j];
    }
    enc_gemm_pack_rows(count, k, u, k, ENC_GEMM_M, packed);
    enc_gemm_multiply(rows->tile, count, row, k, packed, pass->packed + view * pass->pitch, decoded, row,
                      0);
    for (size_t i = 0; i < count && s->sbrdf; i++)
        add_sbrdf(pass, view, source_of(s, view, first + i), decoded + i * row);
    for (size_t i = 0; i < count; i++) {
        const bool hidden = s->n_centres > 0 && s->gain[view * rows->texels + first + i] == 0;
        if (hidden)
            decode_centre(rows, s, s->centre[view * rows->texels + first + i], decoded + i * row);
        const float gain = hidden    ? 1.0f
                           : s->gain ? (float)s->gain[view * rows->texels + first + i] * s->gain_scale
                                     : 1.0f;
        for (size_t p = 0; p < row; p++) {
            const float y = fmaxf(decoded[i * row + p] * gain, 0.0f), truth = block[i * row + p];
            const float a = clipped_radiance(rows, y), b = clipped_radiance(rows, truth);
            const double coded_error = coded(pass->table, a) - coded(pass->table, b);
            sum->fitted += (double)(y - truth) * (y - truth);
            sum->linear += (double)(a - b) * (a - b);
            sum->srgb += coded_error * coded_error;
        }
    }
}

/* Directions of one view as floats, [component][row], times m(l). */
static void unpack_view(const joint_rows *rows, const enc_solution *s, size_t view, float *out) {
    const size_t k = s->n_components, lights = rows->row / 3;
    for (size_t light = 0; light < lights; light++)
        for (size_t channel = 0; channel < 3; channel++)
            for (size_t j = 0; j < k; j++) {
                const size_t p = channel * lights + light;
                out[j * rows->row + p] =
                    (float)s->residual_directions[((view * lights + light) * 3 + channel) * k + j] *
                    rows->multiplier[p];
            }
}

btf_result joint_measure(const joint_rows *rows, const enc_solution *solution, joint_error *out_error) {
    const size_t k = solution->n_components, row = rows->row, threads = (size_t)rows->context->threads;
    measure_pass pass = {.rows = rows,
                         .solution = solution,
                         .pitch = enc_gemm_panels(row, ENC_GEMM_N) * ENC_GEMM_N * k,
                         .scratch_pitch = JOINT_BLOCK * (2 * k + row)};
    float *view_directions = malloc((k * row + 1) * sizeof *view_directions);
    float *table = malloc((TABLE + 2) * sizeof *table);
    btf_result result = BTF_OK;
    pass.packed = enc_gemm_alloc(rows->views * pass.pitch);
    pass.scratch = enc_gemm_alloc(threads * pass.scratch_pitch);
    pass.sums = calloc(rows->views, sizeof *pass.sums);
    *out_error = (joint_error){0};
    if (!view_directions || !table || !pass.packed || !pass.scratch || !pass.sums) {
        result = enc_fail(rows->context, BTF_ERROR_MEMORY,
                          "joint: out of memory for measuring %zu components", k);
        goto fail;
    }
    for (int i = 0; i < TABLE + 2; i++)
        table[i] = enc_srgb_encode((float)i / TABLE * ((float)i / TABLE));
    pass.table = table;
    for (int l = 0; l < rows->data->n_lights; l++)
        for (int axis = 0; axis < 3; axis++)
            pass.lights[axis][l] = rows->data->lights[l].xyz[axis];
    for (size_t view = 0; view < rows->views; view++) {
        unpack_view(rows, solution, view, view_directions);
        enc_gemm_pack_columns(row, k, view_directions, row, ENC_GEMM_N, pass.packed + view * pass.pitch);
    }
    result = joint_rows_pass(rows, measure_block, &pass);
    result = joint_rows_gather(rows, result, pass.sums, sizeof *pass.sums);
    for (size_t view = 0; view < rows->views; view++) {
        out_error->fitted += pass.sums[view].fitted;
        out_error->linear += pass.sums[view].linear;
        out_error->srgb += pass.sums[view].srgb;
    }
fail:
    free(view_directions);
    free(table);
    free(pass.packed);
    free(pass.scratch);
    free(pass.sums);
    return result;
}

double joint_psnr(const joint_rows *rows, double squares) {
    const double samples = (double)rows->texels * (double)rows->views * (double)rows->row;
    const double mean = squares / samples;
    return mean > 1e-10 ? -10.0 * log10(mean) : 100.0;
}
