/* Evaluates a material over lists of (u, v, view, light): on the CPU with the bits of the reference decoder, or on a GL
 * device by the GLSL library. With exact math both give the same bits.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_RENDER_SHADER_H
#define OPENBTF_RENDER_SHADER_H

#include "shader_class.h"

typedef struct shader shader;

/* The material must outlive it. Errors, on log: BTF_ERROR_USAGE (unknown device: the message lists them; fast math on
 * the reference), BTF_ERROR_UNSUPPORTED (no such context here, or one that does not keep to FORMAT.md's arithmetic, or
 * fetches levels, factors or lists of points wrongly: the message says which), BTF_ERROR_MEMORY, BTF_ERROR_INTERNAL
 * (GLSL refused). */
btf_result shader_create(const shader_request *request, const btf_log *log, shader **out_shader);
void shader_destroy(shader **s);

/* Names what variant 0 has folded, and its bytes: "light, 5308416 bytes", "light and view, 65536 bytes", "3 lights and
 * view, 65536 bytes", "nothing". */
const char *shader_folded(const shader *s);

/* Whether every variant shows the sum of the request's `lights`, each with its weight: sum = sum + radiance * weight in
 * single precision, in their order (openbtf/fold.h, btf_fold_add). */
bool shader_shows_sum(const shader *s);

/* The name of the evaluator: "reference decoder", or GL's renderer and version. */
const char *shader_name(const shader *s);

/* The widest list rows that it takes. */
int shader_max_width(const shader *s);

/* inputs[rows][width][TABLE_INPUTS] as table_light makes them, out[rows][width][3]. At most 2^20 samples.
 */
btf_result shader_run(shader *s, int variant, int width, int rows, const float *inputs, float *out,
                      const btf_log *log);

/* The time of evaluating the last list: the median of `repeats`, and the mean of CPU time; a variant, or
 * SHADER_PHONG for a textured Phong shader over the same list. BTF_ERROR_UNSUPPORTED on the reference. */
btf_result shader_time(shader *s, int variant, int repeats, shader_times *out_times);

#endif
