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

/* Squared errors of one texel, whose samples are given, of radiance clipped to [0, peak], added over them;
 * other arguments are those of enc_paper_error. model: 3 * n_lights floats of scratch. */
double enc_paper_texel_error(const enc_data *data, const enc_solution *solution,
                             const enc_occlusion *occlusion, uint32_t effects, double peak, size_t texel,
                             const float *samples, float *model);

/* Finds numbers at one texel: out[numbers]. scratch: 3 * n_lights floats. Called by several threads. */
typedef void (*enc_paper_texel_fn)(const void *user, size_t texel, const float *samples, float *scratch,
                                   double *out);

/* Means a sample and channel of `numbers` sums that fn finds at each of up to ENC_PAPER_SAMPLE texels
 * evenly spaced; the same bits for any number of threads and ranks. Errors: BTF_ERROR_MEMORY, BTF_ERROR_IO. */
btf_result enc_paper_sample(const enc_context *context, const enc_data *data, enc_paper_texel_fn fn,
                            const void *user, size_t numbers, double *out);

/* Mean squared error, of radiance clipped to [0, 1], of SBRDF, shadow map, centre codes of `solution` and
 * shifts, hidden points of `occlusion` (NULL: none) when decoded with `effects`, over the
 * texels of enc_paper_sample. Errors: BTF_ERROR_MEMORY, BTF_ERROR_IO. */
btf_result enc_paper_error(const enc_context *context, const enc_data *data, const enc_solution *solution,
                           const enc_occlusion *occlusion, uint32_t effects, double *out_error);

/* Adds a trial with this mean squared error, clipped, to the stats, and logs it. since: core clock at its
 * begin. */
void enc_paper_note(const enc_context *context, const enc_data *data, const enc_solution *solution,
                    uint32_t effects, double error, double since, const char *verdict,
                    enc_paper_stats *stats);

/* Whether shifts or hidden points promise to gain anything: flows of so few lights, which take a small part
 * of the time of all, as shifts on the sample, and the share of points that they hide. False where they
 * gain less than the tolerance and hide less than one point in a hundred. */
btf_result enc_paper_probe(const enc_context *context, const enc_data *data,
                           const enc_paper_options *options, const enc_solution *solution,
                           enc_paper_stats *stats, bool *out_promising);

/* Leaves out effects one by one, each time the one that costs least, while it costs less than the
 * tolerance: changes solution->effects alone. Notes every set that was tried in stats. */
btf_result enc_paper_choose(const enc_context *context, const enc_data *data,
                            const enc_paper_options *options, enc_solution *solution,
                            const enc_occlusion *occlusion, enc_paper_stats *stats);

#endif
