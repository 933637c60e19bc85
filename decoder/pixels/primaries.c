/* RGB spaces by their primaries and white, and from one of them to linear Rec. 709.
 *
 * SPDX-License-Identifier: MIT
 */
#include "primaries.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

const primaries primaries_rec709 = {{0.64, 0.33}, {0.30, 0.60}, {0.15, 0.06}, {0.3127, 0.3290}};

bool primaries_are_rec709(const primaries *p) {
    const double *a = p->red, *b = primaries_rec709.red;
    for (int i = 0; i < 8; i++) {
        if (!(fabs(a[i] - b[i]) <= 0.002)) {
            return false;
        }
    }
    return true;
}

static void multiply(const double a[9], const double b[9], double out[9]) {
    for (int i = 0; i < 9; i++) {
        const int row = i / 3 * 3, column = i % 3;
        out[i] = a[row] * b[column] + a[row + 1] * b[column + 3] + a[row + 2] * b[column + 6];
    }
}

static void transform(const double m[9], const double in[3], double out[3]) {
    for (int i = 0; i < 3; i++) {
        out[i] = m[3 * i] * in[0] + m[3 * i + 1] * in[1] + m[3 * i + 2] * in[2];
    }
}

static bool invert(const double m[9], double out[9]) {
    const double c[9] = {m[4] * m[8] - m[5] * m[7], m[2] * m[7] - m[1] * m[8], m[1] * m[5] - m[2] * m[4],
                         m[5] * m[6] - m[3] * m[8], m[0] * m[8] - m[2] * m[6], m[2] * m[3] - m[0] * m[5],
                         m[3] * m[7] - m[4] * m[6], m[1] * m[6] - m[0] * m[7], m[0] * m[4] - m[1] * m[3]};
    const double determinant = m[0] * c[0] + m[1] * c[3] + m[2] * c[6];
    if (!(fabs(determinant) > 1e-9) || !isfinite(determinant)) {
        return false;
    }
    for (int i = 0; i < 9; i++) {
        out[i] = c[i] / determinant;
    }
    return true;
}

/* XYZ of a white, Y = 1. */
static bool white_xyz(const double xy[2], double out[3]) {
    if (!(fabs(xy[1]) > 1e-6)) {
        return false;
    }
    out[0] = xy[0] / xy[1];
    out[1] = 1.0;
    out[2] = (1.0 - xy[0] - xy[1]) / xy[1];
    return true;
}

bool primaries_to_xyz(const primaries *p, double out[9]) {
    const double *colour[3] = {p->red, p->green, p->blue};
    double columns[9], inverse[9], white[3], scale[3];
    for (int c = 0; c < 3; c++) {
        columns[c] = colour[c][0];
        columns[3 + c] = colour[c][1];
        columns[6 + c] = 1.0 - colour[c][0] - colour[c][1];
    }
    if (!white_xyz(p->white, white) || !invert(columns, inverse)) {
        return false;
    }
    transform(inverse, white, scale);
    for (int i = 0; i < 9; i++) {
        out[i] = columns[i] * scale[i % 3];
        if (!isfinite(out[i])) {
            return false;
        }
    }
    return true;
}

/* The matrix from XYZ under one white to XYZ under another, by the Bradford transform (K. M. Lam, 1985). */
static bool bradford(const double from[2], const double to[2], double out[9]) {
    static const double cones[9] = {0.8951, 0.2664, -0.1614, -0.7502, 1.7135,
                                    0.0367, 0.0389, -0.0685, 1.0296};
    double back[9], from_white[3], to_white[3], from_cones[3], to_cones[3], scaled[9];
    if (!white_xyz(from, from_white) || !white_xyz(to, to_white) || !invert(cones, back)) {
        return false;
    }
    transform(cones, from_white, from_cones);
    transform(cones, to_white, to_cones);
    for (int i = 0; i < 9; i++) {
        if (!(fabs(from_cones[i / 3]) > 1e-6)) {
            return false;
        }
        scaled[i] = cones[i] * to_cones[i / 3] / from_cones[i / 3];
    }
    multiply(back, scaled, out);
    return true;
}

bool primaries_to_rec709(const primaries *p, float out[9]) {
    double to_xyz[9], adapt[9], rec709[9], back[9], adapted[9], all[9];
    if (!primaries_to_xyz(p, to_xyz) || !primaries_to_xyz(&primaries_rec709, rec709) ||
        !invert(rec709, back) || !bradford(p->white, primaries_rec709.white, adapt)) {
        return false;
    }
    multiply(adapt, to_xyz, adapted);
    multiply(back, adapted, all);
    for (int i = 0; i < 9; i++) {
        out[i] = (float)all[i];
        if (!isfinite(out[i])) {
            return false;
        }
    }
    return true;
}

void primaries_apply(const float m[9], size_t count, float *pixels) {
    for (size_t i = 0; i < count; i++) {
        float *p = pixels + 3 * i;
        const float r = p[0], g = p[1], b = p[2];
        for (int c = 0; c < 3; c++) {
            p[c] = m[3 * c] * r + m[3 * c + 1] * g + m[3 * c + 2] * b;
        }
    }
}

void primaries_text(const primaries *p, char *out, size_t size) {
    snprintf(out, size, "red (%.4g,%.4g), green (%.4g,%.4g), blue (%.4g,%.4g), white (%.4g,%.4g)",
             p->red[0], p->red[1], p->green[0], p->green[1], p->blue[0], p->blue[1], p->white[0],
             p->white[1]);
}
