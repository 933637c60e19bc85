/* One image of a data set, decoded from memory: JPEG, PNG, Radiance HDR or OpenEXR.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_IMAGE_H
#define OPENBTF_ENCODER_IMAGE_H

#include "decoder/pixels/image_info.h"

#include <openbtf/result.h>
#include <stdbool.h>
#include <stddef.h>

/* pixels[row][column][channel], row 0 at the top, as coded in the file: unsigned char (depth 8), unsigned
 * short (16) or float (32, always linear). Alpha is dropped, palettes are resolved. An image that is stored
 * turned, as EXIF says, is refused: its texels would not lie where a viewer shows them. */
typedef struct enc_image {
    int width, height;
    int channels; /* 1 (grey) or 3 */
    int depth;    /* 8, 16 or 32 */
    bool xyz;     /* the file itself says that its channels are X, Y, Z */
    void *pixels; /* malloc'ed */
    image_info info; /* the file's statements about its colours, and notes for the user */
} enc_image;

#ifndef ENC_IMAGE_MAX_PIXELS /* fuzzers take less */
#define ENC_IMAGE_MAX_PIXELS ((size_t)1 << 28)
#endif

/* Decodes by content, not by name. A truncated or damaged file is an error. On failure
 * message[message_size] says what was wrong. Thread-safe. Errors: BTF_ERROR_BAD_FILE,
 * BTF_ERROR_UNSUPPORTED, BTF_ERROR_MEMORY. */
btf_result enc_image_decode(const void *data, size_t size, enc_image *out_image, char *message,
                            size_t message_size);

/* Does the same, but reads of an OpenEXR file the layer or part that `layer` names (exr_choose.h); NULL: as above.
 * Files of other formats have no layers: BTF_ERROR_UNSUPPORTED. */
btf_result enc_image_decode_layer(const void *data, size_t size, const char *layer, enc_image *out_image,
                                  char *message, size_t message_size);

/* Frees the pixels. */
void enc_image_clear(enc_image *image);

#endif
