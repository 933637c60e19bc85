/* A GL device with inputs to decode, on which the sections on decoding measure.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TESTS_BENCH_DECODE_RIG_H
#define OPENBTF_TESTS_BENCH_DECODE_RIG_H

#include "tests/conformance/gpu.h"

#include <openbtf/material.h>

enum { RIG_SIDE = GPU_SIDE, RIG_PIXELS = GPU_SIDE * GPU_SIDE, RIG_MOST_REPEATS = 25 };

typedef struct decode_rig {
    gpu *gpu;
    const btf_log *log;
    int repeats;
    bool have_precise; /* for btf_shader_options */
    bool software;     /* the processor draws, so times are core times; else times of the clock */
    uint32_t *inputs;  /* [RIG_PIXELS][GPU_INPUTS]: u, v, light, view of a sphere that fills the grid */
    uint32_t *outputs; /* [RIG_PIXELS][GPU_OUTPUTS] */
} decode_rig;

/* Errors: BTF_ERROR_UNSUPPORTED without a context, with the reason in why; BTF_ERROR_MEMORY. */
btf_result rig_create(const context_device *device, int repeats, const btf_log *log, char *why,
                      size_t why_size, decode_rig *out_rig);
void rig_destroy(decode_rig *rig);

/* Seconds: of all threads of the process, or of the clock. */
double rig_core_seconds(void);
double rig_wall_seconds(void);

/* Pixel i of the sphere as u, v, light, view. */
void rig_sphere_pixel(int i, float out[8]);

/* Makes the inputs of floor shaders for the same pixels as `decode`: texel, neighbours and table addresses. */
void rig_floor_inputs(const btf_material *material, const uint32_t *decode, uint32_t *floor);

/* Draws a program over RIG_PIXELS inputs, side x side of them, after one run that compiles; returns ns a
 * pixel, median of the repeats, 0 on an error; *out_spread (may be NULL) is (largest - smallest) / median.
 */
double rig_measure(decode_rig *rig, unsigned program, const uint32_t *inputs, int side, double *out_spread);

/* A variant of a material, compiled around `body`, uploaded and bound. */
typedef struct rig_variant {
    unsigned program; /* 0: failed, with a message */
    btf_gl *gl;
} rig_variant;
rig_variant rig_variant_create(decode_rig *rig, const btf_material *material,
                               const btf_shader_options *shader, const char *body, int first_unit);
void rig_variant_destroy(decode_rig *rig, rig_variant *variant);

/* Makes a variant, measures it over the whole side and destroys it; 0 on an error. */
double rig_measure_variant(decode_rig *rig, const btf_material *material, const btf_shader_options *shader,
                           const char *body, const uint32_t *inputs, double *out_spread);

/* A texture of bytes [layer][row][column][4] on a unit. layers 0: a 2D texture with mip levels, filtered;
 * bytes NULL: random. format: GL_RGBA8 or GL_SRGB8_ALPHA8. Returns its name, 0 out of memory. */
unsigned rig_texture(decode_rig *rig, int unit, int format, int width, int height, int layers,
                     const unsigned char *bytes);
void rig_texture_delete(decode_rig *rig, int count, const unsigned *textures);
/* Gives sampler `name` of the program its unit. */
void rig_sampler(decode_rig *rig, unsigned program, const char *name, int unit);

#endif
