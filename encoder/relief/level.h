/* Surfaces of stored heights, level by level of detail.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_RELIEF_LEVEL_H
#define OPENBTF_ENCODER_RELIEF_LEVEL_H

#include "encoder/model/solution.h"
#include "encoder/nodes/warp.h"

/* The surface of a level of detail of a store, with heights filtered from those of level 0; codes, which
 * may be NULL where there is no map: [texel of the level]. Errors, not logged: BTF_ERROR_MEMORY. */
btf_result enc_relief_level(const enc_relief_store *store, int width, int height, int level,
                            uint8_t **out_codes, enc_warp *out_warp);

#endif
