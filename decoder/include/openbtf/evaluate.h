/* OpenBTF: radiance of a material on the CPU, for many arguments at a time.
 *
 * The bits are those of FORMAT.md section 9, hence of the reference decoder and of the GLSL; arrays in, an
 * array out. An evaluator keeps copies of what it reads most in an order of its own: as many bytes as the
 * residual has.
 *
 * Thread rule: the library makes no threads. An evaluator is immutable once made; any number of threads may
 * evaluate with it at the same time, each into its own part of an array.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_EVALUATE_H
#define OPENBTF_EVALUATE_H

#include <openbtf/shader.h>

#ifdef __cplusplus
extern "C" {
#endif

/** A material made ready for evaluation on the CPU; btf_evaluator_create makes it. */
typedef struct btf_evaluator btf_evaluator;

/** How to decode. All zeros is a good default; a null pointer means that too. */
typedef struct btf_evaluate_options {
    size_t struct_size;  /**< sizeof(btf_evaluate_options) */
    uint32_t leave_out;  /**< btf_effect bits not to decode; default 0: decode all that the file has */
    uint32_t components; /**< at most so many components of the residual, or units, where its store is
                              factors; default 0: all */
    btf_interpolation interpolation; /**< of directions; default linear */
    btf_filter filter;               /**< of texels; default the texel that holds uv */
} btf_evaluate_options;

/** The arguments of many evaluations, and the array that their radiance goes to. Directions are unit vectors of the
 * tangent frame (x along +u, y along +v, z the normal). */
typedef struct btf_evaluations {
    size_t struct_size; /**< sizeof(btf_evaluations) */
    size_t count;       /**< evaluations: the length of each array */
    const float *uv; /**< [count][2] texture coordinates: (0, 0) is the lower left corner of the image,
                        which repeats beyond [0, 1) */
    const uint32_t *texels; /**< [count][2] column and row of the level, row 0 the top, where uv is NULL:
                               whole texels, whatever the filter; both wrap at the level's size */
    const float *lights;    /**< [count][3] to the light; with BTF_FIXED_LIGHT [3], the same for all */
    const float *views;     /**< [count][3] to the viewer; with BTF_FIXED_VIEW [3], the same for all */
    const int32_t *levels;  /**< [count] levels of detail, 0 the finest; beyond the last it is the last,
                               below 0 it is 0. NULL: 0 */
    uint32_t fixed;         /**< btf_fixed bits */
    size_t stride; /**< floats from one uv, light or view to the next where they lie in one table, at
                      least 3, or 2 where both directions are fixed; 0: 2, 3 and 3 */
    float *rgb; /**< [count][3] linear Rec. 709 radiance, cosine included, for unit irradiance / pi; 0 below
                   the horizon. Finite and >= 0 for every argument */
} btf_evaluations;

/** Prepares a material, all of its levels; the material must outlive the evaluator. Errors: BTF_ERROR_USAGE
 * (a null pointer), BTF_ERROR_MEMORY, BTF_ERROR_UNSUPPORTED (a build that does not round floats as
 * FORMAT.md section 8 says). *out_evaluator is freed with btf_evaluator_destroy. */
btf_result btf_evaluator_create(const btf_material *material, const btf_log *log,
                                btf_evaluator **out_evaluator);

/** Frees *evaluator and sets it to NULL. NULL and a pointer to NULL are accepted. */
void btf_evaluator_destroy(btf_evaluator **evaluator);

/** Evaluates. Neighbours that share their light, view and level, bit for bit, are evaluated together: sort
 * by them where that is easy. Errors: BTF_ERROR_USAGE (a null pointer, an enum value, a struct_size too
 * small to be one); nothing is written then. */
btf_result btf_evaluate_many(const btf_evaluator *evaluator, const btf_evaluate_options *options,
                             const btf_evaluations *evaluations);

#ifdef __cplusplus
}
#endif
#endif
