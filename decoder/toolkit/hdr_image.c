/* Reading Radiance HDR images (RGBE; G. Ward, "Real Pixels", Graphics Gems II, 1991).
 *
 * SPDX-License-Identifier: MIT
 */
#include "hdr_image.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct cursor {
    const unsigned char *p, *end;
} cursor;

/* Reads a header line, without its end, into text; false at the end of the data or when it is too long. */
static bool read_line(cursor *c, char *text, size_t size) {
    size_t length = 0;
    while (c->p < c->end && *c->p != '\n') {
        if (length + 1 >= size)
            return false;
        text[length++] = (char)*c->p++;
    }
    if (c->p == c->end)
        return false;
    c->p++;
    if (length > 0 && text[length - 1] == '\r')
        length--;
    text[length] = '\0';
    return true;
}

/* One scan line of 4 * width bytes, each component in runs and literals of its own. */
static bool read_new_line(cursor *c, unsigned char *rgbe, int width) {
    for (int component = 0; component < 4; component++) {
        for (int x = 0; x < width;) {
            if (c->end - c->p < 2)
                return false;
            int count = *c->p++;
            const bool run = count > 128;
            if (run)
                count -= 128;
            if (count == 0 || count > width - x || c->end - c->p < (run ? 1 : count))
                return false;
            for (int i = 0; i < count; i++)
                rgbe[4 * (x++) + component] = run ? *c->p : c->p[i];
            c->p += run ? 1 : count;
        }
    }
    return true;
}

/* Flat pixels; (1, 1, 1, n) repeats the last one n times, more of them in a row count in base 256. */
static bool read_old_line(cursor *c, unsigned char *rgbe, int width) {
    int shift = 0;
    for (int x = 0; x < width;) {
        if (c->end - c->p < 4)
            return false;
        if (c->p[0] == 1 && c->p[1] == 1 && c->p[2] == 1) {
            const long count = shift < 24 ? (long)c->p[3] << shift : -1;
            if (x == 0 || count < 0 || count > width - x)
                return false;
            for (long i = 0; i < count; i++, x++)
                memcpy(rgbe + 4 * x, rgbe + 4 * (x - 1), 4);
            shift += 8;
        } else {
            memcpy(rgbe + 4 * x++, c->p, 4);
            shift = 0;
        }
        c->p += 4;
    }
    return true;
}

static bool read_scanline(cursor *c, unsigned char *rgbe, int width) {
    if (width >= 8 && width < 32768 && c->end - c->p >= 4 && c->p[0] == 2 && c->p[1] == 2 &&
        ((int)c->p[2] << 8 | c->p[3]) == width) {
        c->p += 4;
        return read_new_line(c, rgbe, width);
    }
    return read_old_line(c, rgbe, width);
}

/* Reads up to and including the resolution line. */
static btf_result read_header(cursor *c, size_t max_pixels, int *out_width, int *out_height, bool *out_xyz,
                              bool *out_upwards, double *out_exposure, char *message, size_t message_size) {
    char line[256];
    char y_sign, x_sign;
    *out_exposure = 1.0;
    *out_xyz = false;
    for (bool first = true;; first = false) {
        double exposure;
        if (!read_line(c, line, sizeof line))
            goto bad;
        if (first && strncmp(line, "#?", 2) != 0)
            goto bad;
        if (strncmp(line, "FORMAT=", 7) == 0) {
            *out_xyz = strcmp(line + 7, "32-bit_rle_xyze") == 0;
            if (!*out_xyz && strcmp(line + 7, "32-bit_rle_rgbe") != 0)
                goto bad;
        } else if (sscanf(line, "EXPOSURE=%lf", &exposure) == 1) {
            *out_exposure *= exposure;
            if (!(exposure > 0.0 && *out_exposure > 0.0) || !isfinite(*out_exposure))
                goto bad;
        } else if (line[0] == '\0') {
            break;
        }
    }
    if (!read_line(c, line, sizeof line))
        goto bad;
    /* ATRIUM's files say +X W -Y H, which would be column after column, but hold rows from the bottom. */
    const bool atrium = sscanf(line, "+X %9d -Y %9d", out_width, out_height) == 2;
    if (!atrium && (sscanf(line, "%cY %9d %cX %9d", &y_sign, out_height, &x_sign, out_width) != 4 ||
                    x_sign != '+' || (y_sign != '-' && y_sign != '+'))) {
        snprintf(message, message_size, "HDR: resolution \"%.64s\" is not of the form -Y H +X W", line);
        return BTF_ERROR_UNSUPPORTED;
    }
    *out_upwards = atrium || y_sign == '+';
    if (*out_width < 1 || *out_height < 1 || (size_t)*out_width > max_pixels / (size_t)*out_height) {
        snprintf(message, message_size, "HDR: size %dx%d is not usable", *out_width, *out_height);
        return BTF_ERROR_UNSUPPORTED;
    }
    return BTF_OK;
bad:
    snprintf(message, message_size, "HDR: bad header");
    return BTF_ERROR_BAD_FILE;
}

btf_result enc_image_hdr_read(const void *data, size_t size, size_t max_pixels, int *out_width,
                              int *out_height, bool *out_xyz, float **out_pixels, char *message,
                              size_t message_size) {
    cursor c = {data, (const unsigned char *)data + size};
    double exposure;
    bool upwards;
    btf_result result = read_header(&c, max_pixels, out_width, out_height, out_xyz, &upwards, &exposure,
                                    message, message_size);
    if (result != BTF_OK)
        return result;
    const int width = *out_width, height = *out_height;
    unsigned char *rgbe = malloc((size_t)width * 4);
    float *pixels = malloc((size_t)width * (size_t)height * 3 * sizeof *pixels);
    result = rgbe && pixels ? BTF_OK : BTF_ERROR_MEMORY;
    for (int line = 0; line < height && result == BTF_OK; line++) {
        if (!read_scanline(&c, rgbe, width)) {
            snprintf(message, message_size, "HDR: truncated or damaged in scan line %d of %d", line,
                     height);
            result = BTF_ERROR_BAD_FILE;
            break;
        }
        float *out = pixels + (size_t)(upwards ? height - 1 - line : line) * (size_t)width * 3;
        for (int x = 0; x < width; x++) {
            const double scale = rgbe[4 * x + 3] ? ldexp(1.0, rgbe[4 * x + 3] - (128 + 8)) / exposure : 0.0;
            for (int channel = 0; channel < 3; channel++)
                out[3 * x + channel] = (float)(rgbe[4 * x + channel] * scale);
        }
    }
    free(rgbe);
    if (result == BTF_OK)
        *out_pixels = pixels;
    else
        free(pixels);
    return result;
}
