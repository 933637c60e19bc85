/* OpenBTF: the textures of a restriction, out of those of the whole material.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_RESTRICT_TEXTURES_H
#define OPENBTF_RESTRICT_TEXTURES_H

#include "subset.h"

#pragma GCC visibility push(hidden)

/* A restriction in the making: its source, its plan and its result. */
typedef struct btfi_restriction {
    const btf_material *whole;
    uint32_t level;   /* of the whole that becomes level 0 */
    bool shift, gain; /* the plan has that effect */
    btf_material_desc desc;
    btfi_subset views, lights;
    uint8_t acts[BTF_MAX_DIRECTIONS];              /* [view of the restriction] 1 where relief acts */
    uint32_t *centre;                              /* [centre of the whole] its new number, or UINT32_MAX */
    void *made[BTF_MAX_LEVELS][BTF_TEXTURE_COUNT]; /* [level of the restriction] */
} btfi_restriction;

/* Makes the textures that desc.info, views and lights call for, and points desc at them. Counts the centres that are
 * left in desc.info.centres, which holds the number of the whole before. Errors: BTF_ERROR_MEMORY. */
btf_result btfi_restriction_fill(btfi_restriction *restriction, const btf_log *log);

/* Frees the textures and the numbers of centres. */
void btfi_restriction_clear(btfi_restriction *restriction);

#pragma GCC visibility pop

#endif
