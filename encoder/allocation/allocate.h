/* Allocation of bytes: which components are kept, and in how many bits each, for the least error.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_ALLOCATE_H
#define OPENBTF_ENCODER_ALLOCATE_H

#include "classes.h"

#include <stdbool.h>
#include <stdint.h>

/* Words of each class and channel; the words of a class fill whole units. */
typedef struct enc_factor_plan {
    uint32_t words[ENC_FACTOR_CLASSES][ENC_FACTOR_CHANNELS];
} enc_factor_plan;

typedef struct enc_factor_energies {
    size_t rank[ENC_FACTOR_CHANNELS];
    const double *energy[ENC_FACTOR_CHANNELS]; /* [rank] falling */
    /* [class] share of a component's energy that its rounding is thought to leave; NULL: what rounding to the
     * nearest levels leaves */
    const double *rounding;
} enc_factor_energies;

/* Units of a class, units in all, and texels of u in all. */
uint32_t enc_factor_units(const enc_factor_plan *plan, int class);
uint32_t enc_factor_all_units(const enc_factor_plan *plan);
uint32_t enc_factor_u_texels(const enc_factor_plan *plan);

/* Components of a channel that a class holds: its words' capacity, and for class 0 at most what there is,
 * the rest being codes of zero. rank: components of the channel. */
size_t enc_factor_held(const enc_factor_plan *plan, int class, int channel, size_t rank);

/* Bytes on the GPU: texels of u and w, scales, and the views' factors. */
uint64_t enc_factor_bytes(const enc_factor_plan *plan, size_t texels, size_t n_views, size_t n_lights);

/* The error that a plan leaves: what it leaves out, and what classes from `first_rounded` on round off. */
double enc_factor_plan_error(const enc_factor_energies *energies, const enc_factor_plan *plan,
                             int first_rounded);

/* The plan of the least error within `budget` bytes and the limits of the format. Each channel's components
 * are taken by falling energy, the first into class 0. Returns false where not one unit fits. */
bool enc_factor_allocate(const enc_factor_energies *energies, size_t texels, size_t n_views,
                         size_t n_lights, uint64_t budget, enc_factor_plan *out_plan);

#endif
