/* How much a material's node values are smoothed: what a fit gains between the samples against what it costs
 * at them.
 *
 * Its cost is known. Its gain is estimated by leaving samples out: there, the fit of the others moves
 * the blend, and the product of that move with the blend's error is known. Between the samples the fit moves the
 * blend by a known amount, too; neighbours are half as far away, and the product is taken to be 0.6 of that for
 * moves of one size (BRICKS64 and btf-sample's reliefs have 0.5 to 0.6). Of all candidates the one is taken that
 * gains most: squared errors between the samples, less three quarters of those at the samples, linear and sRGB-coded ones
 * added. The codec's own error adds to both sides and does not matter.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_NODES_CHOOSE_H
#define OPENBTF_ENCODER_NODES_CHOOSE_H

#include "apply.h"

enum {
    ENC_FIT_CANDIDATES = 7,
    ENC_FIT_TEXELS = 256, /* drawn at most */
};

/* Means of squares of values clipped to [0, 1]. */
typedef struct enc_fit_error {
    double linear, srgb;
} enc_fit_error;

typedef struct enc_fit_candidate {
    double kappa_views, kappa_lights; /* HUGE_VAL: barycentric */
    bool judged;                      /* else the directions do not have it */
    enc_fit_error at;                 /* at the samples, of what is not compressed */
    enc_fit_error left_out;           /* view and light left out */
    enc_fit_error gain;               /* expected between the samples, over barycentric */
} enc_fit_candidate;

typedef struct enc_fit_choice {
    enc_fit_candidate candidate[ENC_FIT_CANDIDATES]; /* the first: barycentric */
    int chosen;                                      /* 0: no fit pays, or there is none */
    size_t texels;                                   /* that were drawn */
} enc_fit_choice;

/* Judges every candidate for `data`. least_psnr: dB of sRGB-coded PSNR that a fit must leave at the samples,
 * or 0. With a fit chosen *out_tables holds it, else its tables are NULL; enc_node_tables_clear frees them.
 * Every rank does all of it, a fixed number of texels; the same bits for any number of threads. Stage
 * "choose fit". Errors: those of the data, BTF_ERROR_MEMORY, BTF_ERROR_INTERRUPTED. */
btf_result enc_fit_choose(const enc_context *context, const enc_data *data, bool roots, double least_psnr,
                          enc_fit_choice *out_choice, enc_node_tables *out_tables);
void enc_node_tables_clear(enc_node_tables *tables);

#endif
