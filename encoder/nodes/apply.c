/* Fitted values at the nodes. See apply.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "apply.h"

#include "encoder/base/ranks.h"
#include "encoder/base/stage.h"
#include "encoder/math/gemm.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The data and tables that the threads share. */
typedef struct pass {
    const enc_context *context;
    const enc_node_tables *tables;
    const enc_node_relief *relief; /* NULL: none */
    int32_t (*slope)[2];           /* with relief: of each view */
    const enc_data *from;
    enc_data *to;
    enc_gemm_tile tile;
    float *views, *lights; /* packed */
    size_t each;           /* floats of a thread's work */
} pass;

static void to_blended(size_t n, const float *samples, bool roots, float *out) {
    for (size_t i = 0; i < n; i++) {
        out[i] = roots ? sqrtf(samples[i]) : samples[i];
    }
}

static void to_samples(size_t n, float *io, bool roots) {
    for (size_t i = 0; i < n; i++) {
        const float x = io[i], y = roots ? x * fabsf(x) : x > 0 ? x : 0.0f, low = y < FLT_MAX ? y : FLT_MAX;
        io[i] = low > -FLT_MAX ? low : -FLT_MAX;
    }
}

static size_t up(size_t n) {
    return (n + 15) / 16 * 16;
}

static const float least_weight = 0.01f; /* where views are shifted, one that weighs less is left out */

/* Adds to out [n] the values of a view, roots or radiance, fetched around a place, times `weight`. */
static void add_view(const pass *p, size_t view, const enc_warp_fetch *f, float weight, float *out) {
    const size_t n = 3 * (size_t)p->from->n_lights, views = (size_t)p->from->n_views;
    for (int c = 0; c < 4; c++) {
        const float w = weight * f->weight[c], *samples = p->from->samples + (f->texel[c] * views + view) * n;
        for (size_t i = 0; i < n && w != 0; i++) {
            out[i] += w * (p->tables->roots ? sqrtf(samples[i]) : samples[i]);
        }
    }
}

/* Fits the values of node a at a texel from views that are shifted along the surface. own: the samples of
 * view a there. */
static void shift_row(const pass *p, size_t texel, size_t a, const float *own, float *out) {
    const size_t n = 3 * (size_t)p->from->n_lights, views = (size_t)p->from->n_views;
    const enc_warp *w = p->relief->surface;
    const float *weight = p->tables->views + a * views;
    float whole = 0, used = 0;
    int32_t at[2];
    enc_warp_middle(w, texel, at);
    const int32_t z = enc_warp_march(w, at[0], at[1], p->slope[a]);
    const int32_t u = at[0] + enc_warp_move(w, z, p->slope[a][0]), v = at[1] + enc_warp_move(w, z, p->slope[a][1]);
    for (size_t b = 0; b < views; b++) {
        whole += fabsf(weight[b]) >= least_weight ? weight[b] : 0;
    }
    memset(out, 0, n * sizeof *out);
    for (size_t b = 0; b < views; b++) {
        if (fabsf(weight[b]) < least_weight) {
            continue;
        }
        const int32_t x = u - enc_warp_move(w, z, p->slope[b][0]), y = v - enc_warp_move(w, z, p->slope[b][1]);
        const int32_t above = w->heights ? enc_warp_march(w, x, y, p->slope[b]) - z : 0;
        const float share = weight[b] / whole * (float)enc_warp_visible(w, above) / ENC_WARP_WEIGHT;
        enc_warp_fetch fetch;
        enc_warp_around(w, x, y, &fetch);
        add_view(p, b, &fetch, share, out);
        used += share;
    }
    for (size_t i = 0; i < n; i++) {
        out[i] += (1 - used) * own[i];
    }
}

/* Multiplies values [view][channel][light] by the weights of the views, in place. shifted: room for as many
 * values. */
static void apply_views(const pass *p, size_t texel, float *values, float *right, float *shifted) {
    const size_t views = (size_t)p->from->n_views, n = 3 * (size_t)p->from->n_lights;
    enc_gemm_pack_columns(n, views, values, n, ENC_GEMM_N, right);
    enc_gemm_multiply(p->tile, views, n, views, p->views, right, shifted, n, 0);
    for (size_t a = 0; a < views && p->relief; a++) {
        if (p->relief->views[a]) {
            shift_row(p, texel, a, values + a * n, shifted + a * n);
        }
    }
    memcpy(values, shifted, views * n * sizeof *values);
}

/* Fits one texel. work: its values, both packed operands, the product with the lights, samples as read. */
static btf_result apply_texel(const pass *p, size_t texel, float *work) {
    const size_t views = (size_t)p->from->n_views, lights = (size_t)p->from->n_lights;
    const size_t stride = 3 * views * lights;
    float *values = work, *left = values + up(stride), *half = left + up((3 * views + ENC_GEMM_M) * lights),
          *right = half + up(stride), *read = right + up((3 * lights + ENC_GEMM_N) * views);
    const float *samples;
    btf_result result = enc_cancelled(p->context)
                            ? BTF_ERROR_INTERRUPTED
                            : enc_data_texels(p->context, p->from, texel, 1, read, &samples);
    if (result != BTF_OK) {
        return result;
    }
    to_blended(stride, samples, p->tables->roots, values);
    if (p->relief) { /* views first, since the samples that are fetched from other texels are not fitted */
        apply_views(p, texel, values, right, half);
    }
    enc_gemm_pack_rows(3 * views, lights, values, lights, ENC_GEMM_M, left);
    enc_gemm_multiply(p->tile, 3 * views, lights, lights, left, p->lights, half, lights, 0);
    if (p->relief) {
        memcpy(values, half, stride * sizeof *values);
    } else {
        enc_gemm_pack_columns(3 * lights, views, half, 3 * lights, ENC_GEMM_N, right);
        enc_gemm_multiply(p->tile, views, 3 * lights, views, p->views, right, values, 3 * lights, 0);
    }
    to_samples(stride, values, p->tables->roots);
    return enc_data_store_texels(p->context, p->to, texel, 1, values);
}

static btf_result apply_all(const pass *p) {
    float *work = enc_gemm_alloc((size_t)p->context->threads * p->each);
    btf_result result = work ? BTF_OK : BTF_ERROR_MEMORY;
    size_t begin, end;
    enc_ranks_range(p->context, enc_data_texel_count(p->from), &begin, &end);
#pragma omp parallel for schedule(dynamic, 4) num_threads(p->context->threads) if (work)
    for (size_t t = begin; t < (work ? end : begin); t++) {
        const btf_result mine = apply_texel(p, t, work + enc_thread_index() * p->each);
        enc_keep_worse(&result, mine);
        enc_stage_step(p->context, 1);
    }
    free(work);
    return result;
}

static btf_result fill(pass *p) {
    const size_t views = (size_t)p->from->n_views, lights = (size_t)p->from->n_lights;
    p->tile = enc_gemm_select();
    p->views = enc_gemm_alloc((views + ENC_GEMM_M) * views);
    p->lights = enc_gemm_alloc((lights + ENC_GEMM_N) * lights);
    p->each = 3 * up(3 * views * lights) + up((3 * views + ENC_GEMM_M) * lights) +
              up((3 * lights + ENC_GEMM_N) * views);
    p->slope = malloc(views * sizeof *p->slope);
    btf_result result = p->views && p->lights && p->slope ? BTF_OK : BTF_ERROR_MEMORY;
    for (size_t v = 0; v < views && p->slope; v++) {
        enc_warp_slope(p->from->views[v].xyz, p->slope[v]);
    }
    if (result == BTF_OK) {
        enc_gemm_pack_rows(views, views, p->tables->views, views, ENC_GEMM_M, p->views);
        enc_gemm_pack_rows(lights, lights, p->tables->lights, lights, ENC_GEMM_N, p->lights);
        result = apply_all(p);
    }
    free(p->views);
    free(p->lights);
    free(p->slope);
    return result;
}

/* The context with the memory that the samples of `data` leave of the allowed one. */
static enc_context beside(const enc_context *context, const enc_data *data) {
    const size_t held =
        data->samples ? enc_data_texel_count(data) * enc_data_texel_stride(data) * sizeof(float) : 0;
    enc_context rest = *context;
    if (rest.memory > 0) {
        rest.memory = rest.memory > held ? rest.memory - held : 1;
    }
    return rest;
}

btf_result enc_node_apply(const enc_context *context, const enc_node_tables *tables, const enc_node_relief *relief,
                          const enc_data *data, enc_data **out_data) {
    const enc_context rest = beside(context, data);
    pass p = {.context = context,
              .tables = tables,
              .relief = relief && data->samples ? relief : NULL,
              .from = data};
    btf_result result = enc_data_create(&rest, data->width, data->height, data->n_views, data->views,
                                        data->n_lights, data->lights, out_data);
    if (result != BTF_OK) {
        return result;
    }
    p.to = *out_data;
    p.to->original = data;
    enc_stage_begin(context, "fit nodes", enc_data_texel_count(data));
    result = enc_data_copy_lights(data, p.to);
    if (result == BTF_OK) {
        result = fill(&p);
    }
    result = enc_data_complete(&rest, p.to, result);
    enc_stage_end(context);
    if (result != BTF_OK) {
        enc_data_destroy(out_data);
    }
    return result == BTF_ERROR_MEMORY ? enc_fail(context, result, "fit of nodes: out of memory") : result;
}
