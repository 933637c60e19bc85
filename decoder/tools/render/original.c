/* The uncompressed BTF as something to render with.
 *
 * SPDX-License-Identifier: MIT
 */
#include "original.h"

#include "decoder/toolkit/reference_view.h"
#include "decoder/toolkit/file.h"
#include "table.h"
#include <stdlib.h>

struct original {
    original_data data;
    btf_ref_material material; /* for its direction tables */
    int threads;
};

static btf_result same_directions(const char *what, const btf_directions *expected, int count,
                                  const original_direction *got, const btf_log *log) {
    if ((uint32_t)count != expected->count) {
        file_say(log, "option --original: the images have %d %ss, but the material has %u", count, what,
                 (unsigned)expected->count);
        return BTF_ERROR_USAGE;
    }
    for (int i = 0; i < count; i++) {
        for (int k = 0; k < 3; k++) {
            if (fabs((double)got[i].xyz[k] - (double)expected->xyz[3 * i + k]) > 1e-3) {
                file_say(
                    log,
                    "option --original: the images' %s %d at theta %g, phi %g differs from the material's",
                    what, i, got[i].theta, got[i].phi);
                return BTF_ERROR_USAGE;
            }
        }
    }
    return BTF_OK;
}

static btf_result check(const original *o, const btf_material *material, const btf_log *log) {
    const btf_directions views = btf_material_views(material), lights = btf_material_lights(material);
    if ((uint32_t)o->data.width != o->material.width || (uint32_t)o->data.height != o->material.height) {
        file_say(log,
                 "option --original: the images have %d x %d pixels, but the material has %u x %u texels",
                 o->data.width, o->data.height, (unsigned)o->material.width, (unsigned)o->material.height);
        return BTF_ERROR_USAGE;
    }
    btf_result result = same_directions("view", &views, o->data.n_views, o->data.views, log);
    return result ? result : same_directions("light", &lights, o->data.n_lights, o->data.lights, log);
}

btf_result original_open(original_reader *read, const char *input, const btf_material *material,
                         int threads, void *p, const btf_log *log, original **out_original) {
    original *o = calloc(1, sizeof *o);
    *out_original = NULL;
    if (!o) {
        file_say(log, "out of memory for the images of --original");
        return BTF_ERROR_MEMORY;
    }
    o->threads = threads;
    reference_view(material, 0, &o->material);
    btf_result result = read(input, threads, p, log, &o->data);
    if (!result) {
        result = check(o, material, log);
    }
    if (result) {
        original_close(&o);
        return result;
    }
    *out_original = o;
    return BTF_OK;
}

void original_close(original **o) {
    if (!o || !*o) {
        return;
    }
    if ((*o)->data.release) {
        (*o)->data.release((*o)->data.owner);
    }
    free(*o);
    *o = NULL;
}

const float *original_samples(const original *o) {
    return o->data.samples;
}

static btf_ref_neighbours neighbours(const uint16_t *table, uint32_t grid, const float *direction) {
    int32_t q[2];
    btf_ref_project(direction, q);
    return btf_ref_lookup(table, grid, q);
}

static void evaluate(const original *o, const float *in, float *out) {
    const float *view = in + 2, *light = in + 5;
    const size_t lights = (size_t)o->data.n_lights;
    out[0] = out[1] = out[2] = 0;
    if (!(view[2] >= 0x1p-24f && light[2] >= 0x1p-24f)) {
        return;
    }
    btf_ref_neighbours v = neighbours(o->material.view_table, o->material.view_grid, view);
    btf_ref_neighbours l = neighbours(o->material.light_table, o->material.light_grid, light);
    const uint32_t column = btf_ref_coordinate(in[0], o->material.width) >> 18;
    const uint32_t row = o->material.height - 1 - (btf_ref_coordinate(in[1], o->material.height) >> 18);
    const float *texel = o->data.samples + ((size_t)row * o->material.width + column) *
                                               ((size_t)o->data.n_views * 3 * lights);
    for (int a = 0; a < 3; a++) {
        for (int c = 0; c < 3; c++) {
            const float *profile = texel + (3 * (size_t)v.index[a] + (size_t)c) * lights;
            float sum = 0;
            for (int b = 0; b < 3; b++) {
                sum += profile[l.index[b]] * (float)l.weight[b];
            }
            out[c] += sum * (float)v.weight[a] * 0x1p-24f;
        }
    }
}

static btf_result run(void *user, int variant, int width, int rows, const float *inputs, float *out,
                      const btf_log *log) {
    const original *o = user;
    const int count = width * rows;
    (void)variant;
    (void)log;
#pragma omp parallel for schedule(dynamic, 256) num_threads(o->threads)
    for (int i = 0; i < count; i++) {
        evaluate(o, inputs + TABLE_INPUTS * (size_t)i, out + 3 * (size_t)i);
    }
    return BTF_OK;
}

evaluator original_evaluator(original *o) {
    return (evaluator){run, o, 0};
}
