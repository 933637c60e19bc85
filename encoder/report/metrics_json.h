/* Accuracy as JSON, alike in reports and comparisons.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_METRICS_JSON_H
#define OPENBTF_ENCODER_METRICS_JSON_H

#include "decoder/toolkit/json.h"
#include "metrics.h"

/* Writes {"linear": dB, "srgb": dB, "ssim": S, "rings": {"view": [{"theta", "linear", "srgb"}...], "light":
 * [...]}} under `key`; ssim is null unless with_ssim. */
void enc_metrics_json(json *j, const char *key, const enc_metrics *metrics, bool with_ssim);

#endif
