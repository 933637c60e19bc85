/* Tables of light sampling (decoder/SAMPLING.md).
 *
 * SPDX-License-Identifier: MIT
 */
#include "decoder/result.h"

#include <openbtf/sampling.h>

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#define PI 3.14159265358979323846

/* Texels whose mean stands for the material, and the most evaluations that these may take in all. */
enum { MOST_TEXELS = 64, MOST_EVALUATIONS = 1 << 22, PLANE = 8192 };

/* Shares of the cosine that are tried. The least of them bounds the harm: where a light stands in a place that the
 * material reflects little from, the mean square is at most 1 / share times that of the cosine alone. */
enum { SHARES = 9 };
static const double least_share = 10.0 / 11;

/* The least area of all triangles, in a disc of area pi: below it the lights lie on a line but for
 * rounding. */
static const double least_area = 1.0 / 64;

/* Columns and rows of texels spread over the material (the R2 sequence of M. Roberts, 2018). */
static size_t choose_texels(const btf_material_info *info, uint32_t out[MOST_TEXELS][2]) {
    const size_t texels = (size_t)info->width * info->height,
                 pairs = (size_t)info->n_views * info->n_lights;
    size_t count = MOST_EVALUATIONS / pairs < MOST_TEXELS ? MOST_EVALUATIONS / pairs : MOST_TEXELS;
    count = count > texels ? texels : count;
    count = count < 1 ? 1 : count;
    for (size_t i = 0; i < count; i++) {
        if (count == texels) {
            out[i][0] = (uint32_t)(i % info->width);
            out[i][1] = (uint32_t)(i / info->width);
            continue;
        }
        const double x = 0.5 + 0.7548776662466927 * (double)i, y = 0.5 + 0.5698402909980532 * (double)i;
        out[i][0] = (uint32_t)((x - floor(x)) * info->width);
        out[i][1] = (uint32_t)((y - floor(y)) * info->height);
    }
    return count;
}

/* Mean luminance over the texels under each light, seen from a view. */
static void measure(const btf_evaluator *evaluator, const btf_directions *lights, const float *view,
                    uint32_t (*texels)[2], size_t count, double *out) {
    float rgb[MOST_TEXELS][3];
    btf_evaluations of = {.struct_size = sizeof of,
                          .count = count,
                          .texels = texels[0],
                          .views = view,
                          .fixed = BTF_FIXED_LIGHT | BTF_FIXED_VIEW,
                          .rgb = rgb[0]};
    for (uint32_t l = 0; l < lights->count; l++) {
        double sum = 0;
        of.lights = lights->xyz + 3 * (size_t)l;
        btf_evaluate_many(evaluator, NULL, &of);
        for (size_t i = 0; i < count; i++) {
            sum += 0.2126 * (double)rgb[i][0] + 0.7152 * (double)rgb[i][1] + 0.0722 * (double)rgb[i][2];
        }
        out[l] = sum / (double)count;
    }
}

/* Twice the area of a triangle in the plane of radius 1. */
static double twice_area(const btf_directions *lights, const uint16_t *triangle) {
    const uint16_t *a = lights->vertices + 2 * triangle[0], *b = lights->vertices + 2 * triangle[1],
                   *c = lights->vertices + 2 * triangle[2];
    const int64_t cross = (int64_t)(b[0] - a[0]) * (c[1] - a[1]) - (int64_t)(b[1] - a[1]) * (c[0] - a[0]);
    return (double)cross / ((double)PLANE * PLANE);
}

static uint32_t bits_of(float x) {
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits;
}

/* The density of the cosine in the plane. */
static double cosine_at(double z) {
    return z * (1 + z) * (1 + z) / PI;
}

/* The densities in the plane, at each light, that suit a view best; `beyond` is their ratio to the cosine's
 * density outside of the triangles, where no light is, and `outside` the part of the cosine's that lies
 * there. */
typedef struct target {
    const btf_directions *lights;
    double *density;
    double beyond, outside;
} target;

/* Sum over the triangles of area times the mean of the corners. */
static double sum_over_triangles(const btf_directions *lights, const double *values) {
    double sum = 0;
    for (uint32_t t = 0; t < lights->triangle_count; t++) {
        const uint16_t *of = lights->triangles + 3 * (size_t)t;
        sum += twice_area(lights, of) * (values[of[0]] + values[of[1]] + values[of[2]]) / 6;
    }
    return sum;
}

/* Makes the target from luminance at each light; beyond the outermost lights their mean goes on. */
static void aim(const btf_directions *lights, double *luminance, double *scratch, target *out) {
    double rim = 0, rim_cosine = 0;
    for (uint32_t l = 0; l < lights->count; l++) {
        const double z = (double)lights->xyz[3 * (size_t)l + 2];
        luminance[l] *= (1 + z) * (1 + z); /* to the plane: see SAMPLING.md */
        scratch[l] = cosine_at(z);
    }
    for (uint32_t i = 0; i < lights->hull_count; i++) {
        rim += luminance[lights->hull[i]];
        rim_cosine += scratch[lights->hull[i]];
    }
    *out = (target){lights, luminance, 0, 1 - sum_over_triangles(lights, scratch)};
    out->outside = out->outside > 0 ? out->outside : 0;
    out->beyond = rim_cosine > 0 ? rim / rim_cosine : 0;
    const double total = sum_over_triangles(lights, luminance) + out->beyond * out->outside;
    for (uint32_t l = 0; l < lights->count; l++) {
        luminance[l] = total > 0 ? luminance[l] / total : 0;
    }
    out->beyond = total > 0 ? out->beyond / total : 0;
}

/* Densities to add to a share of the cosine: the excess of the target over it. Returns false where there is
 * none. */
static bool exceed(const target *t, double share, double *out) {
    for (uint32_t l = 0; l < t->lights->count; l++) {
        out[l] = fmax(t->density[l] - share * cosine_at((double)t->lights->xyz[3 * (size_t)l + 2]), 0);
    }
    const double total = sum_over_triangles(t->lights, out);
    for (uint32_t l = 0; l < t->lights->count && total > 0; l++) {
        out[l] *= (1 - share) / total;
    }
    return total > 0;
}

/* The mean square of an estimate of the light that the target reflects from a white sky: the integral of
 * its square over the density, at the middles of the triangles' edges. */
static double noise(const target *t, double share, const double *beside) {
    double sum = t->beyond * t->beyond * t->outside / share;
    for (uint32_t i = 0; i < t->lights->triangle_count; i++) {
        const uint16_t *of = t->lights->triangles + 3 * (size_t)i;
        double cosine[3], at_edges = 0;
        for (int c = 0; c < 3; c++) {
            cosine[c] = cosine_at((double)t->lights->xyz[3 * (size_t)of[c] + 2]);
        }
        for (int c = 0; c < 3; c++) {
            const int d = (c + 1) % 3;
            const double wanted = t->density[of[c]] + t->density[of[d]];
            at_edges +=
                wanted * wanted / (share * (cosine[c] + cosine[d]) + beside[of[c]] + beside[of[d]]) / 2;
        }
        sum += twice_area(t->lights, of) * at_edges / 6;
    }
    return sum;
}

/* The quietest share of those tried; its densities in `best`. */
static double choose_share(const target *t, double *scratch, double *best) {
    double share = 1, least = t->lights->triangle_count > 0 ? INFINITY : 0;
    memset(best, 0, t->lights->count * sizeof *best);
    for (int i = 0; i < SHARES; i++) {
        const double tried = 1 - (1 - least_share) * i / (SHARES - 1);
        const bool some = tried < 1 && exceed(t, tried, scratch);
        if (tried < 1 && !some) {
            continue;
        }
        if (!some) {
            memset(scratch, 0, t->lights->count * sizeof *scratch);
        }
        const double mean = noise(t, tried, scratch);
        if (mean < least) {
            least = mean;
            share = tried;
            memcpy(best, scratch, t->lights->count * sizeof *best);
        }
    }
    return share;
}

/* The row of a view in both tables. room: [2][lights]. */
static void fill_view(const btf_directions *lights, double *luminance, double *room, uint32_t (*row)[4],
                      float *densities) {
    double area = 0, sum = 0, share = 1, *beside = room + lights->count;
    target t;
    for (uint32_t i = 0; i < lights->triangle_count; i++) {
        area += twice_area(lights, lights->triangles + 3 * (size_t)i) / 2;
    }
    memset(beside, 0, lights->count * sizeof *beside);
    if (area >= least_area) {
        aim(lights, luminance, room, &t);
        share = choose_share(&t, room, beside);
    }
    for (uint32_t l = 0; l < lights->count; l++) {
        densities[l] = (float)beside[l];
    }
    densities[lights->count] = (float)share;
    for (uint32_t i = 0; i < lights->triangle_count; i++) {
        const uint16_t *of = lights->triangles + 3 * (size_t)i;
        const float a = densities[of[0]], b = densities[of[1]], c = densities[of[2]];
        sum += twice_area(lights, of) * ((double)a + (double)b + (double)c) / 6;
        row[i][0] = (uint32_t)(fmin(sum, 1 - share) * 0x1p32);
        row[i][1] = bits_of(a);
        row[i][2] = bits_of(b);
        row[i][3] = bits_of(c);
    }
}

static void fill_corners(const btf_directions *lights, uint32_t (*row)[4]) {
    for (uint32_t t = 0; t < lights->triangle_count; t++) {
        for (int corner = 0; corner < 3; corner++) {
            const uint16_t *q = lights->vertices + 2 * lights->triangles[3 * (size_t)t + (size_t)corner];
            row[t][corner] = q[0] + ((uint32_t)q[1] << 16);
        }
        row[t][3] = 0;
    }
}

btf_result btf_light_sampling_create(const btf_material *material, const btf_evaluator *evaluator,
                                     const btf_log *log, btf_light_sampling **out_sampling) {
    if (!out_sampling) {
        return BTF_ERROR_USAGE;
    }
    *out_sampling = NULL;
    if (!material || !evaluator) {
        return BTF_ERROR_USAGE;
    }
    btf_material_info info = {.struct_size = sizeof info};
    btf_material_get_info(material, &info);
    const btf_directions views = btf_material_views(material), lights = btf_material_lights(material);
    const size_t triangles = lights.triangle_count ? lights.triangle_count : 1;
    btf_light_sampling *s = calloc(1, sizeof *s);
    uint32_t(*rows)[4] = calloc((views.count + 1) * triangles, sizeof *rows);
    float *densities = malloc((size_t)views.count * (lights.count + 1) * sizeof *densities);
    double *luminance = malloc(3 * (size_t)lights.count * sizeof *luminance);
    if (!s || !rows || !densities || !luminance) {
        free(s);
        free(rows);
        free(densities);
        free(luminance);
        return btfi_fail(log, BTF_ERROR_MEMORY, "out of memory for tables of light sampling");
    }
    uint32_t texels[MOST_TEXELS][2];
    const size_t count = choose_texels(&info, texels);
    for (size_t v = 0; v < views.count; v++) {
        measure(evaluator, &lights, views.xyz + 3 * v, texels, count, luminance);
        fill_view(&lights, luminance, luminance + lights.count, rows + v * triangles,
                  densities + v * (lights.count + 1));
    }
    fill_corners(&lights, rows + views.count * triangles);
    free(luminance);
    *s = (btf_light_sampling){views.count, lights.count, (uint32_t)triangles, rows[0], densities};
    *out_sampling = s;
    return BTF_OK;
}

void btf_light_sampling_destroy(btf_light_sampling **sampling) {
    btf_light_sampling *s = sampling ? *sampling : NULL;
    if (!s) {
        return;
    }
    free((void *)s->triangles);
    free((void *)s->densities);
    free(s);
    *sampling = NULL;
}
