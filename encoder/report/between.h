/* Accuracy between the samples: a material or a data set against images that are true at other directions
 * than its own.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_REPORT_BETWEEN_H
#define OPENBTF_ENCODER_REPORT_BETWEEN_H

#include "decoder/toolkit/json.h"
#include "encoder/between/pairs.h"
#include "metrics.h"

#include <stdio.h>

/* Gives the images that are compared with the truth, at pairs first .. first + count - 1,
 * out[pair][texel][3]. Called from one thread; it may use context->threads itself. */
typedef btf_result (*enc_pair_images_fn)(const enc_context *context, const void *user,
                                         const enc_pair *pairs, size_t count, float *out);
typedef struct enc_pair_images {
    enc_pair_images_fn images;
    const void *user;
    const enc_direction *views, *lights; /* the sampled directions of what is compared */
    int n_views, n_lights;
} enc_pair_images;

/* One pair. */
typedef struct enc_between_pair {
    enc_error_sum error;
    double ssim;
    double view_gap, light_gap; /* degrees from the view and the light to the nearest sample */
} enc_between_pair;

/* The pairs of which an angle x lies in low <= x < high, degrees. */
typedef struct enc_between_band {
    double low, high;
    size_t pairs;
    enc_error_sum error;
    double ssim; /* mean */
} enc_between_band;

enum { ENC_BETWEEN_BANDS = 8 };
/* The angles that pairs are divided by. */
typedef enum enc_between_by {
    ENC_BY_VIEW_THETA,
    ENC_BY_LIGHT_THETA,
    ENC_BY_VIEW_GAP,
    ENC_BY_LIGHT_GAP,
    ENC_BY_COUNT
} enc_between_by;

typedef struct enc_between {
    size_t count;
    enc_between_pair *pair; /* [count], as the pairs */
    size_t *worst;          /* [count]: indices of the pairs by falling linear error */
    enc_error_sum total;
    double ssim; /* mean over pairs */
    bool with_ssim;
    enc_between_band band[ENC_BY_COUNT][ENC_BETWEEN_BANDS];
    int n_bands[ENC_BY_COUNT]; /* empty bands are left out */
} enc_between;

/* Compares all pairs with the truth, a block of images at a time (at most a quarter of context->memory, 256
 * MB where it is unbounded, but at least one pair). Deterministic for any number of threads. Stage
 * "between". Errors: those of the images and of the pairs, BTF_ERROR_MEMORY, BTF_ERROR_INTERRUPTED. */
btf_result enc_between_measure(const enc_context *context, const enc_pairs *pairs, enc_pair_images model,
                               bool with_ssim, enc_between **out_between);
void enc_between_destroy(enc_between **between);

/* Prints tables for people: totals, bands, the `worst` worst pairs. */
void enc_between_print(const enc_between *between, const enc_pairs *pairs, size_t worst, FILE *out);

/* {"linear", "srgb", "ssim", "pairs": count, "bands": {"view_theta": [{"low", "high", "pairs", "linear",
 * "srgb", "ssim"}...], "light_theta", "view_gap", "light_gap"}, "images": [{"name", "view": [theta, phi],
 * "light", "view_gap", "light_gap", "linear", "srgb", "ssim"}...]} under `key`. */
void enc_between_json(json *j, const char *key, const enc_between *between, const enc_pairs *pairs);

/* Draws the `worst` worst pairs as a PNG, a row for each: the truth, the model, their error (ENC_ERROR_GAIN
 * times, of sRGB-coded values). Reads these images again: `path_of_pairs` and `options` are what the pairs
 * were opened with. Errors: as enc_between_measure, BTF_ERROR_IO. */
btf_result enc_between_picture(const enc_context *context, const char *path_of_pairs,
                               const enc_read_options *options, const enc_between *between,
                               enc_pair_images model, size_t worst, const char *path);

#endif
