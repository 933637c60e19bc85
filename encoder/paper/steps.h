/* The stages of `--method paper`, each taken from a checkpoint where there is one, else run and kept there.
 *
 * Arguments, results and errors are those of the stages (fit.h, shadow.h, flow.h, refine.h, cluster.h), and
 * those of checkpoint.h.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_PAPER_STEPS_H
#define OPENBTF_ENCODER_PAPER_STEPS_H

#include "cluster.h"
#include "fit.h"
#include "flow.h"
#include "refine.h"
#include "shadow.h"

btf_result enc_step_fit(const enc_context *context, const enc_data *data, const enc_fit_options *options,
                        enc_sbrdf **out_sbrdf, enc_fit_stats *out_stats);
btf_result enc_step_shadow(const enc_context *context, const enc_data *data, const enc_sbrdf *sbrdf,
                           const enc_shadow_options *options, uint8_t *out_shadow);
btf_result enc_step_flow(const enc_context *context, const enc_data *data, const enc_flow_options *options,
                         enc_occlusion **out_occlusion);
btf_result enc_step_refine(const enc_context *context, const enc_data *data, const enc_sbrdf *sbrdf,
                           const uint8_t *shadow, float shadow_scale, const enc_refine_options *options,
                           enc_occlusion *occlusion);
btf_result enc_step_cluster(const enc_context *context, const enc_data *data,
                            const enc_cluster_options *options, int k_total, enc_occlusion *occlusion,
                            enc_centres **out_centres);

#endif
