/* Peers of decoding. See decode_peers.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "decode_peers.h"

#include "encoder/math/srgb.h"
#include "encoder/model/pack.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double phong_exponent = 40; /* that of the shader */

/* Photometric stereo (R. Woodham, 1980): finds g = albedo * normal with the least sum over samples of (luminance - g .
 * l)^2. */
static void fit_normal(const enc_data *data, const float *samples, double normal[3]) {
    const int lights = data->n_lights;
    double a[3][4] = {{0}};
    for (int l = 0; l < lights; l++) {
        double mean = 0;
        for (int v = 0; v < data->n_views; v++) {
            const float *rgb = samples + (size_t)v * 3 * (size_t)lights + l;
            mean += (double)enc_luminance(rgb[0], rgb[lights], rgb[2 * lights]) / data->n_views;
        }
        for (int i = 0; i < 3; i++) {
            for (int j = 0; j < 3; j++) {
                a[i][j] += (double)data->lights[l].xyz[i] * data->lights[l].xyz[j];
            }
            a[i][3] += mean * data->lights[l].xyz[i];
        }
    }
    /* Gauss-Jordan elimination; a small weight of the pole keeps the system solvable with few lights */
    for (int i = 0; i < 3; i++) {
        a[i][i] += 1e-6 * lights;
    }
    for (int i = 0; i < 3; i++) {
        for (int k = 0; k < 3; k++) {
            const double f = k == i ? 0 : a[k][i] / a[i][i];
            for (int j = i; j < 4; j++) {
                a[k][j] -= f * a[i][j];
            }
        }
    }
    for (int i = 0; i < 3; i++) {
        normal[i] = a[i][3] / a[i][i];
    }
    normal[2] = fmax(normal[2], 0);
    const double length = sqrt(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]);
    for (int i = 0; i < 3; i++) {
        normal[i] = length > 0 ? normal[i] / length : i == 2;
    }
}

static double dot3(const double a[3], const float b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Fits the albedo of a texel, and adds its part to the sums that give the strength of the highlight. */
static void fit_albedo(const enc_data *data, const float *samples, const double normal[3], double albedo[3],
                       double sums[2]) {
    const int lights = data->n_lights;
    double above[3] = {0}, below = 0;
    for (int i = 0; i < data->n_views * lights; i++) {
        const double n_l = fmax(dot3(normal, data->lights[i % lights].xyz), 0);
        const float *rgb = samples + (size_t)(i / lights) * 3 * (size_t)lights + i % lights;
        for (int c = 0; c < 3; c++) {
            above[c] += n_l * rgb[c * lights];
        }
        below += n_l * n_l;
    }
    for (int c = 0; c < 3; c++) {
        albedo[c] = below > 0 ? fmin(above[c] / below, 1) : 0;
    }
    for (int i = 0; i < data->n_views * lights; i++) {
        const float *l = data->lights[i % lights].xyz, *v = data->views[i / lights].xyz;
        const double n_l = dot3(normal, l);
        double mirror = 0;
        for (int c = 0; c < 3; c++) {
            mirror += (2 * n_l * normal[c] - l[c]) * v[c];
        }
        const double highlight = mirror > 0 ? pow(mirror, phong_exponent) : 0;
        const float *rgb = samples + (size_t)(i / lights) * 3 * (size_t)lights + i % lights;
        for (int c = 0; c < 3; c++) {
            sums[0] += highlight * (rgb[c * lights] - albedo[c] * fmax(n_l, 0));
            sums[1] += highlight * highlight;
        }
    }
}

static unsigned char to_byte(double x) {
    return (unsigned char)(255 * fmin(fmax(x, 0), 1) + 0.5);
}

btf_result peer_phong(const enc_context *context, const enc_data *data, unsigned char **out_albedo,
                      unsigned char **out_normal) {
    const size_t texels = enc_data_texel_count(data), width = (size_t)data->width;
    float *buffer = malloc(enc_data_texel_stride(data) * sizeof *buffer);
    unsigned char *albedo = malloc(4 * texels), *normals = malloc(4 * texels);
    double sums[2] = {0};
    btf_result result = buffer && albedo && normals
                            ? BTF_OK
                            : enc_fail(context, BTF_ERROR_MEMORY, "bench: out of memory for a Phong model");
    for (size_t t = 0; t < texels && result == BTF_OK; t++) {
        const size_t at = 4 * ((texels / width - 1 - t / width) * width + t % width);
        const float *samples;
        double normal[3], colour[3];
        result = enc_data_texels(context, data, t, 1, buffer, &samples);
        if (result == BTF_OK) {
            fit_normal(data, samples, normal);
            fit_albedo(data, samples, normal, colour, sums);
            for (int c = 0; c < 3; c++) {
                albedo[at + (size_t)c] = to_byte(enc_srgb_encode((float)colour[c]));
                normals[at + (size_t)c] = to_byte(0.5 * normal[c] + 0.5);
            }
            normals[at + 3] = 255;
        }
    }
    for (size_t t = 0; t < texels && result == BTF_OK; t++) {
        albedo[4 * t + 3] = to_byte(sums[1] > 0 ? sums[0] / sums[1] : 0);
    }
    free(buffer);
    if (result != BTF_OK) {
        free(albedo);
        free(normals);
        albedo = normals = NULL;
    }
    *out_albedo = albedo;
    *out_normal = normals;
    return result;
}

btf_result peer_images(const enc_context *context, const enc_data *data, int *out_columns, int *out_rows,
                       unsigned char **out_bytes) {
    const size_t width = (size_t)data->width, height = (size_t)data->height, texels = width * height;
    const size_t lights = (size_t)data->n_lights;
    size_t columns = 1;
    while (columns * columns < lights) {
        columns++;
    }
    const size_t rows = (lights + columns - 1) / columns, layer = 4 * columns * rows * texels;
    unsigned char *bytes = calloc((size_t)data->n_views, layer);
    float *images = malloc(lights * texels * 3 * sizeof *images);
    btf_result result = bytes && images
                            ? BTF_OK
                            : enc_fail(context, BTF_ERROR_MEMORY, "bench: out of memory for all images");
    for (int view = 0; view < data->n_views && result == BTF_OK; view++) {
        result = enc_data_view(context, data, view, images);
        for (size_t i = 0; i < lights * texels && result == BTF_OK; i++) {
            const size_t light = i / texels, y = i % texels / width, x = i % width;
            unsigned char *to =
                bytes + (size_t)view * layer +
                4 * ((light / columns * height + y) * columns * width + light % columns * width + x);
            for (size_t c = 0; c < 3; c++) {
                to[c] = to_byte(enc_srgb_encode(images[3 * i + c]));
            }
            to[3] = 255;
        }
    }
    free(images);
    if (result != BTF_OK) {
        free(bytes);
        bytes = NULL;
    }
    *out_columns = (int)columns;
    *out_rows = (int)rows;
    *out_bytes = bytes;
    return result;
}

/* The step of numbers that were rounded to multiples of it; the largest of them is 127 steps. */
static float step_of(const float *x, size_t count, size_t pitch) {
    float range = 0;
    for (size_t i = 0; i < count; i++) {
        range = fmaxf(range, fabsf(x[i * pitch]));
    }
    return range / 127;
}

static int8_t code_of(float x, float step) {
    return step > 0 ? (int8_t)rintf(x / step) : 0;
}

btf_result peer_components(const enc_context *context, const pca_codec *codec,
                           btf_material **out_material) {
    const enc_data *data = codec->data;
    const size_t texels = enc_data_texel_count(data), k = (codec->rank + 3) / 4 * 4;
    const size_t lights = (size_t)data->n_lights, columns = codec->columns;
    enc_solution s = {.width = data->width,
                      .height = data->height,
                      .n_views = data->n_views,
                      .n_lights = data->n_lights,
                      .domain = BTF_DOMAIN_LINEAR,
                      .effects = BTF_EFFECT_RESIDUAL,
                      .radiance_scale = 1,
                      .shadow_scale = 1.0f / 255,
                      .gain_scale = BTF_GAIN_SCALE,
                      .centre_scale = 1.0f / 255,
                      .n_components = (uint32_t)k,
                      .residual_texels = calloc(texels, k),
                      .residual_directions = calloc(columns, k),
                      .residual_scales = calloc(k, sizeof(float))};
    btf_result result = s.residual_texels && s.residual_directions && s.residual_scales
                            ? BTF_OK
                            : enc_fail(context, BTF_ERROR_MEMORY, "bench: out of memory");
    if (result == BTF_OK && k > 256) {
        result = BTF_ERROR_UNSUPPORTED;
    }
    for (size_t j = 0; j < codec->rank && result == BTF_OK; j++) {
        const float u_step = step_of(codec->u + j, texels, codec->rank);
        const float v_step = step_of(codec->v + j * columns, columns, 1);
        const float scale = u_step * v_step;
        s.residual_scales[j] = scale >= 0x1p-24f ? scale : 0.0f;
        for (size_t t = 0; t < texels; t++) {
            s.residual_texels[codec->order[t] * k + j] = code_of(codec->u[t * codec->rank + j], u_step);
        }
        for (size_t i = 0; i < columns; i++) {
            const size_t view = i / (3 * lights), channel = i / lights % 3, light = i % lights;
            s.residual_directions[((view * lights + light) * 3 + channel) * k + j] =
                code_of(codec->v[j * columns + i], v_step);
        }
    }
    const enc_pack_options options = {.layout = BTF_LAYOUT_TIGHT, .method = "pca", .source = data->source};
    if (result == BTF_OK) {
        result = enc_pack(context, data, &s, &options, out_material);
    }
    enc_solution_clear(&s);
    return result;
}
