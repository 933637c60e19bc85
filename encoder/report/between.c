/* Accuracy between the samples. See between.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "between.h"

#include "canvas.h"
#include "encoder/base/stage.h"
#include "encoder/nodes/interpolate.h"
#include "encoder/math/srgb.h"
#include "montage.h"
#include "ssim.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Limits of the bands, degrees. */
static const double limits[ENC_BY_COUNT][ENC_BETWEEN_BANDS + 1] = {
    [ENC_BY_VIEW_THETA] = {0, 15, 30, 45, 60, 75, 90},
    [ENC_BY_LIGHT_THETA] = {0, 15, 30, 45, 60, 75, 90},
    [ENC_BY_VIEW_GAP] = {0, 1, 2, 4, 6, 8, 12, 24, 180},
    [ENC_BY_LIGHT_GAP] = {0, 1, 2, 4, 6, 8, 12, 24, 180},
};
static const char *const by_names[ENC_BY_COUNT] = {"view_theta", "light_theta", "view_gap", "light_gap"};
static const char *const by_titles[ENC_BY_COUNT] = {"view theta", "light theta", "view to sample",
                                                    "light to sample"};

static float clip(float x) {
    return x > 0 ? (x < 1 ? x : 1.0f) : 0.0f;
}

static void add(enc_error_sum *to, const enc_error_sum *from) {
    to->linear += from->linear;
    to->srgb += from->srgb;
    to->count += from->count;
}

/* Compares two images of n floats; `coded` has room for both, sRGB-coded, of which SSIM is taken. */
static void compare(size_t n, const float *truth, const float *model, float *coded, enc_ssim *ssim,
                    enc_between_pair *out) {
    out->error = (enc_error_sum){.count = (double)n};
    for (size_t i = 0; i < n; i++) {
        const double linear = (double)clip(truth[i]) - clip(model[i]);
        coded[i] = enc_srgb_encode(truth[i]);
        coded[n + i] = enc_srgb_encode(model[i]);
        const double srgb = (double)coded[i] - coded[n + i];
        out->error.linear += linear * linear;
        out->error.srgb += srgb * srgb;
    }
    out->ssim = ssim ? enc_ssim_images(ssim, coded, coded + n) : 0;
}

static size_t block_size(const enc_context *context, const enc_pairs *pairs) {
    const size_t pair = 2 * 3 * sizeof(float) * (size_t)pairs->width * (size_t)pairs->height;
    const size_t bytes = context->memory > 0 ? context->memory / 4 : (size_t)256 << 20;
    const size_t fit = bytes / pair;
    return fit < 1 ? 1 : fit < pairs->count ? fit : pairs->count;
}

/* Finds the errors of a block of pairs, whose images are all in memory. */
static btf_result compare_block(const enc_context *context, const enc_pairs *pairs, size_t count,
                                const float *truth, const float *model, bool with_ssim,
                                enc_between_pair *out) {
    const size_t n = 3 * (size_t)pairs->width * (size_t)pairs->height;
    btf_result result = BTF_OK;
#pragma omp parallel num_threads(context->threads)
    {
        float *coded = malloc(2 * n * sizeof *coded);
        enc_ssim *ssim = with_ssim ? enc_ssim_create(pairs->width, pairs->height) : NULL;
        const bool ready = coded && (ssim || !with_ssim);
#pragma omp for schedule(dynamic)
        for (size_t p = 0; p < count; p++) {
            if (ready) {
                compare(n, truth + p * n, model + p * n, coded, ssim, &out[p]);
            }
            enc_stage_step(context, 1);
        }
        if (!ready) {
            enc_keep_worse(&result, BTF_ERROR_MEMORY);
        }
        enc_ssim_destroy(&ssim);
        free(coded);
    }
    return result;
}

static btf_result measure_blocks(const enc_context *context, const enc_pairs *pairs, enc_pair_images model,
                                 bool with_ssim, enc_between_pair *out) {
    const size_t n = 3 * (size_t)pairs->width * (size_t)pairs->height, block = block_size(context, pairs);
    float *truth = malloc(block * n * sizeof *truth), *images = malloc(block * n * sizeof *images);
    btf_result result = truth && images ? BTF_OK : BTF_ERROR_MEMORY;
    for (size_t first = 0; result == BTF_OK && first < pairs->count; first += block) {
        const size_t count = pairs->count - first < block ? pairs->count - first : block;
        for (size_t p = 0; result == BTF_OK && p < count; p++) {
            result = enc_cancelled(context) ? BTF_ERROR_INTERRUPTED
                                            : enc_pairs_read(context, pairs, first + p, truth + p * n);
        }
        if (result == BTF_OK) {
            result = model.images(context, model.user, pairs->pair + first, count, images);
        }
        if (result == BTF_OK) {
            result = compare_block(context, pairs, count, truth, images, with_ssim, out + first);
        }
    }
    free(images);
    free(truth);
    return result;
}

static double quantity(const enc_pair *pair, const enc_between_pair *measured, enc_between_by by) {
    switch (by) {
    case ENC_BY_VIEW_THETA:
        return pair->view.theta;
    case ENC_BY_LIGHT_THETA:
        return pair->light.theta;
    case ENC_BY_VIEW_GAP:
        return measured->view_gap;
    default:
        return measured->light_gap;
    }
}

static void fill_bands(enc_between *b, const enc_pairs *pairs, enc_between_by by) {
    for (int i = 0; i < ENC_BETWEEN_BANDS && limits[by][i + 1] > 0; i++) {
        enc_between_band band = {.low = limits[by][i], .high = limits[by][i + 1]};
        for (size_t p = 0; p < b->count; p++) {
            const double x = quantity(&pairs->pair[p], &b->pair[p], by);
            if (x < band.low || x >= band.high) {
                continue;
            }
            band.pairs++;
            add(&band.error, &b->pair[p].error);
            band.ssim += b->pair[p].ssim;
        }
        if (band.pairs > 0) {
            band.ssim /= (double)band.pairs;
            b->band[by][b->n_bands[by]++] = band;
        }
    }
}

/* A pair and its error, to sort by. */
typedef struct ranked {
    double error;
    size_t index;
} ranked;

static int by_error(const void *a, const void *b) {
    const ranked *x = a, *y = b;
    if (x->error != y->error) {
        return x->error > y->error ? -1 : 1;
    }
    return (x->index > y->index) - (x->index < y->index);
}

static btf_result rank_pairs(enc_between *b) {
    ranked *list = malloc(b->count * sizeof *list);
    if (!list) {
        return BTF_ERROR_MEMORY;
    }
    for (size_t p = 0; p < b->count; p++) {
        list[p] = (ranked){b->pair[p].error.linear, p};
    }
    qsort(list, b->count, sizeof *list, by_error);
    for (size_t p = 0; p < b->count; p++) {
        b->worst[p] = list[p].index;
    }
    free(list);
    return BTF_OK;
}

static void sum_up(enc_between *b, const enc_pairs *pairs, enc_pair_images model) {
    for (size_t p = 0; p < b->count; p++) {
        enc_between_pair *pair = &b->pair[p];
        pair->view_gap = enc_nearest_angle(model.views, model.n_views, pairs->pair[p].view.xyz);
        pair->light_gap = enc_nearest_angle(model.lights, model.n_lights, pairs->pair[p].light.xyz);
        add(&b->total, &pair->error);
        b->ssim += pair->ssim / (double)b->count;
    }
    for (int by = 0; by < ENC_BY_COUNT; by++) {
        fill_bands(b, pairs, (enc_between_by)by);
    }
}

btf_result enc_between_measure(const enc_context *context, const enc_pairs *pairs, enc_pair_images model,
                               bool with_ssim, enc_between **out_between) {
    enc_between *b = calloc(1, sizeof *b);
    btf_result result = BTF_ERROR_MEMORY;
    *out_between = NULL;
    enc_stage_begin(context, "between", pairs->count);
    if (b) {
        b->count = pairs->count;
        b->with_ssim = with_ssim;
        b->pair = calloc(b->count, sizeof *b->pair);
        b->worst = calloc(b->count, sizeof *b->worst);
    }
    if (b && b->pair && b->worst) {
        result = measure_blocks(context, pairs, model, with_ssim, b->pair);
    }
    if (result == BTF_OK) {
        result = rank_pairs(b);
    }
    enc_stage_end(context);
    if (result == BTF_OK) {
        sum_up(b, pairs, model);
        *out_between = b;
        return BTF_OK;
    }
    enc_between_destroy(&b);
    return result == BTF_ERROR_MEMORY
               ? enc_fail(context, result, "comparing %zu images: out of memory", pairs->count)
               : result;
}

void enc_between_destroy(enc_between **between) {
    if (!between || !*between) {
        return;
    }
    free((*between)->pair);
    free((*between)->worst);
    free(*between);
    *between = NULL;
}

static void print_bands(const enc_between *b, enc_between_by by, FILE *out) {
    fprintf(out, "%-16s %6s %8s %8s%s\n", by_titles[by], "pairs", "linear", "sRGB",
            b->with_ssim ? "   SSIM" : "");
    for (int i = 0; i < b->n_bands[by]; i++) {
        const enc_between_band *band = &b->band[by][i];
        char range[32];
        snprintf(range, sizeof range, "%g to %g", band->low, band->high);
        fprintf(out, "%-16s %6zu %8.3f %8.3f", range, band->pairs, enc_psnr_linear(&band->error),
                enc_psnr_srgb(&band->error));
        if (b->with_ssim) {
            fprintf(out, " %6.4f", band->ssim);
        }
        fputc('\n', out);
    }
}

void enc_between_print(const enc_between *b, const enc_pairs *pairs, size_t worst, FILE *out) {
    fprintf(out, "between the samples: %zu pairs of view and light\nPSNR linear %.3f dB, sRGB %.3f dB",
            b->count, enc_psnr_linear(&b->total), enc_psnr_srgb(&b->total));
    if (b->with_ssim) {
        fprintf(out, ", SSIM %.4f", b->ssim);
    }
    fputc('\n', out);
    for (int by = 0; by < ENC_BY_COUNT; by++) {
        print_bands(b, (enc_between_by)by, out);
    }
    fprintf(out, "%-16s %-16s %8s %8s\n", "worst: view", "light", "linear", "sRGB");
    for (size_t i = 0; i < worst && i < b->count; i++) {
        const enc_pair *pair = &pairs->pair[b->worst[i]];
        const enc_error_sum *error = &b->pair[b->worst[i]].error;
        char view[32], light[32];
        snprintf(view, sizeof view, "%.5g,%.5g", pair->view.theta, pair->view.phi);
        snprintf(light, sizeof light, "%.5g,%.5g", pair->light.theta, pair->light.phi);
        fprintf(out, "%-16s %-16s %8.3f %8.3f\n", view, light, enc_psnr_linear(error),
                enc_psnr_srgb(error));
    }
}

static void json_error(json *j, const enc_error_sum *error, double ssim) {
    json_number(j, "linear", enc_psnr_linear(error));
    json_number(j, "srgb", enc_psnr_srgb(error));
    json_number(j, "ssim", ssim);
}

static void json_direction(json *j, const char *key, const enc_direction *d) {
    json_array(j, key);
    json_number(j, NULL, d->theta);
    json_number(j, NULL, d->phi);
    json_end(j);
}

static void json_bands(json *j, const enc_between *b, enc_between_by by) {
    json_array(j, by_names[by]);
    for (int i = 0; i < b->n_bands[by]; i++) {
        const enc_between_band *band = &b->band[by][i];
        json_object(j, NULL);
        json_number(j, "low", band->low);
        json_number(j, "high", band->high);
        json_integer(j, "pairs", (int64_t)band->pairs);
        json_error(j, &band->error, b->with_ssim ? band->ssim : NAN);
        json_end(j);
    }
    json_end(j);
}

void enc_between_json(json *j, const char *key, const enc_between *b, const enc_pairs *pairs) {
    json_object(j, key);
    json_error(j, &b->total, b->with_ssim ? b->ssim : NAN);
    json_integer(j, "pairs", (int64_t)b->count);
    json_object(j, "bands");
    for (int by = 0; by < ENC_BY_COUNT; by++) {
        json_bands(j, b, (enc_between_by)by);
    }
    json_end(j);
    json_array(j, "images");
    for (size_t p = 0; p < b->count; p++) {
        json_object(j, NULL);
        json_string(j, "name", pairs->pair[p].name);
        json_direction(j, "view", &pairs->pair[p].view);
        json_direction(j, "light", &pairs->pair[p].light);
        json_number(j, "view_gap", b->pair[p].view_gap);
        json_number(j, "light_gap", b->pair[p].light_gap);
        json_error(j, &b->pair[p].error, b->with_ssim ? b->pair[p].ssim : NAN);
        json_end(j);
    }
    json_end(j);
    json_end(j);
}

enum { GAP = 6, HEADER = 22, MARGIN = 190, TITLE = 80, COLUMNS = 3 };

typedef struct sheet {
    enc_canvas canvas;
    int zoom, cell_width, cell_height;
} sheet;

static btf_result make_sheet(const enc_context *context, const enc_pairs *pairs, size_t rows, sheet *out) {
    const int side = pairs->width > pairs->height ? pairs->width : pairs->height;
    const char *const titles[COLUMNS] = {"truth", "model", "error"};
    out->zoom = side < 160 ? 160 / side : 1;
    const int width = pairs->width * out->zoom;
    out->cell_width = (width > TITLE ? width : TITLE) + GAP;
    out->cell_height = pairs->height * out->zoom + GAP;
    const btf_result result = enc_canvas_create(context, MARGIN + COLUMNS * out->cell_width,
                                                HEADER + (int)rows * out->cell_height, &out->canvas);
    for (int c = 0; result == BTF_OK && c < COLUMNS; c++) {
        enc_canvas_text(&out->canvas, MARGIN + c * out->cell_width, HEADER - 8,
                        c == COLUMNS - 1 ? "%s x %d" : "%s", titles[c], ENC_ERROR_GAIN);
    }
    return result;
}

/* Replaces a by ENC_ERROR_GAIN |a - b| of sRGB-coded values, decoded to linear ones, since a canvas codes
 * what it draws. */
static void make_error(size_t n, float *a, const float *b) {
    for (size_t i = 0; i < n; i++) {
        const float coded = fabsf(enc_srgb_encode(a[i]) - enc_srgb_encode(b[i])) * ENC_ERROR_GAIN;
        a[i] = coded <= 0.04045f ? coded / 12.92f : powf((coded + 0.055f) / 1.055f, 2.4f);
    }
}

static void draw_row(sheet *s, size_t row, const enc_pairs *pairs, size_t p,
                     const enc_between_pair *measured, float *truth, const float *model) {
    const int y = HEADER + (int)row * s->cell_height, w = pairs->width, h = pairs->height;
    const enc_pair *pair = &pairs->pair[p];
    enc_canvas_text(&s->canvas, 4, y + 16, "view %.5g,%.5g", pair->view.theta, pair->view.phi);
    enc_canvas_text(&s->canvas, 4, y + 34, "light %.5g,%.5g", pair->light.theta, pair->light.phi);
    enc_canvas_text(&s->canvas, 4, y + 52, "%.2f / %.2f dB", enc_psnr_linear(&measured->error),
                    enc_psnr_srgb(&measured->error));
    enc_canvas_image(&s->canvas, MARGIN, y, s->zoom, w, h, truth);
    enc_canvas_image(&s->canvas, MARGIN + s->cell_width, y, s->zoom, w, h, model);
    make_error(3 * (size_t)w * (size_t)h, truth, model);
    enc_canvas_image(&s->canvas, MARGIN + 2 * s->cell_width, y, s->zoom, w, h, truth);
}

/* Draws the rows of the sheet, which stand by rising PSNR, in the order of the images, which are read by
 * rising index. */
static btf_result draw_rows(const enc_context *context, const enc_pairs *pairs, const enc_between *b,
                            enc_pair_images model, size_t rows, sheet *s) {
    const size_t n = 3 * (size_t)pairs->width * (size_t)pairs->height;
    float *truth = malloc(n * sizeof *truth), *image = malloc(n * sizeof *image);
    btf_result result = truth && image ? BTF_OK : BTF_ERROR_MEMORY;
    for (size_t p = 0; result == BTF_OK && p < b->count; p++) {
        size_t row = 0;
        while (row < rows && b->worst[row] != p) {
            row++;
        }
        if (row == rows) {
            continue;
        }
        result = enc_pairs_read(context, pairs, p, truth);
        if (result == BTF_OK) {
            result = model.images(context, model.user, &pairs->pair[p], 1, image);
        }
        if (result == BTF_OK) {
            draw_row(s, row, pairs, p, &b->pair[p], truth, image);
        }
    }
    free(image);
    free(truth);
    return result;
}

btf_result enc_between_picture(const enc_context *context, const char *path_of_pairs,
                               const enc_read_options *options, const enc_between *b, enc_pair_images model,
                               size_t worst, const char *path) {
    const size_t rows = worst < b->count ? worst : b->count;
    enc_pairs *pairs = NULL;
    sheet s = {0};
    btf_result result = enc_pairs_open(context, path_of_pairs, options, &pairs);
    if (result == BTF_OK && pairs->count != b->count) {
        result = enc_fail(context, BTF_ERROR_BAD_FILE, "%s: changed while it was read", path_of_pairs);
    }
    if (result == BTF_OK) {
        result = make_sheet(context, pairs, rows, &s);
    }
    if (result == BTF_OK) {
        result = draw_rows(context, pairs, b, model, rows, &s);
    }
    if (result == BTF_OK) {
        result = enc_canvas_write(context, &s.canvas, path);
    }
    enc_canvas_clear(&s.canvas);
    enc_pairs_close(&pairs);
    return result == BTF_OK ? BTF_OK
                            : enc_fail(context, result, "%s: the picture was not drawn: %s", path,
                                       btf_result_text(result));
}
