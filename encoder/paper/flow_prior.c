/* Shifts of one view from all lights at once (see flow_prior.h).
 *
 * SPDX-License-Identifier: MIT
 */
#include "flow_prior.h"

#include "encoder/model/occlusion.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* In units of the images, whose mean is 1; step and jump are P1 and P2 of Hirschmüller 2008, section 2.2.
 * With them the voted shifts of btf-sample bricks and of BRICKS64, whose true shifts are known, miss by
 * 1.09 and 0.75 texels at 30 degrees; which data they were set on is not recorded. */
static const float most_difference = 0.5f; /* beyond it, a sample is an outlier */
static const float step_penalty = 0.03f;   /* neighbours one step apart */
static const float jump_penalty = 0.2f;    /* neighbours further apart */
static const float equal_sums = 1e-5f; /* sums over paths that differ by less count as equal: nothing but
                                              rounding tells them apart */
static const float never = 1e9f;

static const float aside_gain = 0.9f; /* a line beside the view's own must lower the cost to this share */

enum {
    MAX_SHIFT = 127,
    MAX_ASIDE = 2,    /* texels by which the images of a view may lie beside their place, each way */
    ASIDE_LIGHTS = 5, /* lights by which that is found */
};

btf_result enc_flow_planes_create(int width, int height, const float *images, int n_chosen,
                                  const int *chosen, enc_flow_planes *out_planes) {
    const size_t texels = (size_t)width * (size_t)height;
    *out_planes = (enc_flow_planes){.width = width, .height = height, .n_lights = n_chosen};
    out_planes->values = malloc((size_t)n_chosen * 3 * texels * sizeof *out_planes->values);
    if (!out_planes->values) {
        return BTF_ERROR_MEMORY;
    }
    for (int i = 0; i < n_chosen; i++) {
        const float *image = images + (size_t)chosen[i] * texels * 3;
        float *planes = out_planes->values + (size_t)i * 3 * texels;
        double sum = 0;
        for (size_t t = 0; t < texels; t++) {
            for (size_t c = 0; c < 3; c++) {
                const float v = image[3 * t + c];
                planes[c * texels + t] = v > 0 ? sqrtf(v) : 0;
            }
            sum += enc_luminance(planes[t], planes[texels + t], planes[2 * texels + t]);
        }
        const float scale = sum > 1e-6 * (double)texels ? (float)((double)texels / sum) : 0;
        for (size_t k = 0; k < 3 * texels; k++) {
            planes[k] *= scale;
        }
    }
    return BTF_OK;
}

void enc_flow_planes_clear(enc_flow_planes *planes) {
    free(planes->values);
    planes->values = NULL;
}

/* The line on which one search looks for shifts: label j is the shift (first + j) * (columns, rows) + aside
 * * (-rows, columns). */
typedef struct shift_line {
    float columns, rows; /* one texel long */
    float aside;         /* texels */
    int first, count;
} shift_line;

static float line_column(const shift_line *line, float along) {
    return line->columns * along - line->rows * line->aside;
}

static float line_row(const shift_line *line, float along) {
    return line->rows * along + line->columns * line->aside;
}

/* The volumes of a search. A volume has count + 2 floats a texel, the outer two being room for `never`. */
typedef struct prior_work {
    int width, height;
    shift_line line;
    size_t depth;  /* count + 2 */
    float *cost;   /* [label][texel] */
    float *volume; /* [texel][depth]: cost */
    float *sum;    /* [texel][depth]: sum over paths */
    float *path;   /* [2][column][depth] */
    float *twice;  /* [row][2 * column]: one plane, repeated */
} prior_work;

static void work_free(prior_work *w) {
    free(w->cost);
    free(w->volume);
    free(w->sum);
    free(w->path);
    free(w->twice);
}

static btf_result work_make(int width, int height, const shift_line *line, prior_work *out) {
    const size_t texels = (size_t)width * (size_t)height, depth = (size_t)line->count + 2;
    *out = (prior_work){.width = width, .height = height, .line = *line, .depth = depth};
    out->cost = malloc(texels * (size_t)line->count * sizeof(float));
    out->volume = malloc(texels * depth * sizeof(float));
    out->sum = malloc(texels * depth * sizeof(float));
    out->path = malloc(2 * (size_t)width * depth * sizeof(float));
    out->twice = malloc(2 * texels * sizeof(float));
    return out->cost && out->volume && out->sum && out->path && out->twice ? BTF_OK : BTF_ERROR_MEMORY;
}

/* Adds |from(x) - to(x + shift)|, bilinear, to the cost of every label and texel. */
static void add_plane(const prior_work *w, const float *from, const float *to) {
    const size_t width = (size_t)w->width, height = (size_t)w->height;
    for (size_t r = 0; r < height; r++) {
        memcpy(w->twice + 2 * r * width, to + r * width, width * sizeof(float));
        memcpy(w->twice + (2 * r + 1) * width, to + r * width, width * sizeof(float));
    }
    for (int j = 0; j < w->line.count; j++) {
        const float x = line_column(&w->line, (float)(w->line.first + j));
        const float y = line_row(&w->line, (float)(w->line.first + j));
        const float left = floorf(x), top = floorf(y), fx = x - left, fy = y - top;
        const float w00 = (1 - fx) * (1 - fy), w01 = fx * (1 - fy), w10 = (1 - fx) * fy, w11 = fx * fy;
        const size_t c0 = (size_t)enc_occlusion_modulo((int)left, w->width), c1 = (c0 + 1) % width;
        for (size_t r = 0; r < height; r++) {
            const size_t r0 = (size_t)enc_occlusion_modulo((int)r + (int)top, w->height),
                         r1 = (r0 + 1) % height;
            const float *a = from + r * width;
            const float *b00 = w->twice + 2 * r0 * width + c0, *b01 = w->twice + 2 * r0 * width + c1;
            const float *b10 = w->twice + 2 * r1 * width + c0, *b11 = w->twice + 2 * r1 * width + c1;
            float *cost = w->cost + ((size_t)j * height + r) * width;
#pragma omp simd
            for (size_t c = 0; c < width; c++) {
                const float b = w00 * b00[c] + w01 * b01[c] + w10 * b10[c] + w11 * b11[c];
                const float d = a[c] > b ? a[c] - b : b - a[c];
                cost[c] += d < most_difference ? d : most_difference;
            }
        }
    }
}

/* One step of a path: the least cost of reaching each label of a texel from its predecessor's. Arrays have
 * `never` before and behind their `count` labels. */
static void path_step(int count, const float *cost, const float *before, float *path) {
    float least = never;
    for (int j = 1; j <= count; j++) {
        least = before[j] < least ? before[j] : least;
    }
    for (int j = 1; j <= count; j++) {
        const float lower = before[j - 1] + step_penalty, upper = before[j + 1] + step_penalty;
        float reach = least + jump_penalty;
        reach = before[j] < reach ? before[j] : reach;
        reach = lower < reach ? lower : reach;
        reach = upper < reach ? upper : reach;
        path[j] = cost[j] + reach - least;
    }
    path[0] = path[count + 1] = never;
}

static void add_path(int count, const float *path, float *sum) {
    for (int j = 1; j <= count; j++) {
        sum[j] += path[j];
    }
}

/* The four straight paths to every texel. Each runs twice around the tile: the first round only finds out
 * what comes before the first texel. */
static void add_paths(const prior_work *w) {
    const int count = w->line.count, width = w->width, height = w->height;
    const size_t depth = w->depth, line = (size_t)width * depth;
    for (int backwards = 0; backwards < 2; backwards++) {
        for (int r = 0; r < height; r++) {
            float *path[2] = {w->path, w->path + depth};
            memset(path[1], 0, depth * sizeof(float));
            path[1][0] = path[1][count + 1] = never;
            for (int i = 0; i < 2 * width; i++) {
                const int c = backwards ? width - 1 - i % width : i % width;
                const size_t t = (size_t)r * (size_t)width + (size_t)c;
                path_step(count, w->volume + t * depth, path[(i + 1) & 1], path[i & 1]);
                if (i >= width) {
                    add_path(count, path[i & 1], w->sum + t * depth);
                }
            }
        }
        float *rows[2] = {w->path, w->path + line};
        memset(rows[1], 0, line * sizeof(float));
        for (int c = 0; c < width; c++) {
            rows[1][(size_t)c * depth] = rows[1][(size_t)c * depth + (size_t)count + 1] = never;
        }
        for (int i = 0; i < 2 * height; i++) {
            const int r = backwards ? height - 1 - i % height : i % height;
            for (int c = 0; c < width; c++) {
                const size_t t = (size_t)r * (size_t)width + (size_t)c, at = (size_t)c * depth;
                path_step(count, w->volume + t * depth, rows[(i + 1) & 1] + at, rows[i & 1] + at);
                if (i >= height) {
                    add_path(count, rows[i & 1] + at, w->sum + t * depth);
                }
            }
        }
    }
}

/* The label of least sum, the smallest shift among those that rounding may have set apart, moved by up to
 * half a label by a parabola. */
static float best_shift(const prior_work *w, const float *sum) {
    float least = sum[1];
    for (int j = 2; j <= w->line.count; j++) {
        least = fminf(least, sum[j]);
    }
    int best = 0;
    for (int j = 1; j <= w->line.count; j++) {
        if (sum[j] <= least + equal_sums &&
            (best == 0 || abs(w->line.first + j - 1) < abs(w->line.first + best - 1))) {
            best = j;
        }
    }
    float fraction = 0;
    if (best > 1 && best < w->line.count) {
        const float bend = sum[best - 1] + sum[best + 1] - 2 * sum[best];
        if (bend > equal_sums) {
            fraction = 0.5f * (sum[best - 1] - sum[best + 1]) / bend;
        }
    }
    return (float)(w->line.first + best - 1) + fraction;
}

static btf_result search(const enc_flow_planes *from, const enc_flow_planes *to, const shift_line *line,
                         float *out_shift) {
    const size_t texels = (size_t)from->width * (size_t)from->height;
    const size_t planes = 3 * (size_t)from->n_lights, count = (size_t)line->count;
    prior_work w;
    const btf_result result = work_make(from->width, from->height, line, &w);
    if (result == BTF_OK) {
        memset(w.cost, 0, texels * count * sizeof *w.cost);
        for (size_t k = 0; k < planes; k++) {
            add_plane(&w, from->values + k * texels, to->values + k * texels);
        }
        const float scale = 1.0f / (float)planes;
        memset(w.sum, 0, texels * w.depth * sizeof *w.sum);
        for (size_t j = 0; j < count; j++) {
            for (size_t t = 0; t < texels; t++) {
                w.volume[t * w.depth + j + 1] = w.cost[j * texels + t] * scale;
            }
        }
        add_paths(&w);
        for (size_t t = 0; t < texels; t++) {
            const float shift = best_shift(&w, w.sum + t * w.depth);
            out_shift[2 * t] = line_column(line, shift);
            out_shift[2 * t + 1] = line_row(line, shift);
        }
    }
    work_free(&w);
    return result;
}

/* Finds how well a line explains the view: the sum over texels of the least cost of any label, by a few
 * lights. */
static btf_result line_cost(const enc_flow_planes *from, const enc_flow_planes *to, const shift_line *line,
                            double *out_cost) {
    const size_t texels = (size_t)from->width * (size_t)from->height, count = (size_t)line->count;
    prior_work w;
    const btf_result result = work_make(from->width, from->height, line, &w);
    *out_cost = 0;
    if (result == BTF_OK) {
        const int lights = from->n_lights < ASIDE_LIGHTS ? from->n_lights : ASIDE_LIGHTS;
        memset(w.cost, 0, texels * count * sizeof *w.cost);
        for (int i = 0; i < lights; i++) {
            const size_t green = 3 * (size_t)(i * from->n_lights / lights) + 1;
            add_plane(&w, from->values + green * texels, to->values + green * texels);
        }
        for (size_t t = 0; t < texels; t++) {
            float least = never;
            for (size_t j = 0; j < count; j++) {
                least = fminf(least, w.cost[j * texels + t]);
            }
            *out_cost += (double)least;
        }
    }
    work_free(&w);
    return result;
}

/* Moves the line aside if it then explains the view clearly better: measured images may lie a little beside
 * their place, and points then off their line. */
static btf_result move_line(const enc_flow_planes *target, const enc_flow_planes *top, shift_line *line) {
    double centred = 0, least = 0;
    float best = 0;
    for (int i = 0; i <= 2 * MAX_ASIDE; i++) {
        const int aside = i % 2 == 0 ? i / 2 : -(i + 1) / 2; /* 0, -1, 1, -2, 2 */
        shift_line moved = *line;
        moved.aside = (float)aside;
        double cost;
        const btf_result result = line_cost(target, top, &moved, &cost);
        if (result != BTF_OK) {
            return result;
        }
        if (i == 0) {
            centred = cost;
        }
        if (i == 0 || cost < least) {
            least = cost;
            best = moved.aside;
        }
    }
    if (least < (double)aside_gain * centred - (double)equal_sums * target->width * target->height) {
        line->aside = best;
    }
    return BTF_OK;
}

static int capped(float texels, int most) {
    return texels < (float)most ? (int)ceilf(texels) : most;
}

btf_result enc_flow_prior(const enc_flow_planes *target, const enc_flow_planes *top,
                          const enc_direction *view, float depth, float rise, float *out_forward,
                          float *out_backward) {
    const int side = target->width > target->height ? target->width : target->height;
    const int most = (side - 1) / 2 < MAX_SHIFT ? (side - 1) / 2 : MAX_SHIFT;
    const float across = hypotf(view->xyz[0], view->xyz[1]);
    const float per_height = across / fmaxf(view->xyz[2], 1e-3f) * (float)side;
    /* rows run against y; a point below the plane moves against the view's azimuth */
    shift_line line = {.columns = across > 0 ? -view->xyz[0] / across : 0,
                       .rows = across > 0 ? view->xyz[1] / across : 0};
    line.first = -capped(rise * per_height, most);
    line.count = capped(depth * per_height, most) - line.first + 1;
    btf_result result = across > 0 ? move_line(target, top, &line) : BTF_OK;
    if (result == BTF_OK) {
        result = search(target, top, &line, out_forward);
    }
    line.columns = -line.columns;
    line.rows = -line.rows;
    if (result == BTF_OK) {
        result = search(top, target, &line, out_backward);
    }
    return result;
}
