/* The picture a report comes with. See montage.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "montage.h"

#include "canvas.h"
#include "encoder/math/srgb.h"
#include "metrics.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

int enc_nearest_direction(const enc_direction *directions, int count, double theta, double phi) {
    const enc_direction wanted = enc_direction_from_angles(theta, phi);
    int best = 0;
    double best_dot = -2;
    for (int i = 0; i < count; i++) {
        double dot = 0;
        for (int axis = 0; axis < 3; axis++) {
            dot += (double)wanted.xyz[axis] * directions[i].xyz[axis];
        }
        if (dot > best_dot + 1e-9) {
            best_dot = dot;
            best = i;
        }
    }
    return best;
}

/* Pixels. A column is at least as wide as the longest title, of 9 letters. */
enum { GAP = 6, HEADER = ENC_CANVAS_LETTER_HEIGHT + 12, TITLE = 9 * ENC_CANVAS_LETTER_WIDTH, LABEL = 32 };

/* Writes the label of a row, which is its view. Returns the number of letters. */
static int row_label(const enc_data *shape, double theta, char text[LABEL], int *out_view) {
    *out_view = enc_nearest_direction(shape->views, shape->n_views, theta, 120);
    return snprintf(text, LABEL, "view %.4g,%.4g", shape->views[*out_view].theta,
                    shape->views[*out_view].phi);
}

/* Pixels to the left of the pictures, for the labels. */
static int margin_for(const enc_data *shape, int rings, const double *theta) {
    char text[LABEL];
    int letters = 0, view;
    for (int r = 0; r < rings; r++) {
        const int length = row_label(shape, theta[r], text, &view);
        letters = length > letters ? length : letters;
    }
    return letters * ENC_CANVAS_LETTER_WIDTH + 2 * GAP;
}

static int zoom_for(const enc_data *shape) {
    const int zoom = 160 / (shape->width > shape->height ? shape->width : shape->height);
    return zoom > 0 ? zoom : 1;
}

/* Draws ENC_ERROR_GAIN |a - b| of sRGB-coded values, [row][column][3]. */
static void draw_error(enc_canvas *canvas, int x, int y, int zoom, const enc_data *shape, const float *a,
                       const float *b, float *work) {
    const size_t samples = enc_data_texel_count(shape) * 3;
    for (size_t i = 0; i < samples; i++) {
        const float coded = fabsf(enc_srgb_encode(a[i]) - enc_srgb_encode(b[i])) * ENC_ERROR_GAIN;
        /* decoded, since enc_canvas_image codes what it draws */
        work[i] = coded <= 0.04045f ? coded / 12.92f : powf((coded + 0.055f) / 1.055f, 2.4f);
    }
    enc_canvas_image(canvas, x, y, zoom, shape->width, shape->height, work);
}

btf_result enc_montage_write(const enc_context *context, const enc_data *shape, int count,
                             const enc_montage_column *columns, const char *path) {
    double theta[ENC_MAX_DIRECTIONS];
    int ring_of[ENC_MAX_DIRECTIONS];
    const int rings = enc_rings(shape->views, shape->n_views, theta, ring_of);
    const int light = enc_nearest_direction(shape->lights, shape->n_lights, 45, 60);
    const int zoom = zoom_for(shape), cell_h = shape->height * zoom + GAP;
    const size_t image = enc_data_texel_count(shape) * 3, all = image * (size_t)shape->n_lights;
    const int margin = margin_for(shape, rings, theta);
    const int image_w = shape->width * zoom, cell_w = (image_w > TITLE ? image_w : TITLE) + GAP;
    float *original = malloc(all * sizeof *original), *other = malloc(all * sizeof *other);
    float *work = malloc(image * sizeof *work);
    enc_canvas canvas = {0};
    btf_result result =
        enc_canvas_create(context, margin + (count + 1) * cell_w, HEADER + rings * cell_h, &canvas);
    if (result == BTF_OK && (!original || !other || !work)) {
        result = BTF_ERROR_MEMORY;
    }
    for (int c = 0; result == BTF_OK && c < count; c++) {
        enc_canvas_text(&canvas, margin + c * cell_w, HEADER - 8, "%s", columns[c].title);
    }
    if (result == BTF_OK) {
        enc_canvas_text(&canvas, margin + count * cell_w, HEADER - 8, "error x %d", ENC_ERROR_GAIN);
    }
    for (int r = 0; result == BTF_OK && r < rings; r++) {
        const int y = HEADER + r * cell_h;
        char label[LABEL];
        int view;
        row_label(shape, theta[r], label, &view);
        enc_canvas_text(&canvas, GAP, y + (shape->height * zoom + ENC_CANVAS_LETTER_HEIGHT) / 2, "%s",
                        label);
        for (int c = 0; result == BTF_OK && c < count; c++) {
            float *pixels = c == 0 ? original : other;
            result = columns[c].images.view(columns[c].images.user, view, pixels);
            if (result == BTF_OK) {
                enc_canvas_image(&canvas, margin + c * cell_w, y, zoom, shape->width, shape->height,
                                 pixels + (size_t)light * image);
            }
        }
        if (result == BTF_OK) {
            draw_error(&canvas, margin + count * cell_w, y, zoom, shape, original + (size_t)light * image,
                       other + (size_t)light * image, work);
        }
    }
    if (result == BTF_OK) {
        result = enc_canvas_write(context, &canvas, path);
    }
    enc_canvas_clear(&canvas);
    free(work);
    free(other);
    free(original);
    return result == BTF_OK ? BTF_OK
                            : enc_fail(context, result, "%s: the picture was not drawn: %s", path,
                                       btf_result_text(result));
}
