/* Bands of elevation, into which tables of errors are divided (FORMAT.md section 7).
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_BANDS_H
#define OPENBTF_ENCODER_BANDS_H

#include "encoder/data/data.h"

#include <openbtf/material.h>

/* Band i reaches from limit[i] to limit[i + 1], degrees. */
typedef struct enc_bands {
    int count;
    double limit[BTF_MAX_BANDS + 1];
} enc_bands;

/* One band a ring, consecutive rings together where there are more than BTF_MAX_BANDS; limits lie midway
 * between rings, the first at the pole, the last on the outermost ring. */
enc_bands enc_bands_make(const enc_direction *directions, int count);

/* Lists the directions of a band, indices in rising order; returns how many there are. */
int enc_bands_members(const enc_bands *bands, int band, const enc_direction *directions, int count,
                      int out_members[ENC_MAX_DIRECTIONS]);

/* Draws a direction of a band, uniformly over its solid angle; seeds of two draws differ by 2 or more. */
void enc_bands_draw(const enc_bands *bands, int band, uint64_t seed, float out_direction[3]);

/* Draws one of the sampled directions of a band; of a band without any, the first of all. */
void enc_bands_draw_sample(const enc_bands *bands, int band, const enc_direction *directions, int count,
                           uint64_t seed, float out_direction[3]);

/* The numbers that a table begins with: counts and limits of both. Returns where its rows begin. */
float *enc_bands_write(const enc_bands *views, const enc_bands *lights, float *out);

#endif
