/* A material decoded at any directions, as often as errors are measured: FORMAT.md section 9 to the bit.
 *
 * The reference decoder takes the codes of factors apart one by one. Materials that have nothing but
 * factors, shift and gain are decoded here with sums over the levels of all codes in long vectors, and one
 * evaluation gives the radiance for several counts of units. Other materials go to the library's evaluator,
 * or to the reference where the caller gives neighbours that no look-up would give.
 *
 * btf_evaluate_many cannot stand in for it: it looks its neighbours up itself, where measuring by a view or light that
 * is left out gives them, and lights of each view apart; it decodes one count of units, where the table of effect
 * errors asks for all counts of a texel at once; and it keeps no levels of a texel's codes from one call to the next,
 * which here are taken apart once for all pairs of directions. Its interface would have to take on all three for this
 * one caller. Both give the reference's bits, which tests hold of each.
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

/* Decodes `evaluations` at the evaluator's level (their own levels are not read) by the options. The bits
 * are those of btf_ref_evaluate(), or of btf_ref_evaluate_texel() where texels are given. */
void enc_evaluator_many(const enc_evaluator *evaluator, const btf_ref_options *options,
                        const btf_evaluations *evaluations);

/* A texel, and the levels of its sources' codes, which all evaluations of it share; for one thread at a
 * time. */
typedef struct enc_evaluated_texel enc_evaluated_texel;

/* NULL when out of memory. */
enc_evaluated_texel *enc_evaluated_texel_create(const enc_evaluator *evaluator, size_t texel);
/* Goes on to another texel of the same level; levels that were found stay. */
void enc_evaluated_texel_move(enc_evaluated_texel *evaluated, size_t texel);
void enc_evaluated_texel_destroy(enc_evaluated_texel **texel);

/* The light and the view to evaluate at, and their neighbours. */
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

/* Decodes the texel `count` times, with options.effects and options.interpolation: out[i] with the first
 * components[i] components. The counts must fall; options.components is not read. */
void enc_evaluate(enc_evaluated_texel *texel, const btf_ref_options *options, const enc_evaluated_at *at,
                  const uint32_t *components, size_t count, float out[][3]);

#endif
