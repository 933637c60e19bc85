/* Decoding a solution at its own sampled directions: FORMAT.md section 9 where every weight is 4096, a
 * light profile at a time. It measures and pictures what an encode gives; results agree with the reference
 * decoder up to float rounding (tested), and are not normative.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_MODEL_DECODE_SAMPLES_H
#define OPENBTF_ENCODER_MODEL_DECODE_SAMPLES_H

#include "encoder/data/images.h"
#include "solution.h"

typedef struct enc_playback enc_playback;

/* Keeps pointers to `data` (directions only) and `solution`. */
btf_result enc_playback_create(const enc_context *context, const enc_data *data,
                               const enc_solution *solution, enc_playback **out_playback);
void enc_playback_destroy(enc_playback **playback);

/* Decodes with the effects that both `effects` and the solution have. */
typedef struct enc_played {
    const enc_playback *playback;
    uint32_t effects;
} enc_played;

/* An image source of the decoded BTF; `decoded` must outlive it. */
enc_image_source enc_played_images(const enc_played *decoded);

#endif
