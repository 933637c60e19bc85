/* Tables of where lights stood. See light_positions.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "light_positions.h"

#include "encoder/data/coincident.h"
#include "csv.h"
#include "named_images.h"
#include "names.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static int find_view(const enc_data *data, double theta, double phi) {
    for (int v = 0; v < data->n_views; v++) {
        if (enc_same_direction(&data->views[v], theta, phi)) {
            return v;
        }
    }
    return -1;
}

/* Cuts a line off where a comment begins. */
static void drop_comment(enc_csv *csv) {
    for (size_t i = 0; i < csv->count; i++) {
        char *comment = strchr(csv->fields[i], '#');
        if (!comment) {
            continue;
        }
        *comment = '\0';
        csv->count = csv->fields[i][0] ? i + 1 : i;
        return;
    }
}

/* Reads the four angles of a line, with or without a number before them. *out_numbers: how many fields are
 * numbers. */
static bool parse_line(const enc_csv *csv, double angles[4], size_t *out_numbers) {
    double v[5];
    *out_numbers = 0;
    for (size_t i = 0; i < csv->count; i++) {
        *out_numbers +=
            enc_names_number(csv->fields[i], enc_csv_has_decimal_commas(csv), &v[i < 5 ? i : 4]);
    }
    if ((csv->count != 4 && csv->count != 5) || *out_numbers != csv->count) {
        return false;
    }
    memcpy(angles, v + (csv->count - 4), 4 * sizeof *angles);
    return true;
}

static btf_result take_line(const enc_csv *csv, bool is_first, const enc_read_options *options,
                            enc_data *data) {
    double a[4];
    size_t numbers;
    if (!parse_line(csv, a, &numbers)) {
        if (!is_first || numbers > 0) {
            return enc_csv_fail(
                csv, "expected theta and phi of the view, then theta and phi of the light: %.60s",
                csv->fields[csv->count > 4 ? csv->count - 4 : 0]);
        }
        enc_log(
            csv->context, BTF_LOG_WARNING,
            "%s: line %zu is taken for headings, which are not looked at: the columns are theta and phi of "
            "the view, then theta and phi of the light",
            csv->path, csv->text.number);
        return BTF_OK;
    }
    if (!(a[2] >= 0.0 && a[2] < 90.0)) {
        return enc_csv_fail(csv, "theta %g of the light is not at least 0 and below 90", a[2]);
    }
    const int view = find_view(data, a[0], enc_named_azimuth(options, a[0], a[1]));
    const int light = view >= 0 ? enc_coincident_light(data, view) : -1;
    if (light < 0) {
        return enc_csv_fail(csv, "(%g,%g) is not a view of %s that has a light in the same direction", a[0],
                            a[1], data->source ? data->source : "the data");
    }
    if (data->moved_light[view].index >= 0) {
        return enc_csv_fail(csv, "the view (%g,%g) is listed a second time", a[0], a[1]);
    }
    data->moved_light[view] =
        (enc_moved_light){light, enc_direction_from_angles(a[2], enc_named_azimuth(options, a[2], a[3]))};
    return BTF_OK;
}

btf_result enc_coincident_read(const enc_context *context, const char *path,
                               const enc_read_options *options, enc_data *data) {
    enc_csv csv;
    bool more = true, is_first = true, is_empty = true;
    btf_result result = enc_csv_open(context, path, &csv);
    if (result != BTF_OK) {
        return result;
    }
    data->moved_light = malloc((size_t)data->n_views * sizeof *data->moved_light);
    if (!data->moved_light) {
        result = BTF_ERROR_MEMORY;
    }
    for (int v = 0; v < data->n_views && data->moved_light; v++) {
        data->moved_light[v].index = -1;
    }
    while (result == BTF_OK && more) {
        result = enc_csv_next(&csv, &more);
        if (result != BTF_OK || !more || csv.is_comment) {
            continue;
        }
        drop_comment(&csv);
        if (csv.count > 0) {
            result = take_line(&csv, is_first, options, data);
        }
        is_first = false;
    }
    for (int v = 0; v < data->n_views && data->moved_light; v++) {
        is_empty = is_empty && data->moved_light[v].index < 0;
    }
    if (result == BTF_OK && is_empty) {
        result = enc_fail(context, BTF_ERROR_BAD_FILE, "%s: the table holds no direction", path);
    }
    enc_csv_close(&csv);
    return result;
}
