/* Sums over codes, and powers. See kernels.h.
 *
 * The sums over the lights of a pair of codes are made first, one for all texels: sum_b w_b (2 c_b - m),
 * for codes c of 0 to m, is twice `sum_b w_b c_b - 2048 m`, since weights sum to 4096; that is within
 * -30720 .. 30720 for 4 bits, so that 16 bits hold it and one instruction multiplies and adds pairs of them
 * with levels of u. Integers are exact in any order. The rest is in the order of FORMAT.md.
 *
 * SPDX-License-Identifier: MIT
 */
#include "kernels.h"

#include "exact.h"

enum { UNIT = BTFI_UNIT_BYTES, MOST_CODES = 4 * UNIT, WORDS = 4, LIGHTS = 3 };

typedef float four_floats __attribute__((vector_size(16)));
typedef uint8_t bytes __attribute__((vector_size(16)));
typedef int8_t signed_bytes __attribute__((vector_size(16)));
typedef uint16_t halves __attribute__((vector_size(32)));
typedef int16_t signed_halves __attribute__((vector_size(32), may_alias));
typedef int32_t words __attribute__((vector_size(64)));

/* Codes of a unit under the lights of a view, weighted. */
typedef struct lit_unit {
    signed_halves codes[MOST_CODES / UNIT]; /* half of the sum in the comment at the top: classes 1 to 4 */
    words bytes;                            /* class 0 */
} lit_unit;

/* Where the lights' codes are, and their weights. */
typedef struct lit {
    const uint8_t *w[LIGHTS];
    uint16_t weight[LIGHTS];
} lit;

BTFI_INLINE void load(const uint8_t *from, bytes *out) {
    memcpy(out, from, sizeof *out);
}

/* Codes of `bits` bits, the lowest of each byte first. */
BTFI_INLINE void light_codes(const lit *at, size_t unit, int bits, signed_halves *out) {
    const uint8_t mask = (uint8_t)((1 << bits) - 1);
    const uint16_t middle = (uint16_t)(2048 * mask);
    bytes from[LIGHTS];
    for (int b = 0; b < LIGHTS; b++) {
        load(at->w[b] + UNIT * unit, &from[b]);
    }
    for (int part = 0; part < 8 / bits; part++) {
        const bytes a = from[0] >> bits * part & mask, b = from[1] >> bits * part & mask,
                    c = from[2] >> bits * part & mask;
        out[part] = (signed_halves)(__builtin_convertvector(a, halves) * at->weight[0] +
                                    __builtin_convertvector(b, halves) * at->weight[1] +
                                    __builtin_convertvector(c, halves) * at->weight[2] - middle);
    }
}

BTFI_INLINE void light_bytes(const lit *at, size_t unit, words *out) {
    bytes from[LIGHTS];
    for (int b = 0; b < LIGHTS; b++) {
        load(at->w[b] + UNIT * unit, &from[b]);
    }
    *out = __builtin_convertvector((signed_bytes)from[0], words) * (int32_t)at->weight[0] +
           __builtin_convertvector((signed_bytes)from[1], words) * (int32_t)at->weight[1] +
           __builtin_convertvector((signed_bytes)from[2], words) * (int32_t)at->weight[2];
}

/* 2 code - most, of codes of 4 or 2 bits. */
BTFI_INLINE void few_levels(const bytes *from, int down, int bits, signed_halves *out) {
    const uint8_t mask = (uint8_t)((1 << bits) - 1);
    const signed_bytes level = (signed_bytes)(2 * (*from >> down & mask) - mask);
    *out = __builtin_convertvector(level, signed_halves);
}

/* Levels of u of a unit, in the order of light_codes(). */
BTFI_INLINE void texel_levels(int class_index, const uint8_t *u, signed_halves *out) {
    bytes from[2];
    load(u, &from[0]);
    if (class_index == 1 || class_index == 3) {
        load(u + UNIT, &from[1]);
    }
    switch (class_index) {
    case 1:
        out[0] = (signed_halves)(2 * __builtin_convertvector(from[0], halves) - 255);
        out[1] = (signed_halves)(2 * __builtin_convertvector(from[1], halves) - 255);
        break;
    case 2:
        few_levels(&from[0], 0, 4, &out[0]);
        few_levels(&from[0], 4, 4, &out[1]);
        break;
    case 3:
        for (int part = 0; part < 4; part++) {
            few_levels(&from[part / 2], 4 * (part % 2), 4, &out[part]);
        }
        break;
    default:
        for (int part = 0; part < 4; part++) {
            few_levels(&from[0], 2 * part, 2, &out[part]);
        }
        break;
    }
}

/* e >> s of a class, of half of e. */
BTFI_INLINE int32_t scaled_down(int class_index, int32_t half) {
    return class_index == 1 ? half >> 4 : class_index == 2 ? half : 2 * half;
}

/* A unit of class 1 to 4 with one texel: adds to the sums of its tier. */
BTFI_INLINE void add_codes(const btfi_unit *unit, int class_index, const signed_halves *of_light,
                           const uint8_t *u, float sums[3]) {
    enum { PARTS_4 = 2, PARTS_2 = 4 };
    signed_halves of_texel[MOST_CODES / UNIT];
    const int16_t *codes = (const int16_t *)of_light, *levels = (const int16_t *)of_texel;
    const int count = (class_index < 3 ? PARTS_4 : PARTS_2) * UNIT;
    texel_levels(class_index, u, of_texel);
    if (unit->whole) {
        int32_t sum = 0;
        for (int i = 0; i < count; i++) {
            sum += codes[i] * levels[i];
        }
        sums[0] = sums[0] + (float)scaled_down(class_index, sum) * unit->scale[0];
        return;
    }
    int32_t products[UNIT];
    for (int j = 0; j < UNIT; j++) {
        products[j] = codes[j] * levels[j] + codes[UNIT + j] * levels[UNIT + j];
    }
    if (count > 2 * UNIT) {
        for (int j = 0; j < UNIT; j++) {
            products[j] +=
                codes[2 * UNIT + j] * levels[2 * UNIT + j] + codes[3 * UNIT + j] * levels[3 * UNIT + j];
        }
    }
    for (int k = 0; k < WORDS; k++) {
        const int32_t *p = products + 4 * k;
        float *channel = &sums[unit->channel[k]];
        *channel = *channel + (float)scaled_down(class_index, p[0] + p[1] + p[2] + p[3]) * unit->scale[k];
    }
}

/* A unit of class 0. */
BTFI_INLINE void add_bytes(const btfi_unit *unit, const words *codes, const uint8_t *u, float sums[3]) {
    bytes from;
    load(u, &from);
    const words products = *codes * __builtin_convertvector((signed_bytes)from, words);
    for (int k = 0; k < WORDS; k++) {
        const int32_t e = products[4 * k] + products[4 * k + 1] + products[4 * k + 2] + products[4 * k + 3];
        float *channel = &sums[unit->channel[k]];
        *channel = *channel + (float)(e >> 4) * unit->scale[k];
    }
}

/* A unit with all texels. */
BTFI_INLINE void add_unit(const btf_evaluator *e, const btfi_level *level, size_t index, int class_index,
                          const lit *at, const btfi_seen *seen, float sums[][3]) {
    const btfi_unit *unit = &e->units[index];
    lit_unit codes;
    if (class_index == 0) {
        light_bytes(at, index, &codes.bytes);
    } else {
        light_codes(at, index, class_index < 3 ? 4 : 2, codes.codes);
    }
    for (int i = 0; i < seen->count; i++) {
        const uint8_t *u = level->u + seen->texel[i] * e->u_bytes + unit->u;
        if (class_index == 0) {
            add_bytes(unit, &codes.bytes, u, sums[i]);
        } else {
            add_codes(unit, class_index, codes.codes, u, sums[i]);
        }
    }
}

BTFI_INLINE void factors(const btf_evaluator *e, const btfi_level *level, uint32_t units,
                         const btfi_seen *seen, float out_r[][3]) {
    float total[BTFI_MOST_POINTS][3] = {{0}};
    const size_t row = UNIT * (size_t)e->info.components;
    const uint8_t *w = e->w + (size_t)seen->view * e->info.n_lights * row;
    lit at;
    for (int b = 0; b < LIGHTS; b++) {
        at.w[b] = w + seen->lights->index[b] * row;
        at.weight[b] = (uint16_t)seen->lights->weight[b];
    }
    uint32_t i = 0;
    for (int tier = 0; tier < BTFI_TIERS; tier++) {
        float sums[BTFI_MOST_POINTS][3] = {{0}};
        for (; i < units && e->units[i].tier == tier; i++) {
            switch (e->units[i].class_index) {
            case 0:
                add_unit(e, level, i, 0, &at, seen, sums);
                break;
            case 1:
                add_unit(e, level, i, 1, &at, seen, sums);
                break;
            case 2:
                add_unit(e, level, i, 2, &at, seen, sums);
                break;
            case 3:
                add_unit(e, level, i, 3, &at, seen, sums);
                break;
            default:
                add_unit(e, level, i, 4, &at, seen, sums);
                break;
            }
        }
        const float *of_view = e->factor_views + 4 * (BTFI_TIERS * (size_t)seen->view + (size_t)tier);
        for (int p = 0; p < seen->count; p++) {
            for (int c = 0; c < 3; c++) {
                total[p][c] = total[p][c] + sums[p][c] * of_view[c];
            }
        }
    }
    for (int p = 0; p < seen->count; p++) {
        const float y = total[p][0], c1 = total[p][1], c2 = total[p][2];
        out_r[p][0] = y + c1 + c2;
        out_r[p][1] = y - (c2 + c2);
        out_r[p][2] = y - c1 + c2;
    }
}

BTFI_INLINE void components(const btf_evaluator *e, const btfi_level *level, uint32_t k,
                            const btfi_seen *seen, float out_r[][3]) {
    enum { BLOCK = 64 };
    const size_t stored = e->info.components, view = (size_t)seen->view * e->info.n_lights;
    const btfi_neighbours *lights = seen->lights;
    const int8_t *a = e->v + 4 * stored * (view + lights->index[0]),
                 *b = e->v + 4 * stored * (view + lights->index[1]),
                 *c = e->v + 4 * stored * (view + lights->index[2]);
    const int32_t wa = lights->weight[0], wb = lights->weight[1], wc = lights->weight[2];
    four_floats sums[BTFI_MOST_POINTS] = {{0}};
    for (uint32_t first = 0; first < k; first += BLOCK) {
        const uint32_t count = k - first < BLOCK ? k - first : BLOCK;
        float lit_v[BLOCK][4] __attribute__((aligned(16)));
        float *flat = lit_v[0];
        const int8_t *from_a = a + 4 * (size_t)first, *from_b = b + 4 * (size_t)first,
                     *from_c = c + 4 * (size_t)first;
        for (uint32_t i = 0; i < 4 * count; i++) {
            flat[i] = (float)(wa * from_a[i] + wb * from_b[i] + wc * from_c[i]);
        }
        for (int p = 0; p < seen->count; p++) {
            const int8_t *u = level->components + seen->texel[p] * stored + first;
            four_floats sum = sums[p];
            for (uint32_t j = 0; j < count; j++) {
                const float factor = (float)u[j] * e->scales[first + j];
                sum = sum + *(const four_floats *)lit_v[j] * factor;
            }
            sums[p] = sum;
        }
    }
    for (int p = 0; p < seen->count; p++) {
        for (int channel = 0; channel < 3; channel++) {
            out_r[p][channel] = sums[p][channel];
        }
    }
}

BTFI_INLINE void powers(int count, const float *exponents, float *values) {
    for (int first = 0; first < count; first += 8) {
        for (int i = first; i < first + 8; i++) {
            values[i] = btfi_pow(values[i], exponents[i]);
        }
    }
}

#define KERNELS(name, target)                                                                              \
    target static void factors_##name(const btf_evaluator *e, const btfi_level *level, uint32_t units,     \
                                      const btfi_seen *seen, float out_r[][3]) {                           \
        factors(e, level, units, seen, out_r);                                                             \
    }                                                                                                      \
    target static void components_##name(const btf_evaluator *e, const btfi_level *level, uint32_t k,      \
                                         const btfi_seen *seen, float out_r[][3]) {                        \
        components(e, level, k, seen, out_r);                                                              \
    }                                                                                                      \
    target static void powers_##name(int count, const float *exponents, float *values) {                   \
        powers(count, exponents, values);                                                                  \
    }                                                                                                      \
    static const btfi_kernels kernels_##name = {factors_##name, components_##name, powers_##name};

#define EVERY_MACHINE
KERNELS(base, EVERY_MACHINE)
#if defined __x86_64__ && defined __GNUC__
#define WITH_AVX2 __attribute__((target("avx2")))
KERNELS(avx2, WITH_AVX2)
#endif

const btfi_kernels *btfi_kernels_of(btfi_isa limit) {
#if defined __x86_64__ && defined __GNUC__
    if (limit >= BTFI_ISA_AVX2 && __builtin_cpu_supports("avx2")) {
        return &kernels_avx2;
    }
#endif
    (void)limit;
    return &kernels_base;
}
