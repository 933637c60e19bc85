/* The float pipeline against the same stages in double precision: the loss by single precision in dB.
 *
 * SPDX-License-Identifier: MIT
 */
#include "cases.h"
#include "encode.h"
#include "precision.h"

#include "encoder/lafortune/gram.h"
#include "encoder/model/decode_samples.h"
#include "encoder/paper/shadow.h"
#include "tests/support/messages.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const enc_context context = {.threads = 1};

/* ---- the fit ---- */

typedef struct target {
    const enc_data *data;
    size_t texel;
    int lobes;
    bool rgb, square_root;
} target;

enum { MOST = 3 + 7 * ENC_MAX_LOBES };

/* The model in double: as hard_model, with parameters in double and before any squaring. */
static double model(const target *t, const double *p, const enc_direction *v, const enc_direction *l,
                    int c) {
    const double *shape = p + (t->rgb ? 3 + 3 * t->lobes : 4);
    double sum = p[t->rgb ? c : 3];
    for (int j = 0; j < t->lobes; j++, shape += 4) {
        double base = 0;
        for (int k = 0; k < 3; k++) {
            base += shape[k] * (double)l->xyz[k] * (double)v->xyz[k];
        }
        const double power = base > 1e-9 && shape[3] > 0 ? pow(base, shape[3]) : 0;
        sum += t->rgb ? p[3 + 3 * j + c] * power : power;
    }
    const double m = (double)l->xyz[2];
    return (t->square_root ? sqrt(m) : m) * sum * (t->rgb ? 1 : p[c]);
}

/* Residuals into r; returns their sum of squares. */
static double residuals(const target *t, const double *p, double *r) {
    double sum = 0;
    size_t i = 0;
    for (int v = 0; v < t->data->n_views; v++) {
        for (int l = 0; l < t->data->n_lights; l++) {
            for (int c = 0; c < 3; c++, i++) {
                const double y = (double)*hard_sample(t->data, t->texel, v, c, l);
                r[i] = model(t, p, t->data->views + v, t->data->lights + l, c) -
                       (t->square_root ? sqrt(y) : y);
                sum += r[i] * r[i];
            }
        }
    }
    return sum;
}

/* Levenberg-Marquardt in double from p to its end, with the bounds of the float fit. */
static double refit(const target *t, double *p) {
    const int n = (int)enc_sbrdf_stride(t->lobes, t->rgb);
    const size_t rows = (size_t)t->data->n_views * (size_t)t->data->n_lights * 3;
    double *r = malloc(rows * sizeof *r), *moved = malloc(rows * sizeof *moved);
    double *jacobian = malloc(rows * MOST * sizeof *jacobian);
    if (r == NULL || moved == NULL || jacobian == NULL) {
        exit(1);
    }
    double cost = residuals(t, p, r), damping = 1e-4;
    for (int step = 0; step < 60; step++) {
        for (int k = 0; k < n; k++) {
            const double before = p[k], h = 1e-6 * fmax(fabs(before), 1e-3);
            p[k] = before + h;
            residuals(t, p, moved);
            for (size_t i = 0; i < rows; i++) {
                jacobian[i * MOST + (size_t)k] = (moved[i] - r[i]) / h;
            }
            p[k] = before;
        }
        double a[MOST][MOST + 1] = {{0}};
        for (size_t i = 0; i < rows; i++) {
            const double *row = jacobian + i * MOST;
            for (int j = 0; j < n; j++) {
                for (int k = 0; k < n; k++) {
                    a[j][k] += row[j] * row[k];
                }
                a[j][n] -= row[j] * r[i];
            }
        }
        const double before = cost;
        for (int tries = 0; tries < 8; tries++) {
            double m[MOST][MOST + 1], next[MOST];
            memcpy(m, a, sizeof m);
            for (int k = 0; k < n; k++) {
                m[k][k] = m[k][k] * (1 + damping) + 1e-12;
            }
            for (int k = 0; k < n; k++) { /* positive definite: no pivoting */
                for (int j = k + 1; j < n; j++) {
                    const double f = m[j][k] / m[k][k];
                    for (int i = k; i <= n; i++) {
                        m[j][i] -= f * m[k][i];
                    }
                }
            }
            for (int k = n - 1; k >= 0; k--) {
                for (int i = k + 1; i < n; i++) {
                    m[k][n] -= m[k][i] * m[i][n];
                }
                m[k][n] /= m[k][k];
                next[k] = p[k] + m[k][n];
            }
            for (int j = 0; j < t->lobes; j++) {
                double *exponent = next + (t->rgb ? 3 + 3 * t->lobes : 4) + 4 * j + 3;
                *exponent = fmin(fmax(*exponent, *exponent == 0 ? 0 : 0.5), 200);
            }
            const double there = residuals(t, next, moved);
            if (there < cost) {
                memcpy(p, next, sizeof next);
                memcpy(r, moved, rows * sizeof *r);
                cost = there;
                damping = fmax(damping / 10, 1e-12);
                break;
            }
            damping *= 10;
        }
        if (before - cost < 1e-9 * before) {
            break;
        }
    }
    free(r);
    free(moved);
    free(jacobian);
    return cost;
}

static void fits(void) {
    static const struct {
        const char *name;
        int lobes;
        bool rgb, square_root;
    } list[] = {{"1 lobe of one colour", 1, false, false},
                {"3 lobes of one colour", 3, false, false},
                {"2 RGB lobes", 2, true, false},
                {"2 RGB lobes, square root", 2, true, true}};
    const hard_directions d = hard_twentyfive();
    enc_data *data = hard_create(3, 2, &d, &d, precision_measured, NULL);
    for (size_t i = 0; i < sizeof list / sizeof *list; i++) {
        enc_fit_options options = enc_fit_options_default();
        options.lobes = list[i].lobes;
        options.rgb = list[i].rgb;
        options.square_root = list[i].square_root;
        options.rounds = 0;
        options.tolerance = 1e-9;
        options.max_evaluations = 500;
        enc_sbrdf *sbrdf = NULL;
        double single = 0, twice = 0;
        const size_t stride = enc_sbrdf_stride(list[i].lobes, list[i].rgb);
        bool ok = enc_fit(&context, data, &options, &sbrdf, NULL) == BTF_OK;
        for (size_t t = 0; ok && t < 6; t++) {
            double p[MOST], r[25 * 25 * 3];
            for (size_t k = 0; k < stride; k++) {
                p[k] = (double)sbrdf->values[t * stride + k];
            }
            const target at = {data, t, list[i].lobes, list[i].rgb, list[i].square_root};
            single += residuals(&at, p, r);
            twice += refit(&at, p);
        }
        const double n = 6 * 25 * 25 * 3, loss = hard_psnr(twice, n, 1) - hard_psnr(single, n, 1);
        cases_add(told("fit of %s, refitted in double", list[i].name), "less than 0.05 dB",
                  ok && loss < precision_most_loss && loss > -1e-6,
                  "%.2f dB, double %.4f dB more", hard_psnr(single, n, 1), loss);
        enc_sbrdf_destroy(&sbrdf);
    }
    enc_data_destroy(&data);
}

/* ---- Gram sums ---- */

/* The sums of Gram matrices that the fit is made of (paper 2.2): vectorised floats against doubles with libm's pow and
 * log. The cost of the model is among them. */
static void gram(void) {
    enum { N = 1024 };
    static _Alignas(64) float planes[7][N];
    const enc_gram_samples samples = {
        N, {planes[0], planes[1], planes[2]}, planes[3], {planes[4], planes[5], planes[6]}};
    enc_gram_point point = {.shape = {{-1, -1, 1, 8}, {0.8f, -0.3f, 0.6f, 2}, {0.9f, 0.9f, 0.9f, 150}}};
    for (int c = 0; c < 3; c++) {
        for (int t = 0; t < 4; t++) {
            point.colour[c][t] = 0.2f + 0.1f * (float)(c + t);
        }
    }
    for (uint32_t i = 0; i < N; i++) {
        const double a = 6.28 * (double)hard_random(i, 1, 0), b = 6.28 * (double)hard_random(i, 2, 0);
        const double ra = sqrt((double)hard_random(i, 3, 0)), rb = sqrt((double)hard_random(i, 4, 0));
        planes[0][i] = (float)(ra * cos(a) * rb * cos(b));
        planes[1][i] = (float)(ra * sin(a) * rb * sin(b));
        planes[2][i] = (float)(sqrt(1 - ra * ra) * sqrt(1 - rb * rb));
        planes[3][i] = (float)sqrt(1 - ra * ra);
        for (uint32_t c = 0; c < 3; c++) {
            planes[4 + c][i] = hard_random(i, 5 + c, 0);
        }
    }
    double out[ENC_GRAM_MAX_COLUMNS * ENC_GRAM_MAX_COLUMNS],
        want[ENC_GRAM_MAX_COLUMNS * ENC_GRAM_MAX_COLUMNS] = {0};
    const int columns = enc_gram_columns(3);
    enc_gram_accumulate(&samples, 3, &point, out);
    for (int i = 0; i < N; i++) {
        double column[ENC_GRAM_MAX_COLUMNS] = {(double)planes[3][i]}, value[3];
        for (int j = 0; j < 3; j++) {
            double base = 0;
            for (int k = 0; k < 3; k++) {
                base += (double)point.shape[j][k] * (double)planes[k][i];
            }
            const double n = (double)point.shape[j][3], h = base < 1e-4 ? 0 : column[0] * pow(base, n - 1);
            for (int k = 0; k < 3; k++) {
                column[4 + 4 * j + k] = h * (double)planes[k][i];
            }
            value[j] = base < 1e-4 ? 0 : h * base;
            column[4 + 4 * j + 3] = base < 1e-4 ? 0 : value[j] * log(base);
        }
        for (int c = 0; c < 3; c++) {
            column[1 + c] = (double)point.colour[c][0] * column[0] - (double)planes[4 + c][i];
            for (int j = 0; j < 3; j++) {
                column[1 + c] += (double)point.colour[c][1 + j] * value[j];
            }
        }
        for (int a = 0; a < columns; a++) {
            for (int b = 0; b < columns; b++) {
                want[a * columns + b] += column[a] * column[b];
            }
        }
    }
    double worst = 0, cost = 0, exact = 0;
    for (int a = 0; a < columns; a++) {
        for (int b = 0; b < columns; b++) {
            const double size = sqrt(want[a * columns + a] * want[b * columns + b]);
            worst = fmax(worst, size > 0 ? fabs(out[a * columns + b] - want[a * columns + b]) / size : 0);
        }
    }
    for (int c = 1; c < 4; c++) {
        cost += out[c * columns + c];
        exact += want[c * columns + c];
    }
    const double loss = fabs(10 * log10(cost / exact));
    cases_add("Gram sums of 1024 samples, lobes of n = 8, 2 and 150",
              "within 3e-5 of the columns' lengths, cost within 0.05 dB",
              worst < 3e-5 && loss < precision_most_loss, "off by %.1e, cost by %.1e dB", worst, loss);
}

/* ---- shadow ---- */

static void shadows(void) {
    const hard_directions d = hard_thirteen();
    enc_data *data = hard_create(6, 6, &d, &d, precision_measured, NULL);
    enc_fit_options options = enc_fit_options_default();
    enc_sbrdf *sbrdf = NULL;
    static uint8_t codes[13 * 36];
    const enc_shadow_options shadow = enc_shadow_options_default();
    bool ok = enc_fit(&context, data, &options, &sbrdf, NULL) == BTF_OK &&
              enc_top_view_shadow(&context, data, sbrdf, &shadow, codes) == BTF_OK;
    double squares[2] = {0};
    int other = 0, shadowed = 0;
    for (int l = 0; ok && l < 13; l++) {
        for (size_t t = 0; t < 36; t++) {
            double m[3], y[3];
            for (int c = 0; c < 3; c++) {
                m[c] = hard_model(sbrdf->values + t * enc_sbrdf_stride(3, false), 3, false, false,
                                  data->views + data->top_view, data->lights + l, c);
                y[c] = (double)*hard_sample(data, t, data->top_view, c, l);
            }
            const double model = 0.2126 * m[0] + 0.7152 * m[1] + 0.0722 * m[2];
            const double btf = 0.2126 * y[0] + 0.7152 * y[1] + 0.0722 * y[2];
            const bool is = model - btf > 0.3 * btf && btf < 0.3 && model >= 1e-5;
            const double ratio = is ? fmin(btf / model, 1) : 1;
            const int code = (int)floor(255 * ratio + 0.5);
            other += code != codes[l * 36 + (int)t];
            shadowed += is;
            for (int c = 0; c < 3; c++) {
                const double single = m[c] * codes[l * 36 + (int)t] / 255 - y[c],
                             twice = m[c] * code / 255 - y[c];
                squares[0] += single * single;
                squares[1] += twice * twice;
            }
        }
    }
    const double n = 13 * 36 * 3, loss = hard_psnr(squares[1], n, 1) - hard_psnr(squares[0], n, 1);
    cases_add("shadow map, its model and ratios in double", "less than 0.05 dB",
              ok && fabs(loss) < precision_most_loss && shadowed > 0,
              "%.2f dB, double %.5f dB more, %d of 468 codes differ, %d shadowed",
              hard_psnr(squares[0], n, 1), loss, other, shadowed);
    enc_sbrdf_destroy(&sbrdf);
    enc_data_destroy(&data);
}

/* ---- playback ---- */

/* Compares the PSNR of enc_sample_decoder with that of the same codes decoded in double. */
static void playback(const char *what, const enc_data *data, const enc_solution *s, bool ok) {
    const size_t texels = enc_data_texel_count(data), lights = (size_t)data->n_lights;
    enc_sample_decoder *decoder = NULL;
    float *images = calloc(lights * texels * 3, sizeof *images);
    double squares[2] = {0};
    btf_result result = ok && images ? enc_sample_decoder_create(&context, data, s, &decoder)
                                     : BTF_ERROR_MEMORY;
    const enc_decoded_samples played = {decoder, BTF_EFFECT_ALL};
    const enc_image_source source = enc_decoded_images(&played);
    for (int v = 0; result == BTF_OK && v < data->n_views; v++) {
        result = source.view(source.user, v, images);
        for (size_t i = 0; i < lights * texels * 3; i++) {
            const int l = (int)(i / (3 * texels)), c = (int)(i % 3);
            const size_t t = i / 3 % texels;
            const double truth = (double)*hard_sample(data, t, v, c, l);
            const double single = (double)images[i] - truth;
            const double twice = precision_decode(data, s, t, v, c, l) - truth;
            squares[0] += single * single;
            squares[1] += twice * twice;
        }
    }
    const double n = (double)(texels * enc_data_texel_stride(data)),
                 loss = hard_psnr(squares[1], n, 1) - hard_psnr(squares[0], n, 1);
    cases_add(told("playback of %s, decoded in double", what), "less than 0.05 dB either way",
              result == BTF_OK && fabs(loss) < precision_most_loss,
              "%.2f dB, double %.6f dB more", hard_psnr(squares[0], n, 1), loss);
    enc_sample_decoder_destroy(&decoder);
    free(images);
}

/* A file of version 1 as encoders before 0.3 wrote them: sources of a residual of low rank in square roots,
 * of random codes, with shifts and gains. */
static enc_solution low_rank(const enc_data *data) {
    enum { K = 4 };
    const size_t texels = enc_data_texel_count(data), points = texels * (size_t)data->n_views,
                 directions = (size_t)data->n_views * (size_t)data->n_lights * 3;
    enc_solution s = {.width = data->width,
                      .height = data->height,
                      .n_views = data->n_views,
                      .n_lights = data->n_lights,
                      .domain = BTF_DOMAIN_SQRT,
                      .effects = BTF_EFFECT_SHIFT | BTF_EFFECT_GAIN | BTF_EFFECT_RESIDUAL,
                      .radiance_scale = 1,
                      .gain_scale = BTF_GAIN_SCALE,
                      .n_components = K,
                      .shift = malloc(2 * points),
                      .gain = malloc(points),
                      .residual_texels = malloc(texels * K),
                      .residual_directions = malloc(directions * K),
                      .residual_scales = malloc(K * sizeof(float))};
    if (!s.shift || !s.gain || !s.residual_texels || !s.residual_directions || !s.residual_scales) {
        exit(1);
    }
    for (size_t i = 0; i < points; i++) {
        s.shift[2 * i] = (int8_t)(hard_random((uint32_t)i, 1, 0) * 3) - 1;
        s.shift[2 * i + 1] = (int8_t)(hard_random((uint32_t)i, 1, 1) * 3) - 1;
        s.gain[i] = (uint8_t)(BTF_GAIN_ONE - 20 + hard_random((uint32_t)i, 1, 2) * 40);
    }
    for (size_t i = 0; i < texels * K; i++) {
        s.residual_texels[i] = (int8_t)(hard_random((uint32_t)i, 2, 0) * 120);
    }
    for (size_t i = 0; i < directions * K; i++) {
        s.residual_directions[i] = (int8_t)(hard_random((uint32_t)i, 3, 0) * 120 - 10);
    }
    for (int j = 0; j < K; j++) {
        s.residual_scales[j] = 6e-5f / (float)(j + 1);
    }
    return s;
}

static void playbacks(void) {
    const hard_directions d = hard_thirteen();
    enc_data *data = hard_create(6, 5, &d, &d, precision_measured, NULL);
    for (int method = 0; method < ENCODE_METHODS; method++) {
        enc_solution s = {0};
        char what[80];
        btf_result result;
        if (method != ENCODE_JOINT) {
            const enc_paper_options options = encode_paper_options((encode_method)method, 1);
            enc_paper_stats stats;
            result = enc_paper(&context, data, &options, &s, NULL, &stats);
        } else {
            const enc_factors_settings settings = encode_joint_settings(data, ENC_PRESET_FAST);
            enc_factors_stats stats;
            result = enc_factors_solve(&context, data, &settings, &s, &stats);
        }
        snprintf(what, sizeof what, "method %s", encode_names[method]);
        playback(what, data, &s, result == BTF_OK);
        enc_solution_clear(&s);
    }
    enc_solution s = low_rank(data);
    playback("sources of low rank", data, &s, true);
    enc_solution_clear(&s);
    enc_data_destroy(&data);
}

int main(void) {
    cases_title(
        "The float pipeline against the same stage in double: PSNR (peak 1), and what double would gain.");
    fits();
    gram();
    shadows();
    playbacks();
    precision_fit();
    precision_flow();
    precision_hidden();
    precision_clusters();
    return cases_result();
}
