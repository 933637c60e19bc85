/* Small BTFs made of a formula, see hard_data.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "hard_data.h"

#include "tests/sample/sample.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

hard_directions hard_rings(int rings, const double *theta, const int *count) {
    hard_directions d = {0};
    for (int ring = 0; ring < rings; ring++) {
        for (int i = 0; i < count[ring]; i++) {
            d.list[d.n++] = enc_direction_from_angles(theta[ring], 360.0 * i / count[ring]);
        }
    }
    return d;
}

hard_directions hard_thirteen(void) {
    return hard_rings(3, (const double[]){0, 30, 60}, (const int[]){1, 6, 6});
}

hard_directions hard_twentyfive(void) {
    return hard_rings(4, (const double[]){0, 25, 50, 75}, (const int[]){1, 6, 8, 10});
}

enc_data *hard_create(int width, int height, const hard_directions *views, const hard_directions *lights,
                      hard_value_fn value, const void *user) {
    const enc_context context = {.threads = 1};
    enc_data *data = NULL;
    if (enc_data_create(&context, width, height, views->n, views->list, lights->n, lights->list, &data) !=
        BTF_OK) {
        fprintf(stderr, "hard_data: cannot make %d x %d texels\n", width, height);
        exit(1);
    }
    for (size_t t = 0; t < enc_data_texel_count(data); t++) {
        for (int v = 0; v < views->n; v++) {
            for (int l = 0; l < lights->n; l++) {
                float rgb[3] = {0};
                value(user, (int)t, views->list + v, lights->list + l, v * lights->n + l, rgb);
                for (int c = 0; c < 3; c++) {
                    *hard_sample(data, t, v, c, l) = rgb[c];
                }
            }
        }
    }
    return data;
}

enc_data *hard_relief(int side, const hard_directions *views, const hard_directions *lights, float scale) {
    const sample_options options = {.width = side,
                                    .height = side,
                                    .grid = 128,
                                    .views = views->list,
                                    .n_views = views->n,
                                    .lights = lights->list,
                                    .n_lights = lights->n};
    enc_data *data = NULL;
    if (sample_render(&options, &data, NULL) != BTF_OK) {
        fprintf(stderr, "hard_data: cannot render the relief\n");
        exit(1);
    }
    for (size_t i = 0; i < enc_data_texel_count(data) * enc_data_texel_stride(data); i++) {
        data->samples[i] *= scale;
    }
    return data;
}

enc_data *hard_moved(const enc_data *data, const enc_direction *views, const enc_direction *lights,
                     void (*from)(const void *user, int *texel, int *view, int *light), const void *user) {
    const enc_context context = {.threads = 1};
    enc_data *moved = NULL;
    if (enc_data_create(&context, data->width, data->height, data->n_views, views ? views : data->views,
                        data->n_lights, lights ? lights : data->lights, &moved) != BTF_OK) {
        fprintf(stderr, "hard_data: cannot copy\n");
        exit(1);
    }
    for (size_t t = 0; t < enc_data_texel_count(data); t++) {
        for (int v = 0; v < data->n_views; v++) {
            for (int l = 0; l < data->n_lights; l++) {
                int texel = (int)t, view = v, light = l;
                from(user, &texel, &view, &light);
                for (int c = 0; c < 3; c++) {
                    *hard_sample(moved, t, v, c, l) = *hard_sample(data, (size_t)texel, view, c, light);
                }
            }
        }
    }
    return moved;
}

float hard_random(uint32_t a, uint32_t b, uint32_t c) {
    uint32_t x = a * 0x9E3779B1u ^ b * 0x85EBCA77u ^ c * 0xC2B2AE3Du ^ 0x27D4EB2Fu;
    for (int i = 0; i < 3; i++) {
        x ^= x >> 15;
        x *= 0x2C1B3C6Du;
        x ^= x >> 12;
        x *= 0x297A2D39u;
    }
    x ^= x >> 15;
    return (float)(x >> 8) * 0x1p-24f;
}

void hard_black(const void *user, int texel, const enc_direction *view, const enc_direction *light,
                int sample, float out_rgb[3]) {
    (void)user, (void)texel, (void)view, (void)light, (void)sample, (void)out_rgb;
}

void hard_constant(const void *user, int texel, const enc_direction *view, const enc_direction *light,
                   int sample, float out_rgb[3]) {
    (void)texel, (void)view, (void)light, (void)sample;
    out_rgb[0] = out_rgb[1] = out_rgb[2] = *(const float *)user;
}

void hard_noise(const void *user, int texel, const enc_direction *view, const enc_direction *light,
                int sample, float out_rgb[3]) {
    (void)view, (void)light;
    for (int c = 0; c < 3; c++) {
        out_rgb[c] =
            (user ? *(const float *)user : 1) * hard_random((uint32_t)texel, (uint32_t)sample, (uint32_t)c);
    }
}

void hard_spread(const void *user, int texel, const enc_direction *view, const enc_direction *light,
                 int sample, float out_rgb[3]) {
    (void)user, (void)view, (void)light;
    for (int c = 0; c < 3; c++) {
        out_rgb[c] = powf(10, -8 + 14 * hard_random((uint32_t)texel, (uint32_t)sample, (uint32_t)c));
    }
}

double hard_model(const float *parameters, int lobes, bool rgb, bool square_root, const enc_direction *view,
                  const enc_direction *light, int channel) {
    const float *shape = parameters + (rgb ? 3 + 3 * lobes : 4);
    double sum = (double)parameters[rgb ? channel : 3];
    for (int j = 0; j < lobes; j++, shape += 4) {
        double base = 0;
        for (int k = 0; k < 3; k++) {
            base += (double)shape[k] * (double)light->xyz[k] * (double)view->xyz[k];
        }
        const double power = base > 0x1p-24 ? pow(base, (double)shape[3]) : 0;
        sum += rgb ? (double)parameters[3 + 3 * j + channel] * power : power;
    }
    sum *= rgb ? 1 : (double)parameters[channel];
    const double cosine = fmax((double)light->xyz[2], 0);
    const double value = sum * (square_root ? sqrt(cosine) : cosine);
    return square_root ? value * value : value;
}

double hard_psnr(double squares, double count, double peak) {
    return squares > 0 ? 10 * log10(peak * peak * count / squares) : 200;
}
