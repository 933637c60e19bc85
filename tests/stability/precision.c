/* Helpers of the comparisons with double precision. See precision.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "precision.h"

#include <math.h>
#include <stdlib.h>

const double precision_most_loss = 0.05;

void precision_measured(const void *user, int texel, const enc_direction *v, const enc_direction *l,
                        int sample, float rgb[3]) {
    (void)user;
    const double h[3] = {(double)(v->xyz[0] + l->xyz[0]), (double)(v->xyz[1] + l->xyz[1]),
                         (double)(v->xyz[2] + l->xyz[2])};
    const double length = sqrt(h[0] * h[0] + h[1] * h[1] + h[2] * h[2]);
    const double gloss = pow(h[2] / length, 20 + 40 * (texel % 4)), rim = pow(1 - (double)v->xyz[2], 3);
    for (int c = 0; c < 3; c++) {
        const double albedo = 0.1 + 0.5 * (double)hard_random((uint32_t)texel, (uint32_t)c, 5);
        const double noise =
            1 + 0.1 * ((double)hard_random((uint32_t)texel, (uint32_t)sample, (uint32_t)c) - 0.5);
        const double shade = texel % 3 == 0 && l->phi > 100 && l->phi < 190 ? 0.2 : 1;
        rgb[c] = (float)((double)l->xyz[2] * shade * noise * (albedo + 0.5 * gloss + 0.3 * rim));
    }
}

/* The root of a sample as the sum over factors, cosine included. */
static double factors_root(const enc_solution *s, size_t source, int v, int c, int l) {
    static const double sign[3][3] = {{1, 1, 1}, {1, 0, -1}, {1, -2, 1}};
    const enc_factor_store *f = &s->factors;
    const size_t lights = (size_t)s->n_lights, pairs = (size_t)s->n_views * lights;
    enc_factor_unit *units = calloc(f->units, sizeof *units);
    if (units == NULL) {
        exit(1);
    }
    const size_t components = enc_store_list(f->classes, units);
    int16_t *u = calloc(components, sizeof *u);
    if (u == NULL) {
        exit(1);
    }
    enc_store_texel_levels(units, f->units, f->texels, enc_solution_texels(s), source, u);
    double y = 0;
    for (size_t i = 0; i < f->units; i++) {
        int16_t w[ENC_STORE_WORDS * ENC_STORE_MOST_WORD];
        enc_store_w_levels(&units[i], f->directions + (i * pairs + (size_t)v * lights + (size_t)l) * 4, w);
        for (int k = 0; k < ENC_STORE_WORDS; k++) {
            const int channel = units[i].channel[k];
            double sum = 0;
            for (int j = 0; j < units[i].word; j++) {
                const int at = k * units[i].word + j;
                sum += (double)u[units[i].first + (size_t)at] * w[at];
            }
            y += sign[channel][c] * sum * (double)f->scales[4 * i + (size_t)k] *
                 (double)f->views[((size_t)v * ENC_STORE_TIERS + (size_t)units[i].tier) * 4 +
                                  (size_t)channel];
        }
    }
    free(u);
    free(units);
    return y;
}

double precision_decode(const enc_data *data, const enc_solution *s, size_t t, int v, int c, int l) {
    const size_t texels = enc_solution_texels(s), at = (size_t)v * texels + t, lights = (size_t)s->n_lights;
    if (s->gain && (s->effects & BTF_EFFECT_HIDDEN) && s->gain[at] == 0) {
        const double y =
            s->centre_codes[(s->centre[at] * lights + (size_t)l) * 3 + (size_t)c] * (double)s->centre_scale;
        return y * y * (double)s->radiance_scale;
    }
    size_t source = t;
    if (s->shift && (s->effects & BTF_EFFECT_SHIFT)) {
        source = enc_occlusion_source(s->width, s->height, t, s->shift[2 * at], s->shift[2 * at + 1]);
    }
    double y = 0;
    if (s->sbrdf) {
        /* hard_model multiplies by the cosine, which comes last here */
        y = hard_model(s->sbrdf->values + source * enc_sbrdf_stride(s->sbrdf->lobes, s->sbrdf->rgb),
                       s->sbrdf->lobes, s->sbrdf->rgb, false, data->views + v, data->lights + l, c) /
            (double)data->lights[l].xyz[2];
        if (s->shadow && (s->effects & BTF_EFFECT_SHADOW)) {
            y *= s->shadow[(size_t)l * texels + source] * (double)s->shadow_scale;
        }
    }
    if (s->factors.units > 0) {
        const double gain = s->gain ? (double)enc_solution_gain(s, s->gain[at]) : 1,
                     root = gain * factors_root(s, source, v, c, l);
        return root >= 0x1p-30 ? fmin(root, 0x1p32) * fmin(root, 0x1p32) * (double)s->radiance_scale : 0;
    }
    if (s->effects & BTF_EFFECT_RESIDUAL) {
        for (size_t j = 0; j < s->n_components; j++) {
            y += s->residual_texels[source * s->n_components + j] * (double)s->residual_scales[j] *
                 s->residual_directions[(((size_t)v * lights + (size_t)l) * 3 + (size_t)c) *
                                            s->n_components +
                                        j];
        }
    }
    const bool square = s->domain == BTF_DOMAIN_SQRT;
    y *= square ? sqrt((double)data->lights[l].xyz[2]) : (double)data->lights[l].xyz[2];
    if (s->gain && (s->effects & BTF_EFFECT_GAIN)) {
        y *= s->gain[at] * (double)s->gain_scale;
    }
    y = y >= 0x1p-30 ? fmin(y, 0x1p32) : 0;
    return (square ? y * y : y) * (double)s->radiance_scale;
}

double precision_psnr(const enc_data *data, const enc_solution *s) {
    double squares = 0;
    for (size_t t = 0; t < enc_data_texel_count(data); t++) {
        for (int v = 0; v < data->n_views; v++) {
            for (int c = 0; c < 3; c++) {
                for (int l = 0; l < data->n_lights; l++) {
                    const double r =
                        precision_decode(data, s, t, v, c, l) - (double)*hard_sample(data, t, v, c, l);
                    squares += r * r;
                }
            }
        }
    }
    return hard_psnr(squares, (double)(enc_data_texel_count(data) * enc_data_texel_stride(data)), 1);
}

double precision_psnr_of_parts(const enc_data *data, enc_sbrdf *sbrdf, uint8_t *shadow,
                               const enc_occlusion *occlusion, const enc_centres *centres) {
    enc_solution s = {.width = data->width,
                      .height = data->height,
                      .n_views = data->n_views,
                      .n_lights = data->n_lights,
                      .domain = BTF_DOMAIN_LINEAR,
                      .radiance_scale = 1,
                      .sbrdf = sbrdf,
                      .effects = BTF_EFFECT_SHADOW,
                      .shadow = shadow,
                      .shadow_scale = 1 / 255.0f};
    if (occlusion == NULL) {
        return precision_psnr(data, &s);
    }
    const size_t points = (size_t)data->n_views * enc_data_texel_count(data);
    s.effects |= BTF_EFFECT_SHIFT;
    s.shift = occlusion->shift;
    s.gain = malloc(points);
    if (s.gain == NULL) {
        exit(1);
    }
    for (size_t i = 0; i < points; i++) {
        s.gain[i] = occlusion->hidden[i] ? 0 : BTF_GAIN_ONE;
    }
    if (centres != NULL) {
        s.effects |= BTF_EFFECT_HIDDEN;
        s.centre = occlusion->centre;
        s.centre_codes = centres->codes;
        s.centre_scale = centres->scale;
        s.n_centres = (uint32_t)centres->k;
    }
    const double psnr = precision_psnr(data, &s);
    free(s.gain);
    return psnr;
}

precision_scene precision_scene_make(int side) {
    static const enc_context context = {.threads = 1};
    const hard_directions d = hard_thirteen();
    precision_scene s = {.data = hard_relief(side, &d, &d, 1)};
    enc_fit_options options = enc_fit_options_default();
    const enc_shadow_options shadow = enc_shadow_options_default();
    const size_t texels = enc_data_texel_count(s.data);
    options.starts = 1;
    s.shadow = malloc((size_t)d.n * texels);
    if (s.shadow == NULL || enc_fit(&context, s.data, &options, &s.sbrdf, NULL) != BTF_OK ||
        enc_top_view_shadow(&context, s.data, s.sbrdf, &shadow, s.shadow) != BTF_OK) {
        exit(1);
    }
    return s;
}

void precision_scene_clear(precision_scene *s) {
    enc_sbrdf_destroy(&s->sbrdf);
    enc_data_destroy(&s->data);
    free(s->shadow);
}

enc_occlusion *precision_occlusion(const enc_data *data) {
    const size_t texels = enc_data_texel_count(data);
    enc_occlusion *o = NULL;
    if (enc_occlusion_create(data->n_views, texels, &o) != BTF_OK) {
        exit(1);
    }
    for (uint32_t i = (uint32_t)texels; i < (uint32_t)data->n_views * texels; i++) {
        o->hidden[i] = hard_random(i, 1, 0) < 0.4f;
    }
    return o;
}
