/* OpenBTF: tables of measured errors by bands of view and light (FORMAT.md section 7): of each way to
 * decode (openbtf.effectErrors, openbtf.effectDifferences), and between the samples (openbtf.betweenErrors,
 * openbtf.levelBetweenErrors).
 *
 * SPDX-License-Identifier: MIT
 */
#include "effect_errors.h"
#include "decoder/shape.h"

#include <math.h>
#include <stdbool.h>

enum { ROW_HEAD = 5 };

static bool is_integer(float value, uint32_t low, uint32_t high) {
    return value >= (float)low && value <= (float)high && value == floorf(value);
}

/* The differences between the tables. */
typedef struct table_kind table_kind;
struct table_kind {
    const char *name; /* in messages */
    size_t most;      /* rows */
    /* Of errors between the samples: the levels that it may have rows of. */
    uint32_t first_level, end_level;
    btf_result (*check_row)(const btfi_check *check, const table_kind *kind, const btf_material_info *info,
                            const float *row, size_t index, size_t length);
};

static btf_result check_limits(const btfi_check *check, const char *table, const char *name,
                               const float *limits, size_t bands) {
    for (size_t i = 0; i <= bands; i++) {
        if (!(limits[i] >= 0 && limits[i] <= 90) || (i > 0 && !(limits[i] > limits[i - 1]))) {
            return btfi_fail(check->log, check->code,
                             "%s: limit %zu of the %s bands is %g; limits must rise within 0 to 90 degrees",
                             table, i, name, (double)limits[i]);
        }
    }
    return BTF_OK;
}

static btf_result check_effect_row(const btfi_check *check, const table_kind *kind,
                                   const btf_material_info *info, const float *row, size_t index,
                                   size_t length) {
    if (!is_integer(row[0], 0, BTF_EFFECT_ALL) || ((uint32_t)row[0] & ~info->effects) != 0) {
        return btfi_fail(check->log, check->code,
                         "%s: row %zu decodes the effects %g, which the material does not have", kind->name,
                         index, (double)row[0]);
    }
    const bool residual = ((uint32_t)row[0] & BTF_EFFECT_RESIDUAL) != 0;
    if (!is_integer(row[1], residual ? 1 : 0, residual ? info->components : 0)) {
        return btfi_fail(check->log, check->code, "%s: row %zu has %g components", kind->name, index,
                         (double)row[1]);
    }
    if (!is_integer(row[2], 0, 4) || !is_integer(row[3], 0, info->levels - 1) ||
        !(row[4] >= 0 && row[4] <= 0x1p62f)) {
        return btfi_fail(check->log, check->code,
                         "%s: row %zu begins (effects, components, directions, level, bytes) "
                         "with (%g, %g, %g, %g, %g), of which a number is out of range",
                         kind->name, index, (double)row[0], (double)row[1], (double)row[2], (double)row[3],
                         (double)row[4]);
    }
    for (size_t i = ROW_HEAD; i < length; i++) {
        if (!(row[i] >= 0 && row[i] <= 1)) {
            return btfi_fail(check->log, check->code, "%s: row %zu, number %zu is %g, not within 0 to 1",
                             kind->name, index, i, (double)row[i]);
        }
    }
    return BTF_OK;
}

enum { ROWS_OF_LEVEL = 7 }; /* of errors between the samples */

static bool may_leave_out(const btf_material_info *info, uint32_t what) {
    switch (what) {
    case 1:
    case 2:
    case 3:
        return true;
    case 5:
    case 7:
        return info->effects & BTF_EFFECT_RELIEF;
    case 9:
    case 11:
        return info->effects & BTF_EFFECT_GLOSS;
    default:
        return false;
    }
}

static btf_result check_between_row(const btfi_check *check, const table_kind *kind,
                                    const btf_material_info *info, const float *row, size_t index,
                                    size_t length) {
    if (!is_integer(row[0], BTF_BETWEEN_NEXT_LEVEL * kind->first_level,
                    BTF_BETWEEN_NEXT_LEVEL * kind->end_level - 1) ||
        !may_leave_out(info, (uint32_t)row[0] % BTF_BETWEEN_NEXT_LEVEL)) {
        return btfi_fail(check->log, check->code,
                         "%s: row %zu says that %g is left out; it must say 1 (view), 2 "
                         "(light) or 3 (both), and with the effect relief also 5 or 7, with gloss 9 or 11, "
                         "plus 16 times a level of detail, from %u to %u here",
                         kind->name, index, (double)row[0], (unsigned)kind->first_level,
                         (unsigned)kind->end_level - 1);
    }
    for (size_t i = 1; i < length; i++) {
        if (!(row[i] >= 0 && row[i] <= 1) && !(row[i] == -1 && i >= ROW_HEAD)) {
            return btfi_fail(check->log, check->code, "%s: row %zu, number %zu is %g, not within 0 to 1",
                             kind->name, index, i, (double)row[i]);
        }
    }
    return BTF_OK;
}

static btf_result check_table(const btfi_check *check, const table_kind *kind,
                              const btf_material_info *info, const float *values, size_t count) {
    if (count == 0) {
        return BTF_OK;
    }
    if (count < 6 || !is_integer(values[0], 1, BTF_MAX_BANDS) || !is_integer(values[1], 1, BTF_MAX_BANDS)) {
        return btfi_fail(check->log, check->code,
                         "%s: of %zu numbers the first two must be the counts of view and light bands, but "
                         "the first is %g",
                         kind->name, count, (double)values[0]);
    }
    const size_t views = (size_t)values[0], lights = (size_t)values[1], head = 4 + views + lights;
    const size_t length = ROW_HEAD + 2 * views * lights;
    if (count < head || (count - head) % length != 0 || (count - head) / length > kind->most) {
        return btfi_fail(check->log, check->code,
                         "%s: %zu numbers do not make a head of %zu and at most %zu rows of %zu",
                         kind->name, count, head, kind->most, length);
    }
    btf_result result;
    if ((result = check_limits(check, kind->name, "view", values + 2, views)) ||
        (result = check_limits(check, kind->name, "light", values + 3 + views, lights))) {
        return result;
    }
    for (size_t i = 0; i < (count - head) / length; i++) {
        if ((result = kind->check_row(check, kind, info, values + head + i * length, i, length))) {
            return result;
        }
    }
    return BTF_OK;
}

btf_result btfi_check_effect_errors(const btfi_check *check, const btf_material_info *info,
                                    const float *values, size_t count) {
    static const table_kind kind = {"effect errors", BTFI_MOST_EFFECT_ROWS, 0, 0, check_effect_row};
    return check_table(check, &kind, info, values, count);
}

btf_result btfi_check_effect_differences(const btfi_check *check, const btf_material_info *info,
                                         const float *values, size_t count) {
    static const table_kind kind = {"effect differences", BTFI_MOST_EFFECT_ROWS, 0, 0, check_effect_row};
    return check_table(check, &kind, info, values, count);
}

btf_result btfi_check_between_errors(const btfi_check *check, const btf_material_info *info,
                                     btfi_between_table where, const float *values, size_t count) {
    const bool coarser = where == BTFI_BETWEEN_OF_COARSER_LEVELS;
    const uint32_t levels = btfi_version(info) < 2 ? 1 : info->levels;
    const uint32_t first = coarser ? 1 : 0, end = where == BTFI_BETWEEN_OF_LEVEL_0 ? 1 : levels;
    if (count && end <= first) {
        return btfi_fail(check->log, check->code,
                         "level between errors: there are %zu numbers, but no coarser level", count);
    }
    const table_kind kind = {coarser ? "level between errors" : "between errors",
                             ROWS_OF_LEVEL * (size_t)(end - first), first, end, check_between_row};
    return check_table(check, &kind, info, values, count);
}

size_t btfi_table_head(const float *values) {
    return 4 + (size_t)values[0] + (size_t)values[1];
}

btf_between_errors btfi_between_errors_of(const float *values, size_t count) {
    const btf_effect_errors table = btfi_effect_errors_of(values, count);
    return (btf_between_errors){.view_bands = table.view_bands,
                                .light_bands = table.light_bands,
                                .view_limits = table.view_limits,
                                .light_limits = table.light_limits,
                                .row_count = table.row_count,
                                .row_stride = table.row_stride,
                                .rows = table.rows};
}

btf_effect_errors btfi_effect_errors_of(const float *values, size_t count) {
    btf_effect_errors table = {0};
    if (!values) {
        return table;
    }
    table.view_bands = (uint32_t)values[0];
    table.light_bands = (uint32_t)values[1];
    table.view_limits = values + 2;
    table.light_limits = table.view_limits + table.view_bands + 1;
    table.rows = table.light_limits + table.light_bands + 1;
    table.row_stride = ROW_HEAD + 2 * table.view_bands * table.light_bands;
    table.row_count = (uint32_t)((count - (size_t)(table.rows - values)) / table.row_stride);
    return table;
}
