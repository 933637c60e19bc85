/* A material of the library as the reference decoder takes it.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TOOLS_REFERENCE_VIEW_H
#define OPENBTF_TOOLS_REFERENCE_VIEW_H

#include "btf_reference.h"
#include <openbtf/material.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Fills *out with pointers into the material's textures, which must outlive it. Always succeeds: returns 0.
 */
int reference_view(const btf_material *material, btf_ref_material *out);

#ifdef __cplusplus
}
#endif
#endif
