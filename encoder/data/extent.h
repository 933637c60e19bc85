/* The size of a data set, which a reader tells before it reads the samples.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_EXTENT_H
#define OPENBTF_ENCODER_EXTENT_H

#include "encoder/base/context.h"
#include <stdint.h>

/* Where samples come from. */
typedef enum enc_origin_kind {
    ENC_ORIGIN_IMAGES = 0, /* images but JPEG, decoded once */
    ENC_ORIGIN_JPEG,       /* JPEG images, decoded once */
    ENC_ORIGIN_BONN,       /* made from factors */
} enc_origin_kind;

typedef struct enc_extent {
    int width, height, n_views, n_lights;
    enc_origin_kind origin;
    uint64_t pixels;   /* of all images, before they are cropped and resized */
    size_t components; /* of a Bonn file's factorisations, the most; 0: it has none */
} enc_extent;

/* Is called once, when the extent of a data set is known. Anything but BTF_OK ends the reading with that
 * result. */
typedef struct enc_extent_listener {
    btf_result (*extent)(void *user, const enc_context *context, const enc_extent *extent);
    void *user;
} enc_extent_listener;

/* For readers: calls the context's listener. */
static inline btf_result enc_extent_announce(const enc_context *context, const enc_extent *extent) {
    const enc_extent_listener *to = context ? context->listener : NULL;
    return to ? to->extent(to->user, context, extent) : BTF_OK;
}

/* Bytes of the samples as floats. */
static inline uint64_t enc_extent_bytes(const enc_extent *e) {
    return 12 * (uint64_t)e->width * (uint64_t)e->height * (uint64_t)e->n_views * (uint64_t)e->n_lights;
}

#endif
