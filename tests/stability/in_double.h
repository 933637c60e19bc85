/* Compiles stages of the encoder a second time with every float replaced by a double: the build includes this file
 * before the sources of the fit and the flow (-include). The data and the arguments of OpenCV stay floats, behind the
 * functions below; in_double.c has plain loops in place of the vectorised ones. When one of these sources begins to
 * call another function of floats, it has to be named here.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TESTS_STABILITY_IN_DOUBLE_H
#define OPENBTF_TESTS_STABILITY_IN_DOUBLE_H

#include <assert.h>
#include <float.h>
#include <math.h>
#include <omp.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

/* These headers are included first, so that their floats stay floats. */
#include "encoder/lafortune/ceres_bridge.h"
#include "encoder/data/data.h"
#include "encoder/model/occlusion.h"
#include "encoder/base/opencv_bridge.h"
#include "encoder/base/ranks.h"

typedef struct double_direction {
    double xyz[3];
} double_direction;

/* The functions of floats that the sources call, for doubles. Not for several threads. */
const double_direction *double_light(const enc_data *data, size_t view, size_t light);
double double_luminance(double r, double g, double b);
btf_result double_texels(const enc_context *context, const enc_data *data, size_t first, size_t count,
                         double *buffer, const double **out_samples);
btf_result double_view(const enc_context *context, const enc_data *data, int view, double *out);
int double_cv_flow(enc_cv_flow *flow, int width, int height, const unsigned char *from,
                   const unsigned char *to, double *out_xy);

#define enc_data_light double_light
#define enc_luminance double_luminance
#define enc_data_texels double_texels
#define enc_data_view double_view
#define enc_cv_flow_compute double_cv_flow

/* Other names for all functions that these sources, sbrdf.c and gram.c define, since the float build has the plain
 * names. */
#define enc_fit double_fit
#define enc_fit_options_default double_fit_options_default
#define enc_fit_workspace_create double_fit_workspace_create
#define enc_fit_workspace_destroy double_fit_workspace_destroy
#define enc_fit_texel double_fit_texel
#define enc_fit_fixed_start double_fit_fixed_start
#define enc_fit_evaluate double_fit_evaluate
#define enc_fit_overshoot double_fit_overshoot
#define enc_fit_drop_idle_lobe double_fit_drop_idle_lobe
#define enc_gram_accumulate double_gram_accumulate
#define enc_gram_peak double_gram_peak
#define enc_sbrdf_create double_sbrdf_create
#define enc_sbrdf_destroy double_sbrdf_destroy
#define enc_sbrdf_evaluate double_sbrdf_evaluate
#define enc_flow_vote double_flow_vote
#define enc_flow_pair double_flow_pair
#define enc_flow_error double_flow_error
#define enc_flow_worker_create double_flow_worker_create
#define enc_flow_worker_clear double_flow_worker_clear
#define enc_flow_image_create double_flow_image_create
#define enc_flow_image_clear double_flow_image_clear
#define enc_flow_pair_compute double_flow_pair_compute
#define enc_flow_planes_create double_flow_planes_create
#define enc_flow_planes_clear double_flow_planes_clear
#define enc_flow_prior double_flow_prior
#define enc_flow_bytes double_flow_bytes

#ifdef __clang__
#pragma clang diagnostic ignored "-Wkeyword-macro"
#endif
#define float double
#define sqrtf sqrt
#define fabsf fabs
#define fmaxf fmax
#define fminf fmin
#define floorf floor
#define ceilf ceil
#define hypotf hypot
#define lrintf lrint

#endif
