/* Converts the file of one image to linear radiance, as the options and the file itself say.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_RADIANCE_H
#define OPENBTF_ENCODER_RADIANCE_H

#include "encoder/base/context.h"
#include "image.h"
#include "read_options.h"
#include "source.h"

enum { ENC_MAX_SIDE = 16384 }; /* texels */

/* How the images of a set are converted, which the first image settles for all. */
typedef struct enc_radiance {
    const enc_read_options *options;
    enc_decoder *decoder;        /* of the first image; the others should be coded as it is */
    int file_width, file_height; /* of every image, as in the files */
    enc_rectangle area;          /* the part that is used */
    int width, height;           /* of the decoded image */
} enc_radiance;

/* Settles the conversion by the first image's file; `options` must outlive *out. Errors, on the log with
 * location and name, or with the option: those of enc_image_decode_layer, BTF_ERROR_USAGE,
 * BTF_ERROR_UNSUPPORTED, BTF_ERROR_MEMORY. */
btf_result enc_radiance_settle(const enc_context *context, const enc_read_options *options,
                               const char *location, const char *name, const void *file, size_t size,
                               enc_radiance *out);
/* Reads image `index` of a source and settles the conversion by it as enc_radiance_settle does. *out_file,
 * the file's bytes, is malloc'ed, and the caller frees it even where its contents are refused; NULL where
 * the file cannot be read. Errors: those of reading as well. */
btf_result enc_radiance_settle_first(const enc_context *context, const enc_read_options *options,
                                     enc_source *source, size_t index, void **out_file, size_t *out_size,
                                     enc_radiance *out);
void enc_radiance_clear(enc_radiance *radiance);

/* Converts one file to out[row][column][3] of width x height, linear Rec. 709: transfer, colour, crop, flip and
 * size; times light_z, the z of the light's direction, where options say that values lack that cosine. Values below
 * 0, unless options refuse them, are set to 0 and counted in *out_negative. *out_notes: what the image says of its
 * pixels. Runs on any thread and does not log: message[message_size] says what failed. Errors: those of
 * enc_image_decode_layer, BTF_ERROR_BAD_FILE (another size than the first image's, a value that is no number),
 * BTF_ERROR_UNSUPPORTED (the coding), BTF_ERROR_MEMORY. */
btf_result enc_radiance_convert(const enc_radiance *radiance, const void *file, size_t size, float light_z,
                                float *out, size_t *out_negative, image_notes *out_notes, char *message,
                                size_t message_size);

#endif
