/* A picture put together from images and captions. See canvas.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "canvas.h"

#include "decoder/toolkit/font.h"
#include "decoder/toolkit/png_image.h"
#include "encoder/math/srgb.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

btf_result enc_canvas_create(const enc_context *context, int width, int height, enc_canvas *out) {
    const size_t size = (size_t)width * (size_t)height * 3;
    *out = (enc_canvas){.width = width, .height = height, .rgb = malloc(size)};
    if (!out->rgb) {
        return enc_fail(context, BTF_ERROR_MEMORY, "out of memory for a picture of %d x %d", width, height);
    }
    memset(out->rgb, 255, size);
    return BTF_OK;
}

void enc_canvas_clear(enc_canvas *canvas) {
    free(canvas->rgb);
    *canvas = (enc_canvas){0};
}

static void block(enc_canvas *canvas, int x, int y, int zoom, const unsigned char colour[3]) {
    for (int row = y < 0 ? 0 : y; row < y + zoom && row < canvas->height; row++) {
        for (int column = x < 0 ? 0 : x; column < x + zoom && column < canvas->width; column++) {
            memcpy(canvas->rgb + 3 * ((size_t)row * (size_t)canvas->width + (size_t)column), colour, 3);
        }
    }
}

void enc_canvas_image(enc_canvas *canvas, int x, int y, int zoom, int width, int height,
                      const float *pixels) {
    for (int row = 0; row < height; row++) {
        for (int column = 0; column < width; column++) {
            const float *pixel = pixels + 3 * ((size_t)row * (size_t)width + (size_t)column);
            unsigned char colour[3];
            for (int channel = 0; channel < 3; channel++) {
                colour[channel] = (unsigned char)(enc_srgb_encode(pixel[channel]) * 255.0f + 0.5f);
            }
            block(canvas, x + column * zoom, y + row * zoom, zoom, colour);
        }
    }
}

void enc_canvas_codes(enc_canvas *canvas, int x, int y, int zoom, int width, int height,
                      const unsigned char *codes) {
    for (int row = 0; row < height; row++) {
        for (int column = 0; column < width; column++) {
            const unsigned char code = codes[(size_t)row * (size_t)width + (size_t)column];
            const unsigned char colour[3] = {code, code, code};
            block(canvas, x + column * zoom, y + row * zoom, zoom, colour);
        }
    }
}

static void letter(enc_canvas *canvas, int x, int y, char c) {
    static const unsigned char black[3] = {0, 0, 0};
    enum { ZOOM = ENC_CANVAS_LETTER_WIDTH / FONT_WIDTH };
    for (int v = 0; v < FONT_HEIGHT; v++) {
        for (int u = 0; u < FONT_WIDTH; u++) {
            if (font_pixel(c, u, v)) {
                block(canvas, x + u * ZOOM, y + v * ZOOM, ZOOM, black);
            }
        }
    }
}

void enc_canvas_text(enc_canvas *canvas, int x, int y, const char *format, ...) {
    char text[256];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    for (int i = 0; text[i]; i++) {
        letter(canvas, x + i * ENC_CANVAS_LETTER_WIDTH, y - ENC_CANVAS_LETTER_HEIGHT, text[i]);
    }
}

btf_result enc_canvas_write(const enc_context *context, const enc_canvas *canvas, const char *path) {
    return png_image_write8(path, canvas->width, canvas->height, canvas->rgb, context->log);
}
