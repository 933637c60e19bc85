/* The lights that gloss looks up when a view or a light is left out (FORMAT.md section 9, Gloss).
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_REPORT_LEFT_OUT_LIGHTS_H
#define OPENBTF_ENCODER_REPORT_LEFT_OUT_LIGHTS_H

#include "encoder/data/data.h"

#include <openbtf/reference.h>

typedef struct enc_left_out_lights enc_left_out_lights;

/* Prepares look-ups for the directions of `data`, which must outlive them; share: of the half vector, in
 * quarters. For each light, all others are triangulated. Errors: those of enc_interpolator_create,
 * BTF_ERROR_MEMORY (not logged). */
btf_result enc_left_out_lights_create(const enc_context *context, const enc_data *data, uint32_t share,
                                      enc_left_out_lights **out_lights);
void enc_left_out_lights_destroy(enc_left_out_lights **lights);

/* Finds the lights that each neighbour of a view looks up for one of the data's lights, as indices of the
 * data's list; with `left_out`, among the other lights alone. Thread-safe. */
void enc_left_out_lights_find(const enc_left_out_lights *lights, int view, const btf_ref_neighbours *views,
                              int light, bool left_out, btf_ref_neighbours out_lights[3]);

#endif
