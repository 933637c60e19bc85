/* GL devices to measure decoding on. See decode_rig.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "decode_rig.h"

#include "decoder/toolkit/reference_view.h"
#include "tests/conformance/random.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

double rig_core_seconds(void) {
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

double rig_wall_seconds(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static int compare_double(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return x < y ? -1 : x > y;
}

void rig_sphere_pixel(int i, float out[8]) {
    double px = 2 * (i % RIG_SIDE + 0.5) / RIG_SIDE - 1, py = 2 * (i / RIG_SIDE + 0.5) / RIG_SIDE - 1,
           r = hypot(px, py);
    if (r > 0.97) {
        px *= 0.97 / r;
        py *= 0.97 / r;
    }
    double n[3] = {px, py, sqrt(1 - px * px - py * py)}, world_light[3] = {0.3, 0.2, sqrt(1 - 0.09 - 0.04)};
    double t[3] = {n[2], 0, -n[0]}, length = hypot(t[0], t[2]);
    for (int c = 0; c < 3; ++c) {
        t[c] /= length;
    }
    double b[3] = {n[1] * t[2] - n[2] * t[1], n[2] * t[0] - n[0] * t[2], n[0] * t[1] - n[1] * t[0]};
    const double *axes[3] = {t, b, n};
    out[0] = (float)(2 * px + 2);
    out[1] = (float)(2 * py + 2);
    for (int c = 0; c < 3; ++c) {
        out[2 + c] = (float)(axes[c][0] * world_light[0] + axes[c][1] * world_light[1] +
                             axes[c][2] * world_light[2]);
        out[5 + c] = (float)axes[c][2];
    }
    out[4] = fmaxf(out[4], 0.05f);
}

/* Returns the number of records that a look-up tries, and tells the texel of the table with the first of them. */
static uint32_t records_tried(const uint16_t *table, uint32_t grid, const int32_t q[2],
                              uint32_t *out_first) {
    uint32_t cx = ((uint32_t)(q[0] < 16383 ? q[0] : 16383) * grid) >> 14,
             cy = ((uint32_t)(q[1] < 16383 ? q[1] : 16383) * grid) >> 14;
    const uint16_t *cell = table + 4 * (cy * grid + cx);
    *out_first = grid * grid + 3u * cell[0];
    for (uint32_t i = 0; i < cell[1]; ++i) {
        const uint16_t *r = table + 4 * ((size_t)*out_first + 3 * i);
        int64_t x[4] = {r[0], r[2], r[4], r[0]}, y[4] = {r[1], r[3], r[5], r[1]};
        int inside = !(r[7] & 1);
        for (int e = 0; e < 3; ++e) {
            inside = inside && (x[e] - q[0]) * (y[e + 1] - q[1]) - (y[e] - q[1]) * (x[e + 1] - q[0]) >= 0;
        }
        if (inside) {
            return i + 1;
        }
    }
    return cell[1];
}

void rig_floor_inputs(const btf_material *material, const uint32_t *decode, uint32_t *floor) {
    btf_ref_material m;
    reference_view(material, 0, &m);
    for (int i = 0; i < RIG_PIXELS; ++i, decode += GPU_INPUTS, floor += GPU_INPUTS) {
        float f[8];
        int32_t q[2];
        uint32_t first, tried;
        memcpy(f, decode, sizeof f);
        floor[0] = btf_ref_coordinate(f[0], m.width) >> 18;
        floor[1] = m.height - 1 - (btf_ref_coordinate(f[1], m.height) >> 18);
        for (int of_lights = 0; of_lights < 2; ++of_lights) {
            const uint16_t *table = of_lights ? m.light_table : m.view_table;
            uint32_t grid = of_lights ? m.light_grid : m.view_grid;
            btf_ref_project(f + (of_lights ? 2 : 5), q);
            btf_ref_neighbours n = btf_ref_lookup(table, grid, q);
            tried = records_tried(table, grid, q, &first);
            floor[2 + of_lights] = n.index[0] | n.index[1] << 16;
            floor[4 + of_lights] = n.index[2] | tried << 16;
            floor[6 + of_lights] = first;
        }
    }
}

static double seconds(const decode_rig *rig) {
    return rig->software ? rig_core_seconds() : rig_wall_seconds();
}

/* How often a picture is drawn for one measurement: small pictures so often that all have the same number of pixels; on
 * a GPU until drawing takes long compared with waiting for it. 0: failed. */
static int draws_of(const decode_rig *rig, unsigned program, int side) {
    static const double long_enough = 0.02; /* seconds */
    int draws = 2 * (RIG_SIDE / side) * (RIG_SIDE / side);
    while (!rig->software && draws < 1 << 16) {
        const double before = seconds(rig);
        if (gpu_draw(rig->gpu, program, side, draws) != BTF_OK) {
            return 0;
        }
        if (seconds(rig) - before >= long_enough) {
            break;
        }
        draws *= 2;
    }
    return draws;
}

double rig_measure(decode_rig *rig, unsigned program, const uint32_t *inputs, int side,
                   double *out_spread) {
    double ns[RIG_MOST_REPEATS];
    if (gpu_run(rig->gpu, program, RIG_PIXELS, inputs, rig->outputs, rig->log) != BTF_OK) {
        return 0;
    }
    const int draws = draws_of(rig, program, side);
    if (draws == 0) {
        return 0;
    }
    for (int i = 0; i < rig->repeats; ++i) {
        double before = seconds(rig);
        if (gpu_draw(rig->gpu, program, side, draws) != BTF_OK) {
            return 0;
        }
        ns[i] = 1e9 * (seconds(rig) - before) / ((double)draws * side * side);
    }
    qsort(ns, (size_t)rig->repeats, sizeof *ns, compare_double);
    double median = ns[rig->repeats / 2];
    if (out_spread) {
        *out_spread = (ns[rig->repeats - 1] - ns[0]) / median;
    }
    return median;
}

rig_variant rig_variant_create(decode_rig *rig, const btf_material *material,
                               const btf_shader_options *shader, const char *body, int first_unit) {
    btf_shader_options options = *shader;
    rig_variant variant = {0};
    char *text = NULL;
    options.struct_size = sizeof options;
    options.have_precise = rig->have_precise;
    if (btf_shader_source(material, &options, rig->log, &text) != BTF_OK) {
        return variant;
    }
    variant.program = gpu_program(rig->gpu, NULL, text, body, rig->log);
    btf_free(text);
    btf_gl_options upload = gpu_gl_options(rig->gpu, &options);
    if (variant.program &&
        (btf_gl_upload(material, &upload, rig->log, &variant.gl) != BTF_OK ||
         btf_gl_bind(variant.gl, variant.program, first_unit, NULL, rig->log, NULL) != BTF_OK)) {
        rig_variant_destroy(rig, &variant);
    }
    return variant;
}

void rig_variant_destroy(decode_rig *rig, rig_variant *variant) {
    btf_gl_destroy(&variant->gl);
    if (variant->program) {
        gpu_delete_program(rig->gpu, variant->program);
    }
    variant->program = 0;
}

double rig_measure_variant(decode_rig *rig, const btf_material *material, const btf_shader_options *shader,
                           const char *body, const uint32_t *inputs, double *out_spread) {
    rig_variant variant = rig_variant_create(rig, material, shader, body, GPU_FIRST_UNIT);
    double ns = variant.program ? rig_measure(rig, variant.program, inputs, RIG_SIDE, out_spread) : 0;
    rig_variant_destroy(rig, &variant);
    return ns;
}

static void fill_random(unsigned char *bytes, size_t size) {
    random_state r = {size};
    for (size_t i = 0; i + 8 <= size; i += 8) {
        uint64_t bits = random_bits(&r);
        memcpy(bytes + i, &bits, sizeof bits);
    }
}

unsigned rig_texture(decode_rig *rig, int unit, int format, int width, int height, int layers,
                     const unsigned char *bytes) {
    const gl_api *api = gpu_api(rig->gpu);
    size_t size = 4 * (size_t)width * (size_t)height * (size_t)(layers ? layers : 1);
    GLenum target = layers ? GL_TEXTURE_2D_ARRAY : GL_TEXTURE_2D;
    unsigned char *own = bytes ? NULL : malloc(size);
    GLuint texture = 0;
    if (!bytes && !own) {
        return 0;
    }
    if (own) {
        fill_random(own, size);
    }
    api->ActiveTexture((GLenum)(GL_TEXTURE0 + unit));
    api->GenTextures(1, &texture);
    api->BindTexture(target, texture);
    if (layers) {
        api->TexParameteri(target, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
        api->TexParameteri(target, GL_TEXTURE_MAX_LEVEL, 0);
        api->TexImage3D(target, 0, format, width, height, layers, 0, GL_RGBA, GL_UNSIGNED_BYTE,
                        own ? own : bytes);
    } else {
        api->TexImage2D(target, 0, format, width, height, 0, GL_RGBA, GL_UNSIGNED_BYTE, own ? own : bytes);
        api->GenerateMipmap(target);
    }
    free(own);
    return texture;
}

void rig_texture_delete(decode_rig *rig, int count, const unsigned *textures) {
    const gl_api *api = gpu_api(rig->gpu);
    api->DeleteTextures(count, textures);
}

void rig_sampler(decode_rig *rig, unsigned program, const char *name, int unit) {
    const gl_api *api = gpu_api(rig->gpu);
    api->UseProgram(program);
    api->Uniform1i(api->GetUniformLocation(program, name), unit);
}

btf_result rig_create(const context_device *device, int repeats, const btf_log *log, char *why,
                      size_t why_size, decode_rig *rig) {
    *rig = (decode_rig){.log = log,
                        .repeats = repeats < 1                  ? 1
                                   : repeats > RIG_MOST_REPEATS ? RIG_MOST_REPEATS
                                                                : repeats,
                        .have_precise = device->enable_gpu_shader5};
    context_prepare(device);
    rig->gpu = gpu_create(device, why, why_size);
    if (!rig->gpu) {
        return BTF_ERROR_UNSUPPORTED;
    }
    rig->software = strstr(gpu_name(rig->gpu), "llvmpipe") || strstr(gpu_name(rig->gpu), "softpipe") ||
                    strstr(gpu_name(rig->gpu), "SwiftShader");
    rig->inputs = calloc(RIG_PIXELS, GPU_INPUTS * sizeof *rig->inputs);
    rig->outputs = calloc(RIG_PIXELS, GPU_OUTPUTS * sizeof *rig->outputs);
    if (!rig->inputs || !rig->outputs) {
        snprintf(why, why_size, "out of memory");
        rig_destroy(rig);
        return BTF_ERROR_MEMORY;
    }
    for (int i = 0; i < RIG_PIXELS; ++i) {
        float f[8];
        rig_sphere_pixel(i, f);
        memcpy(rig->inputs + GPU_INPUTS * (size_t)i, f, sizeof f);
    }
    return BTF_OK;
}

void rig_destroy(decode_rig *rig) {
    free(rig->inputs);
    free(rig->outputs);
    gpu_destroy(&rig->gpu);
    *rig = (decode_rig){0};
}
