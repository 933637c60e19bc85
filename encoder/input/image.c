/* One image of a data set, decoded from memory: JPEG, PNG, Radiance HDR or OpenEXR.
 *
 * SPDX-License-Identifier: MIT
 */
#include "image.h"

#include "decoder/toolkit/exr_image.h"
#include "decoder/toolkit/jpeg_image.h"
#include "decoder/toolkit/png_image.h"
#include "decoder/toolkit/hdr_image.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static bool begins_with(const void *data, size_t size, const char *magic, size_t length) {
    return size >= length && memcmp(data, magic, length) == 0;
}

btf_result enc_image_decode(const void *data, size_t size, enc_image *out_image, char *message,
                            size_t message_size) {
    return enc_image_decode_layer(data, size, NULL, out_image, message, message_size);
}

btf_result enc_image_decode_layer(const void *data, size_t size, const char *layer, enc_image *out_image,
                                  char *message, size_t message_size) {
    enc_image image = {.depth = 8, .channels = 3};
    btf_result result;
    message[0] = '\0';
    if (layer && !begins_with(data, size, "\x76\x2f\x31\x01", 4)) {
        snprintf(message, message_size,
                 "option layer: '%s', but this is no OpenEXR file, and other formats have no layers",
                 layer);
        return BTF_ERROR_UNSUPPORTED;
    }
    if (begins_with(data, size, "\xff\xd8", 2)) {
        unsigned char *pixels = NULL;
        result = jpeg_image_read(data, size, ENC_IMAGE_MAX_PIXELS, &image.width, &image.height,
                                 &image.channels, &pixels, &image.info, message, message_size);
        image.pixels = pixels;
    } else if (begins_with(data, size, "\x89PNG", 4)) {
        result = png_image_read(data, size, ENC_IMAGE_MAX_PIXELS, &image.width, &image.height,
                                &image.channels, &image.depth, &image.pixels, &image.info, message, message_size);
    } else if (begins_with(data, size, "#?", 2)) {
        float *pixels = NULL;
        result = hdr_image_read(data, size, ENC_IMAGE_MAX_PIXELS, &image.width, &image.height, &image.xyz,
                                &pixels, &image.info, message, message_size);
        image.depth = 32;
        image.pixels = pixels;
    } else if (begins_with(data, size, "\x76\x2f\x31\x01", 4)) {
        exr_image exr = {0};
        result = exr_image_read(data, size, ENC_IMAGE_MAX_PIXELS, layer, &exr, &image.info, message, message_size);
        image.width = exr.width;
        image.height = exr.height;
        image.channels = exr.channels;
        image.depth = 32;
        image.xyz = exr.xyz;
        image.pixels = exr.pixels;
        if (exr.cube) {
            image_note(&image.info, IMAGE_NOTE_ENVMAP, "EXR: an environment map of six faces, taken as one picture");
        }
    } else {
        snprintf(message, message_size,
                 size == 0 ? "empty file" : "not a JPEG, PNG, Radiance HDR or OpenEXR file");
        return BTF_ERROR_BAD_FILE;
    }
    if (result == BTF_OK) {
        *out_image = image;
    } else if (!message[0]) {
        snprintf(message, message_size, "%s", btf_result_text(result));
    }
    return result;
}

void enc_image_clear(enc_image *image) {
    free(image->pixels);
    image->pixels = NULL;
}
