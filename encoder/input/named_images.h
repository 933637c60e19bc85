/* The images of a source with the angles that their names, or a table, give.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_NAMED_IMAGES_H
#define OPENBTF_ENCODER_NAMED_IMAGES_H

#include "read_options.h"
#include "source.h"

/* A direction of one image in degrees: as it is used, and its azimuth as the name gives it. */
typedef struct enc_named_direction {
    double theta, phi;
    double given_phi;
    size_t source;
} enc_named_direction;

/* One image whose name was understood. */
typedef struct enc_named_image {
    enc_named_direction view, light;
    size_t source;
} enc_named_image;

/* Finds the images of a source and their directions, in its order, and warns of names that are doubtful or
 * not understood. Angles within ENC_NAMED_SAME of each other get one value. *out_images is malloc'ed, after
 * an error too (or NULL). Errors: BTF_ERROR_BAD_FILE (names that no rule reads for sure, no image, a theta
 * of 90 degrees or more), BTF_ERROR_MEMORY. */
btf_result enc_named_images_find(const enc_context *context, const enc_source *source,
                                 const enc_read_options *options, enc_named_image **out_images,
                                 size_t *out_count);

/* The azimuth that options make of a given one, degrees in [0, 360), on a grid of 1e-9 degrees so that 360
 * - tiny does not differ from 0. */
double enc_named_azimuth(const enc_read_options *options, double theta, double phi);

/* Degrees within which two angles are one. */
#define ENC_NAMED_SAME 1e-3

#endif
