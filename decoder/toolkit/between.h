/* The gain, in dB between the samples, of the effects that act there alone (relief and gloss).
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TOOLKIT_BETWEEN_H
#define OPENBTF_TOOLKIT_BETWEEN_H

#include <openbtf/material.h>
#include <stdbool.h>

/* Effects that change nothing at the samples. */
enum { BETWEEN_EFFECTS = BTF_EFFECT_RELIEF | BTF_EFFECT_GLOSS };

/* dB, linear and sRGB-coded, that an effect adds where views (of gloss: views and lights) are left out and
 * predicted from the others, by the material's table of errors between the samples; returns false where the table
 * does not say. */
bool between_gain(const btf_material *material, uint32_t effect, double out_gain[2]);

#endif
