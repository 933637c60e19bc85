/* The fit that pays. See choose.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "choose.h"

#include "rows.h"

#include "encoder/base/ranks.h"
#include "encoder/base/stage.h"
#include "encoder/math/gemm.h"
#include "encoder/math/srgb.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    DRAWN = 12,      /* views, and as many lights, drawn for a texel and a place: all their pairs are judged */
    ACCUMULATED = 3, /* sums of squares: the errors of the barycentric and of the fitted blend, and the fit's
                        move */
};

/* Strengths for views and lights, rising. Lights take stronger fits than views, since shading changes
 * faster with the light than parallax does with the view. FIT.md has what each of the ladder gives on
 * BRICKS64, btf-sample and UBO_IMPALLA64. */
static const int ladder[ENC_FIT_CANDIDATES][2] = {{0, 0}, {1, 1}, {2, 2}, {3, 3}, {4, 4}, {4, 5}, {4, 6}};

typedef struct sums {
    double linear[ACCUMULATED], srgb[ACCUMULATED];
} sums;

/* Sums of one texel. */
typedef struct texel_sums {
    sums of[ENC_FIT_CANDIDATES][ENC_ROWS_PLACES];
} texel_sums;

typedef struct job {
    const enc_context *context;
    const enc_data *data;
    bool roots;
    enc_node_rows views, lights;
    bool judged[ENC_FIT_CANDIDATES];
    int strength[ENC_FIT_CANDIDATES][2]; /* of views, of lights */
} job;

/* The radiance, clipped to [0, 1], that a blended value stands for: a root or radiance itself. */
static float shown(const job *j, float x) {
    const float positive = x > 0 ? x : 0.0f, value = j->roots ? positive * positive : positive;
    return value < 1 ? value : 1.0f;
}

/* Adds the errors of one colour channel in one pair of directions. */
static void add(const job *j, bool has_truth, float truth, float plain, float fitted, sums *to) {
    const double p = shown(j, plain), f = shown(j, fitted);
    const double ps = enc_srgb_encode((float)p), fs = enc_srgb_encode((float)f);
    to->linear[2] += (f - p) * (f - p);
    to->srgb[2] += (fs - ps) * (fs - ps);
    if (has_truth) {
        const double t = shown(j, truth), ts = enc_srgb_encode((float)t);
        to->linear[0] += (p - t) * (p - t);
        to->linear[1] += (f - t) * (f - t);
        to->srgb[0] += (ps - ts) * (ps - ts);
        to->srgb[1] += (fs - ts) * (fs - ts);
    }
}

/* out [drawn][3 lights] = rows of weights times [views][3 lights]. */
static void weigh_views(size_t n, size_t columns, const float *weight, const float *values, float *out) {
    memset(out, 0, columns * sizeof *out);
    for (size_t v = 0; v < n; v++) {
        const float w = weight[v], *row = values + v * columns;
        for (size_t i = 0; w != 0 && i < columns; i++) {
            out[i] += w * row[i];
        }
    }
}

/* Sixteen sums side by side, so that every machine adds in one order. */
static float weigh_lights(size_t n, const float *weight, const float *values) {
    float part[16] = {0}, sum = 0;
    size_t i = 0;
    for (; i + 16 <= n; i += 16) {
        for (size_t k = 0; k < 16; k++) {
            part[k] += weight[i + k] * values[i + k];
        }
    }
    for (size_t k = 0; i + k < n; k++) {
        part[k] += weight[i + k] * values[i + k];
    }
    for (size_t k = 0; k < 16; k++) {
        sum += part[k];
    }
    return sum;
}

/* Draws the directions of a place at which a texel is judged: spread evenly, and others for each texel.
 * Returns their number. */
static int draw(const enc_node_rows *rows, int place, size_t index, int out[DRAWN]) {
    const int all = rows->count[place], count = all < DRAWN ? all : DRAWN;
    for (int i = 0; i < count; i++) {
        out[i] = (int)(((size_t)i * (size_t)all / (size_t)count + index) % (size_t)all);
    }
    return count;
}

static const float *row(const enc_node_rows *rows, int strength, int place, int at) {
    return rows->weight[strength][place] + (size_t)at * (size_t)rows->n;
}

/* The number of floats that judge_place works in. */
static size_t work_floats(const enc_data *data) {
    return (size_t)ENC_STRENGTHS * DRAWN * 3 * (size_t)data->n_lights;
}

/* Adds the errors of all pairs of drawn views and lights at one place. values: [view][channel][light]. */
static void judge_place(const job *j, int place, size_t index, const float *values, float *work,
                        texel_sums *out) {
    const size_t lights = (size_t)j->lights.n, columns = 3 * lights;
    int views[DRAWN], light[DRAWN];
    const int n_views = draw(&j->views, place, index, views), n_lights = draw(&j->lights, place, index / 2, light);
    for (int s = 0; s < ENC_STRENGTHS; s++) {
        for (int a = 0; a < n_views && j->views.usable[s]; a++) {
            weigh_views((size_t)j->views.n, columns, row(&j->views, s, place, views[a]), values,
                        work + (size_t)(s * DRAWN + a) * columns);
        }
    }
    for (int a = 0; a < n_views; a++) {
        for (int b = 0; b < n_lights; b++) {
            const int view = j->views.sample[place][views[a]], of = j->lights.sample[place][light[b]];
            const bool has_truth = place != ENC_ROWS_BETWEEN;
            for (size_t c = 0; c < 3; c++) {
                const float *plain_row = work + (size_t)a * columns + c * lights;
                const float plain = weigh_lights(lights, row(&j->lights, 0, place, light[b]), plain_row);
                const float truth = has_truth ? values[((size_t)view * 3 + c) * lights + (size_t)of] : 0;
                for (int k = 1; k < ENC_FIT_CANDIDATES; k++) {
                    if (j->judged[k]) {
                        const float *fitted_row = work + (size_t)(j->strength[k][0] * DRAWN + a) * columns;
                        add(j, has_truth, truth, plain,
                            weigh_lights(lights, row(&j->lights, j->strength[k][1], place, light[b]),
                                         fitted_row + c * lights),
                            &out->of[k][place]);
                    }
                }
            }
        }
    }
}

/* Judges texel number `index` of those that are drawn. */
static btf_result judge_texel(const job *j, size_t index, size_t texels, texel_sums *out) {
    const size_t stride = enc_data_texel_stride(j->data), count = enc_data_texel_count(j->data);
    const size_t texel = (2 * index + 1) * count / (2 * texels);
    float *buffer = malloc((2 * stride + work_floats(j->data)) * sizeof *buffer);
    const float *samples;
    btf_result result = buffer ? BTF_OK : BTF_ERROR_MEMORY;
    if (result == BTF_OK) {
        result = enc_cancelled(j->context)
                     ? BTF_ERROR_INTERRUPTED
                     : enc_data_texels(j->context, j->data, texel, 1, buffer, &samples);
    }
    if (result == BTF_OK) {
        float *values = buffer + stride;
        for (size_t i = 0; i < stride; i++) {
            values[i] = j->roots ? sqrtf(samples[i]) : samples[i];
        }
        for (int place = 0; place < ENC_ROWS_PLACES; place++) {
            judge_place(j, place, index, values, values + stride, out);
        }
    }
    free(buffer);
    enc_stage_step(j->context, 1);
    return result;
}

static double pairs_of(const job *j, int place) {
    int unused[DRAWN];
    return 3.0 * draw(&j->views, place, 0, unused) * draw(&j->lights, place, 0, unused);
}

/* Means over all texels and pairs in one of the two codings, linear or sRGB. */
static enc_fit_moved moved_of(const double left[ACCUMULATED], const double between[ACCUMULATED],
                              double pairs_left, double pairs_between) {
    return (enc_fit_moved){.error = left[0] / pairs_left,
                           .fitted = left[1] / pairs_left,
                           .move = left[2] / pairs_left,
                           .moves = between[2] / pairs_between};
}

/* Turns the sums into figures of each candidate; the last that was judged is the strongest. */
static void fill_candidates(const job *j, sums total[ENC_FIT_CANDIDATES][ENC_ROWS_PLACES], size_t texels,
                            enc_fit_choice *choice) {
    const double left = pairs_of(j, ENC_ROWS_LEFT_OUT) * (double)texels;
    const double between = pairs_of(j, ENC_ROWS_BETWEEN) * (double)texels;
    const double at = pairs_of(j, ENC_ROWS_AT) * (double)texels;
    enc_fit_moved linear[ENC_FIT_CANDIDATES] = {{0}}, srgb[ENC_FIT_CANDIDATES] = {{0}};
    for (int k = 1; k < ENC_FIT_CANDIDATES; k++) {
        const sums *l = &total[k][ENC_ROWS_LEFT_OUT], *b = &total[k][ENC_ROWS_BETWEEN];
        const sums *n = &total[k][ENC_ROWS_AT];
        if (j->judged[k]) {
            linear[k] = moved_of(l->linear, b->linear, left, between);
            srgb[k] = moved_of(l->srgb, b->srgb, left, between);
        }
        choice->candidate[k] = (enc_fit_candidate){.kappa_views = enc_strength_kappa[j->strength[k][0]],
                                                   .kappa_lights = enc_strength_kappa[j->strength[k][1]],
                                                   .judged = j->judged[k],
                                                   .at = {n->linear[1] / at, n->srgb[1] / at}};
    }
    enc_fit_expect(linear, srgb, choice);
}

static void decide(double least_psnr, enc_fit_choice *choice) {
    double best = 0;
    const double most_at = least_psnr > 0 ? pow(10, -least_psnr / 10) : HUGE_VAL;
    for (int k = 1; k < ENC_FIT_CANDIDATES; k++) {
        enc_fit_candidate *c = &choice->candidate[k];
        c->value = c->judged ? enc_fit_value(choice, c) : 0;
        c->allowed = c->judged && enc_fit_allowed(choice, c) && c->at.srgb < most_at;
        if (c->allowed && c->value > best) {
            best = c->value;
            choice->chosen = choice->best = k;
        }
    }
}

static btf_result judge(const job *j, enc_fit_choice *choice) {
    const size_t count = enc_data_texel_count(j->data);
    const size_t texels = count < ENC_FIT_TEXELS ? count : ENC_FIT_TEXELS;
    sums total[ENC_FIT_CANDIDATES][ENC_ROWS_PLACES] = {0};
    texel_sums *each = calloc(texels, sizeof *each);
    btf_result result = each ? BTF_OK : BTF_ERROR_MEMORY;
    choice->texels = texels;
#pragma omp parallel for schedule(dynamic) num_threads(j->context->threads) if (each)
    for (size_t i = 0; i < (each ? texels : 0); i++) {
        const btf_result mine = judge_texel(j, i, texels, &each[i]);
        enc_keep_worse(&result, mine);
    }
    for (size_t i = 0; result == BTF_OK && i < texels; i++) {
        for (int k = 1; k < ENC_FIT_CANDIDATES; k++) {
            for (int place = 0; place < ENC_ROWS_PLACES; place++) {
                for (int a = 0; a < ACCUMULATED; a++) {
                    total[k][place].linear[a] += each[i].of[k][place].linear[a];
                    total[k][place].srgb[a] += each[i].of[k][place].srgb[a];
                }
            }
        }
    }
    free(each);
    if (result == BTF_OK) {
        fill_candidates(j, total, texels, choice);
    }
    return result;
}

/* Finds the steps of the ladder that exist for these directions; a list (views or lights) that has no fit
 * stays barycentric. */
static void set_up(job *j) {
    const bool views = j->views.usable[1], lights = j->lights.usable[1];
    for (int k = 1; k < ENC_FIT_CANDIDATES; k++) {
        j->strength[k][0] = views ? ladder[k][0] : 0;
        j->strength[k][1] = lights ? ladder[k][1] : 0;
        j->judged[k] = (views || lights) && j->views.usable[j->strength[k][0]] &&
                       j->lights.usable[j->strength[k][1]];
    }
}

static btf_result take(const job *j, const enc_fit_choice *choice, enc_node_tables *out) {
    const size_t views = (size_t)j->views.n, lights = (size_t)j->lights.n;
    const int *strength = j->strength[choice->chosen];
    *out = (enc_node_tables){.n_views = j->views.n,
                             .n_lights = j->lights.n,
                             .views = malloc(views * views * sizeof(float)),
                             .lights = malloc(lights * lights * sizeof(float)),
                             .roots = j->roots};
    if (!out->views || !out->lights) {
        enc_node_tables_clear(out);
        return BTF_ERROR_MEMORY;
    }
    memcpy(out->views, j->views.weight[strength[0]][ENC_ROWS_AT], views * views * sizeof(float));
    memcpy(out->lights, j->lights.weight[strength[1]][ENC_ROWS_AT], lights * lights * sizeof(float));
    return BTF_OK;
}

void enc_node_tables_clear(enc_node_tables *tables) {
    free(tables->views);
    free(tables->lights);
    *tables = (enc_node_tables){0};
}

static btf_result choose(job *j, double least_psnr, const enc_fit_error *coder, enc_fit_choice *choice,
                         enc_node_tables *out_tables) {
    btf_result result = enc_node_rows_make(j->context, j->data->views, j->data->n_views, &j->views);
    if (result == BTF_OK) {
        result = enc_node_rows_make(j->context, j->data->lights, j->data->n_lights, &j->lights);
    }
    if (result == BTF_OK) {
        set_up(j);
        result = judge(j, choice);
    }
    if (result == BTF_OK) {
        choice->coder = coder ? *coder : choice->candidate[0].between;
        decide(least_psnr, choice);
    }
    if (result == BTF_OK && choice->chosen > 0) {
        result = take(j, choice, out_tables);
    }
    enc_node_rows_clear(&j->views);
    enc_node_rows_clear(&j->lights);
    return result;
}

btf_result enc_fit_choose(const enc_context *context, const enc_data *data, bool roots, double least_psnr,
                          const enc_fit_error *coder, enc_fit_choice *out_choice,
                          enc_node_tables *out_tables) {
    job j = {.context = context, .data = data, .roots = roots};
    const size_t count = enc_data_texel_count(data);
    *out_choice =
        (enc_fit_choice){.candidate = {{.kappa_views = HUGE_VAL, .kappa_lights = HUGE_VAL, .judged = true}}};
    *out_tables = (enc_node_tables){0};
    enc_stage_begin(context, "choose fit", count < ENC_FIT_TEXELS ? count : ENC_FIT_TEXELS);
    btf_result result = choose(&j, least_psnr, coder, out_choice, out_tables);
    result = enc_ranks_agree(context, result);
    enc_stage_end(context);
    if (result != BTF_OK) {
        enc_node_tables_clear(out_tables);
    }
    return result == BTF_ERROR_MEMORY ? enc_fail(context, result, "fit of nodes: out of memory") : result;
}
