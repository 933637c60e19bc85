/* Pictures: from linear radiance to the values of a screen.
 *
 * SPDX-License-Identifier: MIT
 */
#include "picture.h"

#include "decoder/toolkit/file.h"
#include "decoder/toolkit/exr_image.h"
#include "decoder/toolkit/png_image.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

btf_result picture_create(int width, int height, picture *out_picture) {
    *out_picture = (picture){width, height, calloc((size_t)width * (size_t)height * 3, sizeof(float))};
    return out_picture->rgb ? BTF_OK : BTF_ERROR_MEMORY;
}

void picture_clear(picture *p) {
    free(p->rgb);
    *p = (picture){0};
}

static size_t value_count(const picture *p) {
    return (size_t)p->width * (size_t)p->height * 3;
}

/* sRGB coding of a value clipped to [0, 1]. */
static double srgb(double linear) {
    if (!(linear > 0)) {
        return 0;
    }
    if (linear >= 1) {
        return 1;
    }
    return linear <= 0.0031308 ? 12.92 * linear : 1.055 * pow(linear, 1 / 2.4) - 0.055;
}

unsigned char picture_code(double linear) {
    return (unsigned char)(255 * srgb(linear) + 0.5);
}

double picture_tone(tone t, double x) {
    if (t == TONE_REINHARD) {
        return x / (1 + x);
    }
    if (t == TONE_FILMIC) {
        return x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14);
    }
    return x;
}

void picture_expose(picture *p, double exposure) {
    for (size_t i = 0; i < value_count(p); i++) {
        p->rgb[i] = (float)((double)p->rgb[i] * exposure);
    }
}

bool picture_knows(const char *path) {
    return file_ends_in(path, ".png") || file_ends_in(path, ".exr");
}

btf_result picture_write(const picture *p, const char *path, tone t, btf_log log) {
    if (file_ends_in(path, ".exr")) {
        return exr_image_write(path, p->width, p->height, p->rgb, false, log);
    }
    unsigned char *codes = malloc(value_count(p));
    if (!codes) {
        return BTF_ERROR_MEMORY;
    }
    for (size_t i = 0; i < value_count(p); i++) {
        codes[i] = picture_code(picture_tone(t, (double)p->rgb[i]));
    }
    btf_result result = png_image_write8(path, p->width, p->height, codes, log);
    free(codes);
    return result;
}

double picture_psnr(const picture *a, const picture *b, const unsigned char *mask, bool coded) {
    double sum = 0;
    size_t count = 0;
    for (size_t i = 0; i < value_count(a); i++) {
        if (mask && !mask[i / 3]) {
            continue;
        }
        double x = fmin(fmax((double)a->rgb[i], 0), 1), y = fmin(fmax((double)b->rgb[i], 0), 1);
        double difference = coded ? srgb(x) - srgb(y) : x - y;
        sum += difference * difference;
        count++;
    }
    return sum > 0 ? fmin(99.99, -10 * log10(sum / (double)count)) : 99.99;
}
