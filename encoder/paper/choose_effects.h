/* `--effects auto` of method paper: the error that each effect removes, on a sample of texels.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_PAPER_CHOOSE_EFFECTS_H
#define OPENBTF_ENCODER_PAPER_CHOOSE_EFFECTS_H

#include "encoder/model/solution.h"
#include "options.h"

enum { ENC_PAPER_PROBE_LIGHTS = 3 }; /* lights whose flows the probe takes */
enum { ENC_PAPER_SAMPLE = 256 };     /* texels of the sample that errors are measured on */

/* The sum of squared errors over the samples of one texel, which are given, of radiance clipped to [0,
 * peak]; the other arguments are those of enc_paper_error. model: 3 * n_lights floats of scratch. */
double enc_paper_texel_error(const enc_data *data, const enc_solution *solution,
                             const enc_occlusion *occlusion, uint32_t effects, double peak, size_t texel,
                             const float *samples, float *model);

/* Finds numbers at one texel: out[numbers]. scratch: 3 * n_lights floats. Called by several threads. */
typedef void (*enc_paper_texel_fn)(const void *user, size_t texel, const float *samples, float *scratch,
                                   double *out);

/* Adds up the numbers that fn finds at each of up to ENC_PAPER_SAMPLE texels, evenly spaced, and divides
 * the `numbers` sums by the count of samples and channels. The same bits for any number of threads and
 * ranks. Errors: BTF_ERROR_MEMORY, BTF_ERROR_IO. */
btf_result enc_paper_sample(const enc_context *context, const enc_data *data, enc_paper_texel_fn fn,
                            const void *user, size_t numbers, double *out);

/* Finds the mean squared error of radiance clipped to [0, 1] over the texels of enc_paper_sample, decoded
 * with `effects` from the SBRDF, shadow map and centre codes of `solution` and the shifts and hidden points
 * of `occlusion` (NULL: none). Errors: BTF_ERROR_MEMORY, BTF_ERROR_IO. */
btf_result enc_paper_error(const enc_context *context, const enc_data *data, const enc_solution *solution,
                           const enc_occlusion *occlusion, uint32_t effects, double *out_error);

/* Adds a trial with this mean squared error, clipped, to the stats, and logs it. since: the core clock when
 * it began. */
void enc_paper_note(const enc_context *context, const enc_data *data, const enc_solution *solution,
                    uint32_t effects, double error, double since, const char *verdict,
                    enc_paper_stats *stats);

/* Finds whether shifts or hidden points promise to gain anything, from the flows of ENC_PAPER_PROBE_LIGHTS
 * lights, which take a small part of the time of all: false where these shifts gain less than the tolerance
 * on the sample and the flows hide less than one point in a hundred. */
btf_result enc_paper_probe(const enc_context *context, const enc_data *data,
                           const enc_paper_options *options, const enc_solution *solution,
                           enc_paper_stats *stats, bool *out_promising);

/* Leaves out effects one by one, each time the one that costs least, while it costs less than the
 * tolerance: changes solution->effects alone. Notes every set that was tried in stats. */
btf_result enc_paper_choose(const enc_context *context, const enc_data *data,
                            const enc_paper_options *options, enc_solution *solution,
                            const enc_occlusion *occlusion, enc_paper_stats *stats);

#endif
