/* The cost of each effect: its frame time, which is measured here, and its PSNR, from the file's error table.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_VIEW_COSTS_H
#define OPENBTF_VIEW_COSTS_H

#include <openbtf/material.h>
#include <stddef.h>

typedef struct costs {
    double ms[BTF_EFFECT_ALL + 1]; /* the last time of a frame by effect mask; 0: not measured */
} costs;

void costs_clear(costs *c);
void costs_record(costs *c, uint32_t effects, double ms);

/* The error row of the effects as decoded from this file; NULL when the encoder measured none. */
const btf_material_error *costs_error(const btf_material *material, uint32_t effects);

/* Lines for the panel: for each effect of the file whether it is on, its milliseconds and its dB (linear /
 * sRGB): what is gained by having it on beside the other effects as they are. "-" where unknown. */
void costs_text(const costs *c, const btf_material *material, uint32_t effects, char *text, size_t size);

#endif
