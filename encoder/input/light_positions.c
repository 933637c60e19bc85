/* Tables of where lights stood. See light_positions.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "light_positions.h"

#include "encoder/data/coincident.h"
#include "grid.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int find_view(const enc_data *data, double theta, double phi) {
    for (int v = 0; v < data->n_views; v++)
        if (enc_same_direction(&data->views[v], theta, phi))
            return v;
    return -1;
}

/* The four angles of a line, after a number or not. */
static bool parse_line(const char *line, double angles[4]) {
    double v[5];
    int n = 0;
    for (char *end; *(line += strspn(line, " \t")); line = end) {
        double number = strtod(line, &end);
        if (n == 5 || end == line || !(*end == 0 || *end == ' ' || *end == '\t'))
            return false;
        v[n++] = number;
    }
    if (n != 4 && n != 5)
        return false;
    memcpy(angles, v + (n - 4), 4 * sizeof *angles);
    return isfinite(angles[0]) && isfinite(angles[1]) && isfinite(angles[2]) && isfinite(angles[3]);
}

static btf_result take_line(const enc_context *context, const char *path, int number, const char *line,
                            const enc_read_options *options, enc_data *data) {
    double a[4];
    if (!parse_line(line, a))
        return enc_fail(context, BTF_ERROR_BAD_FILE,
                        "%s: line %d: expected theta, phi, and theta and phi of the light: %.60s", path,
                        number, line);
    if (!(a[2] >= 0.0 && a[2] < 90.0))
        return enc_fail(context, BTF_ERROR_BAD_FILE,
                        "%s: line %d: theta %g of the light is not at least 0 and below 90", path, number,
                        a[2]);
    const int view = find_view(data, a[0], enc_grid_azimuth(options, a[0], a[1]));
    const int light = view >= 0 ? enc_coincident_light(data, view) : -1;
    if (light < 0)
        return enc_fail(context, BTF_ERROR_BAD_FILE, "%s: line %d: (%g,%g) is no view and light of %s",
                        path, number, a[0], a[1], data->source ? data->source : "the data");
    if (data->moved_light[view].index >= 0)
        return enc_fail(context, BTF_ERROR_BAD_FILE, "%s: line %d: (%g,%g) a second time", path, number,
                        a[0], a[1]);
    data->moved_light[view] =
        (enc_moved_light){light, enc_direction_from_angles(a[2], enc_grid_azimuth(options, a[2], a[3]))};
    return BTF_OK;
}

btf_result enc_coincident_read(const enc_context *context, const char *path,
                               const enc_read_options *options, enc_data *data) {
    char line[4096];
    btf_result result = BTF_OK;
    FILE *file = fopen(path, "r");
    if (!file)
        return enc_fail(context, BTF_ERROR_IO, "%s: %s", path, strerror(errno));
    data->moved_light = malloc((size_t)data->n_views * sizeof *data->moved_light);
    if (!data->moved_light)
        result = BTF_ERROR_MEMORY;
    for (int v = 0; v < data->n_views && data->moved_light; v++)
        data->moved_light[v].index = -1;
    for (int number = 1; result == BTF_OK && fgets(line, sizeof line, file); number++) {
        if (strlen(line) + 1 == sizeof line && line[sizeof line - 2] != '\n')
            result = enc_fail(context, BTF_ERROR_BAD_FILE, "%s: line %d is longer than %zu bytes", path,
                              number, sizeof line - 2);
        line[strcspn(line, "#\r\n")] = '\0';
        if (result == BTF_OK && line[strspn(line, " \t")] != '\0')
            result = take_line(context, path, number, line, options, data);
    }
    if (result == BTF_OK && ferror(file))
        result = enc_fail(context, BTF_ERROR_IO, "%s: %s", path, strerror(errno));
    fclose(file);
    return result;
}
