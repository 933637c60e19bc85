/* OpenBTF: the header attributes of a file (FORMAT.md section 7).
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_HEADER_H
#define OPENBTF_HEADER_H

#include "material.h"
#include <openexr.h>

#pragma GCC visibility push(hidden)

/* Attributes that become textures; NULL: not in the file. Each to be freed. */
typedef struct btfi_scales {
    float *residual; /* [component] */
    float *factor;   /* [unit][word] */
    float *view;     /* [view][tier][Y, C1, C2] */
    uint8_t *relief; /* [view] 1 where relief acts, else 0 */
} btfi_scales;

/* Reads and checks every attribute of part 0 into the material: info (half_float aside), directions,
 * scales, provenance, errors. Errors: BTF_ERROR_BAD_FILE, BTF_ERROR_UNSUPPORTED (newer version),
 * BTF_ERROR_MEMORY. */
btf_result btfi_header_read(exr_const_context_t context, const btf_log *log, btf_material *material,
                            btfi_scales *out_scales);

#pragma GCC visibility pop

#endif
