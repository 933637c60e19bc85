/* The images of all views with the lights of each texel reduced to a few numbers, which the estimator of
 * heights compares.
 *
 * A texel's profile in a view is its roots of radiance, clipped to 1, under all lights in three channels.
 * Their principal components over all views hold most of what tells texels apart, so that squared
 * differences between the numbers are nearly those between the profiles.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_RELIEF_IMAGES_H
#define OPENBTF_ENCODER_RELIEF_IMAGES_H

#include "encoder/data/data.h"

enum { ENC_RELIEF_NUMBERS = 16 };

typedef struct enc_relief_images {
    int width, height, n_views;
    float *of; /* [view][texel][ENC_RELIEF_NUMBERS] */
} enc_relief_images;

/* Bytes of such images. */
uint64_t enc_relief_images_bytes(int width, int height, int n_views);

/* Two sets of numbers. */
typedef enum enc_relief_kind {
    ENC_RELIEF_ROOTS,    /* of the roots as they are: distances are decoding errors */
    ENC_RELIEF_STANDARD, /* of roots of mean 0 and variance 1 in each image: for comparing views, so that
                            no image counts more for its contrast */
    ENC_RELIEF_KINDS,
} enc_relief_kind;

/* Makes the images of the data, reading every sample once. The images have width >> shift columns and height >>
 * shift rows, each texel the mean of those that it covers; 1 << shift must divide both. Steps of the stage: the
 * data's texels. The same bits for any number of threads. Errors: those of the data, BTF_ERROR_MEMORY (not logged),
 * BTF_ERROR_INTERRUPTED. */
btf_result enc_relief_images_create(const enc_context *context, const enc_data *data, int shift,
                                    enc_relief_images out_images[ENC_RELIEF_KINDS]);
/* Makes images of half the columns and rows by filtering. Errors, not logged: BTF_ERROR_MEMORY. */
btf_result enc_relief_images_halve(const enc_relief_images *images, enc_relief_images *out_images);
void enc_relief_images_clear(enc_relief_images *images);

static inline const float *enc_relief_numbers(const enc_relief_images *images, int view, size_t texel) {
    return images->of +
           ((size_t)view * (size_t)images->width * (size_t)images->height + texel) * ENC_RELIEF_NUMBERS;
}

#endif
