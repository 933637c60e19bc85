/* The gain, in dB between the samples, of the effects that act there alone (relief and gloss).
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TOOLKIT_BETWEEN_H
#define OPENBTF_TOOLKIT_BETWEEN_H

#include <openbtf/material.h>
#include <stdbool.h>

/* The effects that change nothing at the samples, only between them. */
enum { BETWEEN_EFFECTS = BTF_EFFECT_RELIEF | BTF_EFFECT_GLOSS };

/* The dB, linear and sRGB-coded, that an effect adds between the samples, by the material's table of errors there:
 * measured where views (for gloss: views and lights) were left out and predicted from the others. Returns false where
 * the table does not say. */
bool between_gain(const btf_material *material, uint32_t effect, double out_gain[2]);

#endif
