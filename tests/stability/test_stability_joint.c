/* Hard data through whole encodes by both methods: the file opens, decodes to finite values, is the same for any number
 * of threads, and is no worse than a diffuse surface.
 *
 * SPDX-License-Identifier: MIT
 */
#include "cases.h"
#include "encode.h"
#include "tests/support/messages.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static float random_of(int texel, int sample, int channel) {
    return hard_random((uint32_t)texel, (uint32_t)sample, (uint32_t)channel);
}

/* A plain surface with a highlight, to which the outliers are added. */
static float plain(int texel, const enc_direction *v, const enc_direction *l, int channel) {
    const float albedo = 0.2f + 0.5f * random_of(texel, 1, channel);
    const float base =
        1.1f * (-l->xyz[0] * v->xyz[0] - l->xyz[1] * v->xyz[1]) + 0.95f * l->xyz[2] * v->xyz[2];
    return l->xyz[2] * (albedo + 0.4f * powf(fmaxf(base, 0), 12));
}

/* user: value of the outliers, which are one sample in 97, or, where they are 1e7, one in 1999. */
static void outliers(const void *user, int texel, const enc_direction *v, const enc_direction *l,
                     int sample, float rgb[3]) {
    for (int c = 0; c < 3; c++) {
        rgb[c] = (sample * 31 + texel * 7) % (*(const float *)user == 1e7f ? 1999 : 97) == 0
                     ? *(const float *)user
                     : plain(texel, v, l, c);
    }
}

/* user: scale. */
static void scaled(const void *user, int texel, const enc_direction *v, const enc_direction *l, int sample,
                   float rgb[3]) {
    (void)sample;
    for (int c = 0; c < 3; c++) {
        rgb[c] = *(const float *)user * plain(texel, v, l, c);
    }
}

static void zeros(const void *user, int texel, const enc_direction *v, const enc_direction *l, int sample,
                  float rgb[3]) {
    (void)user;
    for (int c = 0; c < 3; c++) {
        rgb[c] = random_of(texel, sample, 9) < 0.5f ? 0 : plain(texel, v, l, c);
    }
}

/* One texel of light in black ones. */
static void one_texel_lit(const void *user, int texel, const enc_direction *v, const enc_direction *l,
                          int sample, float rgb[3]) {
    (void)user, (void)sample;
    for (int c = 0; c < 3; c++) {
        rgb[c] = texel == 5 ? plain(texel, v, l, c) : 0;
    }
}

static void one_sample(const void *user, int texel, const enc_direction *v, const enc_direction *l,
                       int sample, float rgb[3]) {
    (void)user, (void)v, (void)l;
    rgb[0] = rgb[1] = rgb[2] = texel == 3 && sample == 40 ? 1 : 0;
}

/* 8-bit sRGB codes, highlights clipped. */
static void quantised(const void *user, int texel, const enc_direction *v, const enc_direction *l,
                      int sample, float rgb[3]) {
    (void)user, (void)sample;
    for (int c = 0; c < 3; c++) {
        const double x = fmin(4 * (double)plain(texel, v, l, c), 1);
        const double code =
            floor(255 * (x <= 0.0031308 ? 12.92 * x : 1.055 * pow(x, 1 / 2.4) - 0.055) + 0.5) / 255;
        rgb[c] = (float)(code <= 0.04045 ? code / 12.92 : pow((code + 0.055) / 1.055, 2.4));
    }
}

typedef struct hard_case {
    const char *input;
    int width, height;
    hard_value_fn value;
    float user;
    enum {
        MANY,
        FEW,
        GRAZING
    } directions; /* FEW: one view, one light; GRAZING: 0 and 85 to 89.9 degrees */
    float peak;   /* of the PSNR */
} hard_case;

static const hard_case list[] = {
    {"black", 4, 3, hard_black, 0, MANY, 1},
    {"constant 0.5", 4, 3, hard_constant, 0.5f, MANY, 1},
    {"constant 1", 4, 3, hard_constant, 1, MANY, 1},
    {"noise", 5, 4, hard_noise, 1, MANY, 1},
    {"one sample in two thousand is 1e7", 4, 4, outliers, 1e7f, MANY, 1},
    {"one sample in a hundred is 1e6", 4, 4, outliers, 1e6f, MANY, 1e6f},
    {"one sample in a hundred is 65504", 4, 4, outliers, 65504, MANY, 65504},
    {"one sample in a hundred is 1e38", 4, 4, outliers, 1e38f, MANY, 0x1p24f},
    {"values from 1e-8 to 1e6", 4, 4, hard_spread, 0, MANY, 1e6f},
    {"a surface times 1e-8", 4, 4, scaled, 1e-8f, MANY, 1e-8f},
    {"a surface times 1e-40, denormals", 4, 4, scaled, 1e-40f, MANY, 1e-40f},
    {"a surface times 1e-3", 4, 4, scaled, 1e-3f, MANY, 1e-3f},
    {"a surface times 1e-5", 4, 4, scaled, 1e-5f, MANY, 1e-5f},
    {"a surface times 1e6", 4, 4, scaled, 1e6f, MANY, 1e6f},
    {"a surface times 1e12", 4, 4, scaled, 1e12f, MANY, 0x1p24f},
    {"half of the samples 0", 4, 4, zeros, 0, MANY, 1},
    {"one texel lit, the others black", 4, 3, one_texel_lit, 0, MANY, 1},
    {"one sample lit of 2028", 4, 3, one_sample, 0, MANY, 1},
    {"8-bit sRGB codes with clipped highlights", 4, 4, quantised, 0, MANY, 1},
    {"views and lights at 0 and 85 to 89.9 degrees", 4, 3, scaled, 1, GRAZING, 1},
    {"1x1 texel", 1, 1, scaled, 1, MANY, 1},
    {"1x9 texels", 1, 9, scaled, 1, MANY, 1},
    {"one view, one light, 3x3 texels", 3, 3, scaled, 1, FEW, 1},
    {"one sample", 1, 1, scaled, 1, FEW, 1},
};

/* One hard case by one method: encodes with one thread and with two, and adds the case. The joint method must also be
 * as good as the texture whose every texel is the mean. */
static void run(const hard_case *h, encode_method method) {
    const hard_directions many = hard_thirteen(),
                          one = hard_rings(1, (const double[]){0}, (const int[]){1});
    const hard_directions grazing =
        hard_rings(4, (const double[]){0, 85, 88, 89.9}, (const int[]){1, 4, 4, 4});
    const hard_directions *directions = h->directions == FEW       ? &one
                                        : h->directions == GRAZING ? &grazing
                                                                   : &many;
    enc_data *data = hard_create(h->width, h->height, directions, directions, h->value, &h->user);
    encoded e[2];
    bool same = true;
    for (int i = 0; i < 2; i++) {
        e[i] = encode(data, method, 1 + i, 1);
        same = same && e[i].result == BTF_OK && e[i].size == e[0].size &&
               memcmp(e[i].file, e[0].file, e[0].size) == 0;
    }
    char input[120];
    snprintf(input, sizeof input, "%s: %s", encode_names[method], h->input);
    const bool joint = method == ENCODE_JOINT;
    const bool denormal = h->value == scaled && h->user == 1e-40f;
    char expected[240];
    snprintf(expected, sizeof expected, "opens, finite, same bytes with 1 and 2 threads, %s%s",
             denormal ? "decodes to exactly 0" : encode_promise,
             joint && !denormal ? ", or than the mean texel" : "");
    double psnr = 0, mean = encode_psnr_of_mean(data, h->peak);
    const double diffuse = encode_psnr_of_diffuse(data, method, h->peak);
    bool ok = same && e[0].finite && e[0].played <= 1e-3;
    if (e[0].result == BTF_OK) {
        psnr = encode_psnr(data, e[0].decoded, h->peak);
        ok = ok && (!joint || denormal || psnr >= fmin(mean, 47) - 0.1);
        ok = ok && encode_keeps_promise(method, psnr, diffuse);
        for (size_t i = 0; denormal && i < enc_data_texel_count(data) * enc_data_texel_stride(data); i++) {
            ok = ok && e[0].decoded[i] == 0;
        }
    }
    cases_add(input, expected, ok,
              "%s, %.1f dB, diffuse fit %.1f dB, mean texel %.1f dB, playback off by %.1e",
              e[0].result != BTF_OK ? "FAILED"
              : !e[0].finite        ? "NOT FINITE"
              : same                ? "the same bytes"
                                    : "OTHER BYTES",
              psnr, diffuse, mean, e[0].played);
    for (int i = 0; i < 2; i++) {
        encode_clear(&e[i]);
    }
    enc_data_destroy(&data);
}

/* PSNR of a surface times `scale` by the joint method, relative to its peak. */
static double surface_psnr(float scale) {
    const hard_directions many = hard_thirteen();
    enc_data *data = hard_create(4, 4, &many, &many, scaled, &scale);
    encoded e = encode(data, ENCODE_JOINT, 1, 1);
    const double psnr = e.result == BTF_OK ? encode_psnr(data, e.decoded, scale) : 0;
    encode_clear(&e);
    enc_data_destroy(&data);
    return psnr;
}

/* The method's relative accuracy does not depend on brightness. */
static void dim_is_as_good(void) {
    static const float scales[] = {0.3f, 1e-3f, 1e-5f};
    const double bright = surface_psnr(0.6f);
    for (size_t i = 0; i < sizeof scales / sizeof *scales; i++) {
        const double dim = surface_psnr(scales[i]);
        cases_add(told("%s: a surface times %g, relative to its peak", encode_names[ENCODE_JOINT],
                             (double)scales[i]),
                  "within 1 dB of the surface times 0.6, or better", dim >= bright - 1,
                  "%.1f dB, times 0.6 %.1f dB", dim, bright);
    }
}

int main(void) {
    cases_title("Whole encodes of hard data, saved, opened and decoded by the reference at the sampled "
                "directions.");
    for (int method = 0; method < ENCODE_METHODS; method++) {
        for (size_t i = 0; i < sizeof list / sizeof *list; i++) {
            run(list + i, (encode_method)method);
        }
    }
    dim_is_as_good();
    return cases_result();
}
