/* The data of a joint fit as rows: light profiles of points (texel, view) in the fitted domain.
 *
 * A row is 3 * n_lights floats, [channel][light], of y = sqrt(min(L, scale) / scale) in the square-root
 * domain and y = min(L, scale) / scale in the linear one; scale is the file's radianceScale.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_JOINT_ROWS_H
#define OPENBTF_ENCODER_JOINT_ROWS_H

#include "encoder/data/data.h"
#include "encoder/math/gemm.h"

/* Texels that a pass over the data handles at a time: a multiple of ENC_GEMM_M. */
enum { JOINT_BLOCK = 240 };

/* Immutable once made, so that any thread may read it. */
typedef struct joint_rows {
    const enc_context *context;
    const enc_data *data;
    size_t texels, views, row;
    bool root;
    float scale;
    float *multiplier; /* [row] m(l): l.z, or its square root in the square-root domain */
    float *energy;     /* [view][texel] sum of squares of a row */
    double total;      /* sum of all energies */
    enc_gemm_tile tile;
} joint_rows;

/* Reads the data once: finds the scale (see rows.c) and the energies.
 * Errors: BTF_ERROR_MEMORY, BTF_ERROR_IO, BTF_ERROR_INTERRUPTED. Free with joint_rows_clear in any case. */
btf_result joint_rows_init(const enc_context *context, const enc_data *data, bool root,
                           joint_rows *out_rows);
/* The same with a scale that is given, as for the levels of a file. */
btf_result joint_rows_init_scaled(const enc_context *context, const enc_data *data, bool root, float scale,
                                  joint_rows *out_rows);
void joint_rows_clear(joint_rows *rows);

/* The row of one point: out [row]. texel_buffer: enc_data_texel_stride floats. Thread-safe. Errors:
 * BTF_ERROR_IO. */
btf_result joint_rows_one(const joint_rows *rows, size_t texel, size_t view, float *texel_buffer,
                          float *out);

/* Called with `count` <= JOINT_BLOCK rows of one view: texels first .. first + count - 1, contiguous. */
typedef void (*joint_pass_fn)(void *user, size_t view, size_t first, size_t count, const float *rows);

/* Calls `fn` for every view and every block of texels, from context->threads threads: blocks of one view
 * come in ascending order, one after another, so that what `fn` sums up view by view does not depend on
 * the number of threads. A rank passes over its own views alone (joint_rows_views).
 * Errors: BTF_ERROR_IO, BTF_ERROR_MEMORY, BTF_ERROR_INTERRUPTED. */
btf_result joint_rows_pass(const joint_rows *rows, joint_pass_fn fn, void *user);

/* The views of this rank: out_first .. out_end - 1. */
void joint_rows_views(const joint_rows *rows, size_t *out_first, size_t *out_end);
/* Completes an array [view] of view_bytes each, of which every rank has filled its own views; the ranks
 * meet (ranks.h). */
btf_result joint_rows_gather(const joint_rows *rows, btf_result result, void *array, size_t view_bytes);

typedef bool (*joint_want_fn)(void *user, size_t view, size_t texel);
typedef void (*joint_row_fn)(void *user, size_t view, size_t texel, const float *row);

/* Calls `fn` for the rows of all views that `want` asks for, from context->threads threads; texels of one
 * view come in ascending order, one after another. Errors as above. */
btf_result joint_rows_pick(const joint_rows *rows, joint_want_fn want, joint_row_fn fn, void *user);

#endif
