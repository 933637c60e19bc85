/* What a checkpoint holds of the stages of `--method paper`.
 *
 * A step that cannot be of this data set and these options counts as none, however it came to be: what is
 * taken can be worked with, whatever is in the file. Nothing is taken where context->checkpoint is NULL.
 * Each enc_keep_ function writes what its enc_kept_ function takes; errors are those of enc_checkpoint_put.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_PAPER_KEPT_H
#define OPENBTF_ENCODER_PAPER_KEPT_H

#include "cluster.h"
#include "fit.h"

/* On false *out_sbrdf is NULL. */
bool enc_kept_fit(const enc_context *context, const enc_data *data, const enc_fit_options *options,
                  enc_sbrdf **out_sbrdf, enc_fit_stats *out_stats);
btf_result enc_keep_fit(const enc_context *context, const enc_sbrdf *sbrdf, const enc_fit_stats *stats);

/* out_shadow[light][texel]; on false its values mean nothing. */
bool enc_kept_shadow(const enc_context *context, const enc_data *data, uint8_t *out_shadow);
btf_result enc_keep_shadow(const enc_context *context, const enc_data *data, const uint8_t *shadow);

/* Of step "flow" or "refine", all but centres: those are 0. On false *out_occlusion is NULL. */
bool enc_kept_occlusion(const enc_context *context, const char *step, const enc_data *data,
                        enc_occlusion **out_occlusion);
btf_result enc_keep_occlusion(const enc_context *context, const char *step, const enc_occlusion *occlusion);

/* The centres, at most k_total, and occlusion->centre for its hidden points. On false *out_centres is NULL
 * and occlusion->centre means nothing. */
bool enc_kept_cluster(const enc_context *context, const enc_data *data, int k_total,
                      enc_occlusion *occlusion, enc_centres **out_centres);
btf_result enc_keep_cluster(const enc_context *context, const enc_occlusion *occlusion,
                            const enc_centres *centres);

#endif
