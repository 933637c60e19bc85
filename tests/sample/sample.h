/* Renders a BTF with known truth: a relief seen from every view under every light.
 *
 * Values are linear Rec. 709 radiance over (normal-incidence irradiance / pi), cosine included, not
 * clipped: highlights exceed 1. Axes, texels and shifts are those of FORMAT.md: row 0 is the top (+v), x =
 * (column + 0.5) / width, y = 1 - (row + 0.5) / height, and images are rectified to the plane z = 0 of the
 * highest points: a point p of the surface shows at p.xy - p.z * v.xy / v.z.
 *
 * The same options give the same bytes for any number of threads.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_SAMPLE_SAMPLE_H
#define OPENBTF_SAMPLE_SAMPLE_H

#include "encoder/data/data.h"
#include "raycast.h"

/* The BTF to render. Zero means the default that stands beside a field. */
typedef struct sample_options {
    const enc_context *context; /* messages, progress, threads, cancellation; NULL: silent, one thread */
    relief_kind relief;         /* 0 = RELIEF_BRICKS */
    uint32_t seed;              /* another seed, another material of the same kind */
    int width, height;          /* texels; 0 = 64. The tile is the unit square whatever they are */
    int supersample;            /* rays along each side of a texel, 1..4; 0 = 2: four a texel */
    int grid; /* cells along each side of the relief, a power of two, 64..4096; 0 = 1024 */
    const enc_direction *views; /* paper order; NULL = the 81 of UBO2003 */
    int n_views;
    const enc_direction *lights; /* likewise */
    int n_lights;
} sample_options;

/* The truth about the rendered BTF. "The point seen" by a texel is what its centre's ray hits. */
typedef struct sample_truth {
    int width, height, n_views, n_lights;
    float *position; /* [view][row][column][3]: the point seen, in tiles; x, y unwrapped (may leave 0..1), z
                        <= 0 */
    float *shift; /* [view][row][column][2]: (columns, rows), not wrapped, such that the same point shows in
                     the view from the pole at (column, row) + shift */
    uint8_t *hidden; /* [view][row][column]: 1 where the view from the pole does not show the point; a
                        height field has none, so all are 0 */
    uint8_t *shadow; /* [view][light][row][column]: 1 where at least half of the texel's rays end at a point
                        that the light does not reach: it is occluded, or faces away */
    uint8_t *top_shadow; /* [light][row][column]: the same for the view from the pole */
} sample_truth;

/* A relief with its lights and their shadows, ready to render view by view. Immutable once made: any number
 * of threads may render from it. */
typedef struct sample_scene sample_scene;

/* Errors: BTF_ERROR_USAGE (with a message that holds the value), BTF_ERROR_MEMORY, BTF_ERROR_INTERRUPTED. */
btf_result sample_scene_create(const sample_options *options, sample_scene **out_scene);
void sample_scene_destroy(sample_scene **scene);
const relief *sample_scene_relief(const sample_scene *scene);
/* The options with every default filled in; the lists are the scene's own. */
const sample_options *sample_scene_options(const sample_scene *scene);

/* Radiance of one point of the surface under one of the scene's lights, towards the unit vector v.
 * Returns whether the light reaches it. */
bool sample_shade(const sample_scene *scene, const raycast_hit *hit, const double v[3], int light,
                  double out_rgb[3]);

/* All images of one view: images[light][row][column][3]. view == n_views means the view from the pole, for
 * truth. truth may be NULL; else what belongs to this view is filled in (the view from the pole fills
 * top_shadow). images may be NULL. One thread; several may render different views at once, into one truth.
 * Errors: BTF_ERROR_MEMORY. */
btf_result sample_scene_view(const sample_scene *scene, int view, float *images, sample_truth *truth);

/* One image at any view and light, of the scene's lists or not: image[row][column][3], the bits that
 * sample_scene_view gives there. One thread; several may render at once. Errors: BTF_ERROR_MEMORY. */
btf_result sample_scene_pair(const sample_scene *scene, const enc_direction *view,
                             const enc_direction *light, float *image);

btf_result sample_truth_create(const sample_scene *scene, sample_truth **out_truth);
void sample_truth_destroy(sample_truth **truth);

/* Renders all of it into memory, n_views * n_lights * width * height * 12 bytes. out_truth may be NULL.
 * Errors: as sample_scene_create. */
btf_result sample_render(const sample_options *options, enc_data **out_data, sample_truth **out_truth);

/* The same of size x size texels, a ray each, of a relief of 256 x 256 cells, from directions as directions_parse() takes
 * them. Errors: those of both. */
btf_result sample_render_small(const enc_context *context, relief_kind relief, const char *views,
                               const char *lights, int size, enc_data **out_data);

#endif
