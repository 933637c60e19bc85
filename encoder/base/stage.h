/* Named stages of an encode: what progress shows, and what the traffic between ranks is counted under.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_STAGE_H
#define OPENBTF_ENCODER_STAGE_H

#include "context.h"

/* Starts a named stage of `total` steps. Stages follow one another; one is active at a time. */
void enc_stage_begin(const enc_context *context, const char *name, size_t total);
/* Adds `steps` finished steps; callable from any thread. */
void enc_stage_step(const enc_context *context, size_t steps);
/* Ends the stage; its wall time is kept by the progress object under its name. */
void enc_stage_end(const enc_context *context);

#endif
