/* The search for the sources of hidden points against the same search in double, without pruning.
 *
 * SPDX-License-Identifier: MIT
 */
#include "cases.h"
#include "precision.h"

#include "encoder/paper/refine.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const enc_context context = {.threads = 1};

/* STVS under one view: out[texel][channel][light]. */
static void model_view(const precision_scene *s, int view, double *out) {
    const size_t texels = enc_data_texel_count(s->data), lights = (size_t)s->data->n_lights;
    for (size_t t = 0; t < texels; t++) {
        for (size_t i = 0; i < 3 * lights; i++) {
            const size_t l = i % lights;
            out[t * 3 * lights + i] =
                hard_model(s->sbrdf->values + t * enc_sbrdf_stride(3, false), 3, false, false,
                           s->data->views + view, s->data->lights + l, (int)(i / lights)) *
                s->shadow[l * texels + t] / 255;
        }
    }
}

/* sum_l || BTF(texel, l, view) - model(l) ||. */
static double distance(const enc_data *data, size_t texel, int view, const double *model) {
    double sum = 0;
    for (int l = 0; l < data->n_lights; l++) {
        double square = 0;
        for (int c = 0; c < 3; c++) {
            const double d = (double)*hard_sample(data, texel, view, c, l) - model[c * data->n_lights + l];
            square += d * d;
        }
        sum += sqrt(square);
    }
    return sum;
}

/* enc_refine in double, over the whole tile. */
static void refine(const precision_scene *s, enc_occlusion *o) {
    const enc_data *data = s->data;
    const size_t texels = enc_data_texel_count(data), profile = 3 * (size_t)data->n_lights;
    double *model = malloc(texels * profile * sizeof *model);
    if (model == NULL) {
        exit(1);
    }
    for (int v = 0; v < data->n_views; v++) {
        double threshold = 0;
        size_t shown = 0;
        model_view(s, v, model);
        for (size_t t = 0; t < texels; t++) {
            const size_t at = (size_t)v * texels + t;
            if (!o->hidden[at]) {
                const int8_t *shift = o->shift + 2 * at;
                const size_t source =
                    enc_occlusion_source(data->width, data->height, t, shift[0], shift[1]);
                threshold += distance(data, t, v, model + source * profile);
                shown++;
            }
        }
        threshold = shown > 0 ? threshold / (double)shown : 0;
        for (size_t t = 0; t < texels; t++) {
            const size_t at = (size_t)v * texels + t;
            double least = INFINITY;
            int8_t best[2] = {0, 0};
            for (int y = -((data->height - 1) / 2); o->hidden[at] && y <= data->height / 2; y++) {
                for (int x = -((data->width - 1) / 2); x <= data->width / 2; x++) {
                    const int8_t shift[2] = {(int8_t)x, (int8_t)y};
                    const size_t source = enc_occlusion_source(data->width, data->height, t, x, y);
                    const double d = distance(data, t, v, model + source * profile);
                    if (d < least || (d == least && enc_occlusion_compare_shift(shift, best) < 0)) {
                        least = d;
                        memcpy(best, shift, 2);
                    }
                }
            }
            if (o->hidden[at]) {
                memcpy(o->shift + 2 * at, best, 2);
                o->hidden[at] = !(least < threshold);
            }
        }
    }
    free(model);
}

/* Clusters by the float stage. */
static enc_centres *cluster(const enc_data *data, enc_occlusion *o) {
    enc_centres *centres = NULL;
    if (enc_cluster(&context, data, NULL, 48, o, &centres) != BTF_OK) {
        exit(1);
    }
    return centres;
}

void precision_hidden(void) {
    precision_scene s = precision_scene_make(10);
    enc_occlusion *single = precision_occlusion(s.data), *twice = precision_occlusion(s.data);
    const size_t points = (size_t)s.data->n_views * enc_data_texel_count(s.data),
                 before = enc_occlusion_hidden_count(single, -1);
    const bool ok =
        enc_refine(&context, s.data, s.sbrdf, s.shadow, 1 / 255.0f, NULL, single, NULL) == BTF_OK;
    refine(&s, twice);
    size_t shifts = 0, flags = 0;
    for (size_t i = 0; i < points; i++) {
        shifts += memcmp(single->shift + 2 * i, twice->shift + 2 * i, 2) != 0;
        flags += single->hidden[i] != twice->hidden[i];
    }
    const size_t left = enc_occlusion_hidden_count(single, -1);
    const bool work = left > 0 && left < before;
    enc_centres *a = cluster(s.data, single), *b = cluster(s.data, twice);
    for (int shown = 0; shown < 2; shown++) {
        const double psnr =
            precision_psnr_of_parts(s.data, s.sbrdf, s.shadow, single, shown == 0 ? a : NULL);
        const double exact =
            precision_psnr_of_parts(s.data, s.sbrdf, s.shadow, twice, shown == 0 ? b : NULL);
        cases_add(shown == 0 ? "search of hidden points in double, what stays hidden by clusters"
                             : "search of hidden points in double, each by its source",
                  "less than 0.05 dB either way", ok && work && fabs(exact - psnr) < precision_most_loss,
                  "%.4f dB, double %.4f dB; of %zu points %zu stay hidden, %zu shifts and %zu flags differ",
                  psnr, exact, before, left, shifts, flags);
    }
    enc_centres_destroy(&a);
    enc_centres_destroy(&b);
    enc_occlusion_destroy(&single);
    enc_occlusion_destroy(&twice);
    precision_scene_clear(&s);
}
