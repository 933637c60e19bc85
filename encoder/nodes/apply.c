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

/* One texel. work: its values, both packed operands, the product with the lights, samples as read. */
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
    enc_gemm_pack_rows(3 * views, lights, values, lights, ENC_GEMM_M, left);
    enc_gemm_multiply(p->tile, 3 * views, lights, lights, left, p->lights, half, lights, 0);
    enc_gemm_pack_columns(3 * lights, views, half, 3 * lights, ENC_GEMM_N, right);
    enc_gemm_multiply(p->tile, views, 3 * lights, views, p->views, right, values, 3 * lights, 0);
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
        if (mine != BTF_OK) {
#pragma omp atomic write
            result = mine;
        }
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
    btf_result result = p->views && p->lights ? BTF_OK : BTF_ERROR_MEMORY;
    if (result == BTF_OK) {
        enc_gemm_pack_rows(views, views, p->tables->views, views, ENC_GEMM_M, p->views);
        enc_gemm_pack_rows(lights, lights, p->tables->lights, lights, ENC_GEMM_N, p->lights);
        result = apply_all(p);
    }
    free(p->views);
    free(p->lights);
    return result;
}

/* The allowed memory less the samples that lie in it. */
static enc_context beside(const enc_context *context, const enc_data *data) {
    const size_t held =
        data->samples ? enc_data_texel_count(data) * enc_data_texel_stride(data) * sizeof(float) : 0;
    enc_context rest = *context;
    if (rest.memory > 0) {
        rest.memory = rest.memory > held ? rest.memory - held : 1;
    }
    return rest;
}

btf_result enc_node_apply(const enc_context *context, const enc_node_tables *tables, const enc_data *data,
                          enc_data **out_data) {
    const enc_context rest = beside(context, data);
    pass p = {.context = context, .tables = tables, .from = data};
    btf_result result = enc_data_create(&rest, data->width, data->height, data->n_views, data->views,
                                        data->n_lights, data->lights, out_data);
    if (result != BTF_OK) {
        return result;
    }
    p.to = *out_data;
    p.to->original = data;
    enc_stage_begin(context, "fit nodes", enc_data_texel_count(data));
    result = enc_data_copy_lights(data, p.to);
    result = result == BTF_OK ? fill(&p) : result;
    result = enc_data_complete(&rest, p.to, result);
    enc_stage_end(context);
    if (result != BTF_OK) {
        enc_data_destroy(out_data);
    }
    return result == BTF_ERROR_MEMORY ? enc_fail(context, result, "fit of nodes: out of memory") : result;
}
