/* OpenBTF shaders: the samplers, one a texture of FORMAT.md section 3, and the run-time zero.
 *
 * Only what the variant reads is declared: at most 13 samplers (layout tight: an SBRDF, shadow, shift, gain, centres,
 * four of factors, heights, view vectors and two tables; 11 where points are packed, 12 where they lie in lists), and two more
 * with BTF_SAMPLING, of the 16 that every GL and ES has for a fragment shader.
 * In Vulkan, BTF_UNIFORM(n) has to give set and binding. WGSL is defined while btf_shader_wgsl() makes WGSL of the text, where
 * the zero has a binding, too. To use samplers of other names, define BTF_NO_INTERFACE and,
 * say, btf_maps as the name of yours.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef BTF_UNIFORM
#ifdef WGSL
#define BTF_UNIFORM(n) layout(set = 0, binding = n) uniform
#else
#define BTF_UNIFORM(n) uniform
#endif
#endif

#ifndef BTF_BINDING_SBRDF
#define BTF_BINDING_SBRDF 0
#define BTF_BINDING_MAPS 1
#define BTF_BINDING_SHADOW 2
#define BTF_BINDING_SHIFT 3
#define BTF_BINDING_GAIN 4
#define BTF_BINDING_CENTRES 5
#define BTF_BINDING_RESIDUAL_TEXELS 6
#define BTF_BINDING_RESIDUAL_DIRECTIONS 7
#define BTF_BINDING_RESIDUAL_SCALES 8
#define BTF_BINDING_VIEW_TABLE 9
#define BTF_BINDING_LIGHT_TABLE 10
#define BTF_BINDING_FACTOR_TEXELS 11
#define BTF_BINDING_FACTOR_DIRECTIONS 12
#define BTF_BINDING_FACTOR_SCALES 13
#define BTF_BINDING_FACTOR_VIEWS 14
#define BTF_BINDING_POINTS 15
#define BTF_BINDING_POINT_LISTS 16
#define BTF_BINDING_POINT_INDICES 17
#define BTF_BINDING_HEIGHTS 18
#define BTF_BINDING_VIEW_VECTORS 19
#define BTF_BINDING_FOLDED 20
#define BTF_BINDING_SAMPLING_TRIANGLES 21
#define BTF_BINDING_SAMPLING_DENSITIES 22
#define BTF_BINDING_ZERO 23
#endif

#ifndef BTF_NO_INTERFACE
#if BTF_COLOUR != 2
BTF_UNIFORM(BTF_BINDING_SBRDF) highp sampler2DArray btf_sbrdf;
#endif
#if BTF_LAYOUT_TIGHT
#if BTF_SHADOW
BTF_UNIFORM(BTF_BINDING_SHADOW) highp usampler2DArray btf_shadow;
#endif
#if BTF_POINTS
#if BTF_SHIFT || BTF_GAIN
#if BTF_POINTS == 2
BTF_UNIFORM(BTF_BINDING_POINT_LISTS) highp usampler2DArray btf_point_lists;
BTF_UNIFORM(BTF_BINDING_POINT_INDICES) highp usampler2DArray btf_point_indices;
#else
BTF_UNIFORM(BTF_BINDING_POINTS) highp usampler2DArray btf_points;
#endif
#endif
#else
#if BTF_SHIFT || BTF_HIDDEN
BTF_UNIFORM(BTF_BINDING_SHIFT) highp usampler2DArray btf_shift;
#endif
#if BTF_GAIN || BTF_HIDDEN || (BTF_SHIFT && BTF_CODE_ZERO)
BTF_UNIFORM(BTF_BINDING_GAIN) highp usampler2DArray btf_gain;
#endif
#endif
#if BTF_HIDDEN
BTF_UNIFORM(BTF_BINDING_CENTRES) highp usampler2D btf_centres;
#endif
#else
#if BTF_SHADOW || BTF_SHIFT || BTF_HIDDEN || BTF_GAIN
BTF_UNIFORM(BTF_BINDING_MAPS) highp usampler2D btf_maps;
#endif
#endif
#if BTF_COMPONENTS > 0 && !BTF_FACTORS
BTF_UNIFORM(BTF_BINDING_RESIDUAL_TEXELS) highp isampler2DArray btf_residual_texels;
BTF_UNIFORM(BTF_BINDING_RESIDUAL_DIRECTIONS) highp isampler2DArray btf_residual_directions;
BTF_UNIFORM(BTF_BINDING_RESIDUAL_SCALES) highp sampler2D btf_residual_scales;
#endif
#if BTF_FACTORS
BTF_UNIFORM(BTF_BINDING_FACTOR_TEXELS) highp usampler2DArray btf_factor_texels;
BTF_UNIFORM(BTF_BINDING_FACTOR_DIRECTIONS) highp usampler2DArray btf_factor_directions;
BTF_UNIFORM(BTF_BINDING_FACTOR_SCALES) highp sampler2D btf_factor_scales;
BTF_UNIFORM(BTF_BINDING_FACTOR_VIEWS) highp sampler2D btf_factor_views;
#endif
#if BTF_RELIEF == 2
BTF_UNIFORM(BTF_BINDING_HEIGHTS) highp usampler2D btf_heights;
#endif
#if BTF_RELIEF || BTF_GLOSS
BTF_UNIFORM(BTF_BINDING_VIEW_VECTORS) highp sampler2D btf_view_vectors;
#endif
#if BTF_FOLDED
BTF_UNIFORM(BTF_BINDING_FOLDED) highp usampler2DArray btf_folded;
#endif
#if BTF_FIXED_VIEW == 0
BTF_UNIFORM(BTF_BINDING_VIEW_TABLE) highp usampler2D btf_view_table;
#endif
#if BTF_FIXED_LIGHT == 0
BTF_UNIFORM(BTF_BINDING_LIGHT_TABLE) highp usampler2D btf_light_table;
#endif
#if BTF_SAMPLING
BTF_UNIFORM(BTF_BINDING_SAMPLING_TRIANGLES) highp usampler2D btf_sampling_triangles;
BTF_UNIFORM(BTF_BINDING_SAMPLING_DENSITIES) highp sampler2D btf_sampling_densities;
#endif
#endif

#if !BTF_HAVE_PRECISE && !BTF_FAST_MATH && !defined(BTF_ZERO)
#ifdef WGSL
BTF_UNIFORM(BTF_BINDING_ZERO) highp uint btf_zero;
#else
uniform highp uint btf_zero;
#endif
#define BTF_ZERO btf_zero
#endif
