/* Structural similarity of two images. See ssim.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "ssim.h"

#include "encoder/data/data.h"

#include <math.h>
#include <stdlib.h>

enum { TAPS = 11, FIELDS = 5 };

struct enc_ssim {
    int width, height;
    float weight[TAPS];
    float *field[FIELDS]; /* a, b, a*a, b*b, a*b: [row][column] */
    float *padded;        /* one line with its periodic margins */
    float *blurred;
};

enc_ssim *enc_ssim_create(int width, int height) {
    const size_t texels = (size_t)width * (size_t)height;
    const size_t longest = (size_t)(width > height ? width : height);
    enc_ssim *s = calloc(1, sizeof *s);
    if (!s) {
        return NULL;
    }
    s->width = width;
    s->height = height;
    double sum = 0;
    for (int i = 0; i < TAPS; i++) {
        sum += exp(-(i - TAPS / 2) * (i - TAPS / 2) / (2 * 1.5 * 1.5));
    }
    for (int i = 0; i < TAPS; i++) {
        s->weight[i] = (float)(exp(-(i - TAPS / 2) * (i - TAPS / 2) / (2 * 1.5 * 1.5)) / sum);
    }
    s->padded = malloc((longest + TAPS) * sizeof(float));
    s->blurred = malloc(texels * sizeof(float));
    int ok = s->padded && s->blurred;
    for (int f = 0; f < FIELDS; f++) {
        s->field[f] = malloc(texels * sizeof(float));
        ok = ok && s->field[f];
    }
    if (!ok) {
        enc_ssim_destroy(&s);
    }
    return s;
}

void enc_ssim_destroy(enc_ssim **ssim) {
    enc_ssim *s = *ssim;
    if (!s) {
        return;
    }
    for (int f = 0; f < FIELDS; f++) {
        free(s->field[f]);
    }
    free(s->padded);
    free(s->blurred);
    free(s);
    *ssim = NULL;
}

static void blur_rows(enc_ssim *s, const float *in, float *out) {
    const int w = s->width;
    for (int y = 0; y < s->height; y++) {
        for (int x = 0; x < w + TAPS - 1; x++) {
            s->padded[x] = in[y * w + ((x - TAPS / 2) % w + w) % w];
        }
        for (int x = 0; x < w; x++) {
            float sum = 0;
            for (int i = 0; i < TAPS; i++) {
                sum += s->weight[i] * s->padded[x + i];
            }
            out[y * w + x] = sum;
        }
    }
}

static void blur_columns(enc_ssim *s, const float *in, float *out) {
    const int w = s->width, h = s->height;
    for (int y = 0; y < h; y++) {
        for (int x = 0; x < w; x++) {
            out[y * w + x] = 0;
        }
        for (int i = 0; i < TAPS; i++) {
            const float *row = in + (((y + i - TAPS / 2) % h + h) % h) * w;
            for (int x = 0; x < w; x++) {
                out[y * w + x] += s->weight[i] * row[x];
            }
        }
    }
}

double enc_ssim_images(enc_ssim *s, const float *a, const float *b) {
    const size_t texels = (size_t)s->width * (size_t)s->height;
    for (size_t t = 0; t < texels; t++) {
        const float p = enc_luminance(a[3 * t], a[3 * t + 1], a[3 * t + 2]);
        const float q = enc_luminance(b[3 * t], b[3 * t + 1], b[3 * t + 2]);
        s->field[0][t] = p;
        s->field[1][t] = q;
        s->field[2][t] = p * p;
        s->field[3][t] = q * q;
        s->field[4][t] = p * q;
    }
    for (int f = 0; f < FIELDS; f++) {
        blur_rows(s, s->field[f], s->blurred);
        blur_columns(s, s->blurred, s->field[f]);
    }
    const float c1 = 0.01f * 0.01f, c2 = 0.03f * 0.03f;
    double sum = 0;
    for (size_t t = 0; t < texels; t++) {
        const float ma = s->field[0][t], mb = s->field[1][t];
        const float va = s->field[2][t] - ma * ma, vb = s->field[3][t] - mb * mb,
                    cov = s->field[4][t] - ma * mb;
        sum += (2 * ma * mb + c1) * (2 * cov + c2) / ((ma * ma + mb * mb + c1) * (va + vb + c2));
    }
    return sum / (double)texels;
}
