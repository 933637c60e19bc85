/* The cost of each effect: its frame time, which is measured here, and its PSNR, from the file's error table.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_VIEW_COSTS_H
#define OPENBTF_VIEW_COSTS_H

#include <openbtf/material.h>
#include <stddef.h>

typedef struct costs {
    double ms[BTF_EFFECT_ALL + 1]; /* time of a frame by effect mask, a running mean; 0: not measured */
} costs;

void costs_clear(costs *c);
void costs_record(costs *c, uint32_t effects, double ms);

/* The error row of the effects as decoded from this file; NULL when the encoder measured none. */
const btf_material_error *costs_error(const btf_material *material, uint32_t effects);

/* Lines for the panel, one for each effect: whether it is on, or not in the file; the milliseconds that it takes and
 * the dB (linear / sRGB) that it gains beside the other effects as they are. "-" where unknown. */
void costs_text(const costs *c, const btf_material *material, uint32_t effects, char *text, size_t size);

#endif
