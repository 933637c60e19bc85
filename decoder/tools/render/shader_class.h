/* The interface of the devices behind a shader.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_RENDER_SHADER_CLASS_H
#define OPENBTF_RENDER_SHADER_CLASS_H

#include <openbtf/cost.h>
#include <stdbool.h>

/* The time of evaluating a list: wall time, and CPU time of all threads. */
typedef struct shader_times {
    double seconds, cpu;
} shader_times;

enum { SHADER_VARIANTS = 4, SHADER_PHONG = -1 };

/* Whether what is fixed is decoded once (shade_fold.h). */
typedef enum shader_fold { SHADER_FOLD_AUTO, SHADER_FOLD_ALWAYS, SHADER_FOLD_NEVER } shader_fold;

typedef struct shader_request {
    const char *device; /* "reference", or the name of a context_device */
    const btf_material *material;
    int variants; /* 1..SHADER_VARIANTS */
    uint32_t effects[SHADER_VARIANTS];
    uint32_t components; /* of the residual at most, or units; 0: all */
    btf_interpolation interpolation;
    btf_filter filter;
    btf_math math;  /* BTF_MATH_FAST: not of the reference */
    uint32_t fixed; /* as in btf_shader_options: what is the same in every list */
    float fixed_view[3], fixed_light[3];
    shader_fold fold;
    /* About how many evaluations each variant will make; of lights whose sum can be folded, one for all of them. */
    double samples;
    /* Lights that are the same in every list. Where their sum can be folded, it is shown as that of one light: folded
     * to radiance where the view is fixed; else, where sum_of_views says so, as BTF_FOLD_SUM, which is not exact to
     * the bit. `fixed` does not count them as a fixed light. 0: none. Both arrays [lights][3]: unit vectors of the
     * tangent frame; irradiance / pi. */
    size_t lights;
    const float *light_directions, *light_weights;
    bool sum_of_views;
    btf_picks picks; /* other than none: a list is decoded stochastically */
    int picked; /* the number of picks whose mean is taken, 1 at least; each list has its own random numbers */
    int level;                   /* the level of detail that every sample asks for; below 0: they differ */
    int threads;                 /* of the reference */
    const btf_cost_model *costs; /* of the device, to tell what pays; NULL: those of llvmpipe */
} shader_request;

/* The functions of a device; each device is one file: shade_reference.c, shade_gl.c. */
typedef struct shader_class {
    void *(*create)(const shader_request *request, const btf_log *log, btf_result *out_result);
    void (*destroy)(void *self);
    const char *(*name)(const void *self);
    int (*max_width)(const void *self);
    btf_result (*run)(void *self, int variant, int width, int rows, const float *inputs, float *out,
                      const btf_log *log);
    btf_fold (*folded)(const void *self); /* what variant 0 reads; with the request's `lights` their sum */
    btf_result (*time)(void *self, int variant, int repeats, shader_times *out_times);
} shader_class;

#endif
