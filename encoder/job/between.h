/* The stages that improve the decode between the samples: relief and gloss, and values at the nodes that a
 * decoder blends into a smooth spline.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_JOB_BETWEEN_H
#define OPENBTF_ENCODER_JOB_BETWEEN_H

#include "encoder/nodes/choose.h"
#include "relief_step.h"
#include "settings.h"

typedef struct enc_between {
    bool relief_judged, fit_judged;
    enc_relief_choice relief; /* where relief_judged */
    char reason[ENC_RELIEF_REASON];
    enc_relief_store store; /* zeros: neither relief nor gloss */
    enc_fit_choice fit;     /* where fit_judged */
    enc_node_tables nodes;
    enc_data *fitted; /* values at the nodes, to which the model is fitted; NULL: it is fitted to the
                         samples */
} enc_between;

/* Finds all that the job asks for. Relief and gloss are a step of `checkpoint`, which may be NULL. The fit
 * is found again on resumption, since its values at the nodes would take as much of the disk as the
 * samples. The caller clears *out, whatever comes back. Errors, on the log: those of enc_relief_choose,
 * enc_relief_step_take, enc_foresee_error, enc_fit_choose and enc_node_apply, BTF_ERROR_IO. */
btf_result enc_between_find(const enc_context *context, const enc_job *job, const enc_data *data,
                            enc_checkpoint *checkpoint, enc_between *out);

/* Writes the options, and the choices that they left open, as text, which the caller frees. Errors, on the
 * log: BTF_ERROR_MEMORY. */
btf_result enc_between_provenance(const enc_context *context, const enc_job *job,
                                  const enc_between *between, const char *options, char **out_text);

void enc_between_clear(enc_between *between);

#endif
