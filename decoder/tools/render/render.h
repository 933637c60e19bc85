/* Renders a scene to pictures: cast a band of the table, shade it under every light, resolve.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_RENDER_RENDER_H
#define OPENBTF_RENDER_RENDER_H

#include "picture.h"
#include "sampled_environment.h"
#include "shader.h"
#include "table.h"

enum { RENDER_PICTURES = SHADER_VARIANTS + 1 };

/* Something that turns inputs[rows][width][TABLE_INPUTS] (table_light) into out[rows][width][3]. */
typedef struct evaluator {
    btf_result (*run)(void *user, int variant, int width, int rows, const float *inputs, float *out,
                      const btf_log *log);
    void *user;
    int variant;
} evaluator;

/* An evaluator that is a variant of a shader. */
evaluator evaluator_of_shader(shader *s, int variant);

typedef struct render_times {
    double cast, shade;         /* seconds of wall time, all lights */
    shader_times decode, phong; /* seconds a frame under one light, measured with `repeats` */
    int repeats;                /* 0: decode and phong are not measured */
    shader *shader;             /* whose variant 0 is measured */
} render_times;

typedef struct render_scene {
    table_scene table; /* width, height are set here */
    const light_list *lights;
    const sampled_environment *environment; /* beside the lights; may be NULL */
    int width, height; /* pixels */
    int samples;       /* samples a pixel along each axis */
    double background; /* linear grey behind the mesh */
} render_scene;

/* Renders one picture for each of `count` evaluators, all from the same table: pictures[count], made here, linear.
 * mask[height][width] (may be NULL) is set where the mesh covers all samples of the pixel. Sums run light by light,
 * then direction by direction of the environment, then over a pixel's samples row by row, in double precision: the
 * same bits for any number of threads. Errors: BTF_ERROR_MEMORY, BTF_ERROR_INTERRUPTED, those of the evaluators. */
btf_result render_frame(const render_scene *scene, const evaluator *evaluators, int count,
                        picture *pictures, unsigned char *mask, render_times *times, const btf_log *log);

#endif
