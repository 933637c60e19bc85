/* The intermediate results of an encode as pictures, after the paper's figures.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_PICTURES_H
#define OPENBTF_ENCODER_PICTURES_H

#include "encoder/model/decode_samples.h"
#include "encoder/model/occlusion.h"

/* The results of an encode that pictures are drawn from. Some exist with `--method paper` only. */
typedef struct enc_pictures {
    const enc_data *data;
    const enc_solution *solution;
    const enc_sample_decoder *decoder; /* of the solution */
    const btf_material *material;
    const enc_occlusion *occlusion; /* after refinement; NULL: no pictures of flow and hidden points */
    float t_error, t_btf;           /* thresholds of the shadow test; 0: no pictures of it */
} enc_pictures;

/* Writes into the existing folder `directory`:
 * - abrdf.png, figures 2, 3, 7: apparent BRDFs of four texels (rows views, columns lights): original, each
 *   step of the decode, and its error;
 * - steps.png, figure 4: an image of the original, SBRDF, SBRDF times 6D shadow, STVS, full;
 * - shadow.png, figures 3c, 5: top-view shadow maps, and the 6D shadow under one light in several views;
 * - flow.png, figure 9: top view, target view, motion vectors, HiddenRatio, hidden map;
 * - hidden.png, figure 11: hidden maps before and after refinement, theta about 30, 45, 60;
 * - atlas.png, figure 12: channels of the atlas (layout paper).
 * Errors: BTF_ERROR_IO, BTF_ERROR_MEMORY. */
btf_result enc_pictures_write(const enc_context *context, const enc_pictures *pictures,
                              const char *directory);

#endif
