/* Each view and light predicted from the others. See leave_one_out.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "leave_one_out.h"

#include "drawn_texels.h"
#include "encoder/base/ranks.h"
#include "encoder/base/stage.h"
#include "encoder/data/level_filter.h"
#include "encoder/nodes/left_out.h"
#include "encoder/math/srgb.h"
#include "encoder/model/evaluator.h"
#include "left_out_lights.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { SUMS = 8, WITHOUT_RELIEF = 4, WITHOUT_GLOSS = 8 /* in the numbers of rows */ };

/* The directions of a band from which pairs are drawn: those that can be left out, or all where none
 * can. */
typedef struct pool {
    int count, member[ENC_MAX_DIRECTIONS]; /* in the list */
    bool can_leave; /* each member lies among the other directions, and `near` has its neighbours there */
    btf_ref_neighbours near[ENC_MAX_DIRECTIONS];
} pool;

typedef struct job {
    const enc_context *context;
    const enc_data *data;
    const enc_evaluator *material; /* or NULL */
    const btf_material *packed;    /* or NULL */
    bool relief;                   /* it holds relief, which acts on the present level */
    enc_left_out_lights *gloss;    /* or NULL: it holds no gloss */
    int view_bands, light_bands;
    size_t cells; /* pairs of bands */
    pool views[BTF_MAX_BANDS], lights[BTF_MAX_BANDS];
    size_t texels, pairs;   /* pairs: drawn for a texel in a cell */
    enc_leave_one_out *out; /* [levels] */
} job;

/* One pair of sampled directions. */
typedef struct pair {
    int view, light;                  /* of the data */
    btf_ref_neighbours views, lights; /* among the directions that are not left out */
} pair;

static int pick(const pool *from, uint64_t seed, btf_ref_neighbours *out_near) {
    const size_t at = (size_t)(enc_mix(seed) % (uint64_t)from->count);
    *out_near = from->near[at];
    return from->member[at];
}

static btf_ref_neighbours only(int index) {
    const uint32_t i = (uint32_t)index;
    return (btf_ref_neighbours){.index = {i, i, i}, .weight = {4096, 0, 0}};
}

static bool can_leave(const pool *views, const pool *lights, int left) {
    return (!(left & ENC_LEFT_VIEW) || views->can_leave) && (!(left & ENC_LEFT_LIGHT) || lights->can_leave);
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

/* Interpolates the samples of a texel, [view][channel][light], at a pair. */
static void interpolate(const enc_data *data, const float *samples, const pair *p, float out[3]) {
    const size_t lights = (size_t)data->n_lights;
    for (size_t c = 0; c < 3; c++) {
        double sum = 0;
        for (int a = 0; a < 3; a++) {
            for (int b = 0; b < 3; b++) {
                sum += (double)p->views.weight[a] * p->lights.weight[b] *
                       samples[(p->views.index[a] * 3 + c) * lights + p->lights.index[b]];
            }
        }
        out[c] = (float)(sum * 0x1p-24);
    }
}

/* Decodes the material with some effects and adds its error. lights: those of each neighbouring view; NULL:
 * no gloss. */
static void decode_pair(const job *j, enc_evaluated_texel *texel, const pair *p,
                        const btf_ref_neighbours *lights, uint32_t effects, const float truth[3],
                        double sum[2]) {
    static const uint32_t all = UINT32_MAX;
    const btf_ref_options options = {
        .effects = effects, .interpolation = BTF_REF_LINEAR, .filter = BTF_REF_TEXEL};
    const enc_evaluated_at directions = {.lights = lights ? lights : &p->lights,
                                         .views = &p->views,
                                         .light = j->data->lights[p->light].xyz,
                                         .view = j->data->views[p->view].xyz,
                                         .apart = lights};
    float found[1][3];
    enc_evaluate(texel, &options, &directions, &all, 1, found);
    add_error(truth, found[0], sum);
}

/* Predicts one sample and adds the errors: sum[0..1] of the data, sum[2..3] of the material, sum[4..5] and
 * sum[6..7] of the material without relief and without gloss, which act where a view is left out. */
static void measure_pair(const job *j, enc_evaluated_texel *texel, const float *samples, const pair *p,
                         int left, double *sum) {
    const enc_data *data = j->data;
    const pair at = {.views = only(p->view), .lights = only(p->light)};
    const bool view_left = left & ENC_LEFT_VIEW;
    btf_ref_neighbours lights[3];
    float truth[3], found[1][3];
    interpolate(data, samples, &at, truth);
    interpolate(data, samples, p, found[0]);
    add_error(truth, found[0], sum);
    if (!texel) {
        return;
    }
    const bool shared = j->gloss && view_left;
    if (shared) {
        enc_left_out_lights_find(j->gloss, p->view, &p->views, p->light, left & ENC_LEFT_LIGHT, lights);
    }
    decode_pair(j, texel, p, shared ? lights : NULL, BTF_EFFECT_ALL, truth, sum + 2);
    if (j->relief && view_left) {
        decode_pair(j, texel, p, shared ? lights : NULL, BTF_EFFECT_ALL & ~(uint32_t)BTF_EFFECT_RELIEF,
                    truth, sum + 4);
    }
    if (shared) {
        decode_pair(j, texel, p, NULL, BTF_EFFECT_ALL & ~(uint32_t)BTF_EFFECT_GLOSS, truth, sum + 6);
    }
}

/* Draws a pair, and finds its neighbours among the other directions. A light that stood elsewhere than its
 * direction says gives no truth there, so that another is drawn, eight times at most. */
static pair pick_pair(const job *j, size_t cell, uint64_t seed) {
    const enc_moved_light *moved = j->data->moved_light;
    pair p;
    p.view = pick(&j->views[cell / (size_t)j->light_bands], seed, &p.views);
    for (uint64_t try = 0; try < 8; try++) {
        p.light = pick(&j->lights[cell % (size_t)j->light_bands], enc_mix(seed + 1) + try, &p.lights);
        if (!moved || moved[p.view].index != p.light) {
            break;
        }
    }
    return p;
}

/* Adds the errors of one texel in one pair of bands: sums[left out][SUMS]. */
static void measure_cell(const job *j, enc_evaluated_texel *texel, const float *samples, size_t cell,
                         uint64_t seed, double *sums, size_t stride) {
    const pool *views = &j->views[cell / (size_t)j->light_bands];
    const pool *lights = &j->lights[cell % (size_t)j->light_bands];
    for (size_t n = 0; n < j->pairs; n++) {
        const pair both = pick_pair(j, cell, 2 * (seed + n));
        for (int left = ENC_LEFT_VIEW; left <= ENC_LEFT_BOTH; left++) {
            const pair p = {.view = both.view,
                            .light = both.light,
                            .views = left & ENC_LEFT_VIEW ? both.views : only(both.view),
                            .lights = left & ENC_LEFT_LIGHT ? both.lights : only(both.light)};
            if (can_leave(views, lights, left)) {
                measure_pair(j, texel, samples, &p, left, sums + (size_t)left * stride);
            }
        }
    }
}

/* Adds the errors of all pairs of one texel: sums[left out][cell][SUMS]. Errors: BTF_ERROR_MEMORY. */
static btf_result measure_texel(const void *user, size_t index, size_t texel, const float *samples,
                                double *sums) {
    const job *j = user;
    enc_evaluated_texel *evaluated = j->material ? enc_evaluated_texel_create(j->material, texel) : NULL;
    if (j->material && !evaluated) {
        return BTF_ERROR_MEMORY;
    }
    for (size_t cell = 0; cell < j->cells; cell++) {
        measure_cell(j, evaluated, samples, cell, (index * j->cells + cell) * j->pairs, sums + cell * SUMS,
                     j->cells * SUMS);
    }
    enc_stage_step(j->context, 1);
    enc_evaluated_texel_destroy(&evaluated);
    return BTF_OK;
}

static void add_mean(enc_left_out_errors *to, const enc_left_out_errors *from, double share) {
    to->data.linear += share * from->data.linear;
    to->data.srgb += share * from->data.srgb;
    to->material.linear += share * from->material.linear;
    to->material.srgb += share * from->material.srgb;
    to->no_relief.linear += share * from->no_relief.linear;
    to->no_relief.srgb += share * from->no_relief.srgb;
    to->no_gloss.linear += share * from->no_gloss.linear;
    to->no_gloss.srgb += share * from->no_gloss.srgb;
}

/* Turns the sums of one cell over all texels into means. */
static enc_left_out_errors cell_errors(const job *j, const double *sums, int left, size_t cell) {
    const double *all = sums + ((size_t)left * j->cells + cell) * SUMS;
    const double count = 3.0 * (double)(j->texels * j->pairs);
    enc_left_out_errors e = {.data = {all[0] / count, all[1] / count, 1}};
    if (j->material) {
        e.material = (enc_error_sum){all[2] / count, all[3] / count, 1};
    }
    if (j->relief && left & ENC_LEFT_VIEW) {
        e.no_relief = (enc_error_sum){all[4] / count, all[5] / count, 1};
    }
    if (j->gloss && left & ENC_LEFT_VIEW) {
        e.no_gloss = (enc_error_sum){all[6] / count, all[7] / count, 1};
    }
    return e;
}

/* Fills in the errors of the cells, and their mean, in which each counts by the number of its pairs of
 * directions. */
static void sum_up(const job *j, const double *sums, enc_leave_one_out *out) {
    for (int left = ENC_LEFT_VIEW; left <= ENC_LEFT_BOTH; left++) {
        double pairs = 0;
        enc_left_out_errors all = {.data = {0}};
        for (size_t cell = 0; cell < j->cells; cell++) {
            const pool *views = &j->views[cell / (size_t)j->light_bands];
            const pool *lights = &j->lights[cell % (size_t)j->light_bands];
            if (!can_leave(views, lights, left)) {
                continue;
            }
            out->band_error[left][cell] = cell_errors(j, sums, left, cell);
            add_mean(&all, &out->band_error[left][cell], (double)views->count * lights->count);
            pairs += (double)views->count * lights->count;
        }
        if (pairs > 0) {
            add_mean(&out->error[left], &all, 1 / pairs);
        }
        out->error[left].data.count = pairs > 0;
        out->error[left].material.count = pairs > 0 && j->material;
        out->error[left].no_relief.count = pairs > 0 && j->relief && left & ENC_LEFT_VIEW;
        out->error[left].no_gloss.count = pairs > 0 && j->gloss && left & ENC_LEFT_VIEW;
    }
}

/* Makes the pool that each band draws from. *out_count: how many directions can be left out. */
static btf_result make_pools(const enc_context *context, const enc_direction *directions, int count,
                             const enc_bands *bands, pool *pools, int *out_count) {
    enc_left_out *left = malloc(sizeof *left);
    btf_result result = left ? enc_left_out_make(context, directions, count, left) : BTF_ERROR_MEMORY;
    for (int b = 0; result == BTF_OK && b < bands->count; b++) {
        pool *p = &pools[b];
        int member[ENC_MAX_DIRECTIONS], n = enc_bands_members(bands, b, directions, count, member);
        for (int i = 0; i < left->count; i++) {
            for (int k = 0; k < n; k++) {
                if (member[k] == left->index[i]) {
                    p->near[p->count] = left->near[i];
                    p->member[p->count++] = member[k];
                }
            }
        }
        p->can_leave = p->count > 0;
        for (int k = 0; k < n && !p->can_leave; k++) {
            p->member[p->count++] = member[k];
        }
    }
    *out_count = result == BTF_OK ? left->count : 0;
    free(left);
    return result;
}

/* Prepares what all levels share: the directions that can be left out, and the lights of gloss without each
 * of them. */
static btf_result prepare(job *j) {
    const enc_data *data = j->data;
    enc_leave_one_out *out = &j->out[0];
    btf_material_info info = {.struct_size = sizeof info};
    *out = (enc_leave_one_out){.view_bands = enc_bands_make(data->views, data->n_views),
                               .light_bands = enc_bands_make(data->lights, data->n_lights)};
    btf_result result =
        make_pools(j->context, data->views, data->n_views, &out->view_bands, j->views, &out->views);
    if (result == BTF_OK) {
        result = make_pools(j->context, data->lights, data->n_lights, &out->light_bands, j->lights,
                            &out->lights);
    }
    j->view_bands = out->view_bands.count;
    j->light_bands = out->light_bands.count;
    j->cells = (size_t)j->view_bands * (size_t)j->light_bands;
    j->pairs = ENC_LEFT_OUT_PAIRS / j->cells;
    if (result == BTF_OK && j->packed) {
        result = btf_material_get_info(j->packed, &info);
    }
    if (result == BTF_OK && info.effects & BTF_EFFECT_GLOSS) {
        result = enc_left_out_lights_create(j->context, data, info.gloss_share, &j->gloss);
    }
    return enc_ranks_agree(j->context, result);
}

static size_t texels_of(size_t count, int level) {
    const size_t most = ENC_LEFT_OUT_OF_LEVEL(level);
    return count < most ? count : most;
}

/* Measures a level (an enc_level_fn). */
static btf_result measure_level(void *user, int level, const enc_data *data) {
    job *j = user;
    enc_evaluator *evaluator = NULL;
    const size_t length = (1 + ENC_LEFT_BOTH) * j->cells * SUMS;
    double *sums = calloc(length, sizeof *sums);
    btf_result result = sums ? BTF_OK : BTF_ERROR_MEMORY;
    if (result == BTF_OK && j->packed) {
        result = enc_evaluator_create(j->context, j->packed, (uint32_t)level, &evaluator);
    }
    result = enc_ranks_agree(j->context, result);
    if (result == BTF_OK) {
        j->data = data;
        j->material = evaluator;
        j->relief = evaluator && enc_evaluator_reference(evaluator)->effects & BTF_EFFECT_RELIEF;
        j->texels = texels_of(enc_data_texel_count(data), level);
        result = enc_drawn_texels_sum(j->context, data, j->texels, length, measure_texel, j, sums);
    }
    if (result == BTF_OK) {
        if (level > 0) {
            j->out[level] = (enc_leave_one_out){.views = j->out[0].views,
                                                .lights = j->out[0].lights,
                                                .view_bands = j->out[0].view_bands,
                                                .light_bands = j->out[0].light_bands};
        }
        sum_up(j, sums, &j->out[level]);
    }
    enc_evaluator_destroy(&evaluator);
    free(sums);
    return result;
}

btf_result enc_leave_one_out_measure(const enc_context *context, const enc_data *data,
                                     const btf_material *material, int levels, enc_leave_one_out *out) {
    job *j = calloc(1, sizeof *j);
    btf_result result = enc_ranks_agree(context, j ? BTF_OK : BTF_ERROR_MEMORY);
    if (result == BTF_OK) {
        size_t steps = 0;
        *j = (job){.context = context, .data = data, .packed = material, .out = out};
        for (int level = 0; level < levels; level++) {
            steps += texels_of((size_t)enc_level_side(data->width, level) *
                                   (size_t)enc_level_side(data->height, level),
                               level);
        }
        result = prepare(j);
        enc_stage_begin(context, "leave one out", steps);
        if (result == BTF_OK) {
            result = measure_level(j, 0, data);
        }
        if (result == BTF_OK && levels > 1) {
            result = enc_level_each(context, data, levels, measure_level, j);
        }
        enc_stage_end(context);
        enc_left_out_lights_destroy(&j->gloss);
    }
    free(j);
    return result == BTF_ERROR_MEMORY ? enc_fail(context, result, "leave one out: out of memory") : result;
}

static float *write_error(const enc_error_sum *error, float *out) {
    *out++ = error->count > 0 ? fminf((float)error->linear, 1.0f) : -1.0f;
    *out++ = error->count > 0 ? fminf((float)error->srgb, 1.0f) : -1.0f;
    return out;
}

/* The error that a row of the table gives: without relief, without gloss, or with all effects. */
static const enc_error_sum *error_of_row(const enc_left_out_errors *e, int row) {
    return row & WITHOUT_GLOSS ? &e->no_gloss : row & WITHOUT_RELIEF ? &e->no_relief : &e->material;
}

size_t enc_leave_one_out_numbers(const enc_leave_one_out *measured, int level, float *out) {
    const float *const begin = out;
    const int cells = measured->view_bands.count * measured->light_bands.count;
    if (measured->views == 0 && measured->lights == 0) {
        return 0;
    }
    if (level == 0) {
        out = enc_bands_write(&measured->view_bands, &measured->light_bands, out);
    }
    for (int row = ENC_LEFT_VIEW; row <= WITHOUT_GLOSS + ENC_LEFT_BOTH; row++) {
        const int left = row & ENC_LEFT_BOTH;
        const enc_left_out_errors *e = &measured->error[left];
        if (left == 0 || error_of_row(e, row)->count == 0) {
            continue;
        }
        *out++ = (float)(row + BTF_BETWEEN_NEXT_LEVEL * level);
        out = write_error(&e->data, write_error(error_of_row(e, row), out));
        for (int cell = 0; cell < cells; cell++) {
            out = write_error(error_of_row(&measured->band_error[left][cell], row), out);
        }
    }
    return (size_t)(out - begin);
}

static const char *const left_names[] = {"", "view", "light", "both"};

static const char *errors_text(const enc_error_sum *sum, char text[32]) {
    if (sum->count > 0) {
        snprintf(text, 32, "%.2f / %.2f", enc_psnr_linear(sum), enc_psnr_srgb(sum));
    } else {
        text[0] = '\0';
    }
    return text;
}

void enc_leave_one_out_print(const enc_leave_one_out *measured, FILE *out) {
    char first[32], second[32], third[32], fourth[32];
    const bool relief = measured->error[ENC_LEFT_VIEW].no_relief.count > 0;
    const bool gloss = measured->error[ENC_LEFT_VIEW].no_gloss.count > 0;
    if (measured->views == 0 && measured->lights == 0) {
        return;
    }
    fprintf(out,
            "Between the samples, estimated: %d views and %d lights are left out and each is predicted "
            "from the others\n"
            "(PSNR in dB, linear / sRGB; the others lie twice as far away as they do from a direction "
            "between samples,\n"
            "which overstates the error, most where relief, shadows or highlights move)\n",
            measured->views, measured->lights);
    fprintf(out, "  %-20s %18s %18s%s%s\n", "left out", "data, interpolated", "material",
            relief ? "     without relief" : "", gloss ? "      without gloss" : "");
    for (int left = ENC_LEFT_VIEW; left <= ENC_LEFT_BOTH; left++) {
        const enc_left_out_errors *e = &measured->error[left];
        if (e->data.count > 0) {
            fprintf(out, "  %-20s %18s %18s%*s%*s\n", left_names[left], errors_text(&e->data, first),
                    errors_text(&e->material, second), e->no_relief.count > 0 ? 19 : 0,
                    errors_text(&e->no_relief, third), e->no_gloss.count > 0 ? 19 : 0,
                    errors_text(&e->no_gloss, fourth));
        }
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
        if (e->no_relief.count > 0) {
            json_number(j, "linear_without_relief", enc_psnr_linear(&e->no_relief));
            json_number(j, "srgb_without_relief", enc_psnr_srgb(&e->no_relief));
        }
        if (e->no_gloss.count > 0) {
            json_number(j, "linear_without_gloss", enc_psnr_linear(&e->no_gloss));
            json_number(j, "srgb_without_gloss", enc_psnr_srgb(&e->no_gloss));
        }
        json_number(j, "data_linear", enc_psnr_linear(&e->data));
        json_number(j, "data_srgb", enc_psnr_srgb(&e->data));
        json_end(j);
    }
    json_end(j);
}
