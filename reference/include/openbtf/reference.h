/* OpenBTF reference decoder: the result that a decoder must give, bit for bit (decoder/FORMAT.md, sections 5 to 9).
 *
 * Plain C, no dependency, no thread, no allocation; clarity over speed. A program that takes the sources in
 * puts reference/include on its include path and compiles them with -ffp-contract=off and never with
 * fast-math; btf_ref_self_test() tells whether the build is sound. On 32-bit x86 add -msse2 -mfpmath=sse:
 * where float operations are made in a wider type (x87), the sources refuse to compile.
 *
 * Thread rule: every function is pure; a btf_ref_material may be shared by any number of threads.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_REFERENCE_H
#define OPENBTF_REFERENCE_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Effects, a bit mask: the bits of FORMAT.md section 3. */
enum {
    BTF_REF_SHADOW = 1,
    BTF_REF_SHIFT = 2,
    BTF_REF_HIDDEN = 4,
    BTF_REF_GAIN = 8,
    BTF_REF_RESIDUAL = 16,
    BTF_REF_RELIEF = 32,
    BTF_REF_GLOSS = 64,
};

/** Colour of the SBRDF: one colour a texel, RGB weights of diffuse term and lobes, or no SBRDF. */
enum { BTF_REF_MONO = 0, BTF_REF_RGB = 1, BTF_REF_NONE = 2 };
/** Stores of the residual. */
enum { BTF_REF_COMPONENTS = 0, BTF_REF_FACTORS = 1 };
/** Values in which neighbouring views are blended: radiance, or its square roots. */
enum { BTF_REF_BLEND_RADIANCE = 0, BTF_REF_BLEND_ROOTS = 1 };
/** The classes of factors, each a width of codes (FORMAT.md section 3). */
enum { BTF_REF_FACTOR_CLASSES = 5 };

/** A material as plain textures, exactly as FORMAT.md section 3 has them: [layer][row][column][channel],
 * row 0 the top. Pointers of absent textures are null. The data must have passed the checks of section 2.
 * A level of detail is a material of its own: width, height and the textures with texels are the level's,
 * the rest (centre, residual_directions, residual_scales, factor_directions, factor_scales, factor_views,
 * tables, numbers) is that of level 0. A material of version 1 leaves the members of version 2 zero. */
typedef struct btf_ref_material {
    uint32_t width, height, n_views, n_lights; /**< texels of the level, sampled directions */
    int layout_tight; /**< 0: `maps` is used; 1: shadow, shift, gain, centres are */
    int domain_sqrt;  /**< 1: the model gives the square root of radiance */
    int colour;       /**< BTF_REF_MONO, _RGB, _NONE */
    int half_float;   /**< sbrdf holds 16-bit halves */
    uint32_t lobes, effects, centres, components; /**< J, BTF_REF_ bits, K, k (units, with factors) */
    uint32_t atlas_width, atlas_height;           /**< texels; layout paper */
    float radiance_scale, shadow_scale, gain_scale, centre_scale; /**< factors of section 9 */
    const void *sbrdf;                                            /**< float or half bits */
    const uint8_t *maps;                                          /**< RGBA */
    const uint8_t *shadow;                                        /**< R */
    const uint8_t *shift;                                         /**< RG */
    const uint8_t *gain;                                          /**< R */
    const uint8_t *centre;                                        /**< RGBA */
    const int8_t *residual_texels;                                /**< RGBA */
    const int8_t *residual_directions;                            /**< RGBA */
    const float *residual_scales;                                 /**< RGBA */
    const uint16_t *view_table;                                   /**< RGBA */
    const uint16_t *light_table;                                  /**< RGBA */
    uint32_t view_grid, light_grid;                               /**< G of each table */

    /* version 2 */
    int store;           /**< BTF_REF_COMPONENTS or BTF_REF_FACTORS */
    int blend;           /**< BTF_REF_BLEND_RADIANCE or, with domain_sqrt, BTF_REF_BLEND_ROOTS */
    float horizon_scale; /**< with factors: 1 / l.z of the outermost light, >= 1 */
    uint32_t factor_classes[BTF_REF_FACTOR_CLASSES][3]; /**< of each: units, words of C1, words of C2 */
    const uint32_t *factor_texels;                      /**< RGBA */
    const uint32_t *factor_directions;                  /**< RGBA */
    const float *factor_scales;                         /**< RGBA */
    const float *factor_views;                          /**< RGBA */
    int points_packed; /**< 1: points, or lists of them, in place of shift and gain; layout tight */
    float gain_base, gain_step; /**< with points_packed: gain = base + code * step */
    const uint8_t *points;      /**< RG */
    /** RG, entries of a texel; with point_indices in place of `points`, else null */
    const uint8_t *point_lists;
    const uint8_t *point_indices; /**< R, two views each */
    const uint8_t *heights;       /**< R, with relief_step > 0 */
    const float *view_vectors;    /**< RGBA, with relief or gloss */
    /** With relief: the height of code c is base + ((c * step) >> 8), in 1/256 of a texel of the
     * level that heights were made for. */
    int32_t relief_base, relief_step;
    uint32_t relief_steps; /**< N of a march */
    uint32_t gloss_share;  /**< quarters */
    /** The level of detail that this material is, counted from the level that heights were made for
     * (openbtf.reliefLevel included): moves along the relief halve with each. */
    uint32_t level;
    /** The first level, counted likewise, that is decoded without relief; 0: all have it. */
    uint32_t relief_end;
} btf_ref_material;

/** Directions: the nearest sample, or three neighbours, blended. */
enum { BTF_REF_NEAREST = 0, BTF_REF_LINEAR = 1 };
/** Filter: the texel, four blended by distance, or four blended so that a texel keeps its middle half to itself. */
enum { BTF_REF_TEXEL = 0, BTF_REF_BILINEAR = 1, BTF_REF_STEEP = 2 };

/** How to decode. */
typedef struct btf_ref_options {
    uint32_t effects;    /**< those present in both this mask and the material are decoded */
    uint32_t components; /**< at most this many residual components or units; UINT32_MAX: all */
    int interpolation;   /**< BTF_REF_NEAREST or BTF_REF_LINEAR */
    int filter;          /**< BTF_REF_TEXEL, _BILINEAR or _STEEP */
} btf_ref_options;

/** Three neighbours and integer weights that sum to 4096. */
typedef struct btf_ref_neighbours {
    uint32_t index[3];  /**< of sampled directions */
    uint32_t weight[3]; /**< of 4096 */
} btf_ref_neighbours;

/** Radiance of FORMAT.md section 9 at texture coordinates (u, v): (0, 0) is the lower left corner of the
 * image, which repeats beyond [0, 1). @p light and @p view: unit vectors to the light and to the viewer in
 * the tangent frame (x along +u, y along +v, z the normal). Linear Rec. 709, cosine included, for unit
 * irradiance / pi; 0 below the horizon. Finite and >= 0 for every argument. */
void btf_ref_evaluate(const btf_ref_material *material, const btf_ref_options *options, float u, float v,
                      const float light[3], const float view[3], float out_rgb[3]);

/** The radiance at texel (column, row) of the level, row 0 the top, without texture addressing or filter. */
void btf_ref_evaluate_texel(const btf_ref_material *material, const btf_ref_options *options,
                            uint32_t column, uint32_t row, const float light[3], const float view[3],
                            float out_rgb[3]);

/** btf_ref_evaluate_texel() with neighbours that were looked up before, so that all texels of an image
 * share one look-up: @p lights and @p views are what btf_ref_lookup() gives for @p light and @p view; where
 * options say nearest, btf_ref_nearest() is applied to them here (once more does not change them). The lights are
 * those of every view: no gloss. */
void btf_ref_evaluate_neighbours(const btf_ref_material *material, const btf_ref_options *options,
                                 uint32_t column, uint32_t row, const btf_ref_neighbours *lights,
                                 const btf_ref_neighbours *views, const float light[3], const float view[3],
                                 float out_rgb[3]);

/** btf_ref_evaluate_neighbours() with lights of their own for each of the three views, as gloss has them: @p lights
 * [3], of views->index. */
void btf_ref_evaluate_apart(const btf_ref_material *material, const btf_ref_options *options, uint32_t column,
                            uint32_t row, const btf_ref_neighbours lights[3], const btf_ref_neighbours *views,
                            const float light[3], const float view[3], float out_rgb[3]);

/* Folding: the part of a decode that depends on a light that never changes, or on light and view, is done once and
 * kept; a pixel then reads the kept values. The radiance has the same bits (decoder/README.md, Folding). */

/** The directions that never change where decoding is folded. */
enum {
    BTF_REF_FOLD_LIGHT = 1,      /**< the light */
    BTF_REF_FOLD_BOTH = 2,       /**< the light and the view, of which radiance is kept */
    BTF_REF_FOLD_NEIGHBOURS = 3, /**< the light and the view, of which each neighbouring view is kept */
    BTF_REF_FOLD_SUM = 4,        /**< several lights, of which sums are kept */
};

/** The values that folding kept. */
typedef struct btf_ref_folded {
    int fold; /**< BTF_REF_FOLD_LIGHT, _BOTH, _NEIGHBOURS or _SUM */
    /** [view][row][column][4], of both [row][column][4], of neighbours [neighbour][row][column][4]; as the functions
     * below make them. Of a sum [view][row][column][4], where views are blended as roots [view][4][row][column][4], the
     * bits that btf_fold_sum_rows() of the library makes: no function here does. */
    const float *values;
} btf_ref_folded;

/** @return 1 where @p fold is defined, else 0. That of a light: in materials without an SBRDF, which depends on the
 * viewer between samples, unless gloss is decoded, with which the lights do. That of light and view as radiance:
 * unless relief is decoded, which moves texels by parts of one. That of light and view as neighbours: always. That of
 * several lights: where that of a light is, unless relief is decoded. */
int btf_ref_can_fold(const btf_ref_material *material, const btf_ref_options *options, int fold);

/** Sets rows first_row .. first_row + rows - 1 of the values that texels show in sampled view @p view under
 * @p light: L of section 9, or y where the blend is of roots. @p options says which effects, and whether lights are
 * interpolated. out_values [rows][column][4]; the fourth is 0. */
void btf_ref_fold_light(const btf_ref_material *material, const btf_ref_options *options,
                        const float light[3], uint32_t view, uint32_t first_row, uint32_t rows,
                        float *out_values);

/** Sets the same rows of the radiance that texels show to @p view, which need not be a sample. */
void btf_ref_fold_both(const btf_ref_material *material, const btf_ref_options *options,
                       const float light[3], const float view[3], uint32_t first_row, uint32_t rows,
                       float *out_values);

/** Adds the radiance of one light to the sum of several: sum = sum + values * weight by channel, each product and each sum
 * rounded to float. @p values and @p sum [texels][4], @p weight [3]; the fourth stays. */
void btf_ref_fold_add(size_t texels, const float *values, const float weight[3], float *sum);

/** Sets the same rows of the values that texels show in neighbour @p neighbour (0 to 2) of the three that
 * btf_ref_lookup() gives for @p view (of the nearest, 0): its value under @p light as it is before views are
 * weighted, with gloss under the lights that it has when seen from @p view; 0 where the neighbour weighs
 * nothing. */
void btf_ref_fold_neighbour(const btf_ref_material *material, const btf_ref_options *options,
                            const float light[3], const float view[3], uint32_t neighbour, uint32_t first_row,
                            uint32_t rows, float *out_values);

/** btf_ref_evaluate() with the same options, under the light that was folded; from the view, where that was folded too. */
void btf_ref_evaluate_folded(const btf_ref_material *material, const btf_ref_options *options,
                             const btf_ref_folded *folded, float u, float v, const float light[3],
                             const float view[3], float out_rgb[3]);

/** The neighbours that a stochastic decode picks; the others are blended. */
enum {
    BTF_REF_PICK_VIEW = 1,  /**< the view */
    BTF_REF_PICK_LIGHT = 2, /**< the view and the light */
    BTF_REF_PICK_ALL = 3,   /**< the view, the light and the texel of the filter */
};

/** btf_ref_evaluate() by one of the neighbours in place of all, which three @p random numbers of 32 bits pick: the
 * first the view, the second the light, the third the texel, by their highest bits (FORMAT.md, section 9, Stochastic
 * decode). The mean over all numbers is btf_ref_evaluate_radiance_blend(). @p picks: BTF_REF_PICK_VIEW to _ALL. */
void btf_ref_evaluate_stochastic(const btf_ref_material *material, const btf_ref_options *options, int picks,
                                 float u, float v, const float light[3], const float view[3],
                                 const uint32_t random[3], float out_rgb[3]);

/** Every neighbour that would be picked decoded to radiance, then blended. Where views or lights are blended as
 * roots elsewhere, the result is brighter than btf_ref_evaluate()'s. */
void btf_ref_evaluate_radiance_blend(const btf_ref_material *material, const btf_ref_options *options,
                                     int picks, float u, float v, const float light[3], const float view[3],
                                     float out_rgb[3]);

/** btf_ref_evaluate_stochastic() at @p level between two of the @p count levels of detail, 0 the finest, of which
 * one is picked, too (by bits 8 to 15 of the third number): @p levels are those of one material, by rising level. A
 * level below 0 or NaN counts as 0, one beyond the last as the last. */
void btf_ref_evaluate_stochastic_between(const btf_ref_material *levels, uint32_t count,
                                         const btf_ref_options *options, int picks, float level, float u,
                                         float v, const float light[3], const float view[3],
                                         const uint32_t random[3], float out_rgb[3]);

/** btf_ref_evaluate_radiance_blend() at @p level between two of the levels of detail, which are blended in turn. */
void btf_ref_evaluate_radiance_blend_between(const btf_ref_material *levels, uint32_t count,
                                             const btf_ref_options *options, int picks, float level, float u,
                                             float v, const float light[3], const float view[3],
                                             float out_rgb[3]);

/** Random numbers of a counter, say column, row and frame of a pixel, as btf_random of the shader gives them: PCG3D
 * (Jarzynski and Olano, Hash Functions for GPU Rendering, JCGT 9(3), 2020). */
void btf_ref_random(const uint32_t counter[3], uint32_t out_random[3]);

/** Tables of light sampling (decoder/SAMPLING.md); openbtf/sampling.h of the library makes them of a material. */
typedef struct btf_ref_sampling {
    uint32_t n_triangles;      /**< at least 1 */
    const uint32_t *triangles; /**< RGBA, [n_views + 1][n_triangles] */
    const float *densities;    /**< [n_views][n_lights + 1] */
} btf_ref_sampling;

/** Draws a direction to the light, in proportion to what the material reflects to @p view, from two numbers of 32 random
 * bits, and its density over the solid angle. Texture coordinates are not looked at so far. A view below the horizon
 * gets the normal and density 0. */
void btf_ref_sample_light(const btf_ref_material *material, const btf_ref_sampling *sampling, float u, float v,
                          const float view[3], uint32_t u1, uint32_t u2, float out_light[3], float *out_pdf);

/** The density with which btf_ref_sample_light() draws @p light; 0 where light or view are below the horizon. */
float btf_ref_pdf_light(const btf_ref_material *material, const btf_ref_sampling *sampling, float u, float v,
                        const float view[3], const float light[3]);

/* Integer steps, each as FORMAT.md says. */

/** Section 6: projects a unit vector above the horizon to the plane of the tables, 0 .. 16384 in both. */
void btf_ref_project(const float direction[3], int32_t out_q[2]);
/** Section 6: @return the neighbours of the projected direction @p q, by the direction table @p table, whose G is
 * @p grid. */
btf_ref_neighbours btf_ref_lookup(const uint16_t *table, uint32_t grid, const int32_t q[2]);
/** Section 6: @return the neighbour of the greatest weight, alone. */
btf_ref_neighbours btf_ref_nearest(btf_ref_neighbours neighbours);
/** Section 9: @return t of the texture coordinate @p c on a side of @p size texels; t >> 18 is the texel. */
uint32_t btf_ref_coordinate(float c, uint32_t size);
/** Section 9: sets the two texels of @p t on a side of @p size texels, and the weight of the second, 0 .. 255 of
 * 256. */
void btf_ref_bilinear(uint32_t t, uint32_t size, uint32_t *out_c0, uint32_t *out_c1, uint32_t *out_weight1);
/** Section 5: sets the place in the atlas of layout paper of texel (column, row) of a tile. */
void btf_ref_tile(const btf_ref_material *material, uint32_t tile, uint32_t column, uint32_t row,
                  uint32_t *out_x, uint32_t *out_y);
/** Sections 3 and 5: sets the texel of a centre under a light in `maps` or `centres`. */
void btf_ref_centre(const btf_ref_material *material, uint32_t centre, uint32_t light, uint32_t *out_x,
                    uint32_t *out_y);
/** @return (position + shift) modulo size, of a position below size. */
uint32_t btf_ref_wrap(uint32_t position, int32_t shift, uint32_t size);

/* Exact arithmetic: the same bits everywhere. How far they are from the truth, at most (libm in double;
 * every float of the domain, of pow 2.5e8 random pairs; tests/unit/reference/test_reference.c):
 *
 *  function    domain                          absolute    relative
 *  log2        2^-24 <= x < 2^30               1.05e-6     4.94e-7
 *  exp2        -60 <= x <= 40                              1.04e-7
 *  reciprocal  0.5 <= x <= 4                               9.94e-8
 *  pow         base >= 2^-24, -60 <= t <= 40               1.04e-7 + 3.84e-7 * |t|
 *              base <= 1, exponent >= 0        1.75e-7
 *  half        all                             0           0
 *
 * with t = exponent * log2(base).
 */

/** Section 8: @return the logarithm to base 2 of a normal and positive @p x. */
float btf_ref_log2(float x);

/** Section 8: @return 2 to the power of @p x, which is in [-60, 40]. */
float btf_ref_exp2(float x);

/** Section 8: @return base to the power of exponent; 0 for a base below 2^-24 or NaN, and for a result below 2^-60;
 * at most 2^40. */
float btf_ref_pow(float base, float exponent);

/** Section 8: @return 1 / x of an @p x in [0.5, 4]. */
float btf_ref_reciprocal(float x);

/** @return the float of the bits of a half, exact; infinities and NaN too. */
float btf_ref_half(uint16_t bits);

/** @return 1 when this build rounds float operations and keeps their order as section 8 demands, else 0. */
int btf_ref_self_test(void);

#ifdef __cplusplus
}
#endif
#endif
