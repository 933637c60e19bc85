/* How an evaluation decodes, as the options say of this material.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_EVALUATE_WAY_H
#define OPENBTF_EVALUATE_WAY_H

#include "prepared.h"

typedef struct btfi_way {
    uint32_t effects;    /* of the material, to be decoded */
    uint32_t components; /* of the residual, or units */
    bool linear;         /* directions */
    btf_filter filter;
} btfi_way;

#endif
