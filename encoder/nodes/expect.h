/* The value of a fit: its gain between the samples against its cost at them, both as dB of the error that
 * is left with the coder's own error added. FIT.md has the figures that the constants come from.
 *
 * A fit's cost at the samples is known; a coder's error adds to it. Its gain is estimated by leaving
 * samples out: there, the fit of the others moves the blend by m, and the blend's error e is known, and so
 * are |e|, |m| and the cosine between them. Between the samples |m| is known, too, and neighbours are half
 * as far away: of |e|^2 a half is left of the part that no fit follows, and a thirtieth of that which the
 * strongest follows, whose share is the square of its cosine (a parabola, cut at random places, against the
 * middle of twice its span, leaves 1/30).
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_NODES_EXPECT_H
#define OPENBTF_ENCODER_NODES_EXPECT_H

#include <stdbool.h>
#include <stddef.h>

enum { ENC_FIT_CANDIDATES = 7 };

/* Means of squares of values clipped to [0, 1]. */
typedef struct enc_fit_error {
    double linear, srgb;
} enc_fit_error;

typedef struct enc_fit_candidate {
    double kappa_views, kappa_lights; /* HUGE_VAL: barycentric */
    bool judged;                      /* else the directions do not have it */
    enc_fit_error at;                 /* at the samples, before coding */
    enc_fit_error left_out;           /* view and light left out */
    enc_fit_error gain;               /* expected between the samples, over barycentric */
    enc_fit_error between;            /* expected there, before coding */
    bool allowed;                     /* its cost at the samples is small beside the coder's error there */
    double value;                     /* dB, by which candidates are compared */
} enc_fit_candidate;

typedef struct enc_fit_choice {
    enc_fit_candidate candidate[ENC_FIT_CANDIDATES]; /* the first: barycentric */
    int best;                                        /* worth most; 0: no fit pays, or there is none */
    int chosen;                                      /* taken: the best, or 0 where samples are asked for */
    enc_fit_error coder; /* at the samples, that the factors are expected to add; 0: none */
    size_t texels;       /* that were drawn */
} enc_fit_choice;

/* Means of squares for a candidate in one of the two codings, linear or sRGB. */
typedef struct enc_fit_moved {
    double error, fitted; /* with samples left out: of the barycentric blend, of the fit */
    double move, moves;   /* of the fit's move: with samples left out, between the samples */
} enc_fit_moved;

/* Fills left_out, gain and between of all candidates; those that were not judged have zeros, the last that
 * was is the strongest. */
void enc_fit_expect(const enc_fit_moved linear[ENC_FIT_CANDIDATES],
                    const enc_fit_moved srgb[ENC_FIT_CANDIDATES], enc_fit_choice *io_choice);

/* Whether a candidate adds little to choice->coder at the samples: at most 0.3 of its sRGB-coded squared
 * error, of which one level of 255 is always there. */
bool enc_fit_allowed(const enc_fit_choice *choice, const enc_fit_candidate *candidate);

/* dB that a candidate gains between the samples, linear and sRGB-coded averaged, less an eighth of those,
 * sRGB-coded, that it loses at them beside choice->coder. */
double enc_fit_value(const enc_fit_choice *choice, const enc_fit_candidate *candidate);

/* The error that is expected of a candidate when a coder of error `coder` at the samples has coded it. */
enc_fit_error enc_fit_coded_at(const enc_fit_candidate *candidate, enc_fit_error coder);
enc_fit_error enc_fit_coded_between(const enc_fit_candidate *candidate, enc_fit_error coder);

/* The error of the coder itself, given the error measured at the samples after it coded the chosen
 * candidate. */
enc_fit_error enc_fit_coder_measured(const enc_fit_choice *choice, enc_fit_error measured);

#endif
