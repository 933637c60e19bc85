/* The normal equations of the fit, with colours eliminated, from the Gram matrix of one texel's samples.
 * Internal to the fit.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_LAFORTUNE_NORMAL_EQUATIONS_H
#define OPENBTF_ENCODER_LAFORTUNE_NORMAL_EQUATIONS_H

#include "gram.h"

enum { ENC_FIT_MAX_PARAMETERS = 1 + 4 * ENC_MAX_LOBES };

/* A solution in the scale of the search. RGB lobes have their shapes scaled to a largest base of 1 over the
 * samples, so that a weight is a peak; the solver's own (Cx, Cy, Cz) are `peak` times that. */
typedef struct enc_fit_solution {
    double cost;
    double diffuse;                 /* rho_d; one colour only */
    double peak[ENC_MAX_LOBES];     /* 1 with one colour */
    bool held[ENC_MAX_LOBES];       /* n is at its limit for this shape */
    double shape[ENC_MAX_LOBES][4]; /* Cx, Cy, Cz, n; all 0: the lobe is dead */
    /* RGB lobes: diffuse term, then lobe weights; one colour: [c][0] = C_c */
    double colour[3][1 + ENC_MAX_LOBES];
} enc_fit_solution;

/* One texel under way. */
typedef struct enc_fit_problem {
    enc_gram_samples samples;
    int lobes;
    bool rgb;
    double scale;                    /* targets were divided by this */
    double diffuse_colour[3];        /* the best model without lobes */
    double diffuse_cost, energy;     /* its cost; sum of squared targets */
    double overshoot[ENC_MAX_LOBES]; /* ln of the most times that a lobe may exceed its largest value at a
                                        sample */
    int evaluations;
    enc_fit_solution best; /* the cheapest point evaluated since its cost was set to infinity */
    double gram[ENC_GRAM_MAX_COLUMNS * ENC_GRAM_MAX_COLUMNS];
} enc_fit_problem;

/* enc_ceres_evaluate for an enc_fit_problem. Parameters: rho_d (one colour only), then (Cx, Cy, Cz, ln n) a
 * lobe. The colours, which the model is linear in, are solved for at every point and projected out of the
 * derivatives. Keeps the best point in `best`, whose colours must be set before the first call (0 will do). */
void enc_fit_evaluate(void *problem, const double *parameters, double *out_normal);

/* ln(b / peak), at least 0: b is the largest base over all pairs of directions (the largest of |Cx|, |Cy|,
 * Cz), peak the largest over the samples. A lobe (Cx, Cy, Cz, n) reaches exp(n * overshoot) times its
 * largest sample somewhere between or beyond the samples. */
double enc_fit_overshoot(const enc_gram_samples *samples, const double shape[4], double *out_peak);

/* Sets one lobe of `best` to 0 whose loss costs next to nothing once the diffuse term is solved anew. True
 * when one was found. */
bool enc_fit_drop_idle_lobe(enc_fit_problem *problem);

#endif
