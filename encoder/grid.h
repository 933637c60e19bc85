/* From the names of images to a full grid of views and lights.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_GRID_H
#define OPENBTF_ENCODER_GRID_H

#include "data.h"
#include "reader.h"
#include "source.h"

/* Where one image of a source belongs. */
typedef struct enc_grid_item {
    size_t source; /* index into the source's paths */
    int view, light;
} enc_grid_item;

/* n_views * n_lights items, each pair once; directions in paper order. Items of a sequential source stand
 * in its order, those of any other by view, then by light. */
typedef struct enc_grid {
    int n_views, n_lights;
    enc_direction *views, *lights;
    size_t count;
    enc_grid_item *items;
} enc_grid;

/* Builds the grid or says on the log, with names and counts, why there is none.
 * Errors: BTF_ERROR_BAD_FILE, BTF_ERROR_UNSUPPORTED (more than 256 directions), BTF_ERROR_MEMORY. */
btf_result enc_grid_create(const enc_context *context, const enc_source *source,
                           const enc_read_options *options, enc_grid **out_grid);
void enc_grid_destroy(enc_grid **grid);

#endif
