/* A BTF as a source of images, whatever it comes from: a data set, a decoded material.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_IMAGES_H
#define OPENBTF_ENCODER_IMAGES_H

#include <openbtf/reference.h>
#include "data.h"

/* Writes all images of one view: out[light][texel][channel], linear radiance. Thread-safe. */
typedef btf_result (*enc_view_fn)(const void *user, int view, float *out);

typedef struct enc_image_source {
    enc_view_fn view;
    const void *user;
} enc_image_source;

/* The images of a data set; `data` must outlive the source. */
enc_image_source enc_data_images(const enc_data *data);

/* A material, decoded by the reference at any directions. */
typedef struct enc_reference_images {
    const enc_data *shape; /* size and directions to decode at; its samples are not read */
    btf_ref_material material;
    btf_ref_options options;
} enc_reference_images;

/* shape and material must be of one size (checked by the caller); `images` must outlive the source. */
enc_image_source enc_reference_image_source(const enc_reference_images *images);

#endif
