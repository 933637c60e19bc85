/* Components while they are rounded: which class, word and scale each has, and its levels.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_FACTOR_CODES_H
#define OPENBTF_ENCODER_FACTOR_CODES_H

#include "components.h"
#include "encoder/allocation/allocate.h"

/* Where a component lies. */
typedef struct enc_factor_place {
    uint8_t class;
    uint8_t word;  /* 0 .. 3 of its unit */
    uint8_t index; /* in the word */
    uint16_t unit, u_texel;
    uint16_t
        group; /* 4 * unit + word, of the word whose scale it has: the first of the unit where one scale
                       serves all four */
} enc_factor_place;

typedef struct enc_factor_channel {
    size_t rank;
    enc_factor_place *place; /* [rank] */
    float *step_u, *step_w;  /* [rank] value of a level; equal within a group */
    float *u;                /* [rank][texel] values: level * step_u */
    float *w;                /* [rank][column] values: level * step_w * the view's factor */
} enc_factor_channel;

typedef struct enc_factor_codes {
    enc_factor_plan plan;
    size_t texels, views, lights, columns;
    float *view; /* [view][tier][channel], each 0 or of magnitude 2^-24 .. 2^24 */
    enc_factor_channel channel[ENC_FACTOR_CHANNELS];
} enc_factor_codes;

/* Copies the components that a plan keeps, not rounded yet, with steps of 0. Errors: BTF_ERROR_MEMORY. */
btf_result enc_factor_codes_create(const enc_factor_matrix *matrix, const enc_factor_plan *plan,
                                   const enc_components components[ENC_FACTOR_CHANNELS],
                                   enc_factor_codes *out_codes);
void enc_factor_codes_clear(enc_factor_codes *codes);

/* Adds components of zeros to a channel until the words of class 0 that its plan has are full. Those of a word in use
 * have its steps, others steps of 0. false: out of memory, and the channel is as it was. */
bool enc_factor_codes_extend(enc_factor_codes *io_codes, int channel);

/* Whether unit `unit` of a class has one scale for its four words. */
bool enc_factor_unit_is_pure(const enc_factor_plan *plan, int class, uint32_t unit);

static inline float enc_factor_view(const enc_factor_codes *codes, size_t view, size_t tier, int channel) {
    return codes->view[(view * ENC_FACTOR_TIERS + tier) * ENC_FACTOR_CHANNELS + (size_t)channel];
}

#endif
