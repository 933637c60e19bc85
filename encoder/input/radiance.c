/* Converts the file of one image to linear radiance. See radiance.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "radiance.h"

#include "decoder/pixels/primaries.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { MESSAGE_SIZE = 480 }; /* room for the channels of an OpenEXR file */

/* How an image's samples are coded: as the options say, else as the file does. */
static enc_transfer transfer_of(const enc_radiance *r, const enc_image *image, double *out_gamma) {
    *out_gamma = r->options->gamma;
    if (r->options->transfer != ENC_TRANSFER_AUTO || image->depth == 32) {
        return r->options->transfer;
    }
    return enc_transfer_of(image, out_gamma);
}

static btf_result settle_area(const enc_context *context, const char *location, enc_radiance *r) {
    const int *crop = r->options->crop, *size = r->options->size;
    r->area = crop[2] ? (enc_rectangle){crop[0], crop[1], crop[2], crop[3]}
                      : (enc_rectangle){0, 0, r->file_width, r->file_height};
    if (r->area.x > r->file_width - r->area.width || r->area.y > r->file_height - r->area.height) {
        return enc_fail(context, BTF_ERROR_USAGE,
                        "crop %d,%d,%d,%d does not lie within images of %dx%d pixels", crop[0], crop[1],
                        crop[2], crop[3], r->file_width, r->file_height);
    }
    r->width = size[0] ? size[0] : r->area.width;
    r->height = size[1] ? size[1] : r->area.height;
    if (r->width > ENC_MAX_SIDE || r->height > ENC_MAX_SIDE) {
        return enc_fail(context, BTF_ERROR_UNSUPPORTED,
                        "%s: size %dx%d is not usable: each side is 1 to %d (options size and crop make "
                        "images smaller)",
                        location, r->width, r->height, ENC_MAX_SIDE);
    }
    return BTF_OK;
}

btf_result enc_radiance_settle(const enc_context *context, const enc_read_options *options,
                               const char *location, const char *name, const void *file, size_t size,
                               enc_radiance *out) {
    char message[MESSAGE_SIZE] = "";
    enc_image image = {0};
    double gamma;
    *out = (enc_radiance){.options = options};
    const btf_result result =
        enc_image_decode_layer(file, size, options->layer, &image, message, sizeof message);
    if (result != BTF_OK) {
        return enc_fail(context, result, "%s: %s: %s", location, name,
                        message[0] ? message : btf_result_text(result));
    }
    const enc_transfer transfer = transfer_of(out, &image, &gamma);
    out->decoder = enc_decoder_create(transfer, gamma);
    out->file_width = image.width;
    out->file_height = image.height;
    enc_image_clear(&image);
    return out->decoder ? settle_area(context, location, out) : BTF_ERROR_MEMORY;
}

btf_result enc_radiance_settle_first(const enc_context *context, const enc_read_options *options,
                                     enc_source *source, size_t index, void **out_file, size_t *out_size,
                                     enc_radiance *out) {
    char message[MESSAGE_SIZE] = "";
    *out_file = NULL;
    const btf_result result = source->read(source, index, out_file, out_size, message, sizeof message);
    return result == BTF_OK ? enc_radiance_settle(context, options, source->location, source->paths[index],
                                                  *out_file, *out_size, out)
                            : enc_source_fail(context, source, index, result, message);
}

void enc_radiance_clear(enc_radiance *radiance) {
    enc_decoder_destroy(&radiance->decoder);
}

/* Names the first sample that is no number, or below 0 when that is refused; names[channel] in the message. */
static btf_result check_values(const enc_radiance *r, const float *pixels, const char *names,
                               bool refuse_negative, char *message, size_t message_size) {
    const size_t count = (size_t)r->area.width * (size_t)r->area.height * 3;
    for (size_t i = 0; i < count; i++) {
        const bool finite = isfinite(pixels[i]);
        if (finite && !(refuse_negative && pixels[i] < 0.0f)) {
            continue;
        }
        const size_t texel = i / 3, width = (size_t)r->area.width;
        snprintf(message, message_size, "column %zu, row %zu, channel %c is %s (%g)",
                 (size_t)r->area.x + texel % width, (size_t)r->area.y + texel / width, names[i % 3],
                 finite ? "below 0" : "not a finite number", (double)pixels[i]);
        return BTF_ERROR_BAD_FILE;
    }
    return BTF_OK;
}

/* Decodes the part that is used to linear values, in Rec. 709 or the space that the options name. */
static btf_result decode_area(const enc_radiance *r, enc_image *image, float *pixels, char *message,
                              size_t message_size) {
    double gamma;
    const enc_transfer transfer = transfer_of(r, image, &gamma);
    if (r->options->transfer == ENC_TRANSFER_AUTO && image->info.transfer == IMAGE_TRANSFER_OTHER) {
        snprintf(message, message_size,
                 "%s cannot be decoded: give the coding of values by option transfer",
                 image->info.transfer_name);
        return BTF_ERROR_UNSUPPORTED;
    }
    if (enc_decoder_is(r->decoder, transfer, gamma)) {
        enc_decode_pixels(r->decoder, image, r->area, pixels);
    } else {
        enc_decoder *own = enc_decoder_create(transfer, gamma);
        if (!own) {
            return BTF_ERROR_MEMORY;
        }
        enc_decode_pixels(own, image, r->area, pixels);
        enc_decoder_destroy(&own);
    }
    if (r->options->transfer == ENC_TRANSFER_AUTO && image->info.transfer_name[0]) {
        image_note(&image->info, IMAGE_NOTE_TRANSFER, "%s is applied", image->info.transfer_name);
    }
    if (r->options->colour == ENC_COLOUR_AUTO && image->info.converts && image->channels == 3) {
        primaries_apply(image->info.to_rec709, (size_t)r->area.width * (size_t)r->area.height, pixels);
        image_note(&image->info, IMAGE_NOTE_PRIMARIES, "%s: converted to Rec. 709",
                   image->info.primaries_name);
    }
    return BTF_OK;
}

static btf_result check_image(const enc_radiance *r, const enc_image *image, char *message,
                              size_t message_size) {
    if (image->width != r->file_width || image->height != r->file_height) {
        snprintf(message, message_size, "%dx%d pixels, but the first image has %dx%d", image->width,
                 image->height, r->file_width, r->file_height);
        return BTF_ERROR_BAD_FILE;
    }
    if (image->xyz && r->options->colour != ENC_COLOUR_XYZ) {
        snprintf(message, message_size,
                 "the channels are X, Y, Z, not R, G, B: they are read with option --colour xyz (library "
                 "and Python: primaries xyz)");
        return BTF_ERROR_BAD_FILE;
    }
    return BTF_OK;
}

/* Decodes the part that is used to Rec. 709, with row 0 at the top, and checks every value. */
static btf_result make_linear(const enc_radiance *r, enc_image *image, float *pixels, char *message,
                              size_t message_size) {
    btf_result result = decode_area(r, image, pixels, message, message_size);
    if (result == BTF_OK && r->options->colour == ENC_COLOUR_XYZ) {
        result = check_values(r, pixels, "XYZ", false, message, message_size);
        if (result == BTF_OK) {
            enc_xyz_to_rgb(pixels, (size_t)r->area.width * (size_t)r->area.height);
        }
    }
    if (result == BTF_OK) {
        result = check_values(r, pixels, "RGB", r->options->strict, message, message_size);
    }
    if (result == BTF_OK && r->options->flip_v) {
        enc_flip_rows(pixels, r->area.width, r->area.height);
    }
    return result;
}

/* Multiplies all values by a factor and sets those below 0 to 0; returns how many these were. */
static size_t scale_and_clamp(size_t count, float factor, float *values) {
    size_t negative = 0;
    for (size_t i = 0; i < count; i++) {
        const float value = values[i] * factor;
        negative += value < 0.0f;
        values[i] = value > 0.0f ? value : 0.0f;
    }
    return negative;
}

btf_result enc_radiance_convert(const enc_radiance *r, const void *file, size_t size, float light_z,
                                float *out, size_t *out_negative, image_notes *out_notes, char *message,
                                size_t message_size) {
    const bool resize = r->width != r->area.width || r->height != r->area.height;
    enc_image image = {0};
    float *own = NULL;
    btf_result result =
        enc_image_decode_layer(file, size, r->options->layer, &image, message, message_size);
    if (result == BTF_OK) {
        result = check_image(r, &image, message, message_size);
    }
    if (result == BTF_OK && resize) {
        own = malloc((size_t)r->area.width * (size_t)r->area.height * 3 * sizeof *own);
        result = own ? BTF_OK : BTF_ERROR_MEMORY;
    }
    if (result == BTF_OK) {
        result = make_linear(r, &image, resize ? own : out, message, message_size);
    }
    if (result == BTF_OK) {
        *out_notes = image.info.notes;
    }
    enc_image_clear(&image);
    if (result == BTF_OK && resize) {
        result = enc_resize_area(own, r->area.width, r->area.height, out, r->width, r->height);
    }
    free(own);
    if (result == BTF_OK) {
        *out_negative = scale_and_clamp((size_t)r->width * (size_t)r->height * 3,
                                        r->options->cosine == ENC_COSINE_MISSING ? light_z : 1.0f, out);
    }
    return result;
}
