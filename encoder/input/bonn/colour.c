/* The colour models of Bonn's DFMF files, back to linear RGB.
 *
 * SPDX-License-Identifier: MIT
 */
#include "colour.h"

#include <math.h>

/* What the writer of the files added to values before it took logarithms. */
static const float epsilon = 1e-5f;

static void from_yuv(float s[3]) {
    const float y = s[0], u = s[1], v = s[2];
    s[0] = y + 1.13983f * v;
    s[1] = y - 0.39465f * u - 0.5806f * v;
    s[2] = y + 2.03211f * u;
}

static void from_ycocg(float s[3]) {
    const float y = s[0], a = s[1], b = s[2];
    s[0] = y + a - b;
    s[1] = y + b;
    s[2] = y - a - b;
}

/* Turns principal components back: row vector times matrix, plus mean. */
static void from_principal(float s[3], const float mean[3], const float matrix[9]) {
    const float a = s[0], b = s[1], c = s[2];
    for (int i = 0; i < 3; i++) {
        s[i] = a * matrix[i] + b * matrix[3 + i] + c * matrix[6 + i] + mean[i];
    }
}

static float lab_curve(float t) {
    return t > 6.0f / 29.0f ? t * t * t : 3.0f * (6.0f / 29.0f) * (6.0f / 29.0f) * (t - 4.0f / 29.0f);
}

/* Turns CIE L*a*b* of white D65, which is that of Rec. 709, into linear Rec. 709. */
static void from_lab(float s[3]) {
    const float fy = (s[0] + 16.0f) / 116.0f;
    const float x = 0.95047f * lab_curve(fy + s[1] / 500.0f), y = lab_curve(fy);
    const float z = 1.08883f * lab_curve(fy - s[2] / 200.0f);
    s[0] = 3.2404542f * x - 1.5371385f * y - 0.4985314f * z;
    s[1] = -0.9692660f * x + 1.8760108f * y + 0.0415560f * z;
    s[2] = 0.0556434f * x - 0.2040259f * y + 1.0572252f * z;
}

/* Undoes the logarithm: exp(c) - e. */
static float from_log(float c) {
    return expf(c) - epsilon;
}

static float from_signed_log(float c) {
    return copysignf(expf(fabsf(c) + logf(epsilon)), c) * (c != 0.0f ? 1.0f : 0.0f);
}

void enc_bonn_colour(int32_t model, const float mean[3], const float matrix[9], size_t count, size_t pitch,
                     float *samples) {
    for (size_t i = 0; i < count; i++) {
        float s[3] = {samples[i], samples[i + pitch], samples[i + 2 * pitch]};
        switch (model) {
        case 1:
            from_yuv(s);
            break;
        case 2:
            from_lab(s);
            break;
        case 3:
            from_principal(s, mean, matrix);
            break;
        case 4:
            from_ycocg(s);
            break;
        case 9:
            s[0] = from_log(s[0]);
            from_yuv(s);
            break;
        case 10:
            s[0] = from_log(s[0]);
            s[1] = from_signed_log(s[1]);
            s[2] = from_signed_log(s[2]);
            from_yuv(s);
            break;
        case 11: /* Y = exp(c0) - e, U = c1 (Y + e), V = c2 (Y + e) */
            s[0] = from_log(s[0]);
            s[1] *= s[0] + epsilon;
            s[2] *= s[0] + epsilon;
            from_yuv(s);
            break;
        case 12:
            for (int c = 0; c < 3; c++) {
                s[c] = from_log(s[c]);
            }
            break;
        default: /* 0: RGB */
            break;
        }
        for (size_t c = 0; c < 3; c++) {
            samples[i + c * pitch] = s[c];
        }
    }
}
