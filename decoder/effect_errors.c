/* OpenBTF: the measured errors of each way to decode (FORMAT.md section 7, openbtf.effectErrors).
 *
 * SPDX-License-Identifier: MIT
 */
#include "effect_errors.h"
#include <math.h>
#include <stdbool.h>

enum { ROW_HEAD = 5, MAX_ROWS = 4096 };

static bool is_integer(float value, uint32_t low, uint32_t high) {
    return value >= (float)low && value <= (float)high && value == floorf(value);
}

static btf_result check_limits(const btfi_check *check, const char *name, const float *limits,
                               size_t bands) {
    for (size_t i = 0; i <= bands; i++)
        if (!(limits[i] >= 0 && limits[i] <= 90) || (i > 0 && !(limits[i] > limits[i - 1])))
            return btfi_fail(check->log, check->code,
                             "effect errors: limit %zu of the %s bands is %g, not ascending within 0 to 90",
                             i, name, (double)limits[i]);
    return BTF_OK;
}

static btf_result check_row(const btfi_check *check, const btf_material_info *info, const float *row,
                            size_t index, size_t length) {
    if (!is_integer(row[0], 0, BTF_EFFECT_ALL) || ((uint32_t)row[0] & ~info->effects) != 0)
        return btfi_fail(check->log, check->code, "effect errors: row %zu has effects %g", index,
                         (double)row[0]);
    const bool residual = ((uint32_t)row[0] & BTF_EFFECT_RESIDUAL) != 0;
    if (!is_integer(row[1], residual ? 1 : 0, residual ? info->components : 0))
        return btfi_fail(check->log, check->code, "effect errors: row %zu has %g components", index,
                         (double)row[1]);
    if (!is_integer(row[2], 0, 4) || !is_integer(row[3], 0, info->levels - 1) ||
        !(row[4] >= 0 && row[4] <= 0x1p62f))
        return btfi_fail(check->log, check->code, "effect errors: row %zu begins (%g, %g, %g, %g, %g)",
                         index, (double)row[0], (double)row[1], (double)row[2], (double)row[3],
                         (double)row[4]);
    for (size_t i = ROW_HEAD; i < length; i++)
        if (!(row[i] >= 0 && row[i] <= 1))
            return btfi_fail(check->log, check->code,
                             "effect errors: row %zu, number %zu is %g, not within 0 to 1", index, i,
                             (double)row[i]);
    return BTF_OK;
}

btf_result btfi_check_effect_errors(const btfi_check *check, const btf_material_info *info,
                                    const float *values, size_t count) {
    if (count == 0)
        return BTF_OK;
    if (count < 6 || !is_integer(values[0], 1, BTF_MAX_BANDS) || !is_integer(values[1], 1, BTF_MAX_BANDS))
        return btfi_fail(check->log, check->code, "effect errors: %zu numbers that begin with %g bands",
                         count, (double)values[0]);
    const size_t views = (size_t)values[0], lights = (size_t)values[1], head = 4 + views + lights;
    const size_t length = ROW_HEAD + 2 * views * lights;
    if (count < head || (count - head) % length != 0 || (count - head) / length > MAX_ROWS)
        return btfi_fail(check->log, check->code,
                         "effect errors: %zu numbers are not %zu and up to %d rows of %zu", count, head,
                         MAX_ROWS, length);
    btf_result result;
    if ((result = check_limits(check, "view", values + 2, views)) ||
        (result = check_limits(check, "light", values + 3 + views, lights)))
        return result;
    for (size_t i = 0; i < (count - head) / length; i++)
        if ((result = check_row(check, info, values + head + i * length, i, length)))
            return result;
    return BTF_OK;
}

btf_effect_errors btfi_effect_errors_of(const float *values, size_t count) {
    btf_effect_errors table = {0};
    if (!values)
        return table;
    table.view_bands = (uint32_t)values[0];
    table.light_bands = (uint32_t)values[1];
    table.view_limits = values + 2;
    table.light_limits = table.view_limits + table.view_bands + 1;
    table.rows = table.light_limits + table.light_bands + 1;
    table.row_stride = ROW_HEAD + 2 * table.view_bands * table.light_bands;
    table.row_count = (uint32_t)((count - (size_t)(table.rows - values)) / table.row_stride);
    return table;
}
