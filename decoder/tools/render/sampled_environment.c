/* Directions of an environment map and of the material. See sampled_environment.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "sampled_environment.h"

#include "decoder/toolkit/file.h"
#include "decoder/toolkit/reference_view.h"
#include <openbtf/sampling.h>
#include <stdlib.h>
#include <string.h>

/* Steps of the R2 sequence in 2^-32 (M. Roberts, "The unreasonable effectiveness of quasirandom sequences", 2018),
 * which fills the square evenly from whatever number it starts. */
static const uint32_t steps[2] = {0xC13FA9A9u, 0x91E10DA5u};

struct sampled_environment {
    int width, height, by_map, by_material; /* directions a sample by each */
    float *pixels;                          /* as given */
    double *columns; /* [height][width + 1]: luminance of a row up to a column, times solid angle */
    double *rows;    /* [height + 1]: of the rows up to one */
    double rotate, gain, cosine, sine; /* rotate in radians; the turn about z */
    btf_light_sampling *tables;
    btf_ref_sampling sampling;
    btf_ref_material directions;
};

typedef struct incident {
    double radiance[3], density; /* over the solid angle; 0 where it is dark */
} incident;

static double usable(float value) {
    return value >= 0 && value <= 1e30f ? (double)value : 0;
}

static const float *pixel_at(const sampled_environment *e, int x, int y) {
    return e->pixels + 3 * ((size_t)y * (size_t)e->width + (size_t)x);
}

static double luminance_at(const sampled_environment *e, int x, int y) {
    const float *p = pixel_at(e, x, y);
    return 0.2126 * usable(p[0]) + 0.7152 * usable(p[1]) + 0.0722 * usable(p[2]);
}

static void fill(sampled_environment *e) {
    for (int y = 0; y < e->height; y++) {
        double *row = e->columns + (size_t)y * ((size_t)e->width + 1);
        const double solid = (cos(RENDER_PI * y / e->height) - cos(RENDER_PI * (y + 1) / e->height)) *
                             (2 * RENDER_PI / e->width);
        for (int x = 0; x < e->width; x++) {
            row[x + 1] = row[x] + luminance_at(e, x, y) * solid;
        }
        e->rows[y + 1] = e->rows[y] + row[e->width];
    }
}

btf_result sampled_environment_create(int width, int height, const float *pixels, double rotate,
                                      double gain, const btf_material *material, int count,
                                      const btf_log *log, sampled_environment **out_environment) {
    const size_t size = (size_t)width * (size_t)height * 3 * sizeof *pixels;
    btf_evaluator *evaluator = NULL;
    btf_result result = BTF_ERROR_MEMORY;
    sampled_environment *e = calloc(1, sizeof *e);
    *out_environment = NULL;
    if (e) {
        *e = (sampled_environment){.width = width,
                                   .height = height,
                                   .by_map = (count + 1) / 2,
                                   .by_material = count / 2,
                                   .pixels = malloc(size),
                                   .columns = calloc((size_t)height * ((size_t)width + 1), sizeof(double)),
                                   .rows = calloc((size_t)height + 1, sizeof(double)),
                                   .rotate = rotate * (RENDER_PI / 180),
                                   .gain = gain,
                                   .cosine = 1};
    }
    if (e && e->pixels && e->columns && e->rows) {
        result = btf_evaluator_create(material, log, &evaluator);
    } else {
        file_say(log, "out of memory for a map of %d x %d pixels", width, height);
    }
    if (!result) {
        result = btf_light_sampling_create(material, evaluator, log, &e->tables);
    }
    btf_evaluator_destroy(&evaluator);
    if (result) {
        sampled_environment_destroy(&e);
        return result;
    }
    memcpy(e->pixels, pixels, size);
    fill(e);
    reference_view(material, 0, &e->directions);
    e->sampling = (btf_ref_sampling){e->tables->n_triangles, e->tables->triangles, e->tables->densities};
    *out_environment = e;
    return BTF_OK;
}

void sampled_environment_destroy(sampled_environment **environment) {
    sampled_environment *e = environment ? *environment : NULL;
    if (!e) {
        return;
    }
    btf_light_sampling_destroy(&e->tables);
    free(e->pixels);
    free(e->columns);
    free(e->rows);
    free(e);
    *environment = NULL;
}

int sampled_environment_count(const sampled_environment *environment) {
    return environment->by_map + environment->by_material;
}

void sampled_environment_turn(sampled_environment *environment, double degrees) {
    environment->cosine = cos(degrees * (RENDER_PI / 180));
    environment->sine = sin(degrees * (RENDER_PI / 180));
}

/* Finds the interval of the rising sums[count + 1] that holds the part 0..1 of the last sum; *out_share says where in
 * the interval. Intervals of no length are passed over. */
static int find(const double *sums, int count, double part, double *out_share) {
    const double at = part * sums[count];
    int low = 0, high = count - 1;
    while (low < high) {
        const int middle = (low + high) / 2;
        if (at < sums[middle + 1]) {
            high = middle;
        } else {
            low = middle + 1;
        }
    }
    while (low > 0 && !(sums[low + 1] > sums[low])) { /* `at` rounded up to the last */
        low--;
    }
    const double length = sums[low + 1] - sums[low];
    *out_share = length > 0 ? fmin(fmax((at - sums[low]) / length, 0), 1) : 0.5;
    return low;
}

/* Draws a direction in proportion to luminance, evenly over the solid angle of each pixel. The map must not be
 * black. */
static vec3 draw_of_map(const sampled_environment *e, uint32_t u1, uint32_t u2) {
    double down, across;
    const int y = find(e->rows, e->height, (u1 + 0.5) * 0x1p-32, &down);
    const int x =
        find(e->columns + (size_t)y * ((size_t)e->width + 1), e->width, (u2 + 0.5) * 0x1p-32, &across);
    const double top = cos(RENDER_PI * y / e->height), bottom = cos(RENDER_PI * (y + 1) / e->height);
    const double up = top + (bottom - top) * down, level = sqrt(fmax(1 - up * up, 0)),
                 longitude = (x + across) / e->width * (2 * RENDER_PI) - RENDER_PI + e->rotate;
    const vec3 d = vec(level * sin(longitude), up, -level * cos(longitude));
    return vec(e->cosine * d.x - e->sine * d.y, e->sine * d.x + e->cosine * d.y, d.z);
}

/* The radiance that comes from a direction of the world. */
static incident look(const sampled_environment *e, vec3 to_light) {
    const vec3 d = vec(e->cosine * to_light.x + e->sine * to_light.y,
                       e->cosine * to_light.y - e->sine * to_light.x, to_light.z);
    const double down = acos(fmax(-1, fmin(d.y, 1))) / RENDER_PI;
    double across = (atan2(d.x, -d.z) - e->rotate) / (2 * RENDER_PI) + 0.5;
    across -= floor(across);
    const int y = (int)fmin(down * e->height, e->height - 1),
              x = (int)fmin(across * e->width, e->width - 1);
    const double total = e->rows[e->height];
    const float *p = pixel_at(e, x, y);
    incident in = {.density = total > 0 ? luminance_at(e, x, y) / total : 0};
    for (int c = 0; c < 3; c++) {
        in.radiance[c] = usable(p[c]) * e->gain;
    }
    return in;
}

/* Draws a direction by the material's tables. Returns it in the world; out_local is in the sample's tangent frame. */
static vec3 draw_of_material(const sampled_environment *e, const table_sample *sample, uint32_t u1,
                             uint32_t u2, float out_local[3]) {
    float density;
    btf_ref_sample_light(&e->directions, &e->sampling, sample->uv[0], sample->uv[1], sample->view, u1, u2,
                         out_local, &density);
    const vec3 l = vec_from(out_local);
    return vec_add(
        vec_add(vec_mul(vec_from(sample->tangent), l.x), vec_mul(vec_from(sample->bitangent), l.y)),
        vec_mul(vec_from(sample->normal), l.z));
}

/* Fills in one direction of one sample. random: the numbers with which the sample's two sequences begin, of the map
 * and of the material. */
static void light_sample(const sampled_environment *e, const table_scene *scene, int index,
                         const uint32_t random[2][3], const table_sample *sample, float *in,
                         float *weight) {
    const int by_material = index >= e->by_map;
    const uint32_t at = (uint32_t)(by_material ? index - e->by_map : index) + 1;
    const uint32_t u1 = random[by_material][0] + at * steps[0], u2 = random[by_material][1] + at * steps[1];
    float local[3];
    vec3 to_light;
    if (!by_material && !(e->rows[e->height] > 0)) {
        return;
    }
    if (by_material) {
        to_light = draw_of_material(e, sample, u1, u2, local);
    } else {
        to_light = draw_of_map(e, u1, u2);
        vec_store(table_to_local(sample, to_light), local);
    }
    memcpy(in + 5, local, sizeof local);
    const incident from = look(e, to_light);
    if (!(local[2] > 0) || !(from.density > 0) ||
        (scene->cast_shadows && table_is_shadowed(scene, sample, to_light))) {
        return;
    }
    const double density =
        e->by_map * from.density + e->by_material * (double)btf_ref_pdf_light(&e->directions, &e->sampling,
                                                                              sample->uv[0], sample->uv[1],
                                                                              sample->view, local);
    for (int c = 0; c < 3; c++) {
        weight[c] = (float)(from.radiance[c] / (RENDER_PI * density));
    }
}

void sampled_environment_light(const sampled_environment *environment, const table_scene *scene, int index,
                               int first_row, int rows, const table_sample *samples, float *inputs,
                               float *weights) {
#pragma omp parallel for schedule(dynamic, 4) num_threads(scene->threads)
    for (int row = 0; row < rows; row++) {
        for (int x = 0; x < scene->width; x++) {
            const size_t i = (size_t)row * (size_t)scene->width + (size_t)x;
            uint32_t random[2][3];
            for (uint32_t k = 0; k < 2; k++) {
                const uint32_t counter[3] = {(uint32_t)x, (uint32_t)(first_row + row), k};
                btf_ref_random(counter, random[k]);
            }
            table_set_sample(samples + i, inputs + TABLE_INPUTS * i);
            memset(weights + 3 * i, 0, 3 * sizeof *weights);
            if (samples[i].view[2] != 0) {
                light_sample(environment, scene, index, (const uint32_t(*)[3])random, samples + i,
                             inputs + TABLE_INPUTS * i, weights + 3 * i);
            }
        }
    }
}
