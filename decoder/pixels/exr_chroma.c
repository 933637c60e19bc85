/* Luminance and chroma of OpenEXR files to RGB.
 *
 * SPDX-License-Identifier: MIT
 */
#include "exr_chroma.h"

#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

/* OpenEXR's filter (ImfRgbaYca.cpp): the weights of the samples 1, 3, ... 13 before and behind. */
static const float taps[7] = {0.627123f, -0.186077f, 0.087929f, -0.043159f,
                              0.019597f, -0.007540f, 0.002128f};

/* The value between samples k and k + 1 of n, which lie `step` floats apart; at the edges the last one is
 * repeated. */
static float between(const float *samples, size_t step, int n, int k) {
    float sum = 0.0f;
    for (int t = 0; t < 7; t++) {
        const int before = k - t < 0 ? 0 : k - t, behind = k + 1 + t > n - 1 ? n - 1 : k + 1 + t;
        sum += taps[t] * (samples[(size_t)before * step] + samples[(size_t)behind * step]);
    }
    return sum;
}

/* Fills in the columns, then the rows between those that have chroma. */
static void fill_in(int width, int height, int x_step, int y_step, float *pixels) {
    const size_t row = (size_t)width * 3;
    for (int y = 0; x_step == 2 && y < height; y += y_step) {
        for (int x = 1; x < width; x += 2) {
            for (size_t c = 0; c < 3; c += 2) {
                float *line = pixels + (size_t)y * row + c;
                line[3 * (size_t)x] = between(line, 6, width / 2, x / 2);
            }
        }
    }
    for (int y = 1; y_step == 2 && y < height; y += 2) {
        for (int x = 0; x < width; x++) {
            for (size_t c = 0; c < 3; c += 2) {
                float *column = pixels + 3 * (size_t)x + c;
                column[(size_t)y * row] = between(column, 2 * row, height / 2, y / 2);
            }
        }
    }
}

static void to_rgb(const float weights[3], size_t count, float *pixels) {
    for (size_t i = 0; i < count; i++) {
        float *p = pixels + 3 * i;
        const float luminance = p[1];
        p[0] = (p[0] + 1.0f) * luminance;
        p[2] = (p[2] + 1.0f) * luminance;
        p[1] = (luminance - p[0] * weights[0] - p[2] * weights[2]) / weights[1];
    }
}

static float saturation(const float *p) {
    const float most = fmaxf(p[0], fmaxf(p[1], p[2])), least = fminf(p[0], fminf(p[1], p[2]));
    return most > 0.0f ? 1.0f - least / most : 0.0f;
}

/* Takes saturation to `factor` of what it is, at the same luminance. */
static void desaturate(float *p, float factor, const float weights[3]) {
    const float most = fmaxf(p[0], fmaxf(p[1], p[2]));
    float before = 0.0f, after = 0.0f;
    for (int c = 0; c < 3; c++) {
        before += weights[c] * p[c];
        p[c] = fmaxf(most - (most - p[c]) * factor, 0.0f);
        after += weights[c] * p[c];
    }
    for (int c = 0; c < 3 && after > 0.0f; c++) {
        p[c] *= before / after;
    }
}

/* One row in place, by the rows above and below as they were. */
static void limit_row(int width, const float *above, const float *below, const float weights[3],
                      float *row) {
    for (int x = 0; x < width; x++) {
        const size_t left = 3 * (size_t)(x > 0 ? x - 1 : 0),
                     right = 3 * (size_t)(x < width - 1 ? x + 1 : x);
        const float sum = saturation(above + left) + saturation(above + right) + saturation(below + left) +
                          saturation(below + right);
        const float mean = fminf(1.0f, 0.25f * sum), most = fminf(1.0f, 1.0f - (1.0f - mean) * 0.25f);
        float *p = row + 3 * (size_t)x;
        const float own = saturation(p);
        if (own > mean && own > most) {
            desaturate(p, most / own, weights);
        }
    }
}

btf_result exr_chroma_to_rgb(int width, int height, int x_step, int y_step, const float weights[3],
                             float *pixels) {
    const size_t row = (size_t)width * 3;
    float *kept = malloc(2 * row * sizeof *kept); /* a row and the one above, as they were */
    if (!kept) {
        return BTF_ERROR_MEMORY;
    }
    fill_in(width, height, x_step, y_step, pixels);
    to_rgb(weights, (size_t)width * (size_t)height, pixels);
    for (int y = 0; y < height && (x_step == 2 || y_step == 2); y++) {
        float *line = pixels + (size_t)y * row, *own = kept + (size_t)(y % 2) * row;
        memcpy(own, line, row * sizeof *own);
        limit_row(width, y > 0 ? kept + (size_t)((y + 1) % 2) * row : own,
                  y < height - 1 ? line + row : own, weights, line);
    }
    free(kept);
    return BTF_OK;
}
