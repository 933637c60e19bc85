/* OpenBTF: the errors that a file's tables tell of a scene. See table.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "table.h"
#include "decoder/material.h"
#include "decoder/reach.h"

#include <math.h>
#include <string.h>

#define DEGREE (3.14159265358979323846 / 180)

enum { HEAD = 5 }; /* numbers of a row before its errors */

const btfi_row_kind btfi_share_kinds[BTFI_SHARES] = {BTFI_ROW_SAMPLES, BTFI_ROW_AT_VIEW, BTFI_ROW_AT_LIGHT,
                                                     BTFI_ROW_BETWEEN};

void btfi_band_weights(const btf_range *range, uint32_t count, const float *limits,
                       double weight[BTF_MAX_BANDS]) {
    const bool all = range->theta[0] == 0 && range->theta[1] == 0;
    double low = all ? 0 : range->theta[0], high = all ? 90 : range->theta[1], sum = 0;
    if (range->fixed) {
        low = high = acos(fmin(range->direction[2], 1)) / DEGREE;
    }
    /* Nothing is measured beyond the outermost ring, so the outermost band counts there, too, but with no more than its
     * own solid angle. */
    low = fmin(low, limits[count]);
    high = fmax(fmin(high, limits[count]), low);
    for (uint32_t b = 0; b < count; b++) {
        const double from = fmax(low, b == 0 ? 0 : limits[b]), to = fmin(high, limits[b + 1]);
        weight[b] = to > from ? cos(from * DEGREE) - cos(to * DEGREE) : 0;
        sum += weight[b];
    }
    for (uint32_t b = 0; b < count; b++) {
        const bool here = (b == 0 || low >= limits[b]) && (low < limits[b + 1] || b + 1 == count);
        weight[b] = sum > 0 ? weight[b] / sum : here;
    }
}

static const float *row_at(const btfi_rows *rows, uint32_t index) {
    return rows->table.rows + (size_t)index * rows->table.row_stride;
}

/* The slot of all kinds of rows of one way to decode: multiplicative hashing (Knuth, The Art of Computer Programming 3,
 * 6.4), by a prime near 2^32 over the golden ratio; the top 10 bits number the 1024 slots. */
static uint32_t slot_of(uint32_t level, uint32_t effects, uint32_t components) {
    return ((level * 128 + effects) * 509 + components) * 2654435761u >> 22;
}

static const float *find_in_slot(const btfi_rows *rows, uint32_t slot, uint32_t level, uint32_t effects,
                                 uint32_t components, btfi_row_kind kind) {
    for (uint32_t i = rows->first[slot]; i > 0; i = rows->next[i - 1]) {
        const float *row = row_at(rows, i - 1);
        if (row[0] == (float)effects && row[1] == (float)components && row[2] == (float)kind &&
            row[3] == (float)level) {
            return row;
        }
    }
    return NULL;
}

const float *btfi_find_row(const btfi_rows *rows, uint32_t level, uint32_t effects, uint32_t components,
                           btfi_row_kind kind) {
    return find_in_slot(rows, slot_of(level, effects, components), level, effects, components, kind);
}

const float *btfi_row_of_kind(const btfi_rows *rows, const float *row, btfi_row_kind kind) {
    const float *found = btfi_find_row(rows, btfi_level_of(row), (uint32_t)row[0], (uint32_t)row[1], kind);
    return found ? found : row;
}

static void enter_rows(btfi_rows *rows) {
    memset(rows->first, 0, sizeof rows->first);
    for (uint32_t r = 0; r < rows->table.row_count; r++) {
        const float *row = row_at(rows, r);
        const uint32_t level = btfi_level_of(row), effects = (uint32_t)row[0],
                       components = (uint32_t)row[1], slot = slot_of(level, effects, components);
        if (!find_in_slot(rows, slot, level, effects, components, btfi_kind_of(row))) {
            rows->next[r] = rows->first[slot];
            rows->first[slot] = (uint16_t)(r + 1);
        }
    }
}

void btfi_find_shares(const btfi_error_table *t, double share[BTFI_SHARES]) {
    share[0] = t->at_view * t->at_light;
    share[1] = t->at_view * (1 - t->at_light);
    share[2] = (1 - t->at_view) * t->at_light;
    share[3] = (1 - t->at_view) * (1 - t->at_light);
}

void btfi_add_errors(const btfi_error_table *t, const float *row, double mse[2]) {
    const float *cell = row + HEAD;
    for (uint32_t v = 0; v < t->errors.table.view_bands; v++) {
        for (uint32_t l = 0; l < t->errors.table.light_bands; l++, cell += 2) {
            for (int i = 0; i < 2; i++) {
                mse[i] += t->view[v] * t->light[l] * (double)cell[i];
            }
        }
    }
}

/* Between samples the errors of up to nine samples average out, so that they are less than at the samples. The error is
 * the geometric mean of those measured for both, weighted by how near view and light are to being samples. */
btfi_way btfi_read_way(const btfi_error_table *t, const float *row) {
    const bool nearest = btfi_kind_of(row) == BTFI_ROW_NEAREST;
    btfi_way way = {.effects = (uint32_t)row[0],
                    .components = (uint32_t)row[1],
                    .interpolation = nearest ? BTF_INTERPOLATION_NEAREST : BTF_INTERPOLATION_LINEAR};
    btfi_add_errors(t, row, way.mse);
    if (t->at_view == 0 && t->at_light == 0) {
        return way;
    }
    double share[BTFI_SHARES], mse[BTFI_SHARES][2] = {{0}};
    btfi_find_shares(t, share);
    /* Nearest directions have no rows of their own where one is a sample: between the samples errors are no less. */
    for (int k = 0; k < BTFI_SHARES; k++) {
        const bool own = k + 1 == BTFI_SHARES || (k > 0 && nearest);
        btfi_add_errors(t, own ? row : btfi_row_of_kind(&t->errors, row, btfi_share_kinds[k]), mse[k]);
    }
    for (int i = 0; i < 2; i++) {
        double sum = 0;
        for (int k = 0; k < BTFI_SHARES; k++) {
            sum += share[k] * log(fmax(mse[k][i], 1e-12));
        }
        way.mse[i] = exp(sum);
    }
    return way;
}

/* The sum of squared weights: 1 at a sample, 1/2 on the average over a triangle. */
static double concentration(const btfi_directions *d, const btf_range *range) {
    double sum = 0;
    if (!range->fixed) {
        return 0.5;
    }
    const btfi_neighbours n = btfi_neighbours_of(d, range->direction, false);
    for (uint32_t i = 0; i < n.count; i++) {
        sum += (double)n.weight[i] * n.weight[i] * 0x1p-24;
    }
    return sum;
}

static bool same_limits(uint32_t bands, const float *a, uint32_t other_bands, const float *b) {
    return bands == other_bands && memcmp(a, b, (bands + 1) * sizeof *a) == 0;
}

/* Whether both tables have the same bands: a file may hold two that have not. */
static bool same_bands(const btf_effect_errors *a, const btf_effect_errors *b) {
    return same_limits(a->view_bands, a->view_limits, b->view_bands, b->view_limits) &&
           same_limits(a->light_bands, a->light_limits, b->light_bands, b->light_limits);
}

void btfi_error_table_open(const btf_material *material, const btf_scene *scene, btfi_error_table *out) {
    btf_effect_errors *rows = &out->errors.table, *differences = &out->differences.table;
    *rows = btf_material_effect_errors(material);
    *differences = btf_material_effect_differences(material);
    out->at_view = out->at_light = 0;
    if (rows->row_count == 0 || (differences->row_count > 0 && !same_bands(rows, differences))) {
        differences->row_count = 0;
    }
    enter_rows(&out->errors);
    enter_rows(&out->differences);
    if (rows->row_count == 0) {
        return;
    }
    btfi_band_weights(&scene->view, rows->view_bands, rows->view_limits, out->view);
    btfi_band_weights(&scene->light, rows->light_bands, rows->light_limits, out->light);
    out->at_view = fmin(fmax(1 + log2(concentration(&material->views, &scene->view)), 0), 1);
    out->at_light = fmin(fmax(1 + log2(concentration(&material->lights, &scene->light)), 0), 1);
}
