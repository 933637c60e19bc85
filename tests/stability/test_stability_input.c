/* Images with values at the limits of their formats, read and encoded: 8-bit codes with clipped highlights, the
 * extremes and denormals of half and float, values that are no radiance.
 *
 * SPDX-License-Identifier: MIT
 */
#include "cases.h"
#include "encode.h"

#include "decoder/toolkit/exr_image.h"
#include "decoder/toolkit/png_image.h"
#include "encoder/input/reader.h"
#include "tests/support/messages.h"
#include "tests/support/temporary.h"

#include <float.h>
#include <ftw.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { W = 4, H = 3, DIRECTIONS = 7, TEXELS = W * H };
static const btf_log no_log = {NULL, NULL};
static const enc_context context = {.log = {keep_message, NULL}, .threads = 1};

static void make_folder(void) {
    if (make_temporary_folder(NULL) != 0) {
        exit(1);
    }
    forget_messages();
}

/* Angles of direction i: the pole, then 45 degrees. */
static int theta_of(int i) {
    return i == 0 ? 0 : 45;
}
static int phi_of(int i) {
    return i == 0 ? 0 : 60 * (i - 1);
}

/* A value of an image. */
typedef float (*pixel_fn)(int view, int light, int texel, int channel);

typedef enum kind { PNG8, PNG16, HALF, FLOAT } kind;

static double srgb_code(double x) {
    return x <= 0.0031308 ? 12.92 * x : 1.055 * pow(x, 1 / 2.4) - 0.055;
}
static double srgb_decode(double code) {
    return code <= 0.04045 ? code / 12.92 : pow((code + 0.055) / 1.055, 2.4);
}

/* The linear value that a pixel has after it went through the format. */
static float through(kind k, float value) {
    if (k == PNG8 || k == PNG16) {
        const double most = k == PNG8 ? 255 : 65535;
        return (float)srgb_decode(floor(most * srgb_code(fmin((double)value, 1)) + 0.5) / most);
    }
    if (k == FLOAT || value == 0) {
        return value;
    }
    int exponent;
    frexp((double)value, &exponent);
    const double step = ldexp(1, (exponent < -13 ? -13 : exponent) - 11); /* of a half */
    return (float)fmin(nearbyint((double)value / step) * step, 65504);
}

static void write_images(kind k, pixel_fn pixel) {
    for (int v = 0; v < DIRECTIONS; v++) {
        for (int l = 0; l < DIRECTIONS; l++) {
            char path[400];
            float linear[TEXELS * 3];
            unsigned char codes[TEXELS * 3];
            unsigned short wide[TEXELS * 3];
            for (int i = 0; i < TEXELS * 3; i++) {
                linear[i] = pixel(v, l, i / 3, i % 3);
                if (k == PNG8 || k == PNG16) {
                    const double code = srgb_code(fmin((double)linear[i], 1));
                    codes[i] = (unsigned char)floor(255 * code + 0.5);
                    wide[i] = (unsigned short)floor(65535 * code + 0.5);
                }
            }
            snprintf(path, sizeof path, "%s/tv%03d_pv%03d_tl%03d_pl%03d.%s", temporary_folder, theta_of(v), phi_of(v),
                     theta_of(l), phi_of(l), k >= HALF ? "exr" : "png");
            const btf_result result = k == PNG8    ? png_image_write8(path, W, H, codes, no_log)
                                      : k == PNG16 ? png_image_write16(path, W, H, wide, no_log)
                                                   : exr_image_write(path, W, H, linear, k == HALF, no_log);
            if (result != BTF_OK) {
                exit(1);
            }
        }
    }
}

/* A glossy surface that reaches 1000 in its highlight. */
static float glossy(int view, int light, int texel, int channel) {
    const enc_direction v = enc_direction_from_angles(theta_of(view), phi_of(view));
    const enc_direction l = enc_direction_from_angles(theta_of(light), phi_of(light));
    const float base = -l.xyz[0] * v.xyz[0] - l.xyz[1] * v.xyz[1] + l.xyz[2] * v.xyz[2];
    const float albedo = 0.1f + 0.8f * hard_random((uint32_t)texel, (uint32_t)channel, 1);
    return l.xyz[2] * (albedo + 1000 * powf(fmaxf(base, 0), 60));
}

static float half_extremes(int view, int light, int texel, int channel) {
    static const float list[] = {0,           0x1p-24f, 0x1p-23f,   0x1.ff8p-15f, 0x1p-14f,
                                 0x1.ffcp-1f, 1,        0x1.004p0f, 65504,        1e6f};
    return list[(view * 3 + light * 5 + texel * 7 + channel) % 10];
}

static float float_extremes(int view, int light, int texel, int channel) {
    static const float list[] = {0, FLT_TRUE_MIN, 1e-40f, FLT_MIN, 1e-8f, 1, 1e6f, 1e30f};
    return list[(view * 3 + light * 5 + texel * 7 + channel) % 8];
}

static float some_negative(int view, int light, int texel, int channel) {
    return texel == 5 ? -0.25f : texel == 6 ? -0.0f : glossy(view, light, texel, channel);
}

static void check_images(const char *input, kind k, pixel_fn pixel, const char *expected) {
    make_folder();
    write_images(k, pixel);
    enc_data *data = NULL;
    bool ok = enc_read(&context, temporary_folder, &(enc_read_options){0}, &data) == BTF_OK;
    double worst = 0, psnr[ENCODE_METHODS] = {0}, diffuse[ENCODE_METHODS] = {0};
    float peak = 0;
    uint64_t negative = 0, wanted_negative = 0;
    for (int v = 0; ok && v < DIRECTIONS; v++) {
        for (int l = 0; l < DIRECTIONS; l++) {
            for (int i = 0; i < TEXELS * 3; i++) {
                const float value = pixel(v, l, i / 3, i % 3);
                const double want = value < 0 ? 0 : (double)through(k, value);
                const double seen = (double)*hard_sample(data, (size_t)i / 3, v, i % 3, l);
                wanted_negative += value < 0;
                worst = fmax(worst, fabs(seen - want) / fmax(want, 1e-30));
                ok = ok && !(signbit(seen));
                peak = fminf(fmaxf(peak, (float)seen), 0x1p24f);
            }
        }
    }
    if (ok) {
        negative = data->negative;
        ok = negative == wanted_negative && worst <= (k == PNG8 || k == PNG16 ? 1e-6 : 0);
    }
    for (int method = 0; ok && method < ENCODE_METHODS; method++) {
        encoded e[2] = {encode(data, (encode_method)method, 1, 1),
                        encode(data, (encode_method)method, 2, 1)};
        ok = e[0].result == BTF_OK && e[1].result == BTF_OK && e[0].finite && e[0].size == e[1].size &&
             memcmp(e[0].file, e[1].file, e[0].size) == 0;
        psnr[method] = ok ? encode_psnr(data, e[0].decoded, peak) : 0;
        diffuse[method] = encode_psnr_of_diffuse(data, (encode_method)method, peak);
        ok = ok && encode_keeps_promise((encode_method)method, psnr[method], diffuse[method]);
        encode_clear(&e[0]);
        encode_clear(&e[1]);
    }
    cases_add(input, expected, ok,
              "read off by %.1e; peak %g, PSNR %.1f, %.1f, %.1f dB, diffuse fit %.1f, %.1f, %.1f dB%s%s",
              worst, (double)peak, psnr[0], psnr[1], psnr[2], diffuse[0], diffuse[1], diffuse[2],
              ok ? "" : "; ", ok ? "" : all_messages);
    enc_data_destroy(&data);
    remove_temporary_folder(NULL);
}

static float not_a_number(int view, int light, int texel, int channel) {
    return view == 2 && light == 3 && texel == 4 && channel == 1 ? NAN : 0.5f;
}
static float infinite(int view, int light, int texel, int channel) {
    return view == 2 && light == 3 && texel == 4 && channel == 1 ? INFINITY : 0.5f;
}

static void check_refused(const char *input, pixel_fn pixel) {
    make_folder();
    write_images(FLOAT, pixel);
    enc_data *data = NULL;
    const btf_result result = enc_read(&context, temporary_folder, &(enc_read_options){0}, &data);
    const char *name = strstr(all_messages, "tv045_pv060_tl045_pl120.exr");
    char seen[200];
    snprintf(seen, sizeof seen, "%.190s", name != NULL ? name : all_messages);
    seen[strcspn(seen, "\n")] = 0;
    cases_add(input, "refused, the image named",
              result == BTF_ERROR_BAD_FILE && name != NULL && data == NULL, "%s", seen);
    enc_data_destroy(&data);
    remove_temporary_folder(NULL);
}

int main(void) {
    cases_title(
        "Images at the ends of their formats, read, and encoded by all methods (PSNR to the "
        "largest sample, at most 2^24: paper, the same with RGB lobes, joint).");
    char same[300], negative[300];
    snprintf(
        same, sizeof same,
        "every value as coded, files that decode to finite values, same bytes with 1 and 2 threads, %s",
        encode_promise);
    snprintf(negative, sizeof negative,
             "negative values counted and 0, files that decode to finite values, same bytes with 1 and 2 "
             "threads, %s",
             encode_promise);
    check_images("8-bit PNG, highlights of 1000 clipped to 1", PNG8, glossy, same);
    check_images("16-bit PNG, highlights of 1000 clipped to 1", PNG16, glossy, same);
    check_images("half floats 2^-24 (denormal) to 65504, and 1e6, which becomes 65504", HALF, half_extremes,
                 same);
    check_images("floats 1e-45 (denormal) to 1e30", FLOAT, float_extremes, same);
    check_images("floats of -0.25 and -0", FLOAT, some_negative, negative);
    check_refused("an EXR that holds NaN", not_a_number);
    check_refused("an EXR that holds infinity", infinite);
    return cases_result();
}
