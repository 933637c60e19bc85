/* Accuracy of one BTF against another: PSNR in linear and sRGB-coded values, SSIM, by view ring and light
 * ring.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_METRICS_H
#define OPENBTF_ENCODER_METRICS_H

#include "decoder/toolkit/json.h"
#include "encoder/data/images.h"
#include "encoder/model/solution.h"
#include <openbtf/material.h>

/* Squared errors of values clipped to [0, 1]: linear, and after sRGB coding. */
typedef struct enc_error_sum {
    double linear, srgb;
    double count;
} enc_error_sum;

typedef struct enc_metrics {
    enc_error_sum total;
    enc_error_sum coincident; /* the samples whose view and light have one direction */
    double ssim; /* mean over images; sRGB-coded luminance, Gaussian window (Wang et al. 2004), periodic
                    edges */
    int n_view_rings, n_light_rings;
    double view_ring_theta[BTF_MAX_DIRECTIONS], light_ring_theta[BTF_MAX_DIRECTIONS]; /* degrees */
    enc_error_sum view_ring[BTF_MAX_DIRECTIONS], light_ring[BTF_MAX_DIRECTIONS];
} enc_metrics;

/* PSNR in dB with peak 1; 100 for an error of zero. */
double enc_psnr_linear(const enc_error_sum *sum);
double enc_psnr_srgb(const enc_error_sum *sum);

/* Compares all images. Working set: 2 * n_lights * texels * 3 floats a thread, as many threads as fit half
 * of context->memory. Deterministic for any number of threads. with_ssim = false leaves ssim 0. Errors:
 * those of the sources, BTF_ERROR_MEMORY, BTF_ERROR_INTERRUPTED. */
btf_result enc_metrics_compare(const enc_context *context, const enc_data *shape, enc_image_source original,
                               enc_image_source other, bool with_ssim, enc_metrics *out_metrics);

/* Decodes each level and compares it with the filtered data: out_metrics [count - 1], without SSIM. Stage
 * "measure levels". */
btf_result enc_levels_measure(const enc_context *context, const enc_data *data, const enc_levels *levels,
                              enc_metrics *out_metrics);

/* Finds the rings of a list: their thetas, ascending, and out_ring_of[i], the ring of direction i. Returns
 * the number of rings. */
int enc_rings(const enc_direction *directions, int count, double *out_theta, int *out_ring_of);

/* Writes {"linear": dB, "srgb": dB, "ssim": S, "rings": {"view": [{"theta", "linear", "srgb"}...], "light":
 * [...]}} under `key`; ssim is null unless with_ssim. */
void enc_metrics_json(json *j, const char *key, const enc_metrics *metrics, bool with_ssim);

#endif
