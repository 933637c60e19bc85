/* Evaluating a material over lists of (u, v, view, light): on the CPU by the reference decoder, or on a GL
 * device by the GLSL library. With exact math both give the same bits.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_RENDER_SHADER_H
#define OPENBTF_RENDER_SHADER_H

#include <openbtf/shader.h>
#include <stdbool.h>

typedef struct shader shader;

/* What evaluating a list takes: wall time, and CPU time of all threads. */
typedef struct shader_times {
    double seconds, cpu;
} shader_times;

enum { SHADER_VARIANTS = 4, SHADER_PHONG = -1 };

typedef struct shader_request {
    const char *device; /* "reference", or the name of a context_device */
    const btf_material *material;
    int variants; /* 1..SHADER_VARIANTS */
    uint32_t effects[SHADER_VARIANTS];
    uint32_t components; /* residual components at most */
    btf_interpolation interpolation;
    btf_filter filter;
    btf_math math;  /* BTF_MATH_FAST: not of the reference */
    uint32_t fixed; /* as in btf_shader_options: what is the same in every list; GL alone profits */
    float fixed_view[3], fixed_light[3];
    int level;   /* the level of detail that every sample asks for; below 0: they differ */
    int threads; /* of the reference */
} shader_request;

/* What a device does; each is one file. */
typedef struct shader_class {
    void *(*create)(const shader_request *request, const btf_log *log, btf_result *out_result);
    void (*destroy)(void *self);
    const char *(*name)(const void *self);
    int (*max_width)(const void *self);
    btf_result (*run)(void *self, int variant, int width, int rows, const float *inputs, float *out,
                      const btf_log *log);
    btf_result (*time)(void *self, int variant, int repeats, shader_times *out_times);
} shader_class;

extern const shader_class shader_class_reference, shader_class_gl;

/* The material must outlive it. Errors, on log: BTF_ERROR_USAGE (unknown device: the message lists them;
 * fast math on the reference), BTF_ERROR_UNSUPPORTED (no such context here, or one that does not keep to
 * FORMAT.md's arithmetic, or does not fetch the level that a pixel asks for: the message says why),
 * BTF_ERROR_MEMORY, BTF_ERROR_INTERNAL (GLSL refused). */
btf_result shader_create(const shader_request *request, const btf_log *log, shader **out_shader);
void shader_destroy(shader **s);

/* What evaluates: "reference decoder", or GL's renderer and version. */
const char *shader_name(const shader *s);

/* The widest list rows that it takes. */
int shader_max_width(const shader *s);

/* inputs[rows][width][TABLE_INPUTS] as table_light makes them, out[rows][width][3]. At most 2^20 samples.
 */
btf_result shader_run(shader *s, int variant, int width, int rows, const float *inputs, float *out,
                      const btf_log *log);

/* What evaluating the last list takes: the median of `repeats`, and the mean of CPU time; a variant, or
 * SHADER_PHONG for a textured Phong shader over the same list. BTF_ERROR_UNSUPPORTED on the reference. */
btf_result shader_time(shader *s, int variant, int repeats, shader_times *out_times);

#endif
