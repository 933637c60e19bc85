/* Codes into words. See pack.h.
 *
 * The codes of u lie in their words so that a shader forms a dot product with the codes of w by multiplying
 * words (FORMAT.md): products that fall on one field of bits add up.
 *
 * SPDX-License-Identifier: MIT
 */
#include "pack.h"

#include <stdlib.h>

#include "encoder/model/factor_store.h"

#include <math.h>

/* The code of a value: signed bytes of class 0, else offset binary of odd levels. */
static uint32_t code_of(int class, int top, float value, float step) {
    const int level = step > 0 ? (int)rintf(value / step) : 0;
    const int held = level > top ? top : level < -top ? -top : level;
    return class == 0 ? (uint32_t)held & 0xFF : (uint32_t)((held + top) / 2);
}

static void pack_u(const enc_factor_codes *codes, const enc_factor_channel *channel, size_t j,
                   uint32_t *out) {
    const enc_factor_place *place = &channel->place[j];
    const enc_factor_class *class = &enc_factor_classes[place->class];
    const enc_store_place at = enc_store_place_of_u(place->class, place->index);
    uint32_t *words = out + (place->u_texel + (size_t)at.second) * codes->texels * 4 + place->word;
    for (size_t t = 0; t < codes->texels; t++) {
        words[4 * t] |=
            code_of(place->class, class->top_u, channel->u[j * codes->texels + t], channel->step_u[j])
            << at.bit;
    }
}

static void pack_w(const enc_factor_codes *codes, int c, size_t j, uint32_t *out) {
    const enc_factor_channel *channel = &codes->channel[c];
    const enc_factor_place *place = &channel->place[j];
    const enc_factor_class *class = &enc_factor_classes[place->class];
    uint32_t *words = out + place->unit * codes->columns * 4 + place->word;
    for (size_t i = 0; i < codes->columns; i++) {
        const float step = channel->step_w[j] * enc_factor_view(codes, i / codes->lights, class->tier, c);
        words[4 * i] |= code_of(place->class, class->top_w, channel->w[j * codes->columns + i], step)
                        << (class->bits_w * place->index);
    }
}

/* Whether component j begins a group that shares a scale. Such components share words and follow one
 * another, so that a thread takes them together. */
static bool begins_group(const enc_factor_channel *channel, size_t j) {
    return j == 0 || channel->place[j - 1].group != channel->place[j].group;
}

static void pack_group(const enc_factor_codes *codes, int c, size_t first, uint32_t *texels,
                       uint32_t *directions, float *scales) {
    static const float axis[ENC_FACTOR_CHANNELS] = {0.57735027f, 0.70710678f, 0.40824829f};
    const enc_factor_channel *channel = &codes->channel[c];
    for (size_t j = first; j < channel->rank && (j == first || !begins_group(channel, j)); j++) {
        const enc_factor_place *place = &channel->place[j];
        pack_u(codes, channel, j, texels);
        pack_w(codes, c, j, directions);
        scales[place->unit * 4 + place->word] = channel->step_u[j] * channel->step_w[j] * axis[c];
    }
}

void enc_factor_pack(const enc_context *context, const enc_factor_codes *codes, uint32_t *texels,
                     uint32_t *directions, float *scales) {
    for (int c = 0; c < ENC_FACTOR_CHANNELS; c++) {
        const enc_factor_channel *channel = &codes->channel[c];
#pragma omp parallel for schedule(dynamic) num_threads(context->threads)
        for (size_t j = 0; j < channel->rank; j++) {
            if (begins_group(channel, j)) {
                pack_group(codes, c, j, texels, directions, scales);
            }
        }
    }
}

void enc_factors_destroy(enc_factors **factors) {
    if (factors && *factors) {
        free((*factors)->texels);
        free((*factors)->directions);
        free((*factors)->scales);
        free((*factors)->views);
        free((*factors)->shift);
        free((*factors)->gain);
        free(*factors);
        *factors = NULL;
    }
}
