/* Clusters of hidden points (paper 2.3.3): shares of the views, k-means in each, centres as codes.
 *
 * SPDX-License-Identifier: MIT
 */
#include "cluster.h"

#include "cluster_split.h"
#include "encoder/base/ranks.h"
#include "encoder/base/stage.h"
#include "encoder/data/profiles.h"
#include "encoder/math/kmeans.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    MAX_CENTRES = 65536,
    DEFAULT_ITERATIONS = 30,
    MOST_POINTS = 4096, /* points that are clustered together at most; a view of up to 64x64 texels has no
                           more */
};

/* The view that gets the next centre: it has the largest fraction left of those that may have another;
 * n_views where none may. */
static size_t most_left(int n_views, const size_t *distinct, const size_t *shares, const double *left) {
    size_t best = (size_t)n_views;
    for (size_t v = 0; v < (size_t)n_views; v++) {
        if (shares[v] < distinct[v] && (best == (size_t)n_views || left[v] > left[best])) {
            best = v;
        }
    }
    return best;
}

/* Sum over views of clamp(factor * hidden, 1, distinct), views without hidden points left out. */
static double clamped_sum(int n_views, const size_t *hidden, const size_t *distinct, double factor) {
    double sum = 0;
    for (int v = 0; v < n_views; v++) {
        if (hidden[v] > 0) {
            sum += fmin(fmax(factor * (double)hidden[v], 1), (double)distinct[v]);
        }
    }
    return sum;
}

void enc_cluster_shares(int n_views, const size_t *hidden, const size_t *distinct, size_t k_total,
                        size_t *out_shares) {
    size_t all_hidden = 0, all_distinct = 0, active = 0;
    for (int v = 0; v < n_views; v++) {
        assert((hidden[v] > 0) == (distinct[v] > 0) && distinct[v] <= hidden[v]);
        all_hidden += hidden[v];
        all_distinct += distinct[v];
        active += hidden[v] > 0;
        out_shares[v] = 0;
    }
    const size_t k = k_total < all_distinct ? k_total : all_distinct;
    if (k == 0) {
        return;
    }
    double left[ENC_MAX_DIRECTIONS];
    assert(n_views <= ENC_MAX_DIRECTIONS);
    size_t dealt = 0;
    if (k < active) { /* one each, to the views with most hidden points */
        for (int v = 0; v < n_views; v++) {
            left[v] = (double)hidden[v];
        }
    } else {
        bool bound = false;
        for (int v = 0; v < n_views; v++) {
            const size_t whole = k * hidden[v] / all_hidden, rest = k * hidden[v] % all_hidden;
            out_shares[v] = whole;
            left[v] = (double)rest / (double)all_hidden;
            dealt += whole;
            bound = bound || (hidden[v] > 0 && (whole < 1 || whole + (rest > 0) > distinct[v]));
        }
        if (bound) { /* finds the factor with which the clamped shares add up to k, by bisection from below */
            double low = 0, high = (double)k;
            for (int i = 0; i < 200; i++) {
                const double middle = 0.5 * (low + high);
                if (clamped_sum(n_views, hidden, distinct, middle) <= (double)k) {
                    low = middle;
                } else {
                    high = middle;
                }
            }
            dealt = 0;
            for (int v = 0; v < n_views; v++) {
                const double share =
                    hidden[v] == 0 ? 0 : fmin(fmax(low * (double)hidden[v], 1), (double)distinct[v]);
                out_shares[v] = (size_t)share;
                left[v] = share - (double)out_shares[v];
                dealt += out_shares[v];
            }
        }
    }
    for (; dealt < k; dealt++) {
        const size_t v = most_left(n_views, distinct, out_shares, left);
        out_shares[v]++;
        left[v] -= 1 + (k < active ? (double)all_hidden : 0);
    }
}

/* Everything that the views share. */
typedef struct cluster_stage {
    const enc_context *context;
    const enc_data *data;
    enc_cluster_options options;
    enc_occlusion *occlusion;
    size_t n_texels, dimensions, stride;        /* of a row: [channel][light] */
    size_t *hidden, *distinct, *shares, *first; /* [view] */
    size_t k;
    float *centres; /* [k][stride] */
    uint64_t bytes; /* that the points of the fullest view take, sorted into parts */
} cluster_stage;

/* The hidden points of one view, in parts that are clustered apart. */
typedef struct view_points {
    size_t n, parts;
    size_t *first;   /* [parts + 1] */
    size_t *texels;  /* [n] */
    float *rows;     /* [n][stride], square root of radiance unless options.linear */
    uint32_t *index; /* [n] nearest centre, zeros */
} view_points;

static void points_free(view_points *p) {
    free(p->first);
    free(p->texels);
    free(p->rows);
    free(p->index);
}

/* Puts the points in the order of their parts. */
static btf_result sort_points(const cluster_stage *s, view_points *p) {
    size_t *order = malloc(p->n * sizeof *order), *texels = malloc(p->n * sizeof *texels);
    float *rows = malloc(p->n * s->stride * sizeof *rows);
    btf_result result = order && texels && rows ? BTF_OK : BTF_ERROR_MEMORY;
    if (result == BTF_OK) {
        result = enc_cluster_split(p->n, s->stride, p->rows, MOST_POINTS, order, p->first, &p->parts);
    }
    for (size_t i = 0; i < p->n && result == BTF_OK; i++) {
        texels[i] = p->texels[order[i]];
        memcpy(rows + i * s->stride, p->rows + order[i] * s->stride, s->stride * sizeof *rows);
    }
    free(order);
    if (result != BTF_OK) {
        free(texels);
        free(rows);
        return result;
    }
    free(p->texels);
    free(p->rows);
    p->texels = texels;
    p->rows = rows;
    return BTF_OK;
}

/* The first of a part's centres among those of the view; parts have centres in proportion to their
 * points. */
static size_t part_centre(const cluster_stage *s, int view, const view_points *p, size_t part) {
    return s->shares[view] * p->first[part] / p->n;
}

static btf_result points_of_view(const cluster_stage *s, int view, view_points *out) {
    const uint8_t *hidden = s->occlusion->hidden + (size_t)view * s->n_texels;
    view_points p = {.n = enc_occlusion_hidden_count(s->occlusion, view)};
    *out = p;
    if (p.n == 0) {
        return BTF_OK;
    }
    p.first = malloc((p.n / MOST_POINTS * 2 + 3) * sizeof *p.first);
    p.texels = malloc(p.n * sizeof *p.texels);
    p.rows = calloc(p.n * s->stride, sizeof *p.rows);
    p.index = calloc(p.n, sizeof *p.index);
    float *profiles = enc_profiles_create(p.n, s->data->n_lights);
    *out = p;
    if (!p.first || !p.texels || !p.rows || !p.index || !profiles) {
        free(profiles);
        return BTF_ERROR_MEMORY;
    }
    size_t n = 0;
    for (size_t t = 0; t < s->n_texels; t++) {
        if (hidden[t]) {
            p.texels[n++] = t;
        }
    }
    btf_result result = enc_profiles_of_texels(s->context, s->data, view, p.n, p.texels, profiles);
    const size_t n_lights = (size_t)s->data->n_lights, lanes = enc_profile_lanes(s->data->n_lights);
    for (size_t i = 0; result == BTF_OK && i < p.n; i++) {
        for (size_t c = 0; c < 3; c++) {
            for (size_t l = 0; l < n_lights; l++) {
                const float v = profiles[(i * 3 + c) * lanes + l];
                const float radiance = v > 0 ? v : 0;
                p.rows[i * s->stride + c * n_lights + l] = s->options.linear ? radiance : sqrtf(radiance);
            }
        }
    }
    free(profiles);
    if (result == BTF_OK && p.n > MOST_POINTS) {
        result = sort_points(s, &p);
    } else {
        p.parts = 1;
        p.first[0] = 0;
        p.first[1] = p.n;
    }
    *out = p;
    return result;
}

/* First pass: counts the hidden points of a view, and the different ones among them. */
static btf_result count_view(const cluster_stage *s, int view) {
    view_points points;
    btf_result result = points_of_view(s, view, &points);
    if (result == BTF_OK) {
        result = enc_kmeans_distinct(points.n, s->stride, points.rows, &s->distinct[view]);
    }
    s->hidden[view] = points.n;
    points_free(&points);
    return result;
}

/* Second pass: finds the view's centres, as floats. */
static btf_result find_centres(const cluster_stage *s, int view) {
    if (s->shares[view] == 0) {
        return BTF_OK;
    }
    view_points points;
    btf_result result = points_of_view(s, view, &points);
    for (size_t part = 0; result == BTF_OK && part < points.parts; part++) {
        const size_t begin = points.first[part], count = points.first[part + 1] - begin;
        const size_t centre = part_centre(s, view, &points, part);
        const size_t k = part_centre(s, view, &points, part + 1) - centre;
        if (k > 0) {
            result = enc_kmeans(count, s->stride, points.rows + begin * s->stride, k, s->options.iterations,
                                s->options.seed + (uint64_t)view, s->options.data_points,
                                s->centres + (s->first[view] + centre) * s->stride, points.index + begin);
        }
    }
    points_free(&points);
    return result;
}

/* Third pass: gives each point the nearest of its part's centres, as they will be stored. */
static btf_result choose_centres(const cluster_stage *s, int view) {
    view_points points;
    btf_result result = points_of_view(s, view, &points);
    for (size_t part = 0; result == BTF_OK && part < points.parts && points.n > 0; part++) {
        const size_t begin = points.first[part], end = points.first[part + 1];
        size_t first = part_centre(s, view, &points, part);
        size_t k = part_centre(s, view, &points, part + 1) - first;
        if (k == 0) { /* a part without centres takes those of the whole view, or of all views */
            first = 0;
            k = s->shares[view];
        }
        first += s->shares[view] > 0 ? s->first[view] : 0;
        memset(points.index + begin, 0, (end - begin) * sizeof *points.index);
        result =
            enc_kmeans_nearest(end - begin, s->stride, points.rows + begin * s->stride, k > 0 ? k : s->k,
                               s->centres + first * s->stride, points.index + begin, NULL, NULL);
        for (size_t i = begin; result == BTF_OK && i < end; i++) {
            s->occlusion->centre[(size_t)view * s->n_texels + points.texels[i]] =
                (uint16_t)(first + points.index[i]);
        }
    }
    points_free(&points);
    return result;
}

/* Runs a pass over the views of this rank. */
static btf_result for_each_view(const cluster_stage *s, btf_result (*pass)(const cluster_stage *, int)) {
    btf_result result = BTF_OK;
    const int threads = enc_memory_threads(s->context, s->bytes);
    size_t begin, end;
    enc_ranks_range(s->context, (size_t)s->data->n_views, &begin, &end);
#pragma omp parallel for num_threads(threads) schedule(dynamic, 1)
    for (int view = (int)begin; view < (int)end; view++) {
        btf_result mine = enc_cancelled(s->context) ? BTF_ERROR_INTERRUPTED : pass(s, view);
        enc_stage_step(s->context, 1);
        enc_keep_worse(&result, mine);
    }
    return result;
}

/* Hands the centres that each rank found for its views to all ranks. */
static btf_result share_centres(const cluster_stage *s, btf_result result) {
    const size_t size = (size_t)enc_ranks_count(s->context), views = (size_t)s->data->n_views;
    size_t *bounds = malloc((size + 1) * sizeof *bounds), first, end;
    if (!bounds) {
        return BTF_ERROR_MEMORY;
    }
    bounds[size] = s->k;
    for (size_t r = 0; r < size; r++) {
        enc_ranks_range_of(s->context, (int)r, views, &first, &end);
        bounds[r] = first < views ? s->first[first] : s->k;
    }
    result =
        enc_ranks_gather_bounds(s->context, result, s->centres, s->stride * sizeof *s->centres, bounds);
    free(bounds);
    return result;
}

/* Rounds the centres to codes, and sets them to what the codes mean. */
static btf_result make_codes(const cluster_stage *s, enc_centres *out) {
    const size_t n_lights = (size_t)s->data->n_lights;
    float most = 0;
    for (size_t i = 0; i < s->k * s->stride; i++) {
        most = fmaxf(most, s->centres[i]);
    }
    if (s->options.linear) {
        most = sqrtf(most);
    }
    out->scale = most > 0 ? fminf(fmaxf(most / 255.0f, 0x1p-24f), 0x1p24f) : 1.0f / 255.0f;
    out->k = (int)s->k;
    out->n_lights = s->data->n_lights;
    out->codes = malloc(s->k > 0 ? s->k * s->dimensions : 1);
    if (!out->codes) {
        return BTF_ERROR_MEMORY;
    }
    for (size_t j = 0; j < s->k; j++) {
        for (size_t c = 0; c < 3; c++) {
            for (size_t l = 0; l < n_lights; l++) {
                float *value = &s->centres[j * s->stride + c * n_lights + l];
                const float root = s->options.linear ? sqrtf(*value) : *value;
                const long code = lrintf(fminf(root / out->scale, 255.0f));
                out->codes[(j * n_lights + l) * 3 + c] = (uint8_t)code;
                const float stored = (float)code * out->scale;
                *value = s->options.linear ? stored * stored : stored;
            }
        }
    }
    return BTF_OK;
}

static btf_result cluster_views(cluster_stage *s, int k_total, enc_centres *centres) {
    const size_t views = (size_t)s->data->n_views;
    btf_result result = for_each_view(s, count_view);
    result = enc_ranks_gather(s->context, result, s->hidden, sizeof *s->hidden, views);
    result = enc_ranks_gather(s->context, result, s->distinct, sizeof *s->distinct, views);
    if (result != BTF_OK) {
        return result;
    }
    enc_cluster_shares(s->data->n_views, s->hidden, s->distinct, (size_t)k_total, s->shares);
    for (int v = 0; v < s->data->n_views; v++) {
        s->first[v] = s->k;
        s->k += s->shares[v];
    }
    s->centres = calloc(s->k > 0 ? s->k * s->stride : 1, sizeof *s->centres);
    if (!s->centres) {
        return BTF_ERROR_MEMORY;
    }
    result = share_centres(s, for_each_view(s, find_centres));
    if (result == BTF_OK) {
        result = make_codes(s, centres);
    }
    if (result == BTF_OK) {
        result = for_each_view(s, choose_centres);
    }
    return enc_ranks_gather(s->context, result, s->occlusion->centre,
                            s->n_texels * sizeof *s->occlusion->centre, views);
}

btf_result enc_cluster(const enc_context *context, const enc_data *data, const enc_cluster_options *options,
                       int k_total, enc_occlusion *occlusion, enc_centres **out_centres) {
    assert(context && data && occlusion && out_centres);
    assert(occlusion->n_texels == enc_data_texel_count(data) && occlusion->n_views == data->n_views);
    *out_centres = NULL;
    cluster_stage s = {.context = context, .data = data, .occlusion = occlusion};
    if (options) {
        s.options = *options;
    }
    if (s.options.iterations == 0) {
        s.options.iterations = DEFAULT_ITERATIONS;
    }
    if (s.options.seed == 0) {
        s.options.seed = 1;
    }
    const size_t hidden = enc_occlusion_hidden_count(occlusion, -1);
    if (k_total < 0 || k_total > MAX_CENTRES || (k_total == 0 && hidden > 0)) {
        return enc_fail(context, BTF_ERROR_USAGE,
                        "cluster: %d centres for %zu hidden points, expected 1..%d", k_total, hidden,
                        MAX_CENTRES);
    }
    if (s.options.iterations < 0) {
        return enc_fail(context, BTF_ERROR_USAGE,
                        "cluster: %d iterations, expected at least 0 (0: the default)",
                        s.options.iterations);
    }
    const size_t n_views = (size_t)data->n_views;
    s.n_texels = occlusion->n_texels;
    s.dimensions = 3 * (size_t)data->n_lights;
    s.stride = enc_kmeans_stride(s.dimensions);
    s.hidden = calloc(4 * n_views, sizeof *s.hidden);
    size_t most = 0;
    for (int v = 0; v < data->n_views; v++) {
        const size_t count = enc_occlusion_hidden_count(occlusion, v);
        most = count > most ? count : most;
    }
    s.bytes = (uint64_t)most * (2 * s.stride * sizeof(float) + 8 * sizeof(size_t)) +
              (data->samples ? 0 : 2 * (uint64_t)s.n_texels * s.dimensions * sizeof(float));
    enc_centres *centres = calloc(1, sizeof *centres);
    btf_result result = BTF_ERROR_MEMORY;
    if (s.hidden && centres) {
        s.distinct = s.hidden + n_views;
        s.shares = s.distinct + n_views;
        s.first = s.shares + n_views;
        memset(occlusion->centre, 0, n_views * s.n_texels * sizeof *occlusion->centre);
        size_t begin, end;
        enc_ranks_range(context, n_views, &begin, &end);
        enc_stage_begin(context, "cluster", 3 * (end - begin));
        result = cluster_views(&s, k_total, centres);
        enc_stage_end(context);
    }
    free(s.hidden);
    free(s.centres);
    if (result != BTF_OK) {
        enc_centres_destroy(&centres);
        if (result == BTF_ERROR_INTERRUPTED) {
            return result;
        }
        return enc_fail(context, result, "cluster: %zu hidden points: %s", hidden, btf_result_text(result));
    }
    *out_centres = centres;
    return BTF_OK;
}

void enc_centres_destroy(enc_centres **centres) {
    if (!centres || !*centres) {
        return;
    }
    free((*centres)->codes);
    free(*centres);
    *centres = NULL;
}
