/* Optical flow between two images of one light (see flow_pair.h).
 *
 * SPDX-License-Identifier: MIT
 */
#include "flow_pair.h"

#include "encoder/model/occlusion.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    FINEST_LEVEL = 0, /* patches on the image as handed over, not on half of it */
    PATCH_STRIDE = 5, /* pixels */
    DESCENT_STEPS = 12,
    SMOOTHING_ROUNDS = 0, /* gains nothing here and doubles the time */
};
static const float mean_grey = 100.0f; /* of 255: leaves room for highlights */
static const float black_mean = 1e-6f; /* mean luminance below which an image holds nothing */
static const float dark_floor = 1e-3f; /* of the mean: differences below it are noise */

static int padded(const enc_flow_worker *w, int texels) {
    return w->scale * (texels + 2 * w->padding);
}

btf_result enc_flow_worker_create(int width, int height, int padding, int scale,
                                  enc_flow_worker *out_worker) {
    enc_flow_worker w = {.width = width, .height = height, .padding = padding, .scale = scale};
    const size_t texels = (size_t)width * (size_t)height;
    const size_t pixels = (size_t)padded(&w, width) * (size_t)padded(&w, height);
    w.dis = enc_cv_flow_create();
    w.grey[0] = malloc(pixels);
    w.grey[1] = malloc(pixels);
    w.field = malloc(pixels * 2 * sizeof *w.field);
    w.back = malloc(texels * 2 * sizeof *w.back);
    w.plane = malloc(texels * sizeof *w.plane);
    w.tall = malloc((size_t)scale * texels * sizeof *w.tall);
    w.wide = malloc((size_t)(scale * scale) * texels * sizeof *w.wide);
    *out_worker = w;
    if (!w.dis || !w.grey[0] || !w.grey[1] || !w.field || !w.back || !w.plane || !w.tall || !w.wide) {
        return BTF_ERROR_MEMORY;
    }
    enc_cv_flow_tune(w.dis, FINEST_LEVEL, PATCH_STRIDE, DESCENT_STEPS, SMOOTHING_ROUNDS);
    return BTF_OK;
}

void enc_flow_worker_clear(enc_flow_worker *w) {
    enc_cv_flow_destroy(&w->dis);
    free(w->grey[0]);
    free(w->grey[1]);
    free(w->field);
    free(w->back);
    free(w->plane);
    free(w->tall);
    free(w->wide);
    *w = (enc_flow_worker){0};
}

void enc_flow_image_clear(enc_flow_image *image) {
    free(image->relative);
    free(image->root);
    *image = (enc_flow_image){0};
}

/* Cubic convolution (Keys 1981, a = -1/2) a quarter from a sample: pixel 2i lies 1/4 texel before texel i,
 * pixel 2i + 1 as much behind it. */
static const float cubic[4] = {-0.0703125f, 0.8671875f, 0.2265625f, -0.0234375f};

/* Doubles a periodic signal of n samples, `stride` apart, into `out`, whose samples lie as far apart. */
static void double_line(const float *in, int n, size_t stride, float *out) {
    for (int i = 0; i < n; i++) {
        const float a = in[(size_t)enc_occlusion_modulo(i - 2, n) * stride];
        const float b = in[(size_t)enc_occlusion_modulo(i - 1, n) * stride];
        const float c = in[(size_t)i * stride];
        const float d = in[(size_t)enc_occlusion_modulo(i + 1, n) * stride];
        const float e = in[(size_t)enc_occlusion_modulo(i + 2, n) * stride];
        out[(size_t)(2 * i) * stride] = cubic[3] * a + cubic[2] * b + cubic[1] * c + cubic[0] * d;
        out[(size_t)(2 * i + 1) * stride] = cubic[0] * b + cubic[1] * c + cubic[2] * d + cubic[3] * e;
    }
}

/* Enlarges plane[texel], width x height, and continues it on all sides: out[padded row][padded column]. */
static void make_grey(enc_flow_worker *w, int width, int height, const float *plane, unsigned char *out) {
    const int scale = w->scale, columns = padded(w, width), rows = padded(w, height);
    const float *image = plane;
    if (scale == 2) {
        for (int c = 0; c < width; c++) {
            double_line(plane + c, height, (size_t)width, w->tall + c);
        }
        for (int r = 0; r < 2 * height; r++) {
            double_line(w->tall + (size_t)r * (size_t)width, width, 1, w->wide + (size_t)(2 * r * width));
        }
        image = w->wide;
    }
    for (int r = 0; r < rows; r++) {
        const int from = enc_occlusion_modulo(r - scale * w->padding, scale * height);
        const float *row = image + (size_t)from * (size_t)(scale * width);
        unsigned char *to = out + (size_t)r * (size_t)columns;
        int c0 = enc_occlusion_modulo(-scale * w->padding, scale * width);
        for (int c = 0; c < columns; c++) {
            const float v = row[c0] + 0.5f;
            to[c] = (unsigned char)(v < 0 ? 0 : v > 255 ? 255 : v);
            c0 = c0 + 1 < scale * width ? c0 + 1 : 0;
        }
    }
}

/* Finds the canonical orientation of an image by its first moments about the middle. They are sums of whole
 * numbers, which do not depend on the order, so that a symmetric image stays as it is. */
static void find_orientation(int width, int height, enc_flow_image *image) {
    int64_t x = 0, y = 0;
    for (int r = 0; r < height; r++) {
        for (int c = 0; c < width; c++) {
            const int64_t v = llrintf(16 * image->root[(size_t)r * (size_t)width + (size_t)c]);
            x += v * (2 * c - (width - 1));
            y += v * (2 * r - (height - 1));
        }
    }
    image->flip_columns = x > 0;
    image->flip_rows = y > 0;
    image->transpose = llabs(y) > llabs(x);
}

btf_result enc_flow_image_create(int width, int height, const float *luminance, enc_flow_image *out_image) {
    const size_t texels = (size_t)width * (size_t)height;
    enc_flow_image image = {.relative = malloc(texels * sizeof(float)),
                            .root = malloc(texels * sizeof(float))};
    double sum = 0, root_sum = 0;
    if (image.relative && image.root) {
        for (size_t t = 0; t < texels; t++) {
            image.root[t] = sqrtf(luminance[t]);
            sum += luminance[t];
            root_sum += image.root[t];
        }
        image.black = sum < (double)black_mean * (double)texels;
        const float scale = image.black ? 0 : (float)((double)texels / sum);
        const float grey = image.black ? 0 : (float)((double)mean_grey * (double)texels / root_sum);
        for (size_t t = 0; t < texels; t++) {
            image.relative[t] = luminance[t] * scale;
            image.root[t] *= grey;
        }
        find_orientation(width, height, &image);
    }
    *out_image = image;
    return image.relative && image.root ? BTF_OK : BTF_ERROR_MEMORY;
}

/* Interpolates a periodic image bilinearly at (x, y) texels. */
static float sample_periodic(const float *image, int width, int height, float x, float y) {
    const float left = floorf(x), top = floorf(y);
    const int c = enc_occlusion_modulo((int)left, width), r = enc_occlusion_modulo((int)top, height);
    const int c1 = c + 1 < width ? c + 1 : 0, r1 = r + 1 < height ? r + 1 : 0;
    const float fx = x - left, fy = y - top;
    const float *upper = image + (size_t)r * (size_t)width, *lower = image + (size_t)r1 * (size_t)width;
    return (upper[c] + (upper[c1] - upper[c]) * fx) * (1 - fy) +
           (lower[c] + (lower[c1] - lower[c]) * fx) * fy;
}

/* The texel nearest to (c + x, r + y), wrapped. The shift is rounded and not the sum, which gives the
 * mirrored result for a mirrored pair. */
static size_t nearest_texel(const enc_flow_worker *w, int c, int r, float x, float y) {
    c = enc_occlusion_modulo(c + (int)lrintf(x), w->width);
    r = enc_occlusion_modulo(r + (int)lrintf(y), w->height);
    return (size_t)r * (size_t)w->width + (size_t)c;
}

/* Where column c and row r come to lie when an image is turned the way that brings `like` to its canonical
 * orientation. */
static void oriented(const enc_flow_worker *w, const enc_flow_image *like, int c, int r, int *out_c,
                     int *out_r) {
    c = like->flip_columns ? w->width - 1 - c : c;
    r = like->flip_rows ? w->height - 1 - r : r;
    *out_c = like->transpose ? r : c;
    *out_r = like->transpose ? c : r;
}

/* Warps an image by `prior` (or NULL), turns it as `like` and makes it ready for OpenCV. */
static void prepare_image(enc_flow_worker *w, const enc_flow_image *image, const float *prior,
                          const enc_flow_image *like, unsigned char *out) {
    const int width = like->transpose ? w->height : w->width;
    for (int r = 0; r < w->height; r++) {
        for (int c = 0; c < w->width; c++) {
            const size_t t = (size_t)r * (size_t)w->width + (size_t)c;
            int column, row;
            oriented(w, like, c, r, &column, &row);
            w->plane[(size_t)row * (size_t)width + (size_t)column] =
                !prior ? image->root[t]
                              : sample_periodic(image->root, w->width, w->height, (float)c + prior[2 * t],
                                                (float)r + prior[2 * t + 1]);
        }
    }
    make_grey(w, width, like->transpose ? w->width : w->height, w->plane, out);
}

/* Finds the flow from one image to another, starting from `prior` (or NULL), with both turned as `like`:
 * out[texel][2]. */
static btf_result flow_between(enc_flow_worker *w, const enc_flow_image *from, const enc_flow_image *to,
                               const float *prior, const enc_flow_image *like, float *out) {
    const int width = w->width, height = w->height, scale = w->scale;
    const int columns = padded(w, like->transpose ? height : width);
    const int rows = padded(w, like->transpose ? width : height);
    prepare_image(w, from, NULL, like, w->grey[0]);
    prepare_image(w, to, prior, like, w->grey[1]);
    if (enc_cv_flow_compute(w->dis, columns, rows, w->grey[0], w->grey[1], w->field) != 0) {
        return BTF_ERROR_INTERNAL;
    }
    const float share = 1.0f / (float)(scale * scale * scale); /* for the mean over a texel's pixels, in
                                                                  texels */
    for (int r = 0; r < height; r++) {
        for (int c = 0; c < width; c++) {
            int column, row;
            float sum[2] = {0, 0};
            oriented(w, like, c, r, &column, &row);
            for (int j = 0; j < scale; j++) {
                const float *at =
                    w->field + 2 * ((size_t)(scale * (row + w->padding) + j) * (size_t)columns +
                                    (size_t)(scale * (column + w->padding)));
                for (int i = 0; i < scale; i++) {
                    sum[0] += at[2 * i];
                    sum[1] += at[2 * i + 1];
                }
            }
            float x = share * sum[like->transpose], y = share * sum[!like->transpose];
            x = like->flip_columns ? -x : x;
            y = like->flip_rows ? -y : y;
            const size_t t = (size_t)r * (size_t)width + (size_t)c;
            if (prior) {
                const size_t p = nearest_texel(w, c, r, x, y);
                x += prior[2 * p];
                y += prior[2 * p + 1];
            }
            out[2 * t] = x;
            out[2 * t + 1] = y;
        }
    }
    return BTF_OK;
}

/* delta less the multiple of `size` nearest to it. */
static float wrapped(float delta, int size) {
    return delta - (float)size * floorf(delta / (float)size + 0.5f);
}

btf_result enc_flow_pair_compute(enc_flow_worker *w, const enc_flow_image *target,
                                 const enc_flow_image *top, const float *forward, const float *backward,
                                 float miss, float difference, float *out_flow, uint8_t *out_hidden) {
    const int width = w->width, height = w->height;
    const size_t texels = (size_t)width * (size_t)height;
    memset(out_flow, 0, texels * 2 * sizeof *out_flow);
    memset(out_hidden, 0, texels);
    if (target->black || top->black) {
        return BTF_OK;
    }
    btf_result result = flow_between(w, target, top, forward, target, out_flow);
    if (result == BTF_OK) {
        result = flow_between(w, top, target, backward, target, w->back);
    }
    if (result != BTF_OK) {
        return result;
    }
    for (int r = 0; r < height; r++) {
        for (int c = 0; c < width; c++) {
            const size_t t = (size_t)r * (size_t)width + (size_t)c;
            const float x = out_flow[2 * t], y = out_flow[2 * t + 1];
            const size_t arrival = nearest_texel(w, c, r, x, y);
            const float dx = wrapped(x + w->back[2 * arrival], width);
            const float dy = wrapped(y + w->back[2 * arrival + 1], height);
            const float a = target->relative[t];
            const float b = sample_periodic(top->relative, width, height, (float)c + x, (float)r + y);
            out_hidden[t] = dx * dx + dy * dy > miss * miss ||
                            fabsf(a - b) > difference * fmaxf(fmaxf(a, b), dark_floor);
        }
    }
    return BTF_OK;
}
