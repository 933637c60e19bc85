/* Renders a scene to pictures.
 *
 * SPDX-License-Identifier: MIT
 */
#include "render.h"

#include "decoder/toolkit/progress.h"
#include "decoder/toolkit/file.h"
#include <omp.h>
#include <stdlib.h>
#include <string.h>

enum { BAND = 1 << 18 }; /* samples at a time, about */

typedef struct band {
    const render_scene *scene;
    table_scene table;
    int rows; /* of samples */
    table_sample *samples;
    float *inputs, *weights, *radiance;
    double *sums[RENDER_PICTURES];
} band;

static btf_result run_shader(void *user, int variant, int width, int rows, const float *inputs, float *out,
                             const btf_log *log) {
    return shader_run(user, variant, width, rows, inputs, out, log);
}

evaluator evaluator_of_shader(shader *s, int variant) {
    return (evaluator){run_shader, s, variant};
}

static void clear(band *b) {
    free(b->samples);
    free(b->inputs);
    free(b->weights);
    free(b->radiance);
    for (int e = 0; e < RENDER_PICTURES; e++) {
        free(b->sums[e]);
    }
}

static bool allocate(band *b, const render_scene *scene, int count) {
    const int ss = scene->samples;
    *b = (band){.scene = scene, .table = scene->table};
    b->table.width = scene->width * ss;
    b->table.height = scene->height * ss;
    b->rows = BAND / b->table.width / ss * ss;
    if (b->rows < ss) {
        b->rows = ss;
    }
    if (b->rows > b->table.height) {
        b->rows = b->table.height;
    }
    const size_t n = (size_t)b->rows * (size_t)b->table.width;
    b->samples = calloc(n, sizeof *b->samples);
    b->inputs = calloc(n, TABLE_INPUTS * sizeof *b->inputs);
    b->weights = calloc(n, 3 * sizeof *b->weights);
    b->radiance = calloc(n, 3 * sizeof *b->radiance);
    bool ok = b->samples && b->inputs && b->weights && b->radiance;
    for (int e = 0; e < count && ok; e++) {
        ok = (b->sums[e] = calloc(n, 3 * sizeof *b->sums[e])) != NULL;
    }
    return ok;
}

/* The number of times that samples are shaded: once for each light, then for each direction of the environment. */
static size_t count_passes(const render_scene *scene) {
    return scene->lights->count +
           (scene->environment ? (size_t)sampled_environment_count(scene->environment) : 0);
}

static btf_result shade(band *b, size_t pass, int first_row, int rows, const evaluator *evaluators,
                        int count, const btf_log *log) {
    const light_list *lights = b->scene->lights;
    const int64_t n = (int64_t)rows * b->table.width;
    if (pass < lights->count) {
        table_light(&b->table, &lights->lights[pass], (size_t)n, b->samples, b->inputs, b->weights);
    } else {
        sampled_environment_light(b->scene->environment, &b->table, (int)(pass - lights->count), first_row,
                                  rows, b->samples, b->inputs, b->weights);
    }
    for (int e = 0; e < count; e++) {
        btf_result result = evaluators[e].run(evaluators[e].user, evaluators[e].variant, b->table.width,
                                              rows, b->inputs, b->radiance, log);
        if (result) {
            return result;
        }
        double *sums = b->sums[e];
#pragma omp parallel for schedule(static, 16384) num_threads(b->table.threads)
        for (int64_t i = 0; i < 3 * n; i++) {
            sums[i] += (double)b->radiance[i] * (double)b->weights[i];
        }
    }
    return BTF_OK;
}

/* The mean of a pixel's samples; background where none hits. */
static void resolve(const band *b, int first_row, int rows, const double *sums, picture *out,
                    unsigned char *mask) {
    const int ss = b->scene->samples, width = b->scene->width;
    for (int y = 0; y < rows / ss; y++) {
        for (int x = 0; x < width; x++) {
            double total[3] = {0, 0, 0};
            int hits = 0;
            for (int k = 0; k < ss * ss; k++) {
                size_t i = (size_t)(y * ss + k / ss) * (size_t)b->table.width + (size_t)(x * ss + k % ss);
                bool hit = b->samples[i].view[2] != 0;
                hits += hit;
                for (int c = 0; c < 3; c++) {
                    total[c] += hit ? sums[3 * i + (size_t)c] : b->scene->background;
                }
            }
            size_t pixel = (size_t)(first_row / ss + y) * (size_t)width + (size_t)x;
            for (int c = 0; c < 3; c++) {
                out->rgb[3 * pixel + (size_t)c] = (float)(total[c] / (ss * ss));
            }
            if (mask) {
                mask[pixel] = hits == ss * ss;
            }
        }
    }
}

static btf_result measure(render_times *times) {
    shader_times band;
    btf_result result = shader_time(times->shader, 0, times->repeats, &band);
    if (result) {
        return result;
    }
    times->decode.seconds += band.seconds;
    times->decode.cpu += band.cpu;
    result = shader_time(times->shader, SHADER_PHONG, times->repeats, &band);
    times->phong.seconds += band.seconds;
    times->phong.cpu += band.cpu;
    return result;
}

static btf_result render_band(band *b, int first_row, int rows, const evaluator *evaluators, int count,
                              picture *pictures, unsigned char *mask, render_times *times,
                              const btf_log *log) {
    btf_result result = BTF_OK;
    double start = omp_get_wtime();
    table_cast(&b->table, first_row, rows, b->samples);
    times->cast += omp_get_wtime() - start;
    for (int e = 0; e < count; e++) {
        memset(b->sums[e], 0, (size_t)rows * (size_t)b->table.width * 3 * sizeof *b->sums[e]);
    }
    start = omp_get_wtime();
    for (size_t i = 0; i < count_passes(b->scene) && !result; i++) {
        result = progress_cancelled() ? BTF_ERROR_INTERRUPTED
                                      : shade(b, i, first_row, rows, evaluators, count, log);
    }
    times->shade += omp_get_wtime() - start;
    if (!result && times->repeats && count_passes(b->scene)) {
        result = measure(times);
    }
    for (int e = 0; e < count && !result; e++) {
        resolve(b, first_row, rows, b->sums[e], &pictures[e], mask);
    }
    return result;
}

btf_result render_frame(const render_scene *scene, const evaluator *evaluators, int count,
                        picture *pictures, unsigned char *mask, render_times *times, const btf_log *log) {
    band b;
    btf_result result = allocate(&b, scene, count) ? BTF_OK : BTF_ERROR_MEMORY;
    for (int e = 0; e < count; e++) {
        if (picture_create(scene->width, scene->height, &pictures[e])) {
            result = BTF_ERROR_MEMORY;
        }
    }
    if (result) {
        file_say(log, "out of memory for a picture of %d x %d", scene->width, scene->height);
    }
    for (int row = 0; row < b.table.height && !result; row += b.rows) {
        int rows = b.table.height - row < b.rows ? b.table.height - row : b.rows;
        result = render_band(&b, row, rows, evaluators, count, pictures, mask, times, log);
    }
    clear(&b);
    if (result) {
        for (int e = 0; e < count; e++) {
            picture_clear(&pictures[e]);
        }
    }
    return result;
}
