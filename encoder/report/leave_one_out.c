/* Each view and light predicted from the others. See leave_one_out.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "leave_one_out.h"

#include "decoder/toolkit/reference_view.h"
#include "encoder/base/ranks.h"
#include "encoder/base/stage.h"
#include "encoder/between/left_out.h"
#include "encoder/math/srgb.h"

#include <math.h>
#include <stdlib.h>

enum { MOST_TEXELS = 256, PAIRS = 256, SUMS = 4 };

typedef struct job {
    const enc_context *context;
    const enc_data *data;
    const btf_ref_material *material; /* or NULL */
    enc_left_out views, lights;
    size_t texels;
} job;

/* One pair of sampled directions. */
typedef struct pair {
    int view, light;                   /* of the data */
    btf_ref_neighbours views, lights; /* without what is left out */
} pair;

/* A well-mixed number of 64 bits (SplitMix64). */
static uint64_t mix(uint64_t x) {
    x += 0x9E3779B97F4A7C15u;
    x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9u;
    x = (x ^ (x >> 27)) * 0x94D049BB133111EBu;
    return x ^ (x >> 31);
}

/* One of the directions that can be left out, or where there is none any. */
static int pick(const enc_left_out *from, int count, uint64_t seed, btf_ref_neighbours *out_near) {
    const int n = from->count > 0 ? from->count : count;
    const int at = (int)(mix(seed) % (uint64_t)n);
    *out_near = from->count > 0 ? from->near[at] : (btf_ref_neighbours){.index = {0}};
    return from->count > 0 ? from->index[at] : at;
}

static btf_ref_neighbours only(int index) {
    const uint32_t i = (uint32_t)index;
    return (btf_ref_neighbours){.index = {i, i, i}, .weight = {4096, 0, 0}};
}

static bool can_leave(const job *j, int left) {
    return (!(left & ENC_LEFT_VIEW) || j->views.count > 0) && (!(left & ENC_LEFT_LIGHT) || j->lights.count > 0);
}

static float clip(float x) {
    return x > 0 ? (x < 1 ? x : 1.0f) : 0.0f;
}

/* Adds squared errors, linear and sRGB-coded. */
static void add_error(const float truth[3], const float found[3], double sum[2]) {
    for (int c = 0; c < 3; c++) {
        const double linear = (double)clip(truth[c]) - clip(found[c]);
        const double srgb = (double)enc_srgb_encode(truth[c]) - enc_srgb_encode(found[c]);
        sum[0] += linear * linear;
        sum[1] += srgb * srgb;
    }
}

/* Samples of a texel, [view][channel][light], weighted. */
static void interpolate(const enc_data *data, const float *samples, const pair *p, float out[3]) {
    const size_t lights = (size_t)data->n_lights;
    for (size_t c = 0; c < 3; c++) {
        double sum = 0;
        for (int a = 0; a < 3; a++)
            for (int b = 0; b < 3; b++)
                sum += (double)p->views.weight[a] * p->lights.weight[b] *
                       samples[(p->views.index[a] * 3 + c) * lights + p->lights.index[b]];
        out[c] = (float)(sum * 0x1p-24);
    }
}

/* One sample, predicted: sum[0..1] of the data, sum[2..3] of the material. */
static void measure_pair(const job *j, uint32_t texel, const float *samples, const pair *p, double *sum) {
    static const btf_ref_options everything = {.effects = BTF_EFFECT_ALL,
                                               .components = UINT32_MAX,
                                               .interpolation = BTF_REF_LINEAR,
                                               .filter = BTF_REF_TEXEL};
    const enc_data *data = j->data;
    const pair at = {.views = only(p->view), .lights = only(p->light)};
    float truth[3], found[3];
    interpolate(data, samples, &at, truth);
    interpolate(data, samples, p, found);
    add_error(truth, found, sum);
    if (j->material) {
        const uint32_t width = j->material->width;
        btf_ref_evaluate_neighbours(j->material, &everything, texel % width, texel / width, &p->lights,
                                    &p->views, data->lights[p->light].xyz, data->views[p->view].xyz, found);
        add_error(truth, found, sum + 2);
    }
}

/* A pair and what the others have in its place. A light that stood elsewhere than its direction says shows no truth
 * of it: another is taken, unless chance will have none. */
static pair pick_pair(const job *j, uint64_t seed) {
    const enc_moved_light *moved = j->data->moved_light;
    pair p;
    p.view = pick(&j->views, j->data->n_views, seed, &p.views);
    for (uint64_t try = 0; try < 8; try++) {
        p.light = pick(&j->lights, j->data->n_lights, mix(seed + 1) + try, &p.lights);
        if (!moved || moved[p.view].index != p.light)
            break;
    }
    return p;
}

/* All pairs of one texel: sums[left out][SUMS]. */
static btf_result measure_texel(const job *j, size_t index, float *buffer, double *sums) {
    const size_t count = enc_data_texel_count(j->data), first = index * count / j->texels;
    const size_t texel = first + mix(index) % ((index + 1) * count / j->texels - first);
    const float *samples;
    const btf_result result = enc_data_texels(j->context, j->data, texel, 1, buffer, &samples);
    for (uint64_t n = 0; result == BTF_OK && n < PAIRS; n++) {
        const pair both = pick_pair(j, 2 * (index * PAIRS + n));
        for (int left = ENC_LEFT_VIEW; left <= ENC_LEFT_BOTH; left++) {
            const pair p = {.view = both.view,
                            .light = both.light,
                            .views = left & ENC_LEFT_VIEW ? both.views : only(both.view),
                            .lights = left & ENC_LEFT_LIGHT ? both.lights : only(both.light)};
            if (can_leave(j, left))
                measure_pair(j, (uint32_t)texel, samples, &p, sums + left * SUMS);
        }
    }
    return result;
}

/* sums[texel][left out][SUMS], of which each rank fills its own. */
static btf_result measure(const job *j, double *sums) {
    const size_t length = (1 + ENC_LEFT_BOTH) * SUMS;
    btf_result result = BTF_OK;
    size_t first, end;
    enc_ranks_range(j->context, j->texels, &first, &end);
#pragma omp parallel for schedule(dynamic) num_threads(j->context->threads)
    for (size_t i = first; i < end; i++) {
        float *buffer = malloc(enc_data_texel_stride(j->data) * sizeof *buffer);
        const btf_result mine = !buffer                      ? BTF_ERROR_MEMORY
                                : enc_cancelled(j->context) ? BTF_ERROR_INTERRUPTED
                                                            : measure_texel(j, i, buffer, sums + i * length);
        free(buffer);
        enc_stage_step(j->context, 1);
        if (mine != BTF_OK) {
#pragma omp atomic write
            result = mine;
        }
    }
    return enc_ranks_gather(j->context, result, sums, length * sizeof *sums, j->texels);
}

static void sum_up(const job *j, const double *sums, enc_leave_one_out *out) {
    const double count = 3.0 * PAIRS * (double)j->texels;
    for (int left = ENC_LEFT_VIEW; left <= ENC_LEFT_BOTH; left++) {
        double all[SUMS] = {0};
        for (size_t t = 0; t < j->texels; t++)
            for (int k = 0; k < SUMS; k++)
                all[k] += sums[(t * (1 + ENC_LEFT_BOTH) + (size_t)left) * SUMS + (size_t)k];
        if (!can_leave(j, left))
            continue;
        out->error[left].data = (enc_error_sum){all[0], all[1], count};
        if (j->material)
            out->error[left].material = (enc_error_sum){all[2], all[3], count};
    }
}

btf_result enc_leave_one_out_measure(const enc_context *context, const enc_data *data,
                                     const btf_material *material, enc_leave_one_out *out) {
    btf_ref_material reference;
    job j = {.context = context, .data = data, .material = material ? &reference : NULL};
    const size_t count = enc_data_texel_count(data);
    j.texels = count < MOST_TEXELS ? count : MOST_TEXELS;
    *out = (enc_leave_one_out){0};
    if (material)
        reference_view(material, 0, &reference);
    double *sums = calloc(j.texels * (1 + ENC_LEFT_BOTH) * SUMS, sizeof *sums);
    enc_stage_begin(context, "leave one out", j.texels);
    btf_result result = sums ? BTF_OK : BTF_ERROR_MEMORY;
    if (result == BTF_OK)
        result = enc_left_out_make(context, data->views, data->n_views, &j.views);
    if (result == BTF_OK)
        result = enc_left_out_make(context, data->lights, data->n_lights, &j.lights);
    result = enc_ranks_agree(context, result);
    if (result == BTF_OK)
        result = measure(&j, sums);
    enc_stage_end(context);
    if (result == BTF_OK) {
        out->views = j.views.count;
        out->lights = j.lights.count;
        sum_up(&j, sums, out);
    }
    free(sums);
    return result == BTF_ERROR_MEMORY ? enc_fail(context, result, "leave one out: out of memory") : result;
}

static const char *const left_names[] = {"", "view", "light", "both"};

static const char *errors_text(const enc_error_sum *sum, char text[32]) {
    if (sum->count > 0)
        snprintf(text, 32, "%.2f / %.2f", enc_psnr_linear(sum), enc_psnr_srgb(sum));
    else
        text[0] = '\0';
    return text;
}

void enc_leave_one_out_print(const enc_leave_one_out *measured, FILE *out) {
    char first[32], second[32];
    if (measured->views == 0 && measured->lights == 0)
        return;
    fprintf(out,
            "Between the samples, estimated: %d views and %d lights left out, each predicted from the others\n"
            "(PSNR in dB, linear / sRGB; they lie twice as far away as for a direction between samples, which\n"
            "overstates the error, most where relief, shadows or highlights move)\n",
            measured->views, measured->lights);
    fprintf(out, "  %-20s %18s %18s\n", "left out", "data, interpolated", "material");
    for (int left = ENC_LEFT_VIEW; left <= ENC_LEFT_BOTH; left++) {
        const enc_left_out_errors *e = &measured->error[left];
        if (e->data.count > 0)
            fprintf(out, "  %-20s %18s %18s\n", left_names[left], errors_text(&e->data, first),
                    errors_text(&e->material, second));
    }
}

void enc_leave_one_out_json(json *j, const char *key, const enc_leave_one_out *measured) {
    json_object(j, key);
    json_integer(j, "views", measured->views);
    json_integer(j, "lights", measured->lights);
    for (int left = ENC_LEFT_VIEW; left <= ENC_LEFT_BOTH; left++) {
        const enc_left_out_errors *e = &measured->error[left];
        if (e->data.count == 0) {
            json_null(j, left_names[left]);
            continue;
        }
        const bool material = e->material.count > 0;
        json_object(j, left_names[left]);
        json_number(j, "linear", material ? enc_psnr_linear(&e->material) : NAN);
        json_number(j, "srgb", material ? enc_psnr_srgb(&e->material) : NAN);
        json_number(j, "data_linear", enc_psnr_linear(&e->data));
        json_number(j, "data_srgb", enc_psnr_srgb(&e->data));
        json_end(j);
    }
    json_end(j);
}
