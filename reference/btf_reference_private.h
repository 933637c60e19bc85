/* OpenBTF reference decoder: declarations that its own files share. Not installed.
 *
 * The build. Every float operation must be one IEEE-754 binary32 operation, in the order of the source.
 * Where the compiler says that it computes in a wider type (FLT_EVAL_METHOD > 0: the x87 of 32-bit x86) the
 * build is refused below; contraction, reassociation and another rounding mode are found by
 * btf_ref_self_test(), which probes every file of the decoder with the flags of that file.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_REFERENCE_PRIVATE_H
#define OPENBTF_REFERENCE_PRIVATE_H

#include <openbtf/reference.h>

#include <float.h>
#include <stdbool.h>

#if FLT_RADIX != 2 || FLT_MANT_DIG != 24 || FLT_MAX_EXP != 128
#error "the reference decoder needs IEEE-754 binary32 floats"
#endif
#if defined FLT_EVAL_METHOD && FLT_EVAL_METHOD > 0
#error                                                                                                     \
    "the reference decoder needs float operations in float: on 32-bit x86 compile with -msse2 -mfpmath=sse"
#endif

/** bits(x) of section 8. */
static inline uint32_t btf_ref_bits(float x) {
    union {
        float value;
        uint32_t bits;
    } pun = {.value = x};
    return pun.bits;
}

/** The float of the given bits. */
static inline float btf_ref_float(uint32_t bits) {
    union {
        uint32_t bits;
        float value;
    } pun = {.bits = bits};
    return pun.value;
}

/** Section 8: neither infinite nor NaN; a test of the bits, which no compiler option can remove. */
static inline bool btf_ref_is_finite(float x) {
    return (btf_ref_bits(x) & 0x7F800000u) != 0x7F800000u;
}

/** floor(x) of a float in -2^31 <= x < 2^31. The conversion truncates and is exact. */
static inline int32_t btf_ref_floor(float x) {
    int32_t truncated = (int32_t)x;
    return (float)truncated > x ? truncated - 1 : truncated;
}

/** value >> shift, rounded down: C leaves open how it shifts negative numbers. */
static inline int32_t btf_ref_shift_down(int32_t value, uint32_t shift) {
    return value >= 0 ? value >> shift : -1 - ((-1 - value) >> shift);
}

/** Whether the file that includes this was compiled to round and to order as written.
 *
 *  The operands come from volatile memory, so that arithmetic at run time is what is probed, and each
 * result goes there at once, so that the expressions stay apart. They have the shapes that compilers
 * rewrite: a product that is added to something (contraction; its operands are read anew, or a product that
 * two sums share would be left alone), sums and products that are regrouped, a common factor. Each expected
 * value differs from what the rewritten form gives. */
static inline bool btf_ref_probe(void) {
#ifdef __FAST_MATH__
    return false;
#else
    enum { CHECKS = 13 };
    static const uint32_t expected[CHECKS] = {
        0x3F800000u, 0x3F800002u, 0x3F800002u, 0xBF800000u,              /* to the nearest, ties to even */
        0x3A000000u, 0x3A000000u, 0xBA000000u, 0x3F801000u,              /* contraction keeps 2^-24 */
        0,           0x3F800000u, 0x40400003u, 0x40400004u, 0x40800002u, /* another order */
    };
    volatile float result[CHECKS];
    volatile float grown = 0x1.001p0f; /* 1 + 2^-12; the square is 1 + 2^-11 + 2^-24, a tie */
    volatile float constants[4] = {1.0f, 0x1.000002p0f, 0x1p-24f, 3.0f};
    const float one = constants[0];
    const float next = constants[1]; /* 1 + 2^-23, the float after 1 */
    const float tiny = constants[2]; /* 2^-24, half a step at 1 */
    const float three = constants[3];

    result[0] = one + tiny;
    result[1] = one + three * tiny;
    result[2] = next + tiny;
    result[3] = -one - tiny;
    float squared = grown * grown;
    squared = squared - one;
    result[4] = squared;
    result[5] = grown * grown - one;
    result[6] = one - grown * grown;
    result[7] = tiny + grown * grown;
    result[8] = (one + tiny) - one;
    result[9] = (tiny + one) + tiny;
    result[10] = (next * next) * three;
    result[11] = next * (next * three);
    result[12] = next * next + next * three; /* next * (next + three) is 0x40800001 */

    bool sound = true;
    for (int i = 0; i < CHECKS; ++i) {
        sound = sound && btf_ref_bits(result[i]) == expected[i];
    }
    return sound;
#endif
}

/** The lights of non-zero weight, in their order; weights sum to 4096. */
typedef struct btf_ref_lights {
    uint32_t count;
    uint32_t index[3];
    int32_t weight[3];
} btf_ref_lights;

/** The part of an evaluation that all texels and views share. */
typedef struct btf_ref_situation {
    const btf_ref_material *material;
    uint32_t effects;             /**< decoded */
    uint32_t components;          /**< decoded; units, with factors */
    float product[3];             /**< P of section 9: l * V by component */
    float cosine;                 /**< m of section 9 */
    float horizon;                /**< m_r of section 9; with factors */
    const btf_ref_folded *folded; /**< what texels show, in place of what the material says; null: none */
} btf_ref_situation;

/** The texels that a filter blends, and their weights of 65536; one of weight 0 is left out. */
typedef struct btf_ref_footprint {
    uint32_t count;
    uint32_t column[4], row[4];
    uint32_t weight[4];
} btf_ref_footprint;

/** The functions below make no symbols of the library. */
#if defined __GNUC__
#pragma GCC visibility push(hidden)
#endif
/** Section 9, Factors: the residual of a source texel in a view, of the first `units` units. */
void btf_ref_factors(const btf_ref_material *material, uint32_t units, const btf_ref_lights *lights,
                     uint32_t column, uint32_t row, uint32_t view, float out_r[3]);

/** The value of a texel that is blended in one view: L of section 9, or y where the blend is of roots. */
void btf_ref_view_value(const btf_ref_situation *s, const btf_ref_lights *lights, uint32_t column,
                        uint32_t row, uint32_t view, float out[3]);

/** Section 9, Directions. @return whether there is anything to be seen. */
bool btf_ref_above_horizon(const float light[3], const float view[3]);

/** Computes from two directions above the horizon the part of a decode that all texels and views share. */
btf_ref_situation btf_ref_make_situation(const btf_ref_material *material, const btf_ref_options *options,
                                         const float light[3], const float view[3]);

/** The neighbours that weigh. */
btf_ref_lights btf_ref_lights_of(const btf_ref_neighbours *neighbours);

/** Section 9, texture coordinates and Steep: @p tu and @p tv have 18 bits below the texel. */
btf_ref_footprint btf_ref_texels_around(const btf_ref_material *material, int filter, uint32_t tu,
                                        uint32_t tv);

/** Within 0 and 2^32; 0 below 2^-30. */
float btf_ref_keep_within(float value);

/** Section 9, Steep: f' of a weight f, of 256. */
uint32_t btf_ref_steep(uint32_t weight);

/** Section 9, slope(d): texels across for a texel of height, times 4096; of a @p direction above the
 * horizon. */
void btf_ref_slope(const float direction[3], int32_t out_slope[2]);

/** Section 9, move(x, z, s), wrapped at the level's size. Positions are in 1/256 of a texel of the level, v
 * upwards. */
void btf_ref_move(const btf_ref_material *material, const int32_t position[2], int32_t height,
                  const int32_t slope[2], int32_t out_position[2]);

/** Section 9, march(x, s): the height of the surface where the ray through @p position meets it first from
 * above. */
int32_t btf_ref_march(const btf_ref_material *material, const int32_t position[2], const int32_t slope[2]);

/** Section 9, Relief: x_a, where each neighbouring view shows the point that @p view sees at @p position,
 * and the weights, less where something hides the point, if @p occlusion is wanted; they sum to 4096. */
void btf_ref_relief(const btf_ref_material *material, const btf_ref_neighbours *views, const float view[3],
                    bool occlusion, const int32_t position[2], int32_t out_positions[3][2],
                    uint32_t out_weights[3]);

/** Section 9, Gloss: q_a, where lights are looked up for the neighbouring view @p index. */
void btf_ref_gloss(const btf_ref_material *material, uint32_t index, const float light[3],
                   const float view[3], int32_t out_q[2]);

/** project(d) of section 8 with k in place of the reciprocal of d.z + 1. */
void btf_ref_project_by(const float direction[3], float k, int32_t out_q[2]);

/** btf_ref_probe() of each file. */
bool btf_ref_probe_arithmetic(void);
bool btf_ref_probe_addressing(void);
bool btf_ref_probe_directions(void);
bool btf_ref_probe_evaluate(void);
bool btf_ref_probe_factors(void);
bool btf_ref_probe_source(void);
bool btf_ref_probe_relief(void);
bool btf_ref_probe_gloss(void);
bool btf_ref_probe_stochastic(void);
bool btf_ref_probe_sampling(void);
#if defined __GNUC__
#pragma GCC visibility pop
#endif

#endif
