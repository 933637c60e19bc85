/* The data in a basis of few dimensions, in which sources are searched and solved.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_JOINT_PROJECTION_H
#define OPENBTF_ENCODER_JOINT_PROJECTION_H

#include "encoder/base/context.h"
#include "sources.h"

/* Coordinates of all points (texel, view), view by view: in memory, or in a scratch file. A rank
 * (encoder/base/ranks.h) holds those of its own views. */
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

enum {
    JOINT_FRONT_DIMS = 12,       /* basis vectors for fronts beside a residual ... */
    JOINT_FRONT_ALONE_DIMS = 48, /* ... and without one */
    JOINT_FRONT_SAMPLES = 128,   /* fronts that the basis of a view is made from */
};

/* Per view an orthonormal basis that begins with the span of v[view], v = lower * basis, and every row in
 * it. Without a front dims is k. With one, basis vectors follow that span most of what v leaves of the
 * fronts; the last is zero, where a source has the length of what it has beyond the basis. */
typedef struct joint_projection {
    size_t dims;
    float *basis;         /* [view][dims][row] */
    float *lower;         /* [view][k][k] lower triangular */
    joint_coordinates *c; /* [view], [texel][dims] = basis * row */
} joint_projection;

btf_result joint_projection_init(const joint_rows *rows, const joint_model *model,
                                 joint_projection *out_projection);
void joint_projection_clear(joint_projection *projection);
/* Recomputes all three from model->v: one pass over the data. */
btf_result joint_project(const joint_rows *rows, const joint_model *model, joint_projection *projection);

#endif
