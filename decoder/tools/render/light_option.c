/* Options that give a light as text.
 *
 * SPDX-License-Identifier: MIT
 */
#include "light_option.h"

#include "decoder/toolkit/cli.h"
#include "lights.h"

#include <math.h>

/* Reads comma-separated numbers of magnitude at most 1e6; returns how many, 0 when the text is anything else. */
static int read_numbers(const char *text, double *numbers, int most) {
    const int count = cli_parse_doubles(text, numbers, most);
    for (int i = 0; i < count; i++) {
        if (fabs(numbers[i]) > 1e6) {
            return 0;
        }
    }
    return count;
}

/* Reads intensity and colour behind the first `n` numbers; false when their count is wrong or one is negative. */
static bool read_colour(const double *numbers, int count, int n, double colour[3]) {
    double intensity = count > n ? numbers[n] : 1;
    if (count != n && count != n + 1 && count != n + 4) {
        return false;
    }
    for (int c = 0; c < 3; c++) {
        colour[c] = intensity * (count == n + 4 ? numbers[n + 1 + c] : 1);
        if (!(colour[c] >= 0)) {
            return false;
        }
    }
    return true;
}

const char *light_parse_directional(const char *text, void *value) {
    static const char expected[] =
        "theta,phi[,intensity[,r,g,b]]: degrees (theta 0..180), numbers that are not negative";
    double n[6];
    int count = read_numbers(text, n, 6);
    light l = {0};
    if (count < 2 || !(n[0] >= 0 && n[0] <= 180) || !read_colour(n, count, 2, l.colour)) {
        return expected;
    }
    l.at = vec_from_angles(n[0], n[1]);
    return light_list_add(value, l) ? NULL : "at most 4096 lights";
}

const char *light_parse_point(const char *text, void *value) {
    static const char expected[] = "x,y,z[,intensity[,r,g,b]]: numbers, those of the colour not negative";
    double n[7];
    int count = read_numbers(text, n, 7);
    light l = {.is_point = true};
    if (count < 3 || !read_colour(n, count, 3, l.colour)) {
        return expected;
    }
    l.at = vec(n[0], n[1], n[2]);
    return light_list_add(value, l) ? NULL : "at most 4096 lights";
}
