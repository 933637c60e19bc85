/* The stages of `--method paper`, each taken from a checkpoint where there is one, else run and kept there.
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

/* Arguments, results and errors are those of the stages (fit.h, shadow.h, flow.h, refine.h, cluster.h), and
 * those of encoder/data/checkpoint.h. */
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

/* The functions that take and keep one step, of which those above are made.
 *
 * A step that cannot be of this data set and these options counts as none, however it came to be: whatever
 * the file holds, a step that is taken can be worked with. Nothing is taken where context->checkpoint is
 * NULL. Each enc_step_keep_ function writes the step that its enc_step_take_ function takes; errors are
 * those of enc_checkpoint_put. */

/* On false *out_sbrdf is NULL. */
bool enc_step_take_fit(const enc_context *context, const enc_data *data, const enc_fit_options *options,
                       enc_sbrdf **out_sbrdf, enc_fit_stats *out_stats);
btf_result enc_step_keep_fit(const enc_context *context, const enc_sbrdf *sbrdf,
                             const enc_fit_stats *stats);

/* out_shadow[light][texel]; on false its values mean nothing. */
bool enc_step_take_shadow(const enc_context *context, const enc_data *data, uint8_t *out_shadow);
btf_result enc_step_keep_shadow(const enc_context *context, const enc_data *data, const uint8_t *shadow);

/* The occlusion that step "flow" or "refine" found, without its centres, which are 0. On false *out_occlusion is
 * NULL. */
bool enc_step_take_occlusion(const enc_context *context, const char *step, const enc_data *data,
                             enc_occlusion **out_occlusion);
btf_result enc_step_keep_occlusion(const enc_context *context, const char *step,
                                   const enc_occlusion *occlusion);

/* The centres, at most k_total, and occlusion->centre for its hidden points. On false *out_centres is NULL
 * and occlusion->centre means nothing. */
bool enc_step_take_cluster(const enc_context *context, const enc_data *data, int k_total,
                           enc_occlusion *occlusion, enc_centres **out_centres);
btf_result enc_step_keep_cluster(const enc_context *context, const enc_occlusion *occlusion,
                                 const enc_centres *centres);

#endif
