/* Decodes pixels to linear Rec. 709 radiance, and resizes images.
 *
 * SPDX-License-Identifier: MIT
 */
#include "colour.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

struct enc_decoder {
    enc_transfer transfer;
    double gamma;
    float table8[1 << 8];
    float table16[1 << 16];
};

double enc_srgb_decode(double value) {
    const double v = fabs(value);
    return copysign(v <= 0.04045 ? v / 12.92 : pow((v + 0.055) / 1.055, 2.4), value);
}

static double decode_value(enc_transfer transfer, double gamma, double value) {
    switch (transfer) {
    case ENC_TRANSFER_SRGB:
        return enc_srgb_decode(value);
    case ENC_TRANSFER_GAMMA:
        return copysign(pow(fabs(value), gamma), value);
    case ENC_TRANSFER_BT709: {
        const double v = fabs(value);
        return copysign(v < 0.081 ? v / 4.5 : pow((v + 0.099) / 1.099, 1.0 / 0.45), value);
    }
    case ENC_TRANSFER_AUTO:
    case ENC_TRANSFER_LINEAR:
        break;
    }
    return value;
}

enc_decoder *enc_decoder_create(enc_transfer transfer, double gamma) {
    enc_decoder *decoder = malloc(sizeof *decoder);
    if (!decoder) {
        return NULL;
    }
    decoder->transfer = transfer;
    decoder->gamma = gamma;
    const enc_transfer integer = transfer == ENC_TRANSFER_AUTO ? ENC_TRANSFER_SRGB : transfer;
    for (int i = 0; i < 1 << 8; i++) {
        decoder->table8[i] = (float)decode_value(integer, gamma, i / 255.0);
    }
    for (int i = 0; i < 1 << 16; i++) {
        decoder->table16[i] = (float)decode_value(integer, gamma, i / 65535.0);
    }
    return decoder;
}

void enc_decoder_destroy(enc_decoder **decoder) {
    if (!decoder) {
        return;
    }
    free(*decoder);
    *decoder = NULL;
}

enc_transfer enc_transfer_of(const enc_image *image, double *out_gamma) {
    *out_gamma = image->info.gamma;
    switch (image->info.transfer) {
    case IMAGE_TRANSFER_LINEAR:
        return ENC_TRANSFER_LINEAR;
    case IMAGE_TRANSFER_GAMMA:
        return ENC_TRANSFER_GAMMA;
    case IMAGE_TRANSFER_BT709:
        return ENC_TRANSFER_BT709;
    case IMAGE_TRANSFER_UNSAID:
    case IMAGE_TRANSFER_SRGB:
    case IMAGE_TRANSFER_OTHER:
        break;
    }
    return ENC_TRANSFER_SRGB;
}

bool enc_decoder_is(const enc_decoder *decoder, enc_transfer transfer, double gamma) {
    return decoder->transfer == transfer && (transfer != ENC_TRANSFER_GAMMA || decoder->gamma == gamma);
}

static void decode_row(const enc_decoder *decoder, const enc_image *image, size_t first, size_t count,
                       float *out) {
    if (image->depth == 8) {
        const unsigned char *in = (const unsigned char *)image->pixels + first;
        for (size_t i = 0; i < count; i++) {
            out[i] = decoder->table8[in[i]];
        }
    } else if (image->depth == 16) {
        const unsigned short *in = (const unsigned short *)image->pixels + first;
        for (size_t i = 0; i < count; i++) {
            out[i] = decoder->table16[in[i]];
        }
    } else {
        const float *in = (const float *)image->pixels + first;
        if (decoder->transfer == ENC_TRANSFER_AUTO || decoder->transfer == ENC_TRANSFER_LINEAR) {
            memcpy(out, in, count * sizeof *out);
        } else {
            for (size_t i = 0; i < count; i++) {
                out[i] = (float)decode_value(decoder->transfer, decoder->gamma, in[i]);
            }
        }
    }
}

void enc_decode_pixels(const enc_decoder *decoder, const enc_image *image, enc_rectangle area, float *out) {
    const size_t channels = (size_t)image->channels, width = (size_t)area.width;
    for (int row = 0; row < area.height; row++) {
        const size_t first = ((size_t)(area.y + row) * (size_t)image->width + (size_t)area.x) * channels;
        float *line = out + (size_t)row * width * 3;
        /* Grey is decoded to the last third of the line, and spread over the line from its beginning. */
        float *decoded = line + (3 - channels) * width;
        decode_row(decoder, image, first, width * channels, decoded);
        if (channels == 1) {
            for (size_t x = 0; x < width; x++) {
                line[3 * x] = line[3 * x + 1] = line[3 * x + 2] = decoded[x];
            }
        }
    }
}

void enc_xyz_to_rgb(float *pixels, size_t count) {
    /* The inverse of the matrix that IEC 61966-2-1's primaries and D65 = (0.3127, 0.3290) give. */
    for (size_t i = 0; i < count; i++) {
        float *p = pixels + 3 * i;
        const double x = p[0], y = p[1], z = p[2];
        p[0] = (float)(3.24096994190 * x - 1.53738317757 * y - 0.49861076029 * z);
        p[1] = (float)(-0.96924363628 * x + 1.87596750151 * y + 0.04155505741 * z);
        p[2] = (float)(0.05563007970 * x - 0.20397695889 * y + 1.05697151424 * z);
    }
}

void enc_flip_rows(float *pixels, int width, int height) {
    const size_t row = (size_t)width * 3;
    for (int top = 0, bottom = height - 1; top < bottom; top++, bottom--) {
        float *a = pixels + (size_t)top * row, *b = pixels + (size_t)bottom * row;
        for (size_t i = 0; i < row; i++) {
            const float t = a[i];
            a[i] = b[i];
            b[i] = t;
        }
    }
}

/* Resizes along one axis: element i of the output covers [i * n, (i + 1) * n) in units of 1 / out_n of an
 * input element. Elements lie `stride` floats apart, each of 3 channels; `lines` lines lie line_in and
 * line_out floats apart. */
static void resize_axis(const float *in, int n, size_t stride_in, size_t line_in, float *out, int out_n,
                        size_t stride_out, size_t line_out, int lines) {
    for (int i = 0; i < out_n; i++) {
        const long begin = (long)i * n, end = begin + n;
        for (int line = 0; line < lines; line++) {
            double sum[3] = {0.0, 0.0, 0.0};
            for (long s = begin / out_n; s * out_n < end; s++) {
                const long from = s * out_n > begin ? s * out_n : begin;
                const long to = (s + 1) * out_n < end ? (s + 1) * out_n : end;
                const float *p = in + (size_t)s * stride_in + (size_t)line * line_in;
                for (int c = 0; c < 3; c++) {
                    sum[c] += (double)(to - from) * p[c];
                }
            }
            float *p = out + (size_t)i * stride_out + (size_t)line * line_out;
            for (int c = 0; c < 3; c++) {
                p[c] = (float)(sum[c] / n);
            }
        }
    }
}

btf_result enc_resize_area(const float *in, int width, int height, float *out, int out_width,
                           int out_height) {
    float *narrow = malloc((size_t)out_width * (size_t)height * 3 * sizeof *narrow);
    if (!narrow) {
        return BTF_ERROR_MEMORY;
    }
    const size_t out_row = (size_t)out_width * 3;
    resize_axis(in, width, 3, (size_t)width * 3, narrow, out_width, 3, out_row, height);
    resize_axis(narrow, height, out_row, 3, out, out_height, out_row, 3, out_width);
    free(narrow);
    return BTF_OK;
}
