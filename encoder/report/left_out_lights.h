/* The lights that gloss looks up when a view or a light is left out (FORMAT.md section 9, Gloss).
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_REPORT_LEFT_OUT_LIGHTS_H
#define OPENBTF_ENCODER_REPORT_LEFT_OUT_LIGHTS_H

#include "encoder/data/data.h"

#include <openbtf/reference.h>

typedef struct enc_left_out_lights enc_left_out_lights;

/* Makes the lights for the directions of `data`, which must outlive it; share: of the half vector, in quarters. All lights
 * but one are triangulated for each. Errors: those of enc_interpolator_create, BTF_ERROR_MEMORY (not
 * logged). */
btf_result enc_left_out_lights_create(const enc_context *context, const enc_data *data, uint32_t share,
                                      enc_left_out_lights **out_lights);
void enc_left_out_lights_destroy(enc_left_out_lights **lights);

/* The lights of each neighbour of a view, for one of the data's lights; `left_out`: by the others alone.
 * Indices of the data's list. Thread-safe. */
void enc_left_out_lights_find(const enc_left_out_lights *lights, int view, const btf_ref_neighbours *views,
                              int light, bool left_out, btf_ref_neighbours out_lights[3]);

#endif
