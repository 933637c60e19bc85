/* The attributes of an OpenEXR file that say what its pixels mean: some are obeyed, some are refused, and the user is
 * told of the others.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TOOLS_EXR_ATTRIBUTES_H
#define OPENBTF_TOOLS_EXR_ATTRIBUTES_H

#include "decoder/pixels/exr_choose.h"

#include <stdbool.h>
#include <stddef.h>

typedef struct exr_attributes {
    bool cube;           /* the picture is the six faces of an environment map */
    primaries primaries; /* of chromaticities; Rec. 709's where the file has none, or they do not apply */
} exr_attributes;

/* Reads the attributes of the chosen part, whose data window is `window`. Primaries other than Rec. 709's, and
 * notes of attributes that are not applied, go to *info. On failure message[message_size] says which attribute
 * is refused. Errors: BTF_ERROR_UNSUPPORTED (an Orientation other than 1). */
btf_result exr_attributes_heed(exr_const_context_t context, const exr_choice *choice,
                               const exr_attr_box2i_t *window, exr_attributes *out_attributes,
                               image_info *info, char *message, size_t message_size);

#endif
