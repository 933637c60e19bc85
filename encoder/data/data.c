/* A BTF's samples: in memory, in a scratch file, or made by their origin when asked for.
 *
 * SPDX-License-Identifier: MIT
 */
#include "data.h"

#include "encoder/base/ranks.h"
#include "encoder/base/scratch.h"
#include "encoder/base/stage.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

enum { MAX_SIDE = 16384 };

/* sin and cos of multiples of 90 degrees are exactly 0, 1 or -1. */
static float direction_component(double value) {
    return fabs(value) < 1e-12 ? 0.0f : (float)value;
}

enc_direction enc_direction_from_angles(double theta_degrees, double phi_degrees) {
    const double to_radians = 3.14159265358979323846 / 180.0;
    const double theta = theta_degrees * to_radians, phi = phi_degrees * to_radians;
    return (enc_direction){theta_degrees,
                           phi_degrees,
                           {direction_component(sin(theta) * cos(phi)),
                            direction_component(sin(theta) * sin(phi)), direction_component(cos(theta))}};
}

static enc_direction *copy_directions(const enc_direction *list, int count) {
    enc_direction *copy = malloc((size_t)count * sizeof *copy);
    if (copy) {
        memcpy(copy, list, (size_t)count * sizeof *copy);
    }
    return copy;
}

/* The fewest bytes that the encode takes besides the samples; 0 where the context does not say. */
static uint64_t least_memory(const enc_context *context, int width, int height, int n_views, int n_lights) {
    return context->least_memory ? context->least_memory(width, height, n_views, n_lights, context->threads)
                                 : 0;
}

/* Refuses data of which an encode takes more than the allowed memory at the least. */
static btf_result check_memory(const enc_context *context, int width, int height, int n_views,
                               int n_lights) {
    if (!context || context->memory == 0) {
        return BTF_OK;
    }
    const uint64_t least = least_memory(context, width, height, n_views, n_lights);
    if (least <= context->memory) {
        return BTF_OK;
    }
    return enc_fail(
        context, BTF_ERROR_USAGE,
        "option memory: %zu bytes are too few: %dx%d texels, %d views and %d lights take at least %lluK",
        context->memory, width, height, n_views, n_lights, (unsigned long long)((least + 999) / 1000));
}

/* Makes everything but the samples. */
static btf_result create_empty(const enc_context *context, int width, int height, int n_views,
                               const enc_direction *views, int n_lights, const enc_direction *lights,
                               uint64_t *out_bytes, enc_data **out_data) {
    *out_data = NULL;
    if (width < 1 || height < 1 || width > MAX_SIDE || height > MAX_SIDE) {
        return enc_fail(context, BTF_ERROR_USAGE, "size %dx%d is not usable: each side is 1 to %d", width,
                        height, MAX_SIDE);
    }
    if (n_views < 1 || n_lights < 1 || n_views > ENC_MAX_DIRECTIONS || n_lights > ENC_MAX_DIRECTIONS) {
        return enc_fail(context, BTF_ERROR_USAGE, "%d views and %d lights are not usable: each is 1 to %d",
                        n_views, n_lights, ENC_MAX_DIRECTIONS);
    }
    const btf_result enough = check_memory(context, width, height, n_views, n_lights);
    if (enough != BTF_OK) {
        return enough;
    }
    /* At most 2^28 texels of 3 * 2^16 floats: no overflow in 64 bits. */
    *out_bytes =
        (uint64_t)width * (uint64_t)height * (uint64_t)n_views * 3 * (uint64_t)n_lights * sizeof(float);
    enc_data *data = *out_bytes > SIZE_MAX / 2 ? NULL : calloc(1, sizeof *data);
    if (!data) {
        return BTF_ERROR_MEMORY;
    }
    data->scratch_fd = -1;
    data->width = width;
    data->height = height;
    data->n_views = n_views;
    data->n_lights = n_lights;
    data->views = copy_directions(views, n_views);
    data->lights = copy_directions(lights, n_lights);
    if (!data->views || !data->lights) {
        enc_data_destroy(&data);
        return BTF_ERROR_MEMORY;
    }
    for (int i = 1; i < n_views; i++) {
        if (views[i].theta < views[data->top_view].theta) {
            data->top_view = i;
        }
    }
    *out_data = data;
    return BTF_OK;
}

bool enc_data_fits(const enc_context *context, int width, int height, int n_views, int n_lights) {
    if (!context || context->memory == 0) {
        return true;
    }
    const uint64_t bytes = 12 * (uint64_t)width * (uint64_t)height * (uint64_t)n_views * (uint64_t)n_lights;
    const uint64_t least = least_memory(context, width, height, n_views, n_lights);
    return bytes <= context->memory / 2 && bytes + least <= context->memory;
}

static btf_result allocate(const enc_context *context, enc_data *data, uint64_t bytes) {
    data->samples = calloc((size_t)bytes, 1);
    return data->samples ? BTF_OK
                         : enc_fail(context, BTF_ERROR_MEMORY,
                                    "samples: out of memory for %.2f GB (option memory sets a limit)",
                                    (double)bytes * 1e-9);
}

btf_result enc_data_create(const enc_context *context, int width, int height, int n_views,
                           const enc_direction *views, int n_lights, const enc_direction *lights,
                           enc_data **out_data) {
    uint64_t bytes;
    btf_result result =
        create_empty(context, width, height, n_views, views, n_lights, lights, &bytes, out_data);
    if (result != BTF_OK) {
        return result;
    }
    if (enc_ranks_count(context) > 1) {
        result = enc_scratch_open_shared(context, "samples", bytes, &(*out_data)->scratch_fd,
                                         &(*out_data)->scratch_path);
    } else {
        result = enc_data_fits(context, width, height, n_views, n_lights)
                     ? allocate(context, *out_data, bytes)
                     : enc_scratch_open(context, "samples", bytes, &(*out_data)->scratch_fd);
    }
    if (result != BTF_OK) {
        enc_data_destroy(out_data);
    }
    return result;
}

/* Makes and keeps one block of samples, through `buffer` where samples do not lie in memory. */
static btf_result keep_block(const enc_context *context, enc_data *data, size_t first, size_t count,
                             float *buffer) {
    const size_t stride = enc_data_texel_stride(data);
    float *out = data->samples ? data->samples + first * stride : buffer;
    if (!out) {
        return BTF_ERROR_MEMORY;
    }
    const btf_result result = data->origin->texels(context, data->origin, first, count, out);
    return result != BTF_OK || data->samples ? result
                                             : enc_data_store_texels(context, data, first, count, out);
}

/* Makes all samples, or this rank's part of them, and keeps them. */
static btf_result keep_samples(const enc_context *context, enc_data *data) {
    enum { BLOCK = 16 };
    const int threads = context && context->threads > 0 ? context->threads : 1;
    size_t begin, end;
    btf_result result = BTF_OK;
    enc_ranks_range(context, enc_data_texel_count(data), &begin, &end);
    enc_stage_begin(context, "decode", end - begin);
#pragma omp parallel num_threads(threads)
    {
        float *buffer = data->samples ? NULL : malloc(BLOCK * enc_data_texel_stride(data) * sizeof *buffer);
#pragma omp for schedule(dynamic)
        for (size_t first = begin; first < end; first += BLOCK) {
            const size_t count = end - first < BLOCK ? end - first : BLOCK;
            btf_result mine;
#pragma omp atomic read
            mine = result;
            if (mine != BTF_OK) {
                continue;
            }
            mine = enc_cancelled(context) ? BTF_ERROR_INTERRUPTED
                                          : keep_block(context, data, first, count, buffer);
            enc_keep_worse(&result, mine);
            enc_stage_step(context, count);
        }
        free(buffer);
    }
    result = enc_data_complete(context, data, result);
    enc_stage_end(context);
    return result;
}

/* Maps the samples of a scratch file into memory where there is room for them. If that fails, they are read
 * from the file when asked for. */
static void map_samples(const enc_context *context, enc_data *data) {
    const size_t bytes = enc_data_texel_count(data) * enc_data_texel_stride(data) * sizeof(float);
    if (!enc_data_fits(context, data->width, data->height, data->n_views, data->n_lights)) {
        return;
    }
    void *samples = mmap(NULL, bytes, PROT_READ, MAP_SHARED, data->scratch_fd, 0);
    if (samples == MAP_FAILED) {
        return;
    }
    data->samples = samples;
    data->mapped = bytes;
}

btf_result enc_data_complete(const enc_context *context, enc_data *data, btf_result result) {
    if (enc_ranks_count(context) == 1) {
        return result;
    }
    result = enc_scratch_written(context, result, &data->scratch_fd, &data->scratch_path);
    if (result == BTF_OK) {
        map_samples(context, data);
    }
    return result;
}

btf_result enc_data_create_from(const enc_context *context, int width, int height, int n_views,
                                const enc_direction *views, int n_lights, const enc_direction *lights,
                                enc_data_origin *origin, enc_data **out_data) {
    uint64_t bytes;
    btf_result result =
        create_empty(context, width, height, n_views, views, n_lights, lights, &bytes, out_data);
    if (result != BTF_OK) {
        origin->close(origin);
        return result;
    }
    (*out_data)->origin = origin;
    if (enc_ranks_all(context, enc_data_fits(context, width, height, n_views, n_lights))) {
        result = enc_ranks_count(context) > 1
                     ? enc_scratch_open_shared(context, "samples", bytes, &(*out_data)->scratch_fd,
                                               &(*out_data)->scratch_path)
                     : allocate(context, *out_data, bytes);
        if (result == BTF_OK) {
            result = keep_samples(context, *out_data);
        }
    } else {
        enc_log(context, BTF_LOG_INFO,
                "samples: %.2f GB are more than half of the memory allowed, %.2f GB: they are decoded from "
                "the input again when needed",
                (double)bytes * 1e-9, (double)context->memory * 1e-9);
    }
    if (result != BTF_OK) {
        enc_data_destroy(out_data);
    }
    return result;
}

btf_result enc_data_copy_lights(const enc_data *from, enc_data *to) {
    const size_t size = (size_t)from->n_views * sizeof *from->moved_light;
    if (!from->moved_light) {
        return BTF_OK;
    }
    assert(!to->moved_light && to->n_views == from->n_views);
    to->moved_light = malloc(size);
    if (!to->moved_light) {
        return BTF_ERROR_MEMORY;
    }
    memcpy(to->moved_light, from->moved_light, size);
    return BTF_OK;
}

void enc_data_destroy(enc_data **data) {
    if (!data || !*data) {
        return;
    }
    enc_data *d = *data;
    free(d->views);
    free(d->lights);
    if (d->mapped > 0) {
        munmap(d->samples, d->mapped);
    } else {
        free(d->samples);
    }
    if (d->scratch_fd >= 0) {
        close(d->scratch_fd);
    }
    if (d->scratch_path) {
        unlink(d->scratch_path);
    }
    free(d->scratch_path);
    if (d->origin) {
        d->origin->close(d->origin);
    }
    free(d->moved_light);
    free(d->source);
    free(d);
    *data = NULL;
}

/* Whether samples are made when asked for. */
static bool is_made(const enc_data *data) {
    return data->origin && data->scratch_fd < 0;
}

btf_result enc_data_texels(const enc_context *context, const enc_data *data, size_t first, size_t count,
                           float *buffer, const float **out_samples) {
    const size_t stride = enc_data_texel_stride(data);
    assert(first + count <= enc_data_texel_count(data));
    if (data->samples) {
        *out_samples = data->samples + first * stride;
        return BTF_OK;
    }
    *out_samples = buffer;
    if (is_made(data)) {
        return data->origin->texels(context, data->origin, first, count, buffer);
    }
    return enc_scratch_read(context, data->scratch_fd, (uint64_t)first * stride * sizeof(float),
                            count * stride * sizeof(float), buffer);
}

btf_result enc_data_store_texels(const enc_context *context, enc_data *data, size_t first, size_t count,
                                 const float *samples) {
    const size_t stride = enc_data_texel_stride(data);
    assert(first + count <= enc_data_texel_count(data));
    if (data->samples) {
        memcpy(data->samples + first * stride, samples, count * stride * sizeof(float));
        return BTF_OK;
    }
    return enc_scratch_write(context, data->scratch_fd, (uint64_t)first * stride * sizeof(float),
                             count * stride * sizeof(float), samples);
}

btf_result enc_data_store_run(const enc_context *context, enc_data *data, size_t texel, size_t at,
                              size_t count, const float *samples) {
    const size_t stride = enc_data_texel_stride(data);
    assert(texel < enc_data_texel_count(data) && at + count <= stride);
    if (data->samples) {
        memcpy(data->samples + texel * stride + at, samples, count * sizeof(float));
        return BTF_OK;
    }
    return enc_scratch_write(context, data->scratch_fd, ((uint64_t)texel * stride + at) * sizeof(float),
                             count * sizeof(float), samples);
}

btf_result enc_data_view(const enc_context *context, const enc_data *data, int view, float *out) {
    enum { BLOCK = 16 }; /* texels whose profiles are transposed together */
    assert(view >= 0 && view < data->n_views);
    const size_t texels = enc_data_texel_count(data), lights = (size_t)data->n_lights, profile = 3 * lights;
    const size_t stride = enc_data_texel_stride(data);
    btf_result result = BTF_OK;
    float *buffer = NULL;
    if (!data->samples && !(buffer = malloc(BLOCK * profile * sizeof *buffer))) {
        return BTF_ERROR_MEMORY;
    }
    for (size_t first = 0; first < texels && result == BTF_OK; first += BLOCK) {
        const size_t count = texels - first < BLOCK ? texels - first : BLOCK;
        const float *profiles[BLOCK];
        if (is_made(data) && !data->samples) {
            result = data->origin->profiles(context, data->origin, view, first, count, buffer);
        }
        for (size_t t = 0; t < count && result == BTF_OK; t++) {
            const size_t at = (first + t) * stride + (size_t)view * profile;
            profiles[t] = data->samples ? data->samples + at : buffer + t * profile;
            if (!data->samples && !is_made(data)) {
                result = enc_scratch_read(context, data->scratch_fd, (uint64_t)at * sizeof(float),
                                          profile * sizeof(float), buffer + t * profile);
            }
        }
        if (result != BTF_OK) {
            break;
        }
        for (size_t l = 0; l < lights; l++) {
            for (size_t t = 0; t < count; t++) {
                for (size_t c = 0; c < 3; c++) {
                    out[(l * texels + first + t) * 3 + c] = profiles[t][c * lights + l];
                }
            }
        }
    }
    free(buffer);
    return result;
}
