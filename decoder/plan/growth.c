/* OpenBTF: how much the error grows where a scene looks. See growth.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "growth.h"

#include <math.h>

/* How much the error against the data grows, at directions of a kind, by decoding as `row` says. */
static void growth_of_data(const btfi_error_table *t, const float *row, const float *full,
                           btfi_row_kind kind, double growth[2]) {
    double with[2] = {0, 0}, less[2] = {0, 0};
    /* Nearest directions have no rows of their own where one direction is a sample, as in btfi_read_way. */
    const bool own =
        kind == BTFI_ROW_BETWEEN || (kind != BTFI_ROW_SAMPLES && btfi_kind_of(row) == BTFI_ROW_NEAREST);
    btfi_add_errors(t, kind == BTFI_ROW_BETWEEN ? full : btfi_row_of_kind(&t->errors, full, kind), with);
    btfi_add_errors(t, own ? row : btfi_row_of_kind(&t->errors, row, kind), less);
    for (int i = 0; i < 2; i++) {
        growth[i] = fmax(less[i] - with[i], 0);
    }
}

/* The mean squared difference to the full decode at directions of a kind; false where the file does not say. */
static bool find_difference(const btfi_error_table *t, const float *row, btfi_row_kind kind,
                            double out[2]) {
    const bool nearest = btfi_kind_of(row) == BTFI_ROW_NEAREST;
    const float *found = btfi_find_row(&t->differences, btfi_level_of(row), (uint32_t)row[0],
                                       (uint32_t)row[1], nearest ? BTFI_ROW_NEAREST : kind);
    if (!found) {
        return false;
    }
    out[0] = out[1] = 0;
    btfi_add_errors(t, found, out);
    return true;
}

void btfi_find_growth(const btfi_error_table *t, const float *row, const float *full, btfi_way *way) {
    double share[BTFI_SHARES], at_samples[2], sum[2] = {0, 0};
    btfi_find_shares(t, share);
    growth_of_data(t, row, full, BTFI_ROW_SAMPLES, at_samples);
    for (int k = 0; k < BTFI_SHARES; k++) {
        const btfi_row_kind kind = btfi_share_kinds[k];
        double growth[2], difference[2];
        growth_of_data(t, row, full, kind, growth);
        const bool known = kind != BTFI_ROW_SAMPLES && find_difference(t, row, kind, difference);
        for (int i = 0; i < 2; i++) {
            const double between = known ? difference[i] : fmax(growth[i], (growth[i] + at_samples[i]) / 2);
            sum[i] += share[k] * log(fmax(kind == BTFI_ROW_SAMPLES ? at_samples[i] : between, 1e-12));
        }
    }
    for (int i = 0; i < 2; i++) {
        way->growth[i] = sum[i] > log(1.1e-12) ? exp(sum[i]) : 0;
    }
}

/* The error of a scene in a level by a row of the table of errors between the samples; false where it says nothing. */
static bool find_row_between(const btf_material *material, const btf_scene *scene, uint32_t level,
                             uint32_t left_out, double mse[2]) {
    const btf_between_errors b = btf_material_between_errors(material);
    double view[BTF_MAX_BANDS], light[BTF_MAX_BANDS], sum[2] = {0, 0}, weight = 0;
    uint32_t r = 0;
    while (r < b.row_count &&
           b.rows[(size_t)r * b.row_stride] != (float)(left_out + BTF_BETWEEN_NEXT_LEVEL * level)) {
        r++;
    }
    if (r == b.row_count) {
        return false;
    }
    btfi_band_weights(&scene->view, b.view_bands, b.view_limits, view);
    btfi_band_weights(&scene->light, b.light_bands, b.light_limits, light);
    const float *cell = b.rows + (size_t)r * b.row_stride + 5;
    for (uint32_t v = 0; v < b.view_bands; v++) {
        for (uint32_t l = 0; l < b.light_bands; l++, cell += 2) {
            if (cell[0] >= 0) {
                weight += view[v] * light[l];
                for (int i = 0; i < 2; i++) {
                    sum[i] += view[v] * light[l] * (double)cell[i];
                }
            }
        }
    }
    for (int i = 0; i < 2 && weight > 0; i++) {
        mse[i] = sum[i] / weight;
    }
    return weight > 0;
}

/* The first number of a row of btf_between_errors as bits: samples that are left out, and effects that are not
 * decoded. */
enum { VIEW = 1, LIGHT = 2, BOTH = 3, NO_RELIEF = 4, NO_GLOSS = 8 };

bool btfi_find_between(const btf_material *material, const btf_scene *scene, const btfi_error_table *t,
                       uint32_t level, double mse[2]) {
    return find_row_between(material, scene, level,
                            (t->at_view < 1 ? VIEW : 0u) + (t->at_light < 1 ? LIGHT : 0u), mse);
}

bool btfi_find_without(const btf_material *material, const btf_scene *scene, const btfi_error_table *t,
                       uint32_t level, btf_effect effect, double growth[2]) {
    /* Where the light is a sample, gloss only blurs it by others: what it is worth shows where both are left out. */
    const bool gloss = effect == BTF_EFFECT_GLOSS;
    const uint32_t left = gloss || t->at_light < 1 ? BOTH : VIEW;
    double with[2], without[2];
    if (!find_row_between(material, scene, level, left, with) ||
        !find_row_between(material, scene, level, left + (gloss ? NO_GLOSS : NO_RELIEF), without)) {
        return false;
    }
    for (int i = 0; i < 2; i++) {
        growth[i] = fmax(without[i] / fmax(with[i], 1e-10) - 1, 0) / 2;
    }
    return true;
}

bool btfi_errors_to_tolerate(const btf_material *material, const btf_scene *scene,
                             const btfi_error_table *t, uint32_t level, const btfi_way *full,
                             double base[2]) {
    double between[2] = {0, 0};
    const bool known = btfi_find_between(material, scene, t, level, between);
    for (int i = 0; i < 2; i++) {
        base[i] = fmax(fmax(between[i] / 2, full->mse[i]), 1e-10);
    }
    return known;
}
