/* Vote-based optical flow between the top view and every other view (paper 2.3.1).
 *
 * A pair of images is brought to square-root luminance of equal mean, doubled in size (DIS works on 8x8
 * patches, and relief is finer than that), continued periodically, and handed to OpenCV both ways.
 *
 * SPDX-License-Identifier: MIT
 */
#include "flow.h"

#include "opencv_bridge.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    SCALE = 2,          /* enlargement before the flow */
    MIN_PADDING = 16,   /* texels */
    FINEST_LEVEL = 0,   /* patches on the doubled image itself */
    PATCH_STRIDE = 5,   /* pixels */
    DESCENT_STEPS = 12, /* a patch */
    SMOOTHING_ROUNDS = 0,
};
static const float mean_grey = 100.0f; /* of 255: leaves room for highlights */
static const float black_mean = 1e-6f; /* mean luminance below which an image holds nothing */
static const float dark_floor = 1e-3f; /* of the mean: differences below it are noise */

/* One image made ready: luminance over its mean, and the padded grey image. */
typedef struct flow_image {
    float *relative;     /* [texel], mean 1 */
    unsigned char *grey; /* [padded row][padded column] */
    bool black;
} flow_image;

/* What one thread needs for pairs of one size. */
typedef struct flow_worker {
    int width, height, padding;
    int padded_width, padded_height;
    enc_cv_flow *dis;
    float *root;           /* [texel] */
    float *tall;           /* [SCALE * row][column] */
    float *forward, *back; /* [padded row][padded column][2] */
} flow_worker;

static enc_flow_options with_defaults(const enc_flow_options *given) {
    enc_flow_options o = {0};
    if (given != NULL)
        o = *given;
    if (o.hidden_threshold == 0)
        o.hidden_threshold = 0.7f;
    if (o.miss == 0)
        o.miss = 1.0f;
    if (o.difference == 0)
        o.difference = 0.35f;
    if (o.padding == 0)
        o.padding = MIN_PADDING;
    return o;
}

static btf_result check_options(const enc_context *context, const enc_flow_options *o) {
    if (!(o->hidden_threshold > 0 && o->hidden_threshold <= 1))
        return enc_fail(context, BTF_ERROR_USAGE, "flow: hidden threshold %g, expected 0..1",
                        (double)o->hidden_threshold);
    if (!(o->miss > 0) || !(o->difference > 0))
        return enc_fail(context, BTF_ERROR_USAGE, "flow: miss %g and difference %g must be positive",
                        (double)o->miss, (double)o->difference);
    if (o->padding < MIN_PADDING || o->padding > 4096)
        return enc_fail(context, BTF_ERROR_USAGE, "flow: padding %d, expected %d..4096", o->padding,
                        MIN_PADDING);
    if (o->lights < 0)
        return enc_fail(context, BTF_ERROR_USAGE, "flow: %d lights", o->lights);
    return BTF_OK;
}

static void worker_free(flow_worker *w) {
    enc_cv_flow_destroy(&w->dis);
    free(w->root);
    free(w->tall);
    free(w->forward);
    free(w->back);
}

static btf_result worker_make(int width, int height, int padding, flow_worker *out) {
    flow_worker w = {.width = width, .height = height, .padding = padding};
    w.padded_width = SCALE * (width + 2 * padding);
    w.padded_height = SCALE * (height + 2 * padding);
    const size_t texels = (size_t)width * (size_t)height;
    const size_t pixels = (size_t)w.padded_width * (size_t)w.padded_height;
    w.root = malloc(texels * sizeof *w.root);
    w.tall = malloc(SCALE * texels * sizeof *w.tall);
    w.forward = malloc(pixels * 2 * sizeof *w.forward);
    w.back = malloc(pixels * 2 * sizeof *w.back);
    w.dis = enc_cv_flow_create();
    *out = w;
    if (!w.root || !w.tall || !w.forward || !w.back || !w.dis)
        return BTF_ERROR_MEMORY;
    enc_cv_flow_tune(w.dis, FINEST_LEVEL, PATCH_STRIDE, DESCENT_STEPS, SMOOTHING_ROUNDS);
    return BTF_OK;
}

static void image_free(flow_image *image) {
    free(image->relative);
    free(image->grey);
    *image = (flow_image){0};
}

/* Cubic convolution (Keys 1981, a = -1/2) a quarter from a sample: pixel 2i lies 1/4 texel before texel i,
 * pixel 2i + 1 as much behind it. */
static const float cubic[4] = {-0.0703125f, 0.8671875f, 0.2265625f, -0.0234375f};

/* Doubles a periodic signal of n samples `stride` apart into out of the same stride. */
static void double_line(const float *in, int n, size_t stride, float *out) {
    for (int i = 0; i < n; i++) {
        const float a = in[(size_t)enc_occlusion_modulo(i - 2, n) * stride],
                    b = in[(size_t)enc_occlusion_modulo(i - 1, n) * stride];
        const float c = in[(size_t)i * stride], d = in[(size_t)enc_occlusion_modulo(i + 1, n) * stride];
        const float e = in[(size_t)enc_occlusion_modulo(i + 2, n) * stride];
        out[(size_t)(2 * i) * stride] = cubic[3] * a + cubic[2] * b + cubic[1] * c + cubic[0] * d;
        out[(size_t)(2 * i + 1) * stride] = cubic[0] * b + cubic[1] * c + cubic[2] * d + cubic[3] * e;
    }
}

static btf_result image_make(flow_worker *w, const float *luminance, flow_image *out) {
    const int width = w->width, height = w->height;
    const size_t texels = (size_t)width * (size_t)height;
    flow_image image = {0};
    image.relative = malloc(texels * sizeof *image.relative);
    image.grey = malloc((size_t)w->padded_width * (size_t)w->padded_height);
    float *wide = malloc(SCALE * SCALE * texels * sizeof *wide);
    *out = image;
    if (!image.relative || !image.grey || !wide) {
        free(wide);
        return BTF_ERROR_MEMORY;
    }
    double sum = 0, root_sum = 0;
    for (size_t t = 0; t < texels; t++) {
        w->root[t] = sqrtf(luminance[t]);
        sum += luminance[t];
        root_sum += w->root[t];
    }
    out->black = sum < black_mean * (double)texels;
    const float scale = out->black ? 0 : (float)((double)texels / sum);
    const float grey = out->black ? 0 : (float)(mean_grey * (double)texels / root_sum);
    for (size_t t = 0; t < texels; t++)
        image.relative[t] = luminance[t] * scale;

    for (int c = 0; c < width; c++)
        double_line(w->root + c, height, (size_t)width, w->tall + c);
    for (int r = 0; r < SCALE * height; r++)
        double_line(w->tall + (size_t)r * (size_t)width, width, 1,
                    wide + (size_t)r * SCALE * (size_t)width);
    for (int r = 0; r < w->padded_height; r++) {
        const float *row = wide + (size_t)enc_occlusion_modulo(r - SCALE * w->padding, SCALE * height) *
                                      SCALE * (size_t)width;
        unsigned char *to = image.grey + (size_t)r * (size_t)w->padded_width;
        for (int c = 0; c < w->padded_width; c++) {
            const float v = row[enc_occlusion_modulo(c - SCALE * w->padding, SCALE * width)] * grey + 0.5f;
            to[c] = (unsigned char)(v < 0 ? 0 : v > 255 ? 255 : v);
        }
    }
    free(wide);
    return BTF_OK;
}

/* Bilinear value of a field of vectors at (x, y) pixels, clamped to its edges. */
static void sample_flow(const float *field, int width, int height, float x, float y, float out[2]) {
    x = fminf(fmaxf(x, 0), (float)(width - 1));
    y = fminf(fmaxf(y, 0), (float)(height - 1));
    const int c = (int)x, r = (int)y;
    const int c1 = c + 1 < width ? c + 1 : c, r1 = r + 1 < height ? r + 1 : r;
    const float fx = x - (float)c, fy = y - (float)r;
    for (int k = 0; k < 2; k++) {
        const float a = field[2 * ((size_t)r * (size_t)width + (size_t)c) + (size_t)k];
        const float b = field[2 * ((size_t)r * (size_t)width + (size_t)c1) + (size_t)k];
        const float d = field[2 * ((size_t)r1 * (size_t)width + (size_t)c) + (size_t)k];
        const float e = field[2 * ((size_t)r1 * (size_t)width + (size_t)c1) + (size_t)k];
        out[k] = (a + (b - a) * fx) * (1 - fy) + (d + (e - d) * fx) * fy;
    }
}

/* Bilinear value of a periodic image at (x, y) texels. */
static float sample_periodic(const float *image, int width, int height, float x, float y) {
    const float left = floorf(x), top = floorf(y);
    const int c = enc_occlusion_modulo((int)left, width), r = enc_occlusion_modulo((int)top, height);
    const int c1 = c + 1 < width ? c + 1 : 0, r1 = r + 1 < height ? r + 1 : 0;
    const float fx = x - left, fy = y - top;
    const float *upper = image + (size_t)r * (size_t)width, *lower = image + (size_t)r1 * (size_t)width;
    return (upper[c] + (upper[c1] - upper[c]) * fx) * (1 - fy) +
           (lower[c] + (lower[c1] - lower[c]) * fx) * fy;
}

/* Flow and hidden map of one pair: see enc_flow_pair. */
static btf_result pair_compute(flow_worker *w, const flow_image *target, const flow_image *top,
                               const enc_flow_options *o, float *out_flow, uint8_t *out_hidden) {
    const int width = w->width, height = w->height;
    if (target->black || top->black) {
        memset(out_flow, 0, (size_t)width * (size_t)height * 2 * sizeof *out_flow);
        memset(out_hidden, 0, (size_t)width * (size_t)height);
        return BTF_OK;
    }
    if (enc_cv_flow_compute(w->dis, w->padded_width, w->padded_height, target->grey, top->grey,
                            w->forward) != 0 ||
        enc_cv_flow_compute(w->dis, w->padded_width, w->padded_height, top->grey, target->grey, w->back) !=
            0)
        return BTF_ERROR_INTERNAL;
    for (int r = 0; r < height; r++) {
        for (int c = 0; c < width; c++) {
            const size_t t = (size_t)r * (size_t)width + (size_t)c;
            float x = 0, y = 0; /* mean of the texel's pixels, in texels */
            for (int j = 0; j < SCALE; j++) {
                const float *at =
                    w->forward + 2 * ((size_t)(SCALE * (r + w->padding) + j) * (size_t)w->padded_width +
                                      (size_t)(SCALE * (c + w->padding)));
                for (int i = 0; i < SCALE; i++) {
                    x += at[2 * i];
                    y += at[2 * i + 1];
                }
            }
            x /= SCALE * SCALE * SCALE;
            y /= SCALE * SCALE * SCALE;
            out_flow[2 * t] = x;
            out_flow[2 * t + 1] = y;
            /* where the texel's centre arrives, in pixels of the padded image, and back again */
            float back[2];
            sample_flow(w->back, w->padded_width, w->padded_height,
                        ((float)(c + w->padding) + x + 0.5f) * SCALE - 0.5f,
                        ((float)(r + w->padding) + y + 0.5f) * SCALE - 0.5f, back);
            const float dx = x + back[0] / SCALE, dy = y + back[1] / SCALE;
            const float a = target->relative[t];
            const float b = sample_periodic(top->relative, width, height, (float)c + x, (float)r + y);
            out_hidden[t] = dx * dx + dy * dy > o->miss * o->miss ||
                            fabsf(a - b) > o->difference * fmaxf(fmaxf(a, b), dark_floor);
        }
    }
    return BTF_OK;
}

btf_result enc_flow_pair(const enc_context *context, int width, int height, const float *target,
                         const float *top, const enc_flow_options *options, float *out_flow,
                         uint8_t *out_hidden) {
    assert(width > 0 && height > 0 && target && top && out_flow && out_hidden);
    const enc_flow_options o = with_defaults(options);
    btf_result result = check_options(context, &o);
    if (result != BTF_OK)
        return result;
    flow_worker worker;
    flow_image images[2] = {{0}};
    result = worker_make(width, height, o.padding, &worker);
    if (result == BTF_OK)
        result = image_make(&worker, target, &images[0]);
    if (result == BTF_OK)
        result = image_make(&worker, top, &images[1]);
    if (result == BTF_OK)
        result = pair_compute(&worker, &images[0], &images[1], &o, out_flow, out_hidden);
    image_free(&images[0]);
    image_free(&images[1]);
    worker_free(&worker);
    if (result != BTF_OK)
        return enc_fail(context, result, "flow: a pair of %dx%d images: %s", width, height,
                        btf_result_text(result));
    return BTF_OK;
}

/* A wrapped shift of at most 127 texels. */
static int8_t whole_shift(float delta, int size) {
    const int n = enc_occlusion_wrap((int)lrintf(fminf(fmaxf(delta, -1e6f), 1e6f)), size);
    return (int8_t)(n < -127 ? -127 : n > 127 ? 127 : n);
}

/* The vector named most often among votes[n][2] whose `hidden` is at most `admitted`. seen[n][2] and
 * counts[n] are room for the distinct ones. */
static void majority(int n, const int8_t *votes, const uint8_t *hidden, int admitted, int8_t *seen,
                     int *counts, int8_t out[2]) {
    int distinct = 0, best = 0;
    out[0] = out[1] = 0;
    for (int i = 0; i < n; i++) {
        if (hidden[i] > admitted)
            continue;
        int k = 0;
        while (k < distinct && memcmp(seen + 2 * k, votes + 2 * i, 2) != 0)
            k++;
        if (k == distinct) {
            memcpy(seen + 2 * k, votes + 2 * i, 2);
            counts[distinct++] = 0;
        }
        counts[k]++;
    }
    for (int k = 0; k < distinct; k++) {
        if (counts[k] > best || (counts[k] == best && enc_occlusion_compare_shift(seen + 2 * k, out) < 0)) {
            best = counts[k];
            memcpy(out, seen + 2 * k, 2);
        }
    }
}

/* Everything that the views share. */
typedef struct flow_stage {
    const enc_context *context;
    const enc_data *data;
    enc_flow_options options;
    int n_voters;
    int *voters;     /* [n_voters] light indices */
    flow_image *top; /* [n_voters] */
    enc_occlusion *occlusion;
} flow_stage;

static void luminance_of(const float *rgb, size_t texels, float *out) {
    for (size_t t = 0; t < texels; t++) {
        const float y = enc_luminance(rgb[3 * t], rgb[3 * t + 1], rgb[3 * t + 2]);
        out[t] = y > 0 ? y : 0;
    }
}

/* Prepares the top view's images under the voters. */
static btf_result top_images(flow_stage *s) {
    const size_t texels = enc_data_texel_count(s->data);
    flow_worker worker;
    float *images = malloc((size_t)s->data->n_lights * texels * 3 * sizeof *images);
    float *luminance = malloc(texels * sizeof *luminance);
    btf_result result = worker_make(s->data->width, s->data->height, s->options.padding, &worker);
    if (result == BTF_OK && (!images || !luminance))
        result = BTF_ERROR_MEMORY;
    if (result == BTF_OK)
        result = enc_data_view(s->context, s->data, s->data->top_view, images);
    for (int i = 0; result == BTF_OK && i < s->n_voters; i++) {
        luminance_of(images + (size_t)s->voters[i] * texels * 3, texels, luminance);
        result = image_make(&worker, luminance, &s->top[i]);
    }
    free(images);
    free(luminance);
    worker_free(&worker);
    return result;
}

/* The vote of one view. */
static btf_result vote_view(const flow_stage *s, int view, flow_worker *w) {
    const size_t texels = enc_data_texel_count(s->data), n = (size_t)s->n_voters;
    float *images = malloc((size_t)s->data->n_lights * texels * 3 * sizeof *images);
    float *luminance = malloc(texels * sizeof *luminance);
    float *flow = malloc(texels * 2 * sizeof *flow);
    uint8_t *hidden_now = malloc(texels);
    uint8_t *hidden = malloc(texels * n);   /* [texel][voter] */
    int8_t *votes = malloc(texels * n * 2); /* [texel][voter][2] */
    int8_t *seen = malloc(n * 2);
    int *counts = malloc(n * sizeof *counts);
    btf_result result = BTF_ERROR_MEMORY;
    if (!images || !luminance || !flow || !hidden_now || !hidden || !votes || !seen || !counts)
        goto fail;
    result = enc_data_view(s->context, s->data, view, images);
    size_t voted = 0;
    for (size_t i = 0; result == BTF_OK && i < n; i++) {
        flow_image image = {0};
        if (enc_cancelled(s->context)) {
            result = BTF_ERROR_INTERRUPTED;
            break;
        }
        luminance_of(images + (size_t)s->voters[i] * texels * 3, texels, luminance);
        result = image_make(w, luminance, &image);
        if (result == BTF_OK && !image.black && !s->top[i].black) {
            result = pair_compute(w, &image, &s->top[i], &s->options, flow, hidden_now);
            for (size_t t = 0; t < texels; t++) {
                votes[2 * (t * n + voted)] = whole_shift(flow[2 * t], w->width);
                votes[2 * (t * n + voted) + 1] = whole_shift(flow[2 * t + 1], w->height);
                hidden[t * n + voted] = hidden_now[t];
            }
            voted++;
        }
        image_free(&image);
    }
    if (result != BTF_OK)
        goto fail;
    const size_t first = (size_t)view * texels;
    for (size_t t = 0; t < texels; t++) {
        size_t count = 0;
        for (size_t i = 0; i < voted; i++)
            count += hidden[t * n + i];
        const float ratio = voted == 0 ? 0 : (float)count / (float)voted;
        const uint8_t is_hidden = ratio > s->options.hidden_threshold;
        s->occlusion->ratio[first + t] = ratio;
        s->occlusion->hidden[first + t] = is_hidden;
        s->occlusion->hidden_voted[first + t] = is_hidden;
        majority((int)voted, votes + 2 * t * n, hidden + t * n, count == voted, seen, counts,
                 s->occlusion->shift + 2 * (first + t));
    }
fail:
    free(images);
    free(luminance);
    free(flow);
    free(hidden_now);
    free(hidden);
    free(votes);
    free(seen);
    free(counts);
    return result;
}

static btf_result vote_views(const flow_stage *s) {
    btf_result result = BTF_OK;
    enc_stage_begin(s->context, "flow", (size_t)s->data->n_views);
#pragma omp parallel num_threads(s->context->threads)
    {
        flow_worker worker;
        btf_result mine = worker_make(s->data->width, s->data->height, s->options.padding, &worker);
#pragma omp for schedule(dynamic, 1)
        for (int view = 0; view < s->data->n_views; view++) {
            if (mine == BTF_OK && view != s->data->top_view)
                mine = vote_view(s, view, &worker);
            enc_stage_step(s->context, 1);
        }
#pragma omp critical(enc_flow_result)
        if (mine > result)
            result = mine;
        worker_free(&worker);
    }
    enc_stage_end(s->context);
    return result;
}

btf_result enc_flow_vote(const enc_context *context, const enc_data *data, const enc_flow_options *options,
                         enc_occlusion **out_occlusion) {
    assert(context && data && out_occlusion);
    *out_occlusion = NULL;
    flow_stage s = {.context = context, .data = data, .options = with_defaults(options)};
    btf_result result = check_options(context, &s.options);
    if (result != BTF_OK)
        return result;
    s.n_voters =
        s.options.lights == 0 || s.options.lights > data->n_lights ? data->n_lights : s.options.lights;
    s.voters = malloc((size_t)s.n_voters * sizeof *s.voters);
    s.top = calloc((size_t)s.n_voters, sizeof *s.top);
    result = enc_occlusion_create(data->n_views, enc_data_texel_count(data), &s.occlusion);
    if (result == BTF_OK && (!s.voters || !s.top))
        result = BTF_ERROR_MEMORY;
    for (int i = 0; result == BTF_OK && i < s.n_voters; i++)
        s.voters[i] = (int)((int64_t)i * data->n_lights / s.n_voters);
    if (result == BTF_OK)
        result = top_images(&s);
    if (result == BTF_OK)
        result = vote_views(&s);
    for (int i = 0; s.top != NULL && i < s.n_voters; i++)
        image_free(&s.top[i]);
    free(s.top);
    free(s.voters);
    if (result != BTF_OK) {
        enc_occlusion_destroy(&s.occlusion);
        if (result == BTF_ERROR_INTERRUPTED)
            return result;
        return enc_fail(context, result, "flow of %d views, %dx%d: %s", data->n_views, data->width,
                        data->height, btf_result_text(result));
    }
    *out_occlusion = s.occlusion;
    return BTF_OK;
}

/* A wrapped difference. */
static double wrapped(double delta, int size) {
    return delta - size * floor(delta / size + 0.5);
}

int enc_flow_error(const enc_data *data, const enc_occlusion *occlusion, const float *truth,
                   const uint8_t *exclude, double least, enc_flow_ring *out_rings, int capacity) {
    const size_t texels = occlusion->n_texels;
    assert(texels == enc_data_texel_count(data) && occlusion->n_views == data->n_views);
    int n = 0;
    for (int first = 0, last; first < data->n_views; first = last) {
        enc_flow_ring ring = {.theta = data->views[first].theta};
        for (last = first; last < data->n_views && data->views[last].theta == ring.theta; last++) {
            for (size_t t = 0; t < texels; t++) {
                const size_t i = (size_t)last * texels + t;
                if (exclude != NULL && exclude[i])
                    continue;
                const double tx = truth[2 * i], ty = truth[2 * i + 1];
                const double length = hypot(wrapped(tx, data->width), wrapped(ty, data->height));
                const double error = hypot(wrapped(occlusion->shift[2 * i] - tx, data->width),
                                           wrapped(occlusion->shift[2 * i + 1] - ty, data->height));
                ring.points++;
                ring.error += error;
                ring.zero += length;
                if (length > least) {
                    ring.moved++;
                    ring.moved_hidden += occlusion->hidden_voted[i];
                    ring.moved_error += error;
                    ring.moved_zero += length;
                }
            }
        }
        ring.error /= ring.points > 0 ? (double)ring.points : 1;
        ring.zero /= ring.points > 0 ? (double)ring.points : 1;
        ring.moved_error /= ring.moved > 0 ? (double)ring.moved : 1;
        ring.moved_zero /= ring.moved > 0 ? (double)ring.moved : 1;
        if (n < capacity)
            out_rings[n] = ring;
        n++;
    }
    return n;
}
