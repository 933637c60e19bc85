/* A material decoded at any directions, as often as errors are measured: FORMAT.md section 9 to the bit.
 *
 * The reference decoder takes the codes of factors apart one by one. For materials that have nothing but
 * factors, shift and gain, sums over the levels of all codes are made here in long vectors, and the first
 * units of several counts come from one evaluation. The rest goes to the library's evaluator, and where
 * neighbours are given that no look-up would give, to the reference.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_MODEL_EVALUATOR_H
#define OPENBTF_ENCODER_MODEL_EVALUATOR_H

#include "encoder/base/context.h"
#include "factor_store.h"

#include <openbtf/evaluate.h>
#include <openbtf/reference.h>

typedef struct enc_evaluator enc_evaluator;

/* Evaluates one level of detail; keeps pointers into `material`. Errors: BTF_ERROR_MEMORY. */
btf_result enc_evaluator_create(const enc_context *context, const btf_material *material, uint32_t level,
                                enc_evaluator **out_evaluator);
void enc_evaluator_destroy(enc_evaluator **evaluator);

const btf_ref_material *enc_evaluator_reference(const enc_evaluator *evaluator);

/* Radiance where `evaluations` say, whose levels are not read, by the options; its bits are those of
 * btf_ref_evaluate(), or of btf_ref_evaluate_texel() where texels are given. */
void enc_evaluator_many(const enc_evaluator *evaluator, const btf_ref_options *options,
                        const btf_evaluations *evaluations);

/* A texel, and the levels of the codes of its sources, which evaluations share; one thread at a time. */
typedef struct enc_evaluated_texel enc_evaluated_texel;

/* NULL when out of memory. */
enc_evaluated_texel *enc_evaluated_texel_create(const enc_evaluator *evaluator, size_t texel);
/* To another texel of the same level: levels that are known stay known. */
void enc_evaluated_texel_move(enc_evaluated_texel *evaluated, size_t texel);
void enc_evaluated_texel_destroy(enc_evaluated_texel **texel);

/* Two directions, and their neighbours. */
typedef struct enc_evaluated_at {
    const btf_ref_neighbours *lights, *views;
    const float *light, *view; /* [3] */
    bool looked_up; /* `lights` are the neighbours of the light, so that gloss may look around other directions;
                       else every view takes them as they are (FORMAT.md section 9) */
    bool apart;     /* lights [3], one of each of the views: no other are looked up */
} enc_evaluated_at;

/* The neighbours of a light and of a view of unit length. */
typedef struct enc_evaluated_neighbours {
    btf_ref_neighbours lights, views;
} enc_evaluated_neighbours;
enc_evaluated_neighbours enc_evaluated_look_up(const enc_evaluator *evaluator, const float light[3],
                                               const float view[3]);

/* Radiance with options.effects, options.interpolation, and each of components[0 .. count - 1], which fall;
 * options.components is not read. */
void enc_evaluate(enc_evaluated_texel *texel, const btf_ref_options *options, const enc_evaluated_at *at,
                  const uint32_t *components, size_t count, float out[][3]);

#endif
