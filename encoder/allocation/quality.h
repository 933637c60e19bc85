/* The fewest bytes that reach a quality: which budget to try next.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_ALLOCATION_QUALITY_H
#define OPENBTF_ENCODER_ALLOCATION_QUALITY_H

#include "allocate.h"

enum { ENC_QUALITY_BUDGETS = 512 }; /* from 256 units down to one, a hundredth apart */

/* Budgets, falling, each at least a hundredth less than the one before, whose plans differ. The first one
 * is known to reach the quality. */
typedef struct enc_quality_search {
    double quality; /* dB */
    size_t count;
    uint64_t budget[ENC_QUALITY_BUDGETS];
    double expected[ENC_QUALITY_BUDGETS]; /* dB of roots that the allocation expects; encodes reach more */
    size_t reaches, fails;                /* the indices, of budgets that were tried, of the smallest that
                                             reaches and of the largest that fails; `count` while none has
                                             failed */
    double above[2];                      /* dB reached over those expected, of these two */
} enc_quality_search;

/* Lists budgets for components of these energies, from `most`, which reached `decibels`, down to `least`,
 * both of factors alone. Returns false when out of memory, or where `most` holds no unit. */
bool enc_quality_begin(const enc_factor_energies *energies, size_t texels, size_t n_views, size_t n_lights,
                       uint64_t most, uint64_t least, double quality, double decibels,
                       enc_quality_search *out);

/* The index of the budget to try next: the smallest that is expected to reach the quality, or the one after
 * the smallest that has; `count` where none is left between what reaches and what fails. */
size_t enc_quality_next(const enc_quality_search *search);

/* Notes the quality that the encode of a budget reached. */
void enc_quality_note(enc_quality_search *io_search, size_t index, double decibels);

#endif
