/* Coordinates of all points (texel, view), view by view: in memory, or in a scratch file. A rank
 * (ranks.h) holds those of its own views.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_JOINT_COORDINATES_H
#define OPENBTF_ENCODER_JOINT_COORDINATES_H

#include "encoder/base/context.h"

typedef struct joint_coordinates joint_coordinates;

/* Room for `views` arrays of `floats` each, not cleared. They lie in memory when they fit a quarter of
 * context->memory (0: always), else in a scratch file. Errors: BTF_ERROR_MEMORY, BTF_ERROR_IO. */
btf_result joint_coordinates_create(const enc_context *context, size_t views, size_t floats,
                                    joint_coordinates **out_points);
void joint_coordinates_destroy(joint_coordinates **points);

/* Stores `count` floats of a view from position `at` on. Thread-safe where ranges do not overlap.
 * Errors: BTF_ERROR_IO. */
btf_result joint_coordinates_store(const enc_context *context, joint_coordinates *points, size_t view,
                                   size_t at, size_t count, const float *values);

/* All floats of one view, valid until the next call.
 * Not thread-safe. Errors: BTF_ERROR_IO. */
btf_result joint_coordinates_view(const enc_context *context, joint_coordinates *points, size_t view,
                                  const float **out_values);

#endif
