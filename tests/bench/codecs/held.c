/* Directions that are left out of the encoding. See held.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "held.h"

#include "encoder/report/metrics.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double held_theta = 45;

/* Chosen directions, as indices into a list. */
typedef struct choice {
    int index[ENC_MAX_DIRECTIONS];
    int count;
} choice;

/* Splits a list: of the ring of several directions nearest to 45 degrees, every second one goes to `held`. */
static void split(const enc_direction *directions, int count, choice *train, choice *held) {
    double theta[ENC_MAX_DIRECTIONS];
    int ring_of[ENC_MAX_DIRECTIONS], members[ENC_MAX_DIRECTIONS] = {0}, ring = -1, position = 0;
    const int rings = enc_rings(directions, count, theta, ring_of);
    for (int i = 0; i < count; i++) {
        members[ring_of[i]]++;
    }
    for (int r = 0; r < rings; r++) {
        if (members[r] > 1 && (ring < 0 || fabs(theta[r] - held_theta) < fabs(theta[ring] - held_theta))) {
            ring = r;
        }
    }
    train->count = held->count = 0;
    for (int i = 0; i < count; i++) {
        const bool out = ring_of[i] == ring && position++ % 2 == 1;
        choice *to = out ? held : train;
        to->index[to->count++] = i;
    }
}

/* The data of some views under some lights. */
static btf_result subset(const enc_context *context, const enc_data *data, const choice *views,
                         const choice *lights, enc_data **out_data) {
    enc_direction view_list[ENC_MAX_DIRECTIONS], light_list[ENC_MAX_DIRECTIONS];
    for (int i = 0; i < views->count; i++) {
        view_list[i] = data->views[views->index[i]];
    }
    for (int i = 0; i < lights->count; i++) {
        light_list[i] = data->lights[lights->index[i]];
    }
    btf_result result = enc_data_create(context, data->width, data->height, views->count, view_list,
                                        lights->count, light_list, out_data);
    if (result != BTF_OK) {
        return result;
    }
    const size_t all_lights = (size_t)data->n_lights, n = (size_t)lights->count;
    float *buffer = malloc(enc_data_texel_stride(data) * sizeof *buffer);
    float *part = malloc(enc_data_texel_stride(*out_data) * sizeof *part);
    result = buffer && part ? BTF_OK : enc_fail(context, BTF_ERROR_MEMORY, "bench: out of memory");
    for (size_t t = 0; t < enc_data_texel_count(data) && result == BTF_OK; t++) {
        const float *samples;
        result = enc_data_texels(context, data, t, 1, buffer, &samples);
        for (size_t i = 0; i < (size_t)views->count * 3 && result == BTF_OK; i++) {
            const size_t view = (size_t)views->index[i / 3];
            for (size_t l = 0; l < n; l++) {
                part[i * n + l] = samples[(view * 3 + i % 3) * all_lights + (size_t)lights->index[l]];
            }
        }
        if (result == BTF_OK) {
            result = enc_data_store_texels(context, *out_data, t, 1, part);
        }
    }
    free(buffer);
    free(part);
    if (result != BTF_OK) {
        enc_data_destroy(out_data);
    }
    return result;
}

static btf_ref_neighbours look_up(const uint16_t *table, uint32_t grid, const enc_direction *direction,
                                  bool nearest) {
    int32_t q[2];
    btf_ref_project(direction->xyz, q);
    const btf_ref_neighbours found = btf_ref_lookup(table, grid, q);
    return nearest ? btf_ref_nearest(found) : found;
}

static btf_result blended_view(const void *user, int view, float *out) {
    const bench_blend *b = user;
    const size_t image = enc_data_texel_count(b->shape) * 3, lights = (size_t)b->shape->n_lights;
    const btf_ref_neighbours views =
        look_up(b->tables->view_table, b->tables->view_grid, &b->shape->views[view], b->nearest);
    float *images = malloc((size_t)b->samples->n_lights * image * sizeof *images);
    btf_result result = images ? BTF_OK : BTF_ERROR_MEMORY;
    memset(out, 0, lights * image * sizeof *out);
    for (int i = 0; i < 3 && result == BTF_OK; i++) {
        if (views.weight[i] == 0) {
            continue;
        }
        result = enc_data_view(NULL, b->samples, (int)views.index[i], images);
        for (size_t l = 0; l < lights && result == BTF_OK; l++) {
            const btf_ref_neighbours near =
                look_up(b->tables->light_table, b->tables->light_grid, &b->shape->lights[l], b->nearest);
            for (int k = 0; k < 3; k++) {
                const float weight = (float)(views.weight[i] * near.weight[k]) * 0x1p-24f;
                const float *from = images + near.index[k] * image;
                for (size_t p = 0; p < image && weight > 0; p++) {
                    out[l * image + p] += weight * from[p];
                }
            }
        }
    }
    free(images);
    return result;
}

enc_image_source bench_blended_images(const bench_blend *blend) {
    return (enc_image_source){blended_view, blend};
}

btf_result bench_held_create(const enc_context *context, const enc_data *data, bool wanted,
                             bench_held *out_held) {
    choice views, held_views, lights, held_lights;
    btf_result result = BTF_OK;
    *out_held = (bench_held){.train = data};
    split(data->views, data->n_views, &views, &held_views);
    split(data->lights, data->n_lights, &lights, &held_lights);
    if (!wanted || held_views.count == 0 || held_lights.count == 0) {
        return BTF_OK;
    }
    const choice *const parts[1 + BENCH_HELD_SETS][2] = {
        {&views, &lights}, {&held_views, &lights}, {&views, &held_lights}, {&held_views, &held_lights}};
    for (int i = 0; i <= BENCH_HELD_SETS && result == BTF_OK; i++) {
        result = subset(context, data, parts[i][0], parts[i][1],
                        i == 0 ? &out_held->owned : &out_held->sets[i - 1]);
    }
    out_held->train = out_held->owned;
    out_held->theta = data->views[held_views.index[0]].theta;
    out_held->n_views = held_views.count;
    out_held->n_lights = held_lights.count;
    if (result != BTF_OK) {
        bench_held_clear(out_held);
    }
    return result;
}

void bench_held_clear(bench_held *held) {
    enc_data_destroy(&held->owned);
    for (int i = 0; i < BENCH_HELD_SETS; i++) {
        enc_data_destroy(&held->sets[i]);
    }
    *held = (bench_held){0};
}
