/* Runs a function of GLSL over a grid of integer inputs and reads integers back, for all tests of conformance. * Inputs
 * and outputs are bits in RGBA32UI textures, so that NaN and denormals stay as they are and no result is rounded.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_CONFORMANCE_GPU_H
#define OPENBTF_CONFORMANCE_GPU_H

#include "decoder/tools/context/context.h"
#include "decoder/tools/context/gl_api.h"
#include <stdbool.h>

enum { GPU_SIDE = 256, GPU_INPUTS = 8, GPU_OUTPUTS = 4 }; /* at most 256 x 256 elements a draw */

typedef struct gpu gpu;

/* NULL on failure, with the reason in why[why_size]. The device must have been prepared. */
gpu *gpu_create(const context_device *device, char *why, size_t why_size);

/* For the set-up of a test: prepares the process for the device and opens it. Where the machine has none, prints the
 * reason and ends the process as a skipped test. */
gpu *gpu_create_or_skip(const context_device *device);

/* The set-up and the teardown of a group of tests (cmocka_run_group_tests) on the first device: gpu_create_or_skip and
 * gpu_destroy of gpu_of_group. */
extern gpu *gpu_of_group;
int gpu_group_setup(void **state);
int gpu_group_teardown(void **state);

void gpu_destroy(gpu **g);

/* The renderer and version that GL names. */
const char *gpu_name(const gpu *g);
/* Its functions of GL. */
const gl_api *gpu_api(const gpu *g);
btf_gl_options gpu_gl_options(gpu *g, const btf_shader_options *shader);

/* Compiles `library` (the decoder), then `body`, which defines `uvec4 check(uvec4 a, uvec4 b)`; 0 on
 * failure, with GL's message on log. `preamble` (may be NULL) stands before the library. */
unsigned gpu_program(gpu *g, const char *preamble, const char *library, const char *body,
                     const btf_log *log);
void gpu_delete_program(gpu *g, unsigned program);

/* gpu_run itself uses texture unit 0; the decoder's textures are bound to GPU_FIRST_UNIT onwards. */
enum { GPU_FIRST_UNIT = 1 };

/* Runs the program over `count` elements: inputs[count][8], outputs[count][4]; count at most GPU_SIDE^2. */
btf_result gpu_run(gpu *g, unsigned program, size_t count, const uint32_t *inputs, uint32_t *outputs,
                   const btf_log *log);

/* Draws the program `repeats` times over side x side pixels of the inputs of the last gpu_run, and waits.
 * For timing. */
btf_result gpu_draw(gpu *g, unsigned program, int side, int repeats);

/* A `check` whose elements are u, v, light and view, and whose outputs are the bits of btf_evaluate. */
extern const char gpu_evaluate_body[];

#endif
