/* The decoder in Metal's language on the CPU. See run_metal.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "run_metal.h"

#include <dlfcn.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_BINDINGS = 64 };

/* As metal/metal_stdlib has it. */
typedef struct texture_data {
    uint32_t width, height, layers, levels;
    const uint32_t *level[LOADED_LEVELS];
} texture_data;

static uint32_t float_bits(float value) {
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    return bits;
}

/* IEEE 754 binary16, which files hold without denormals, infinities and NaN. */
static uint32_t half_bits(const unsigned char *at) {
    const uint32_t half = (uint32_t)at[0] | (uint32_t)at[1] << 8, exponent = half >> 10 & 31;
    const float magnitude = exponent ? ldexpf((float)(1024 + (half & 1023)), (int)exponent - 25) : 0;
    return float_bits(half >> 15 ? -magnitude : magnitude);
}

static uint32_t channel(uint32_t vulkan, const unsigned char *texel, uint32_t c) {
    uint32_t word;
    switch (vulkan) {
    case 42: /* VK_FORMAT_R8G8B8A8_SINT */
        return (uint32_t)(int32_t)(signed char)texel[c];
    case 95: /* VK_FORMAT_R16G16B16A16_UINT */
        return (uint32_t)texel[2 * c] | (uint32_t)texel[2 * c + 1] << 8;
    case 97: /* VK_FORMAT_R16G16B16A16_SFLOAT */
        return half_bits(texel + 2 * c);
    case 107: /* VK_FORMAT_R32G32B32A32_UINT and, as bits, _SFLOAT */
    case 109:
        memcpy(&word, texel + 4 * c, sizeof word);
        return word;
    default: /* unsigned bytes */
        return texel[c];
    }
}

/* Four components of 32 bits a texel; those that the format lacks are 0, 0, 1. */
static uint32_t *widen(const exported_texture *t, uint32_t level) {
    const uint32_t channels = t->vulkan == 13 ? 1 : t->vulkan == 20 ? 2 : 4;
    const size_t texels = t->data.size[level] / t->data.texel;
    uint32_t *wide = malloc(texels * 4 * sizeof *wide);
    for (size_t i = 0; wide && i < texels; i++) {
        for (uint32_t c = 0; c < 4; c++) {
            wide[4 * i + c] =
                c < channels ? channel(t->vulkan, t->data.data[level] + i * t->data.texel, c) : c == 3;
        }
    }
    if (!wide) {
        exit(4);
    }
    return wide;
}

void run_metal(const exported *e, const char *library, uint32_t *records, size_t count) {
    static texture_data data[BTF_TEXTURE_COUNT];
    const texture_data *bound[MOST_BINDINGS] = {NULL};
    void *loaded_library = dlopen(library, RTLD_NOW);
    union {
        void *object;
        void (*function)(const texture_data *const *, uint32_t *, size_t);
    } run = {loaded_library ? dlsym(loaded_library, "run_metal") : NULL};
    if (!run.object) {
        fprintf(stderr, "%s\n", dlerror());
        exit(4);
    }
    for (int i = 0; i < e->texture_count; i++) {
        const exported_texture *t = &e->textures[i];
        data[i] = (texture_data){t->data.width, t->data.height, t->data.layers, t->data.levels, {NULL}};
        for (uint32_t k = 0; k < t->data.levels; k++) {
            data[i].level[k] = widen(t, k);
        }
        if (t->binding < MOST_BINDINGS) {
            bound[t->binding] = &data[i];
        }
    }
    run.function(bound, records, count);
    for (int i = 0; i < e->texture_count; i++) {
        for (uint32_t k = 0; k < data[i].levels; k++) {
            free((void *)(uintptr_t)data[i].level[k]);
        }
    }
}
