/* Hands a material of the library to the reference decoder.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TOOLS_REFERENCE_VIEW_H
#define OPENBTF_TOOLS_REFERENCE_VIEW_H

#include <openbtf/reference.h>
#include <openbtf/material.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Fills *out with pointers into the material's textures, which must outlive it. A level of detail (below
 * info.levels) is a material of its own to the reference: that level's size and textures, and what all
 * levels share. Always succeeds: returns 0. */
int reference_view(const btf_material *material, uint32_t level, btf_ref_material *out);

#ifdef __cplusplus
}
#endif
#endif
