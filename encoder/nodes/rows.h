/* Weights of all samples of a list in directions where they can be judged, barycentric and by fits of
 * several strengths.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_NODES_ROWS_H
#define OPENBTF_ENCODER_NODES_ROWS_H

#include "fit.h"

/* Strengths: barycentric, then fits of these kappas. */
enum { ENC_STRENGTHS = 8, ENC_ROWS_PLACES = 3, ENC_ROWS_MOST = 48 };
extern const double enc_strength_kappa[ENC_STRENGTHS];

/* The places for which weights are made. */
typedef enum enc_rows_place {
    ENC_ROWS_LEFT_OUT, /* in the direction of a sample, of the others; where none can be left out, the sample
                          itself */
    ENC_ROWS_BETWEEN,  /* in directions of the hull */
    ENC_ROWS_AT,       /* at the nodes */
} enc_rows_place;

typedef struct enc_node_rows {
    int n;                        /* samples */
    bool usable[ENC_STRENGTHS];   /* the fit exists everywhere and can be judged; the barycentric one always */
    bool leaves;                  /* some samples can be left out */
    int count[ENC_ROWS_PLACES];   /* directions, at most ENC_ROWS_MOST; of ENC_ROWS_AT all nodes */
    int sample[ENC_ROWS_PLACES][ENC_MAX_DIRECTIONS]; /* whose direction it is; -1: of none */
    float *weight[ENC_STRENGTHS][ENC_ROWS_PLACES];   /* [count][n]; NULL where not usable */
} enc_node_rows;

/* Errors: those of enc_left_out_make, BTF_ERROR_MEMORY. The same bits for any number of threads. */
btf_result enc_node_rows_make(const enc_context *context, const enc_direction *directions, int count,
                              enc_node_rows *out_rows);
void enc_node_rows_clear(enc_node_rows *rows);

#endif
