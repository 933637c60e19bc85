/* Decodes pixels to linear Rec. 709 radiance, and resizes images.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_COLOUR_H
#define OPENBTF_ENCODER_COLOUR_H

#include "image.h"

/* How sample values code radiance. */
typedef enum enc_transfer {
    ENC_TRANSFER_AUTO = 0, /* as the file says; else sRGB for 8 and 16 bits, linear for floating point */
    ENC_TRANSFER_SRGB,     /* IEC 61966-2-1 */
    ENC_TRANSFER_LINEAR,
    ENC_TRANSFER_GAMMA, /* value^gamma */
    ENC_TRANSFER_BT709, /* the inverse of the camera's curve of ITU-R BT.709; no option asks for it, only
                           files do */
} enc_transfer;

/* The sRGB curve on [0, 1] and beyond; odd, so that negative values keep their sign. */
double enc_srgb_decode(double value);

/* A transfer function, with tables for integer samples. It does not change once made, so that all threads
 * share it. */
typedef struct enc_decoder enc_decoder;

/* gamma is used by ENC_TRANSFER_GAMMA alone (> 0). Returns NULL when out of memory. */
enc_decoder *enc_decoder_create(enc_transfer transfer, double gamma);
void enc_decoder_destroy(enc_decoder **decoder);

/* The transfer function, and its gamma, that an image of 8 or 16 bits says it has, sRGB where it says nothing. */
enc_transfer enc_transfer_of(const enc_image *image, double *out_gamma);

/* Whether a decoder has this transfer function. */
bool enc_decoder_is(const enc_decoder *decoder, enc_transfer transfer, double gamma);

/* A rectangle of an image: columns x .. x+width-1, rows y .. y+height-1 from the top. */
typedef struct enc_rectangle {
    int x, y, width, height;
} enc_rectangle;

/* Decodes a rectangle of an image to linear values: out[row][column][3]; grey is repeated. */
void enc_decode_pixels(const enc_decoder *decoder, const enc_image *image, enc_rectangle area, float *out);

/* CIE XYZ (white point D65, Y of white 1) to linear Rec. 709 RGB, in place; count pixels of 3 floats.
 * Colours outside the gamut come out with negative values. */
void enc_xyz_to_rgb(float *pixels, size_t count);

/* Mirrors out[row][column][3] top to bottom, in place. */
void enc_flip_rows(float *pixels, int width, int height);

/* Area filter: each pixel of out[out_height][out_width][3] is the mean of in[height][width][3] over the
 * area that it covers, partly covered pixels weighing what is covered. Exact for constants; whole factors
 * average blocks. Errors: BTF_ERROR_MEMORY. */
btf_result enc_resize_area(const float *in, int width, int height, float *out, int out_width,
                           int out_height);

#endif
