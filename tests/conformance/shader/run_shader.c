/* A folder of btf-shader on a device, against the reference decoder of the material that it was written from, bit for bit.
 *
 *     run_shader DEVICE FOLDER FILE.btf.exr [--code CODE] [--theta T] [--count N]
 *
 * DEVICE is one of btf-conform's, vulkan or metal; CODE the compute shader where the folder holds no SPIR-V, or for metal the
 * library that a C++ compiler made of metal.py's text; T the greatest theta of views, for what a plan left. The exit code
 * is 7 when a bit of a result or a byte of a texture differs.
 *
 * SPDX-License-Identifier: MIT
 */
#include "decoder/toolkit/reference_view.h"
#include "exported.h"
#include "run_gl.h"
#include "run_metal.h"
#include "run_vulkan.h"
#include <math.h>
#include <openbtf/shader.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { GRID = 256, MOST = GRID * GRID };

static uint32_t seed = 1;

static double uniform(void) {
    seed = seed * 1664525u + 1013904223u;
    return (double)(seed >> 8) / (1 << 24);
}

static void make_direction(double least_z, float out[3]) {
    const double z = least_z + uniform() * (1 - least_z), s = sqrt(fmax(0, 1 - z * z)),
                 phi = 6.283185307179586 * uniform();
    out[0] = (float)(s * cos(phi));
    out[1] = (float)(s * sin(phi));
    out[2] = (float)z;
}

/* The level and the random numbers are those that run_gl.c derives from a pixel's position. */
static void make_records(const exported *e, double theta, size_t count, uint32_t *records) {
    for (size_t i = 0; i < count; i++) {
        const uint32_t x = (uint32_t)i % GRID, counter[3] = {x, (uint32_t)i / GRID, 7};
        float r[9] = {(float)(4 * uniform() - 2), (float)(4 * uniform() - 2)};
        make_direction(-0.05, r + 2);
        make_direction(theta < 90 ? cos(theta * 3.14159265358979 / 180) : -0.05, r + 5);
        if (e->has_fixed_light) {
            memcpy(r + 2, e->fixed_light, sizeof e->fixed_light);
        }
        if (e->has_fixed_view) {
            memcpy(r + 5, e->fixed_view, sizeof e->fixed_view);
        }
        r[8] = (float)(x % e->levels) + (e->picks ? 0.25f * (float)(x / 16 % 4) : 0);
        memcpy(records + i * RECORD, r, sizeof r);
        btf_ref_random(counter, records + i * RECORD + RESULT);
    }
}

static int compare(const exported *e, const btf_material *material, const uint32_t *before,
                   const uint32_t *after, size_t count) {
    btf_ref_material levels[BTF_MAX_LEVELS];
    size_t different = 0, lit = 0;
    for (uint32_t i = 0; i < e->levels; i++) {
        reference_view(material, i + e->first_level, &levels[i]);
    }
    for (size_t i = 0; i < count; i++) {
        float r[9], expected[3];
        memcpy(r, before + i * RECORD, sizeof r);
        if (e->picks) {
            btf_ref_evaluate_stochastic_between(levels, e->levels, &e->options, e->picks, r[8], r[0], r[1],
                                                r + 2, r + 5, before + i * RECORD + RESULT, expected);
        } else {
            btf_ref_evaluate(&levels[(uint32_t)r[8]], &e->options, r[0], r[1], r + 2, r + 5, expected);
        }
        lit += expected[0] > 0;
        different += memcmp(expected, after + i * RECORD + RESULT, sizeof expected) != 0;
    }
    printf("%s: %zu of %zu evaluations differ, %zu are lit\n", e->language, different, count, lit);
    if (lit < count / 4) {
        fprintf(stderr, "too few evaluations are lit to say anything\n");
        return 3;
    }
    return different ? 7 : 0;
}

static void execute(const char *device, const exported *e, const char *path, uint32_t *records,
                    size_t count) {
    if (!strcmp(device, "metal")) {
        run_metal(e, path, records, count);
    } else if (strcmp(device, "vulkan") != 0) {
        run_gl(device, e, records, count);
    } else {
        size_t size = e->text_size;
        unsigned char *code = path ? load_file(path, &size) : NULL;
        if (path && !code) {
            exit(2);
        }
        run_vulkan(e, (const uint32_t *)(const void *)(path ? code : e->text), size, records, count);
        free(code);
    }
}

int main(int argc, char **argv) {
    const char *code = NULL;
    double theta = 90;
    size_t count = 16384;
    for (int i = 4; i + 1 < argc; i += 2) {
        code = !strcmp(argv[i], "--code") ? argv[i + 1] : code;
        theta = !strcmp(argv[i], "--theta") ? atof(argv[i + 1]) : theta;
        count = !strcmp(argv[i], "--count") ? (size_t)atoi(argv[i + 1]) : count;
    }
    if (argc < 4 || count > MOST || count % 64 != 0) {
        fprintf(stderr,
                "usage: run_shader DEVICE FOLDER FILE.btf.exr [--code CODE] [--theta T] [--count N]\n");
        return 1;
    }
    exported e;
    btf_material *material = NULL;
    if (btf_material_open(argv[3], NULL, &material) != BTF_OK) {
        fprintf(stderr, "%s: cannot be opened\n", argv[3]);
        return 2;
    }
    int result = exported_open(argv[2], &e) ? 0 : 3;
    uint32_t *before = calloc(count, RECORD * sizeof *before),
             *after = malloc(count * RECORD * sizeof *after);
    if (!before || !after) {
        return 4;
    }
    if (!result) {
        make_records(&e, theta, count, before);
        memcpy(after, before, count * RECORD * sizeof *after);
        execute(argv[1], &e, code, after, count);
        result = compare(&e, material, before, after, count);
        /* a plan's textures differ from the material's: only their decoded radiance can be compared */
        if (theta >= 90 && exported_differences(&e, material)) {
            result = 7;
        }
    }
    exported_close(&e);
    btf_material_close(&material);
    free(before);
    free(after);
    return result;
}
