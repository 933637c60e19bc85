/* One run of btf-render. See job.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "job.h"

#include "decoder/toolkit/filter.h"
#include "figure.h"
#include "settings.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void print_times(const char *name, const shader_times *t) {
    printf("%s: %.2f ms a frame, %.1f frames a second, %.2f ms of CPU\n", name, 1e3 * t->seconds,
           1 / t->seconds, 1e3 * t->cpu);
}

static void print_stats(const job *j, const render_times *t) {
    printf("device: %s\nfolded: %s\n", shader_name(j->shader), shader_folded(j->shader));
    if (j->environment) {
        printf("environment: %d directions a sample\n", sampled_environment_count(j->environment));
    }
    printf("picture: %d x %d, %d samples a pixel, %zu lights, %s, %s, %s\n", j->scene.width,
           j->scene.height, j->scene.samples * j->scene.samples, render_options.lights.count,
           (j->whole && !render_options.interpolation_given
                ? j->plan.shader.interpolation
                : (btf_interpolation)render_options.interpolation) == BTF_INTERPOLATION_NEAREST
               ? "nearest"
               : "linear",
           filter_name((btf_filter)render_options.filter),
           render_options.math == BTF_MATH_FAST ? "fast" : "exact");
    printf("cast: %.1f ms\nshade: %.1f ms\n", 1e3 * t->cast, 1e3 * t->shade);
    if (t->decode.seconds > 0) {
        print_times("decode", &t->decode);
        print_times("phong", &t->phong);
    }
}

btf_result job_render(const job *j, const char *path) {
    picture picture;
    const evaluator evaluator = evaluator_of_shader(j->shader, 0);
    render_times times = {.shader = j->shader,
                          .repeats = render_options.stats && strcmp(render_options.device, "reference")
                                         ? render_options.repeats
                                         : 0};
    btf_result result = render_frame(&j->scene, &evaluator, 1, &picture, NULL, &times, &j->log);
    if (result) {
        return result;
    }
    picture_expose(&picture, exp2(render_options.exposure));
    result = picture_write(&picture, path, (tone)render_options.tone, j->log);
    picture_clear(&picture);
    if (!result && render_options.stats) {
        print_stats(j, &times);
    }
    return result;
}

btf_result job_render_figure(const job *j, const char *path) {
    picture pictures[FIGURE_COLUMNS];
    evaluator evaluators[FIGURE_COLUMNS] = {original_evaluator(j->original)};
    render_times times = {0};
    unsigned char *mask = calloc((size_t)j->scene.width * (size_t)j->scene.height, 1);
    if (!mask) {
        return cli_error(&render_program, BTF_ERROR_MEMORY, "out of memory for a mask");
    }
    for (int i = 1; i < FIGURE_COLUMNS; i++) {
        evaluators[i] =
            evaluator_of_shader(i < 3 && j->baseline_shader ? j->baseline_shader : j->shader, i - 1);
    }
    btf_result result =
        render_frame(&j->scene, evaluators, FIGURE_COLUMNS, pictures, mask, &times, &j->log);
    if (!result) {
        for (int i = 0; i < FIGURE_COLUMNS; i++) {
            picture_expose(&pictures[i], exp2(render_options.exposure));
        }
        result = figure_write(pictures, mask, path, (tone)render_options.tone, j->log);
        for (int i = 0; i < FIGURE_COLUMNS; i++) {
            picture_clear(&pictures[i]);
        }
    }
    free(mask);
    if (!result && render_options.stats) {
        print_stats(j, &times);
    }
    return result;
}

void job_close(job *j) {
    original_close(&j->original);
    shader_destroy(&j->shader);
    shader_destroy(&j->baseline_shader);
    bvh_destroy(&j->bvh);
    mesh_destroy(&j->mesh);
    sampled_environment_destroy(&j->environment);
    btf_material_close(&j->material);
    btf_material_close(&j->whole);
    btf_material_close(&j->baseline);
    free(j->seen);
    free(j->lights);
    still_lights_clear(&j->still_lights);
    light_list_clear(&render_options.lights);
}
