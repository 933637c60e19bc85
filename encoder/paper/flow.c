/* Vote-based optical flow between the top view and every other view (paper 2.3.1).
 *
 * SPDX-License-Identifier: MIT
 */
#include "flow.h"

#include "encoder/base/ranks.h"
#include "encoder/base/stage.h"
#include "flow_pair.h"
#include "flow_prior.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    MIN_PADDING = 16,
    PLAIN_SCALE = 2, /* without a first estimate images are doubled: DIS compares 8x8 patches, and relief is
                        finer than that */
    PRIOR_SCALE = 1, /* with an estimate little is left to find, and doubling gains nothing */
};

static enc_flow_options with_defaults(const enc_flow_options *given) {
    enc_flow_options o = {0};
    if (given) {
        o = *given;
    }
    if (o.hidden_threshold == 0) {
        o.hidden_threshold = 0.7f;
    }
    if (o.miss == 0) {
        o.miss = 1.0f;
    }
    if (o.difference == 0) {
        o.difference = 0.35f;
    }
    if (o.padding == 0) {
        o.padding = MIN_PADDING;
    }
    if (o.depth == 0) {
        o.depth = 0.15f;
    }
    if (o.rise == 0) {
        o.rise = 0.03f;
    }
    return o;
}

static btf_result check_options(const enc_context *context, const enc_flow_options *o) {
    if (!(o->hidden_threshold > 0 && o->hidden_threshold <= 1)) {
        return enc_fail(context, BTF_ERROR_USAGE, "flow: hidden threshold %g, expected 0..1",
                        (double)o->hidden_threshold);
    }
    if (!(o->miss > 0) || !(o->difference > 0)) {
        return enc_fail(context, BTF_ERROR_USAGE, "flow: miss %g and difference %g must be positive",
                        (double)o->miss, (double)o->difference);
    }
    if (o->padding < MIN_PADDING || o->padding > 4096) {
        return enc_fail(context, BTF_ERROR_USAGE, "flow: padding %d, expected %d..4096", o->padding,
                        MIN_PADDING);
    }
    if (!(o->depth > 0 && o->depth <= 16) || !(o->rise > 0 && o->rise <= 16)) {
        return enc_fail(context, BTF_ERROR_USAGE, "flow: depth %g and rise %g, expected 0..16 tiles",
                        (double)o->depth, (double)o->rise);
    }
    if (o->lights < 0) {
        return enc_fail(context, BTF_ERROR_USAGE, "flow: %d lights vote, expected at least 0", o->lights);
    }
    return BTF_OK;
}

btf_result enc_flow_pair(const enc_context *context, int width, int height, const float *target,
                         const float *top, const enc_flow_options *options, float *out_flow,
                         uint8_t *out_hidden) {
    assert(width > 0 && height > 0 && target && top && out_flow && out_hidden);
    const enc_flow_options o = with_defaults(options);
    btf_result result = check_options(context, &o);
    if (result != BTF_OK) {
        return result;
    }
    enc_flow_worker worker;
    enc_flow_image images[2] = {{0}};
    result = enc_flow_worker_create(width, height, o.padding, PLAIN_SCALE, &worker);
    if (result == BTF_OK) {
        result = enc_flow_image_create(width, height, target, &images[0]);
    }
    if (result == BTF_OK) {
        result = enc_flow_image_create(width, height, top, &images[1]);
    }
    if (result == BTF_OK) {
        result = enc_flow_pair_compute(&worker, &images[0], &images[1], NULL, NULL, o.miss, o.difference,
                                       out_flow, out_hidden);
    }
    enc_flow_image_clear(&images[0]);
    enc_flow_image_clear(&images[1]);
    enc_flow_worker_clear(&worker);
    if (result != BTF_OK) {
        return enc_fail(context, result, "flow: OpenCV failed on a pair of %dx%d images: %s", width, height,
                        btf_result_text(result));
    }
    return BTF_OK;
}

/* Rounds and wraps a shift, to at most 127 texels. */
static int8_t whole_shift(float delta, int size) {
    const int n = enc_occlusion_wrap((int)lrintf(fminf(fmaxf(delta, -1e6f), 1e6f)), size);
    return (int8_t)(n < -127 ? -127 : n > 127 ? 127 : n);
}

/* Finds the vector named most often among those of votes[n][2] whose `hidden` is at most `admitted`.
 * seen[n][2] and counts[n] have room for the different ones. */
static void majority(int n, const int8_t *votes, const uint8_t *hidden, int admitted, int8_t *seen,
                     int *counts, int8_t out[2]) {
    int distinct = 0, best = 0;
    out[0] = out[1] = 0;
    for (int i = 0; i < n; i++) {
        if (hidden[i] > admitted) {
            continue;
        }
        int k = 0;
        while (k < distinct && memcmp(seen + 2 * k, votes + 2 * i, 2) != 0) {
            k++;
        }
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

/* Chooses `count` of `total` indices, spread evenly. */
static void spread(int count, int total, int *out) {
    for (int i = 0; i < count; i++) {
        out[i] = (int)((int64_t)i * total / count);
    }
}

/* Everything that the views share. */
typedef struct flow_stage {
    const enc_context *context;
    const enc_data *data;
    enc_flow_options options;
    int n_voters, n_prior;
    int *voters;                /* [n_voters] light indices */
    int *prior;                 /* [n_prior] light indices */
    enc_flow_image *top;        /* [n_voters] */
    enc_flow_planes top_planes; /* under the lights of the first estimate */
    enc_occlusion *occlusion;
} flow_stage;

static void luminance_of(const float *rgb, size_t texels, float *out) {
    for (size_t t = 0; t < texels; t++) {
        const float y = enc_luminance(rgb[3 * t], rgb[3 * t + 1], rgb[3 * t + 2]);
        out[t] = y > 0 ? y : 0;
    }
}

static btf_result make_worker(const flow_stage *s, enc_flow_worker *out) {
    return enc_flow_worker_create(s->data->width, s->data->height, s->options.padding,
                                  s->options.plain ? PLAIN_SCALE : PRIOR_SCALE, out);
}

/* Prepares the top view's images. */
static btf_result top_images(flow_stage *s) {
    const size_t texels = enc_data_texel_count(s->data);
    float *images = malloc((size_t)s->data->n_lights * texels * 3 * sizeof *images);
    float *luminance = malloc(texels * sizeof *luminance);
    btf_result result = images && luminance ? BTF_OK : BTF_ERROR_MEMORY;
    if (result == BTF_OK) {
        result = enc_data_view(s->context, s->data, s->data->top_view, images);
    }
    for (int i = 0; result == BTF_OK && i < s->n_voters; i++) {
        luminance_of(images + (size_t)s->voters[i] * texels * 3, texels, luminance);
        result = enc_flow_image_create(s->data->width, s->data->height, luminance, &s->top[i]);
    }
    if (result == BTF_OK && !s->options.plain) {
        result = enc_flow_planes_create(s->data->width, s->data->height, images, s->n_prior, s->prior,
                                        &s->top_planes);
    }
    free(images);
    free(luminance);
    return result;
}

/* The images and flows of one view's vote. */
typedef struct view_vote {
    float *images;             /* [light][texel][3] */
    float *luminance;          /* [texel] */
    float *forward, *backward; /* [texel][2]: first estimate */
    float *flow;               /* [texel][2] */
    uint8_t *hidden_now;       /* [texel] */
    uint8_t *hidden;           /* [texel][voter] */
    int8_t *votes;             /* [texel][voter][2] */
    int8_t *seen;              /* [voter][2] */
    int *counts;               /* [voter] */
} view_vote;

static void vote_free(view_vote *v) {
    free(v->images);
    free(v->luminance);
    free(v->forward);
    free(v->backward);
    free(v->flow);
    free(v->hidden_now);
    free(v->hidden);
    free(v->votes);
    free(v->seen);
    free(v->counts);
}

static btf_result vote_make(const flow_stage *s, view_vote *out) {
    const size_t texels = enc_data_texel_count(s->data), n = (size_t)s->n_voters;
    *out = (view_vote){.images = malloc((size_t)s->data->n_lights * texels * 3 * sizeof(float)),
                       .luminance = malloc(texels * sizeof(float)),
                       .forward = malloc(texels * 2 * sizeof(float)),
                       .backward = malloc(texels * 2 * sizeof(float)),
                       .flow = malloc(texels * 2 * sizeof(float)),
                       .hidden_now = malloc(texels),
                       .hidden = malloc(texels * n),
                       .votes = malloc(texels * n * 2),
                       .seen = malloc(n * 2),
                       .counts = malloc(n * sizeof(int))};
    return out->images && out->luminance && out->forward && out->backward && out->flow && out->hidden_now &&
                   out->hidden && out->votes && out->seen && out->counts
               ? BTF_OK
               : BTF_ERROR_MEMORY;
}

static btf_result estimate(const flow_stage *s, int view, view_vote *v) {
    enc_flow_planes planes = {0};
    btf_result result =
        enc_flow_planes_create(s->data->width, s->data->height, v->images, s->n_prior, s->prior, &planes);
    if (result == BTF_OK) {
        result = enc_flow_prior(&planes, &s->top_planes, &s->data->views[view], s->options.depth,
                                s->options.rise, v->forward, v->backward);
    }
    enc_flow_planes_clear(&planes);
    return result;
}

/* Finds the flow of one view under every light that votes; *out_voted of these images were not black. */
static btf_result collect_votes(const flow_stage *s, enc_flow_worker *w, view_vote *v, size_t *out_voted) {
    const size_t texels = enc_data_texel_count(s->data), n = (size_t)s->n_voters;
    const float *forward = s->options.plain ? NULL : v->forward;
    const float *backward = s->options.plain ? NULL : v->backward;
    btf_result result = BTF_OK;
    size_t voted = 0;
    for (size_t i = 0; result == BTF_OK && i < n; i++) {
        enc_flow_image image = {0};
        if (enc_cancelled(s->context)) {
            return BTF_ERROR_INTERRUPTED;
        }
        luminance_of(v->images + (size_t)s->voters[i] * texels * 3, texels, v->luminance);
        result = enc_flow_image_create(w->width, w->height, v->luminance, &image);
        if (result == BTF_OK && !image.black && !s->top[i].black) {
            result = enc_flow_pair_compute(w, &image, &s->top[i], forward, backward, s->options.miss,
                                           s->options.difference, v->flow, v->hidden_now);
            for (size_t t = 0; t < texels; t++) {
                v->votes[2 * (t * n + voted)] = whole_shift(v->flow[2 * t], w->width);
                v->votes[2 * (t * n + voted) + 1] = whole_shift(v->flow[2 * t + 1], w->height);
                v->hidden[t * n + voted] = v->hidden_now[t];
            }
            voted++;
        }
        enc_flow_image_clear(&image);
    }
    *out_voted = voted;
    return result;
}

static void count_votes(const flow_stage *s, int view, const view_vote *v, size_t voted) {
    const size_t texels = enc_data_texel_count(s->data), n = (size_t)s->n_voters;
    const size_t first = (size_t)view * texels;
    for (size_t t = 0; t < texels; t++) {
        size_t count = 0;
        for (size_t i = 0; i < voted; i++) {
            count += v->hidden[t * n + i];
        }
        const float ratio = voted == 0 ? 0 : (float)count / (float)voted;
        const uint8_t is_hidden = ratio > s->options.hidden_threshold;
        s->occlusion->ratio[first + t] = ratio;
        s->occlusion->hidden[first + t] = is_hidden;
        s->occlusion->hidden_voted[first + t] = is_hidden;
        majority((int)voted, v->votes + 2 * t * n, v->hidden + t * n, count == voted, v->seen, v->counts,
                 s->occlusion->shift + 2 * (first + t));
    }
}

static btf_result vote_view(const flow_stage *s, int view, enc_flow_worker *w) {
    view_vote vote;
    size_t voted = 0;
    btf_result result = vote_make(s, &vote);
    if (result == BTF_OK) {
        result = enc_data_view(s->context, s->data, view, vote.images);
    }
    if (result == BTF_OK && !s->options.plain) {
        result = estimate(s, view, &vote);
    }
    if (result == BTF_OK) {
        result = collect_votes(s, w, &vote, &voted);
    }
    if (result == BTF_OK) {
        count_votes(s, view, &vote, voted);
    }
    vote_free(&vote);
    return result;
}

/* Hands all ranks the shifts that each has found for its views. */
static btf_result share(const flow_stage *s, btf_result result) {
    const size_t texels = enc_data_texel_count(s->data), views = (size_t)s->data->n_views;
    enc_occlusion *o = s->occlusion;
    result = enc_ranks_gather(s->context, result, o->shift, 2 * texels, views);
    result = enc_ranks_gather(s->context, result, o->hidden, texels, views);
    result = enc_ranks_gather(s->context, result, o->hidden_voted, texels, views);
    return enc_ranks_gather(s->context, result, o->ratio, texels * sizeof *o->ratio, views);
}

static btf_result vote_views(const flow_stage *s) {
    size_t begin, end;
    btf_result result = BTF_OK;
    const int width = s->data->width, height = s->data->height;
    const int threads =
        enc_memory_threads(s->context, enc_flow_bytes(enc_data_texel_count(s->data),
                                                      (uint64_t)(width > height ? width : height),
                                                      (uint64_t)s->data->n_lights));
    enc_ranks_range(s->context, (size_t)s->data->n_views, &begin, &end);
    enc_stage_begin(s->context, "flow", end - begin);
#pragma omp parallel num_threads(threads)
    {
        enc_flow_worker worker;
        btf_result mine = make_worker(s, &worker);
#pragma omp for schedule(dynamic, 1)
        for (int view = (int)begin; view < (int)end; view++) {
            if (mine == BTF_OK && view != s->data->top_view) {
                mine = vote_view(s, view, &worker);
            }
            enc_stage_step(s->context, 1);
        }
        enc_keep_worse(&result, mine);
        enc_flow_worker_clear(&worker);
    }
    result = share(s, result);
    enc_stage_end(s->context);
    return result;
}

btf_result enc_flow_vote(const enc_context *context, const enc_data *data, const enc_flow_options *options,
                         enc_occlusion **out_occlusion) {
    assert(context && data && out_occlusion);
    *out_occlusion = NULL;
    flow_stage s = {.context = context, .data = data, .options = with_defaults(options)};
    btf_result result = check_options(context, &s.options);
    if (result != BTF_OK) {
        return result;
    }
    const int n_lights = data->n_lights;
    s.n_voters = s.options.lights == 0 || s.options.lights > n_lights ? n_lights : s.options.lights;
    s.n_prior = n_lights < ENC_FLOW_PRIOR_LIGHTS ? n_lights : ENC_FLOW_PRIOR_LIGHTS;
    s.voters = malloc((size_t)s.n_voters * sizeof *s.voters);
    s.prior = malloc((size_t)s.n_prior * sizeof *s.prior);
    s.top = calloc((size_t)s.n_voters, sizeof *s.top);
    result = enc_occlusion_create(data->n_views, enc_data_texel_count(data), &s.occlusion);
    if (result == BTF_OK && (!s.voters || !s.prior || !s.top)) {
        result = BTF_ERROR_MEMORY;
    }
    if (result == BTF_OK) {
        spread(s.n_voters, n_lights, s.voters);
        spread(s.n_prior, n_lights, s.prior);
        result = top_images(&s);
    }
    if (result == BTF_OK) {
        result = vote_views(&s);
    }
    for (int i = 0; s.top && i < s.n_voters; i++) {
        enc_flow_image_clear(&s.top[i]);
    }
    enc_flow_planes_clear(&s.top_planes);
    free(s.top);
    free(s.voters);
    free(s.prior);
    if (result != BTF_OK) {
        enc_occlusion_destroy(&s.occlusion);
        if (result == BTF_ERROR_INTERRUPTED) {
            return result;
        }
        return enc_fail(context, result, "flow between the images of %d views, %dx%d texels: %s",
                        data->n_views, data->width, data->height, btf_result_text(result));
    }
    *out_occlusion = s.occlusion;
    return BTF_OK;
}

/* Wraps a difference over the tile, to the value nearest to 0. */
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
                if (exclude && exclude[i]) {
                    continue;
                }
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
        if (n < capacity) {
            out_rings[n] = ring;
        }
        n++;
    }
    return n;
}

uint64_t enc_flow_bytes(uint64_t texels, uint64_t side, uint64_t lights) {
    const uint64_t labels = side + 2 < ENC_FLOW_LABELS ? side + 2 : ENC_FLOW_LABELS;
    return texels * (12 * lights + ENC_FLOW_PRIOR_LIGHTS * 12 + 12 * labels + 3 * lights + 64);
}
