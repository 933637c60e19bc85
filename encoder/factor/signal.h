/* Estimates the share of signal, as against noise, in each component of a BTF, by samples that are left out.
 *
 * Bi-cross-validation (Owen and Perry 2009): a block of texels times a block of pairs of view and light is
 * left out; the components of the remaining rows and columns predict it from the left-out texels at the
 * other pairs and from the other texels at the left-out pairs. Noise predicts nothing, whatever its
 * distribution, as long as it is not shared between samples. It takes no iteration, unlike imputation, and
 * two passes over the samples.
 *
 * A component of the smaller block is known less well than the same one of all samples. The spiked model
 * (Benaych-Georges and Nadakuditi 2012) turns the one into the other.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_FACTOR_SIGNAL_H
#define OPENBTF_ENCODER_FACTOR_SIGNAL_H

#include "components.h"

typedef struct enc_signal {
    size_t rank[ENC_FACTOR_CHANNELS];   /* components that gain at left-out samples: the first ones */
    double *share[ENC_FACTOR_CHANNELS]; /* [components found] share of a component's energy that it gains there:
                                           1 at most, not rising, negative where noise is learnt */
    double floor[ENC_FACTOR_CHANNELS];  /* squared error that `rank` components leave at left-out samples,
                                           scaled to all samples */
} enc_signal;

enum {
    ENC_SIGNAL_MOST_TEXELS = 16384,     /* of a larger material so many texels are used, evenly chosen */
    ENC_SIGNAL_LEAST_SAMPLES = 1 << 17, /* texels times pairs; below that, all is signal */
};

/* Judges components that enc_components_find found in the same matrix, for the channels that are `asked`
 * for; results of the others stay. *io_signal is zeroed before the first call. Stage "cross-validate". The
 * same bits for any number of threads and ranks. Of small data all components count as signal. Errors:
 * BTF_ERROR_MEMORY, BTF_ERROR_IO, BTF_ERROR_INTERRUPTED; the caller clears *io_signal then, too. */
btf_result enc_signal_find(const enc_factor_matrix *matrix,
                           const enc_components components[ENC_FACTOR_CHANNELS],
                           const bool asked[ENC_FACTOR_CHANNELS], enc_signal *io_signal);
void enc_signal_clear(enc_signal *signal);

/* The share of a component's energy y^2 that its prediction gains, where a block of `rows` x `columns`
 * samples predicts other samples (left_out), or its own samples without their noise. x2: the energy of the
 * signal over that of the noise of as many samples as the longer side has. Public for tests. */
double enc_signal_share(double x2, double rows, double columns, bool left_out);

#endif
