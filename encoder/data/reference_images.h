/* A material as a source of images, decoded by the reference at any directions.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_REFERENCE_IMAGES_H
#define OPENBTF_ENCODER_REFERENCE_IMAGES_H

#include "btf_reference.h"
#include "images.h"

typedef struct enc_reference_images {
    const enc_data *shape; /* size and directions to decode at; its samples are not read */
    btf_ref_material material;
    btf_ref_options options;
} enc_reference_images;

/* shape and material must be of one size (checked by the caller); `images` must outlive the source. */
enc_image_source enc_reference_image_source(const enc_reference_images *images);

#endif
