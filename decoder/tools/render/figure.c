/* Figure 13 of the paper.
 *
 * SPDX-License-Identifier: MIT
 */
#include "figure.h"

#include "decoder/toolkit/font.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

enum { GAP = 4, CAPTION = 2 * FONT_HEIGHT + 4 };

static const char *const names[FIGURE_COLUMNS] = {"original", "SBRDF", "STVS", "full"};

static float *pixel(const picture *p, int x, int y) {
    return p->rgb + 3 * ((size_t)y * (size_t)p->width + (size_t)x);
}

/* Draws a text in letters of twice the font's size where there is room, else of its size. */
static void draw_text(picture *out, int x, int y, int width, const char *text) {
    const int zoom = (int)strlen(text) * FONT_WIDTH * 2 <= width ? 2 : 1;
    for (int i = 0; text[i]; i++) {
        for (int v = 0; v < FONT_HEIGHT * zoom; v++) {
            for (int u = 0; u < FONT_WIDTH * zoom; u++) {
                int px = x + i * FONT_WIDTH * zoom + u;
                if (px < x + width && font_pixel(text[i], u / zoom, v / zoom)) {
                    for (int c = 0; c < 3; c++) {
                        pixel(out, px, y + v)[c] = 0;
                    }
                }
            }
        }
    }
}

static void draw_picture(picture *out, int x, int y, const picture *p, const picture *minus) {
    for (int v = 0; v < p->height; v++) {
        for (int u = 0; u < p->width; u++) {
            for (int c = 0; c < 3; c++) {
                float value = pixel(p, u, v)[c];
                if (minus) {
                    value = FIGURE_GAIN * fabsf(value - pixel(minus, u, v)[c]);
                }
                pixel(out, x + u, y + v)[c] = value;
            }
        }
    }
}

btf_result figure_write(const picture *pictures, const unsigned char *mask, const char *path, tone t,
                        btf_log log) {
    const int width = pictures[0].width, height = pictures[0].height, line = height + CAPTION + GAP;
    picture out;
    btf_result result = picture_create(FIGURE_COLUMNS * (width + GAP) - GAP, 2 * line - GAP, &out);
    if (result) {
        return result;
    }
    for (size_t i = 0; i < 3 * (size_t)out.width * (size_t)out.height; i++) {
        out.rgb[i] = 1;
    }
    for (int i = 0; i < FIGURE_COLUMNS; i++) {
        const int x = i * (width + GAP);
        char text[80];
        draw_picture(&out, x, CAPTION, &pictures[i], NULL);
        draw_text(&out, x, 2, width, names[i]);
        if (i == 0) {
            continue;
        }
        double linear = picture_psnr(&pictures[i], &pictures[0], mask, false);
        double srgb = picture_psnr(&pictures[i], &pictures[0], mask, true);
        draw_picture(&out, x, line + CAPTION, &pictures[i], &pictures[0]);
        snprintf(text, sizeof text, "error x%d, %.2f dB", FIGURE_GAIN, srgb);
        draw_text(&out, x, line + 2, width, text);
        printf("%s: psnr linear %.2f dB, srgb %.2f dB\n", names[i], linear, srgb);
    }
    result = picture_write(&out, path, t, log);
    picture_clear(&out);
    return result;
}
