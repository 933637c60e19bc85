/* The costs of the stages of an encode: predicted before they run, so that progress can be weighed, and a
 * large encode be judged by a smaller one.
 *
 * Costs are core seconds on one core of an AMD EPYC (Zen 4) that has nothing else to do; constants were
 * fitted to core times measured there (cost.c). They count texels, views, lights, components and rounds, as
 * the method and preset make them.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_COST_H
#define OPENBTF_ENCODER_COST_H

#include "decoder/toolkit/estimate.h"
#include "encoder/data/extent.h"
#include "settings.h"

/* Names of stages that job.c runs itself. */
#define ENC_STAGE_PACK "pack"
#define ENC_STAGE_SAVE "save"

/* The stages of `job` for such data, in the order in which they come. Returns their number, at most
 * ESTIMATE_PARTS. `context` says what memory is allowed. */
size_t enc_cost_parts(const enc_context *context, const enc_job *job, const enc_extent *extent,
                      estimate_part out_parts[ESTIMATE_PARTS]);

/* The sum of all parts, in core seconds. */
double enc_cost_total(const estimate_part *parts, size_t count);

#endif
