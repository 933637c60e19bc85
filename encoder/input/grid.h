/* Builds the full grid of views and lights from the images of a source.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_GRID_H
#define OPENBTF_ENCODER_GRID_H

#include "encoder/data/data.h"
#include "read_options.h"
#include "source.h"

/* The place of one image of a source in the grid. */
typedef struct enc_grid_item {
    size_t source; /* index into the source's paths */
    int view, light;
} enc_grid_item;

/* The full grid: n_views * n_lights items, each pair once, and the directions in paper order. Items of a
 * sequential source stand in its order, those of any other by view, then by light. */
typedef struct enc_grid {
    int n_views, n_lights;
    enc_direction *views, *lights;
    size_t count;
    enc_grid_item *items;
} enc_grid;

/* Builds the grid, or logs with names and counts why the images do not form one. Errors:
 * BTF_ERROR_BAD_FILE, BTF_ERROR_UNSUPPORTED (more than 256 directions), BTF_ERROR_MEMORY. */
btf_result enc_grid_create(const enc_context *context, const enc_source *source,
                           const enc_read_options *options, enc_grid **out_grid);
void enc_grid_destroy(enc_grid **grid);

/* An image and the directions that its name, or the table of the options, gives. */
typedef struct enc_grid_image {
    size_t source; /* index into the source's paths */
    enc_direction view, light;
} enc_grid_image;

/* Lists the images of a source in its order, whether they form a grid or not. Reads their names, and logs
 * what is wrong with them, as enc_grid_create does. *out_images is malloc'ed. Errors: BTF_ERROR_BAD_FILE,
 * BTF_ERROR_MEMORY. */
btf_result enc_grid_list(const enc_context *context, const enc_source *source,
                         const enc_read_options *options, enc_grid_image **out_images, size_t *out_count);

/* The most degrees between the top view and the surface normal. */
#define ENC_GRID_POLE_DISTANCE 5.0

#endif
