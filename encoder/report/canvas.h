/* A picture put together from images and captions, written as PNG.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_CANVAS_H
#define OPENBTF_ENCODER_CANVAS_H

#include "encoder/base/context.h"

typedef struct enc_canvas {
    int width, height;
    unsigned char *rgb; /* [row][column][3], sRGB-coded */
} enc_canvas;

/* A white canvas. Errors: BTF_ERROR_MEMORY. */
btf_result enc_canvas_create(const enc_context *context, int width, int height, enc_canvas *out_canvas);
void enc_canvas_clear(enc_canvas *canvas);

/* Draws a width x height image at (x, y), each pixel as a zoom x zoom block; what lies outside is cut off.
 * `pixels` is [row][column][3], linear radiance. */
void enc_canvas_image(enc_canvas *canvas, int x, int y, int zoom, int width, int height,
                      const float *pixels);

/* Draws values that are shown as they are: 8-bit grey, no sRGB coding. */
void enc_canvas_codes(enc_canvas *canvas, int x, int y, int zoom, int width, int height,
                      const unsigned char *codes);

/* Letters of captions, in pixels: how far apart they begin, and how high capitals are. */
enum { ENC_CANVAS_LETTER_WIDTH = 12, ENC_CANVAS_LETTER_HEIGHT = 14 };

/* A caption in black whose base line starts at (x, y); what lies outside is cut off. */
void enc_canvas_text(enc_canvas *canvas, int x, int y, const char *format, ...)
    __attribute__((format(printf, 4, 5)));

/* Writes the canvas as a PNG file, which is whole or absent. Errors: BTF_ERROR_IO, BTF_ERROR_MEMORY. */
btf_result enc_canvas_write(const enc_context *context, const enc_canvas *canvas, const char *path);

#endif
