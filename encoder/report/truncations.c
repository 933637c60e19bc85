/* Truncations of a residual. See truncations.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "truncations.h"

enum { HEAD = 5, INTERPOLATED = 0, AT_SAMPLES = 2 }; /* numbers before a row's errors; kinds of a row */

typedef struct weights {
    size_t cells;
    double
        of[BTF_MAX_BANDS * BTF_MAX_BANDS]; /* share of each pair of bands in the samples; they sum to 1 */
} weights;

static weights weigh(const enc_data *data, const enc_bands *views, const enc_bands *lights) {
    weights w = {.cells = (size_t)views->count * (size_t)lights->count};
    int member[256];
    double sum = 0;
    for (size_t cell = 0; cell < w.cells; cell++) {
        const int of_views = enc_bands_members(views, (int)(cell / (size_t)lights->count), data->views,
                                               data->n_views, member);
        const int of_lights = enc_bands_members(lights, (int)(cell % (size_t)lights->count), data->lights,
                                                data->n_lights, member);
        w.of[cell] = (double)of_views * of_lights;
        sum += w.of[cell];
    }
    for (size_t cell = 0; cell < w.cells; cell++) {
        w.of[cell] /= sum;
    }
    return w;
}

static enc_error_sum mean_of(const weights *w, const float *errors) {
    enc_error_sum mean = {.count = 1};
    for (size_t cell = 0; cell < w->cells; cell++) {
        mean.linear += w->of[cell] * errors[2 * cell];
        mean.srgb += w->of[cell] * errors[2 * cell + 1];
    }
    return mean;
}

size_t enc_truncations(const float *table, size_t count, const enc_data *data, uint32_t effects,
                       enc_truncation *out) {
    const enc_bands views = enc_bands_make(data->views, data->n_views),
                    lights = enc_bands_make(data->lights, data->n_lights);
    const weights w = weigh(data, &views, &lights);
    const size_t head = 4 + (size_t)(views.count + lights.count), stride = HEAD + 2 * w.cells;
    size_t n = 0;
    if (!(effects & BTF_EFFECT_RESIDUAL)) {
        return 0;
    }
    for (const float *row = table + head; row + stride <= table + count; row += stride) {
        const bool kind = row[2] == INTERPOLATED || row[2] == AT_SAMPLES;
        if (row[0] != (float)effects || row[3] != 0 || !kind) {
            continue;
        }
        size_t i = 0;
        while (i < n && out[i].components != (uint32_t)row[1]) {
            i++;
        }
        if (i == ENC_MOST_TRUNCATIONS) {
            continue;
        }
        n = i == n ? n + 1 : n;
        out[i].components = (uint32_t)row[1];
        out[i].gpu_bytes = row[4];
        *(row[2] == AT_SAMPLES ? &out[i].samples : &out[i].between) = mean_of(&w, row + HEAD);
    }
    return n;
}
