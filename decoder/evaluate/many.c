/* Many evaluations: neighbours in the list that share light, view and level go through the texels together.
 *
 * SPDX-License-Identifier: MIT
 */
#include "decoder/shape.h"
#include "exact.h"
#include "relief.h"
#include "source.h"

#include <stddef.h>
#include <string.h>

enum { CORNERS = 4 };

/* An evaluation's part of the points: count, from the first on, and their weights. */
typedef struct footprint {
    int first, count;
    float weight[CORNERS];
} footprint;

/* Evaluations that share light, view and level. */
typedef struct group {
    const btfi_level *level;
    btfi_way way; /* without relief at a level where it has ended */
    size_t first;
    int count;
    btfi_situation situation;
    int lists; /* of points: one for all views, or with relief one a view */
    btfi_points points[3];
    footprint prints[3][BTFI_MOST_POINTS];
    int32_t weights[BTFI_MOST_POINTS][3]; /* of views; with relief */
    btfi_sources sources[3];
} group;

/* Groups in progress at a time, so that the memory fetches for one while others are computed. */
enum { GROUPS = 4 };

/* Section 9, Texture coordinates. */
static uint32_t coordinate(float c, uint32_t size) {
    const uint32_t magnitude = btfi_bits(c) & 0x7FFFFFFFu;
    if (magnitude > 0x45800000u || magnitude < 0x00800000u) {
        return 0;
    }
    return ((uint32_t)btfi_floor(c * 0x1p18f) & 0x3FFFFu) * size;
}

static uint32_t steep(uint32_t weight) {
    const uint32_t twice = 2 * weight;
    return twice < 128 ? 0 : twice - 128 > 256 ? 256 : twice - 128;
}

/* The two texels around t on an axis, and their weights, of 256. */
static void neighbours(btf_filter filter, uint32_t t, uint32_t size, uint32_t out_texel[2],
                       uint32_t out_weight[2]) {
    const uint32_t start = t - (1u << 17) + (t < 1u << 17 ? size << 18 : 0), weight = start >> 10 & 255;
    out_texel[0] = start >> 18;
    out_texel[1] = out_texel[0] + 1 == size ? 0 : out_texel[0] + 1;
    out_weight[1] = filter == BTF_FILTER_STEEP ? steep(weight) : weight;
    out_weight[0] = 256 - out_weight[1];
}

/* Adds the texels that a filter blends at a point. */
static void add_footprint(const btfi_level *l, btf_filter filter, uint32_t tu, uint32_t tv,
                          btfi_points *points, footprint *out) {
    out->first = points->count;
    out->count = 0;
    if (filter == BTF_FILTER_TEXEL) {
        points->column[points->count] = tu >> 18;
        points->row[points->count++] = l->height - 1 - (tv >> 18);
        out->weight[out->count++] = 1.0f;
        return;
    }
    uint32_t column[2], row[2], weight_u[2], weight_v[2];
    neighbours(filter, tu, l->width, column, weight_u);
    neighbours(filter, tv, l->height, row, weight_v);
    for (int corner = 0; corner < CORNERS; corner++) {
        const int i = corner & 1, j = corner >> 1;
        const uint32_t product = weight_u[i] * weight_v[j];
        if (product == 0) {
            continue;
        }
        points->column[points->count] = column[i];
        points->row[points->count++] = l->height - 1 - row[j];
        out->weight[out->count++] = (float)product * 0x1p-16f;
    }
}

/* The sum over views, and the steps of section 9 after it; values[a] is that of view a. */
static void blend_views(const btf_evaluator *e, int count, const int32_t weights[3],
                        const float *const values[3], float out_rgb[3]) {
    for (int c = 0; c < 3; c++) {
        float sum = 0.0f;
        for (int a = 0; a < count; a++) {
            if (weights[a] > 0) {
                sum = sum + values[a][c] * ((float)weights[a] * 0x1p-12f);
            }
        }
        if (e->info.blend == BTF_BLEND_ROOTS) {
            const float root = btfi_keep_within(sum);
            sum = root * root;
        }
        out_rgb[c] = sum * e->info.radiance_scale;
    }
}

/* The arguments of an evaluation. */
typedef struct arguments {
    const btf_evaluations *of;
    size_t uv_step, light_step, view_step;
} arguments;

static int32_t level_of(const btf_evaluator *e, const arguments *in, size_t i) {
    const int32_t level = in->of->levels ? in->of->levels[i] : 0, last = (int32_t)e->info.levels - 1;
    return level < 0 ? 0 : level > last ? last : level;
}

/* Whether evaluation i may be done together with the one before. */
static bool joins(const btf_evaluator *e, const arguments *in, size_t i) {
    const float *light = in->of->lights + i * in->light_step, *view = in->of->views + i * in->view_step;
    return (in->light_step == 0 || memcmp(light, light - in->light_step, 3 * sizeof *light) == 0) &&
           (in->view_step == 0 || memcmp(view, view - in->view_step, 3 * sizeof *view) == 0) &&
           level_of(e, in, i) == level_of(e, in, i - 1);
}

/* Evaluations from `first` on that stand together. */
static int find_group(const btf_evaluator *e, const btfi_way *way, const arguments *in, size_t first) {
    const int most = BTFI_MOST_POINTS / (way->filter == BTF_FILTER_TEXEL ? 1 : CORNERS);
    int count = 1;
    while (count < most && first + (size_t)count < in->of->count && joins(e, in, first + (size_t)count)) {
        count++;
    }
    return count;
}

/* t of section 9, 18 bits below the texel. */
static void read_position(const arguments *in, size_t i, const btfi_level *l, uint32_t *out_tu,
                          uint32_t *out_tv) {
    if (in->of->uv) {
        const float *uv = in->of->uv + i * in->uv_step;
        *out_tu = coordinate(uv[0], l->width);
        *out_tv = coordinate(uv[1], l->height);
    } else {
        const uint32_t half = 1u << 17, *texel = in->of->texels + 2 * i;
        *out_tu = ((texel[0] % l->width) << 18) + half;
        *out_tv = ((l->height - 1 - texel[1] % l->height) << 18) + half;
    }
}

/* The points of a group; with relief each view's own. */
static void find_points(const btf_evaluator *e, const btfi_way *way, const arguments *in, group *g) {
    const bool relief = way->effects & BTF_EFFECT_RELIEF;
    btfi_slopes slopes;
    g->lists = relief ? g->situation.views.count : 1;
    for (int a = 0; a < g->lists; a++) {
        g->points[a].count = 0;
    }
    if (relief) {
        btfi_relief_slopes(e, &g->situation, &slopes);
    }
    for (int i = 0; i < g->count; i++) {
        uint32_t tu, tv;
        read_position(in, g->first + (size_t)i, g->level, &tu, &tv);
        if (!relief) {
            add_footprint(g->level, way->filter, tu, tv, &g->points[0], &g->prints[0][i]);
            continue;
        }
        const int32_t position[2] = {(int32_t)(tu >> 10), (int32_t)(tv >> 10)};
        int32_t positions[3][2];
        btfi_relief(e, g->level, &g->situation, &slopes, way->linear, position, positions, g->weights[i]);
        for (int a = 0; a < g->lists; a++) {
            add_footprint(g->level, way->filter, (uint32_t)positions[a][0] << 10,
                          (uint32_t)positions[a][1] << 10, &g->points[a], &g->prints[a][i]);
        }
    }
}

static void lists_of(const group *g, const btfi_points *out[3]) {
    for (int a = 0; a < 3; a++) {
        out[a] = &g->points[a < g->lists ? a : 0];
    }
}

/* Texels first, then views: without relief. */
static void blend_texels(const btf_evaluator *e, const group *g, float values[3][BTFI_MOST_POINTS][3],
                         float (*rgb)[3]) {
    for (int i = 0; i < g->count; i++) {
        const footprint *print = &g->prints[0][i];
        float sum[3] = {0.0f, 0.0f, 0.0f};
        for (int p = 0; p < print->count; p++) {
            const int at = print->first + p;
            float radiance[3];
            blend_views(e, g->situation.views.count, g->situation.views.weight,
                        (const float *const[3]){values[0][at], values[1][at], values[2][at]}, radiance);
            for (int c = 0; c < 3; c++) {
                sum[c] = sum[c] + radiance[c] * print->weight[p];
            }
        }
        memcpy(rgb[i], sum, sizeof sum);
    }
}

/* The texels of each view first, then views: with relief. */
static void blend_shifted(const btf_evaluator *e, const group *g, float values[3][BTFI_MOST_POINTS][3],
                          float (*rgb)[3]) {
    for (int i = 0; i < g->count; i++) {
        float sums[3][3] = {{0.0f}};
        for (int a = 0; a < g->lists; a++) {
            const footprint *print = &g->prints[a][i];
            for (int p = 0; p < print->count; p++) {
                for (int c = 0; c < 3; c++) {
                    sums[a][c] = sums[a][c] + values[a][print->first + p][c] * print->weight[p];
                }
            }
        }
        blend_views(e, g->lists, g->weights[i], (const float *const[3]){sums[0], sums[1], sums[2]}, rgb[i]);
    }
}

/* Begins the group from evaluation `first` on. Where nothing is to be seen it writes zeros and returns false. */
static bool begin_group(const btf_evaluator *e, const btfi_way *way, const arguments *in, size_t first,
                        group *g) {
    g->first = first;
    g->count = find_group(e, way, in, first);
    const int32_t level = level_of(e, in, first);
    g->level = &e->levels[level];
    g->way = *way;
    if (btfi_relief_has_ended(&e->info, (uint32_t)level)) {
        g->way.effects &= ~(uint32_t)BTF_EFFECT_RELIEF;
    }
    if (!btfi_look_up(e, &g->way, in->of->lights + first * in->light_step,
                      in->of->views + first * in->view_step, &g->situation)) {
        memset(in->of->rgb + 3 * first, 0, (size_t)g->count * 3 * sizeof(float));
        return false;
    }
    const btfi_points *points[3];
    find_points(e, &g->way, in, g);
    lists_of(g, points);
    btfi_await_points(e, g->level, &g->situation, points);
    return true;
}

static void end_group(const btf_evaluator *e, const arguments *in, const group *g) {
    float values[3][BTFI_MOST_POINTS][3], (*rgb)[3] = (float(*)[3])(in->of->rgb + 3 * g->first);
    btfi_view_values(e, g->level, &g->way, &g->situation, g->sources, values);
    if (g->way.effects & BTF_EFFECT_RELIEF) {
        blend_shifted(e, g, values, rgb);
    } else {
        blend_texels(e, g, values, rgb);
    }
}

static void evaluate(const btf_evaluator *e, const btfi_way *way, const arguments *in) {
    group groups[GROUPS];
    for (size_t first = 0; first < in->of->count;) {
        int begun = 0;
        while (begun < GROUPS && first < in->of->count) {
            group *g = &groups[begun];
            begun += begin_group(e, way, in, first, g);
            first += (size_t)g->count;
        }
        for (int i = 0; i < begun; i++) {
            const btfi_points *points[3];
            lists_of(&groups[i], points);
            btfi_find_sources(e, groups[i].level, &groups[i].way, &groups[i].situation, points,
                              groups[i].sources);
        }
        for (int i = 0; i < begun; i++) {
            end_group(e, in, &groups[i]);
        }
    }
}

static bool choose_way(const btf_evaluator *e, const btf_evaluate_options *options, btfi_way *out) {
    static const btf_evaluate_options everything = {.struct_size = sizeof everything};
    const btf_evaluate_options *o = options ? options : &everything;
    if (o->struct_size < sizeof *o || (uint32_t)o->interpolation > BTF_INTERPOLATION_NEAREST ||
        (uint32_t)o->filter > BTF_FILTER_STEEP) {
        return false;
    }
    *out = (btfi_way){.effects = e->info.effects & ~o->leave_out,
                      .components = e->info.components,
                      .linear = o->interpolation == BTF_INTERPOLATION_LINEAR,
                      .filter = o->filter};
    if (o->components != 0 && o->components < out->components) {
        out->components = o->components;
    }
    return true;
}

btf_result btf_evaluate_many(const btf_evaluator *e, const btf_evaluate_options *options,
                             const btf_evaluations *evaluations) {
    const btf_evaluations *of = evaluations;
    btfi_way way;
    if (!e || !of || of->struct_size < sizeof *of || !choose_way(e, options, &way) ||
        of->fixed & ~(uint32_t)(BTF_FIXED_VIEW | BTF_FIXED_LIGHT)) {
        return BTF_ERROR_USAGE;
    }
    if (of->count == 0) {
        return BTF_OK;
    }
    const size_t least =
        of->fixed == (BTF_FIXED_VIEW | BTF_FIXED_LIGHT) ? 2 : 3; /* so that no two overlap */
    if ((of->uv != NULL) == (of->texels != NULL) || !of->lights || !of->views || !of->rgb ||
        (of->stride && of->stride < least)) {
        return BTF_ERROR_USAGE;
    }
    const arguments in = {of, of->stride ? of->stride : 2,
                          of->fixed & BTF_FIXED_LIGHT ? 0
                          : of->stride                ? of->stride
                                                      : 3,
                          of->fixed & BTF_FIXED_VIEW ? 0
                          : of->stride               ? of->stride
                                                     : 3};
    if (!of->uv) {
        way.filter = BTF_FILTER_TEXEL;
    }
    evaluate(e, &way, &in);
    return BTF_OK;
}
