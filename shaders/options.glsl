/* OpenBTF shaders: the macros that choose a variant, and their defaults.
 *
 * btf_shader_source() writes these lines for a material; by hand, define them before this text. Other macros of
 * yours go behind the whole text: one that is named like a parameter or a variable here would rewrite it.
 *
 *   structure (integer literals; they decide which code exists)
 *     BTF_LAYOUT_TIGHT   0 layout `paper` (one atlas), 1 layout `tight`
 *     BTF_DOMAIN_SQRT    0 linear, 1 the model gives the square root of radiance
 *     BTF_COLOUR         0 mono, 1 rgb, 2 none (no SBRDF)
 *     BTF_LOBES          J, 1..4; 0 with colour none
 *     BTF_SHADOW BTF_SHIFT BTF_HIDDEN BTF_GAIN    1: the effect is in the file and is decoded
 *     BTF_COMPONENTS     k' of the residual that are decoded, 0 none; units, where its store is factors
 *     BTF_CODE_ZERO      1: the file marks hidden points, decoded or not
 *     BTF_FACTORS        1: the residual's store is factors. Default 0. With 1, for each class c of 0..4:
 *     BTF_FACTOR_UNITS_c BTF_FACTOR_C1_c BTF_FACTOR_C2_c    units that are decoded; of their words, those of C1 and C2
 *     BTF_BLEND_ROOTS    1: views are blended as roots. Default 0
 *     BTF_POINTS         1: shift and gain lie packed in one texture; 2: in a list a texel, of which each view has an
 *                        index. Default 0
 *     BTF_RELIEF         1: the file has a relief of one height, 2: of a height map, and it is decoded. Default 0
 *     BTF_GLOSS          1 or 2: the effect is in the file with a share of so many quarters, and is decoded. Default 0
 *   values (any expressions, e.g. uniforms of your own)
 *     BTF_WIDTH BTF_HEIGHT BTF_N_LIGHTS BTF_VIEW_GRID BTF_LIGHT_GRID          uint
 *     BTF_LEVELS                                                              uint, levels of detail; default 1
 *     BTF_ATLAS_WIDTH BTF_ATLAS_HEIGHT BTF_TILES     uint, layout paper; TILES = max(N_v, N_l)
 *     BTF_CENTRE_ROWS                                uint, layout tight with hidden: R of section 3
 *     BTF_RADIANCE_SCALE BTF_SHADOW_SCALE BTF_GAIN_SCALE BTF_CENTRE_SCALE     float; SHADOW_SCALE is
 *                        shadowScale * 2^-12, CENTRE_SCALE is centreScale * 2^-12
 *     BTF_HORIZON_SCALE                              float, with factors
 *     BTF_GAIN_BASE BTF_GAIN_STEP                    float, with BTF_POINTS and BTF_GAIN
 *     BTF_RELIEF_BASE                                int, with relief; with BTF_RELIEF 2 also
 *     BTF_RELIEF_STEP BTF_RELIEF_STEPS               int: of heights, > 0; of a march, >= 1
 *     BTF_RELIEF_LEVEL                               int: reliefLevel; default 0
 *     BTF_RELIEF_END                                 int, >= 1: the first level without relief; not defined: none,
 *                        and no code that asks
 *   how to decode
 *     BTF_NEAREST        1: btf_evaluate takes the nearest directions, 0: it interpolates between three
 *     BTF_BILINEAR       1: four decoded texels are blended, 0: one texel
 *     BTF_STEEP          1, with BTF_BILINEAR: with weights that leave a texel's middle half to itself. Default 0
 *     BTF_STOCHASTIC     0: btf_evaluate and its kin blend all neighbours; 1, 2, 3: in their place stand
 *                        btf_evaluate_stochastic and btf_evaluate_radiance_blend, which pick the view; the view and
 *                        the light; the view, the light and the texel of the filter. Default 0
 *     BTF_FIXED_VIEW     0, or how many neighbours (1 to 3) the one view has that is ever seen; then
 *                        BTF_FIXED_VIEW_INDEX and BTF_FIXED_VIEW_WEIGHT are uvec3 of them, and btf_evaluate
 *                        must be handed this view. BTF_FIXED_LIGHT... likewise, but not with BTF_GLOSS. Default 0
 *     BTF_FOLDED         1: the light never changes, and texture `folded` holds what its texels show in each sampled
 *                        view, as btf_fold_light gives it; 2: nor does the view, and it holds their radiance, as
 *                        btf_fold_both gives it; 3: likewise nor does the view, and it holds what its texels show in
 *                        the three views around it, as btf_fold_neighbour gives it; 4: several lights never change, and
 *                        it holds the sum over lights of what texels show in each sampled view, with BTF_BLEND_ROOTS of
 *                        products of what they show in two. Then the macros above stand for a
 *                        file without any effect but relief (with 2 and 4: without), of colour none and no components;
 *                        neither a fixed light nor, with 2, a fixed view is given; with 1 and 4 BTF_N_VIEWS (uint) is the
 *                        number of views; and with 3 and a fixed view BTF_FIXED_VIEW_LAYER is a uvec3 of the places, 0
 *                        to 2, that its neighbours have where btf_fold_neighbour looks them up. Not with
 *                        BTF_STOCHASTIC. Default 0
 *     BTF_SAMPLING       1: with btf_sample_light and btf_pdf_light, which read the tables of openbtf/sampling.h and
 *                        need both direction tables. Default 0
 *     BTF_FAST_MATH      1: the device's own log2 and exp2, and no order of operations kept
 *   the device
 *     BTF_HAVE_PRECISE   1: the qualifier `precise` exists. Told from the version; define it as 1 when you
 *                        enabled GL_ARB_gpu_shader5 or GL_EXT_gpu_shader5
 *     BTF_ZERO           a uint that is 0 at run time and that no compiler knows to be; needed without
 *                        `precise`. Not defined: the uniform btf_zero is declared (0 until it is set)
 *     BTF_UNIFORM(n)     what stands before the sampler of binding n; default `uniform`, and where WGSL is made of the text
 *                        `layout(set = 0, binding = n) uniform`
 *     BTF_BINDING_...    the bindings, all or none: _SBRDF, _MAPS and so on as in btf_texture_id, the default
 *     BTF_NO_INTERFACE   defined: you declare the samplers yourself
 *
 * FORMAT.md is the specification; its sections are named where they are carried out.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef BTF_FACTORS
#define BTF_FACTORS 0
#endif
#ifndef BTF_BLEND_ROOTS
#define BTF_BLEND_ROOTS 0
#endif
#ifndef BTF_POINTS
#define BTF_POINTS 0
#endif
#ifndef BTF_RELIEF
#define BTF_RELIEF 0
#endif
#ifndef BTF_RELIEF_LEVEL
#define BTF_RELIEF_LEVEL 0
#endif
#ifndef BTF_GLOSS
#define BTF_GLOSS 0
#endif
#ifndef BTF_FOLDED
#define BTF_FOLDED 0
#endif
#if BTF_FOLDED
/* A folded light is not decoded again: neither the textures that the fold replaces nor the light's neighbours are read. */
#define BTF_FIXED_LIGHT 1
#define BTF_FIXED_LIGHT_INDEX uvec3(0u)
#define BTF_FIXED_LIGHT_WEIGHT uvec3(4096u, 0u, 0u)
#if BTF_FOLDED == 2
#define BTF_FIXED_VIEW 1
#define BTF_FIXED_VIEW_INDEX uvec3(0u)
#define BTF_FIXED_VIEW_WEIGHT uvec3(4096u, 0u, 0u)
#endif
#endif
#ifndef BTF_LEVELS
#define BTF_LEVELS 1u
#endif
#ifndef BTF_NEAREST
#define BTF_NEAREST 0
#endif
#ifndef BTF_BILINEAR
#define BTF_BILINEAR 0
#endif
#ifndef BTF_STEEP
#define BTF_STEEP 0
#endif
#ifndef BTF_STOCHASTIC
#define BTF_STOCHASTIC 0
#endif
#ifndef BTF_SAMPLING
#define BTF_SAMPLING 0
#endif
#if BTF_BILINEAR && BTF_STOCHASTIC < 3
#define BTF_TEXELS 4
#else
#define BTF_TEXELS 1
#endif
#define BTF_FACTORS_BY_VIEW ((BTF_SHIFT && !BTF_RELIEF) || BTF_STOCHASTIC > 0)
#ifndef BTF_FAST_MATH
#define BTF_FAST_MATH 0
#endif
#ifndef BTF_FIXED_VIEW
#define BTF_FIXED_VIEW 0
#endif
#ifndef BTF_FIXED_LIGHT
#define BTF_FIXED_LIGHT 0
#endif
#ifndef BTF_HAVE_PRECISE
#if defined(GL_ES)
#if __VERSION__ >= 320
#define BTF_HAVE_PRECISE 1
#else
#define BTF_HAVE_PRECISE 0
#endif
#else
#if __VERSION__ >= 400
#define BTF_HAVE_PRECISE 1
#else
#define BTF_HAVE_PRECISE 0
#endif
#endif
#endif

#if defined(GL_ES) || defined(VULKAN)
precision highp float;
precision highp int;
#endif
