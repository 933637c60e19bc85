/* Chooses the part and the channels of an OpenEXR file that make the picture.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_PIXELS_EXR_CHOOSE_H
#define OPENBTF_PIXELS_EXR_CHOOSE_H

#include "image_info.h"

#include <openexr.h>

typedef enum exr_kind {
    EXR_KIND_GREY,
    EXR_KIND_RGB,
    EXR_KIND_XYZ,
    EXR_KIND_CHROMA,
    EXR_KIND_SPECTRUM
} exr_kind;

/* channel[]: numbers in the part's list; of R, G, B or X, Y, Z or RY, Y, BY, or the one that is grey. A
 * spectrum's are found by exr_wavelength() and layer. */
typedef struct exr_choice {
    int part;
    exr_kind kind;
    int channel[3];
    char layer[256]; /* the prefix of the channels' names, without the last dot; may be empty */
} exr_choice;

/* A channel of a spectrum, "400nm", "w400.5nm", "T.400,5nm", or of a band, "390.00-410.00nm": its wavelength in
 * nm, 100 to 10000, the middle of a band, and the length of what stands before it, without the last dot; false
 * for any other name. */
bool exr_wavelength(const char *name, double *out_nm, size_t *out_layer_length);

/* layer NULL: the channels R, G, B, or X, Y, Z, or RY, Y, BY, or Y of the first part that belong to no
 * layer; else the only ones of any layer and part, in lower case and by the names red, green, blue too, or
 * the only spectrum. Otherwise `layer` names a layer, a part, or both as PART.LAYER, or a single channel,
 * or is "spectral". Notes what was chosen where that is not the first part's own R, G, B. On failure
 * message[message_size] lists parts and channels. Errors: BTF_ERROR_UNSUPPORTED, BTF_ERROR_BAD_FILE. */
btf_result exr_choose(exr_const_context_t context, const char *layer, exr_choice *out_choice,
                      image_info *info, char *message, size_t message_size);

/* "part NAME" or "part 2"; for messages. */
void exr_part_text(exr_const_context_t context, int part, char *out, size_t size);

#endif
