/* A material as a source of images, decoded at any directions: FORMAT.md section 9 to the bit.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_MODEL_EVALUATED_IMAGES_H
#define OPENBTF_ENCODER_MODEL_EVALUATED_IMAGES_H

#include "encoder/data/images.h"
#include "evaluator.h"

typedef struct enc_evaluated_images {
    const enc_data *shape; /* size and directions to decode at; its samples are not read */
    const enc_evaluator *evaluator;
    btf_ref_options options;
} enc_evaluated_images;

/* shape and material must be of one size (checked by the caller); `images` must outlive the source. Errors
 * of the source: BTF_ERROR_MEMORY. */
enc_image_source enc_evaluated_image_source(const enc_evaluated_images *images);

#endif
