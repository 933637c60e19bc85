/* Direction lists for samples: named sets, rings and spirals.
 *
 * SPDX-License-Identifier: MIT
 */
#include "directions.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const double PI = 3.14159265358979323846;

static const struct {
    const char *name, *rings;
} SETS[] = {
    {"ubo", "0:1,15:6,30:12,45:18,60:20,75:24"},
    {"ubo2014", "0:1,11:6:15,23.5:12,30:12:15,37.5:12,45:18,52.5:18:7.5,60:24,67.5:24:7.5,75:24"},
    {"small", "0:1,30:6,60:12"},
    {"tiny", "0:1,45:4"},
};

static double rounded(double degrees) {
    return nearbyint(degrees * 1e4) / 1e4;
}

void directions_format_angle(double degrees, char *buffer) {
    if (fabs(degrees - nearbyint(degrees)) < 5e-5) {
        snprintf(buffer, 16, "%03.0f", degrees);
    } else {
        snprintf(buffer, 16, "%08.4f", degrees);
    }
}

static int by_theta_then_phi(const void *a, const void *b) {
    const enc_direction *p = a, *q = b;
    if (p->theta != q->theta) {
        return p->theta < q->theta ? -1 : 1;
    }
    return p->phi < q->phi ? -1 : p->phi > q->phi;
}

/* Each direction stands for an equal area of the cap from the pole to 75 degrees, and is turned by the golden angle
 * from the one before (H. Vogel, Mathematical Biosciences 44, 1979, here on the sphere). */
static void make_spiral(int count, enc_direction *out) {
    const double lowest = cos(75 * PI / 180), golden = 180 * (3 - sqrt(5));
    for (int i = 0; i < count; ++i) {
        double z = count > 1 ? 1 - (1 - lowest) * i / (count - 1) : 1;
        double theta = rounded(acos(z) * 180 / PI), phi = rounded(fmod(golden * i, 360));
        out[i] = enc_direction_from_angles(theta, theta > 0 && phi < 360 ? phi : 0);
    }
}

/* Reads "THETA:COUNT[:OFFSET],..." ; returns NULL when it is right, else what is wrong with it. */
static const char *parse_rings(const char *text, enc_direction *out, int *out_count) {
    double last_theta = -1;
    int count = 0;
    for (const char *at = text;;) {
        char *end;
        double theta = rounded(strtod(at, &end)), offset = 0;
        if (end == at || *end != ':') {
            return "expected THETA:COUNT";
        }
        if (!(theta >= 0 && theta <= 85)) {
            return "theta is not in 0..85";
        }
        if (!(theta > last_theta)) {
            return "theta does not rise";
        }
        at = end + 1;
        long ring = strtol(at, &end, 10);
        if (end == at || ring < 1 || ring > DIRECTIONS_MAX - count) {
            return "a ring needs a count of at least 1, all rings 256 at most";
        }
        if (theta == 0 && ring != 1) {
            return "the ring at theta 0 has 1 direction";
        }
        if (*end == ':') {
            at = end + 1;
            offset = strtod(at, &end);
            if (end == at || !(offset >= 0 && offset < 360)) {
                return "an azimuth offset is not in 0..360";
            }
        }
        for (long i = 0; i < ring; ++i) {
            double phi = rounded(fmod(offset + 360.0 * (double)i / (double)ring, 360));
            out[count++] = enc_direction_from_angles(theta, theta > 0 && phi < 360 ? phi : 0);
        }
        last_theta = theta;
        if (*end == '\0') {
            break;
        }
        if (*end != ',') {
            return "expected a comma between rings";
        }
        at = end + 1;
    }
    *out_count = count;
    return NULL;
}

btf_result directions_parse(const enc_context *context, const char *text, enc_direction **out_directions,
                            int *out_count) {
    enc_direction *list = malloc(DIRECTIONS_MAX * sizeof *list);
    if (!list) {
        return enc_fail(context, BTF_ERROR_MEMORY, "directions: out of memory");
    }
    int count = 0;
    char *end;
    long number = strtol(text, &end, 10);
    if (end != text && *end == '\0' && number >= 1 && number <= DIRECTIONS_MAX) {
        count = (int)number;
        make_spiral(count, list);
    } else {
        const char *rings = text;
        for (size_t s = 0; s < sizeof SETS / sizeof *SETS; ++s) {
            if (strcmp(text, SETS[s].name) == 0) {
                rings = SETS[s].rings;
            }
        }
        const char *wrong = parse_rings(rings, list, &count);
        if (wrong) {
            free(list);
            return enc_fail(
                context, BTF_ERROR_USAGE,
                "directions '%s': %s (ubo, ubo2014, small, tiny, a number of 1..256, or rings such as "
                "0:1,30:6,60:12)",
                text, wrong);
        }
    }
    qsort(list, (size_t)count, sizeof *list, by_theta_then_phi);
    *out_directions = list;
    *out_count = count;
    return BTF_OK;
}
