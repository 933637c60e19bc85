/* The float pipeline against the same stages in double precision: helpers that the rows of test_precision share.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TESTS_STABILITY_PRECISION_H
#define OPENBTF_TESTS_STABILITY_PRECISION_H

#include "hard_data.h"

#include "encoder/paper/cluster.h"
#include "encoder/paper/fit.h"
#include "encoder/model/occlusion.h"
#include "encoder/paper/shadow.h"
#include "encoder/model/solution.h"

extern const double precision_most_loss; /* dB, of any stage */

/* A hard_value_fn: a surface that no Lafortune model fits exactly: a Fresnel-like sheen, a tinted
 * highlight, a dark side, noise. */
void precision_measured(const void *user, int texel, const enc_direction *v, const enc_direction *l,
                        int sample, float rgb[3]);

/* FORMAT.md section 9 at a sampled direction, in double from the codes. */
double precision_decode(const enc_data *data, const enc_solution *s, size_t t, int v, int c, int l);

/* PSNR (peak 1) of the solution so decoded. */
double precision_psnr(const enc_data *data, const enc_solution *s);

/* The same of a model and a shadow map, with the shifts of `occlusion` (NULL: none), hidden points shown by
 * `centres` (NULL: by their shifts, too). */
double precision_psnr_of_parts(const enc_data *data, enc_sbrdf *sbrdf, uint8_t *shadow,
                               const enc_occlusion *occlusion, const enc_centres *centres);

/* A relief of side x side texels under thirteen directions, its fit of three lobes and its shadow map. */
typedef struct precision_scene {
    enc_data *data;
    enc_sbrdf *sbrdf;
    uint8_t *shadow;
} precision_scene;

precision_scene precision_scene_make(int side);
void precision_scene_clear(precision_scene *scene);

/* No shifts, and two in five points hidden at random, in every view but the top one. */
enc_occlusion *precision_occlusion(const enc_data *data);

/* The rows of a stage. */
void precision_fit(void);
void precision_flow(void);
void precision_hidden(void);
void precision_clusters(void);

#endif
