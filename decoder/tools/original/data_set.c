/* The encoder's reader of data sets as the renderer takes it.
 *
 * SPDX-License-Identifier: MIT
 */
#include "data_set.h"

#include "encoder/input/reader.h"
#include <stdlib.h>
#include <string.h>

typedef struct data_set {
    enc_data *data;
    original_direction *directions; /* views, then lights */
} data_set;

static void release(void *owner) {
    data_set *d = owner;
    enc_data_destroy(&d->data);
    free(d->directions);
    free(d);
}

static void copy_directions(int count, const enc_direction *from, original_direction *to) {
    for (int i = 0; i < count; i++) {
        to[i].theta = from[i].theta;
        to[i].phi = from[i].phi;
        memcpy(to[i].xyz, from[i].xyz, sizeof to[i].xyz);
    }
}

static btf_result fill(data_set *d, const enc_context *context, const char *input, original_data *out) {
    const enc_read_options defaults = {0};
    const btf_result result = enc_read(context, input, &defaults, &d->data);
    if (result) {
        return result;
    }
    const size_t n_views = (size_t)d->data->n_views, n_lights = (size_t)d->data->n_lights;
    d->directions = calloc(n_views + n_lights, sizeof *d->directions);
    if (!d->directions) {
        return BTF_ERROR_MEMORY;
    }
    copy_directions(d->data->n_views, d->data->views, d->directions);
    copy_directions(d->data->n_lights, d->data->lights, d->directions + n_views);
    *out = (original_data){.width = d->data->width,
                           .height = d->data->height,
                           .n_views = d->data->n_views,
                           .n_lights = d->data->n_lights,
                           .views = d->directions,
                           .lights = d->directions + n_views,
                           .samples = d->data->samples,
                           .owner = d,
                           .release = release};
    return BTF_OK;
}

btf_result data_set_read(const char *input, int threads, void *p, const btf_log *log,
                         original_data *out_data) {
    const enc_context context = {.log = log ? *log : (btf_log){0}, .progress = p, .threads = threads};
    data_set *d = calloc(1, sizeof *d);
    *out_data = (original_data){0};
    const btf_result result = d ? fill(d, &context, input, out_data) : BTF_ERROR_MEMORY;
    if (result && d) {
        release(d);
    }
    return result;
}
