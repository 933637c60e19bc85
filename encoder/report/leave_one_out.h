/* An estimate of the accuracy between the samples from the samples alone: each view, each light, and both
 * at once, predicted from the others as if it had not been sampled (cross-validation; Stone 1974).
 *
 * The others stand twice as far away as the samples around a direction between them do, so errors come out
 * larger than they are there. Errors of what moves from sample to sample, shifting relief, shadows and
 * highlights, are overstated most. A sample is left out as a neighbour only: the material was still fitted
 * to it, so that a model of few parameters comes out better than the data. Truth between the samples, where
 * there is any, is measured by between.h.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_LEAVE_ONE_OUT_H
#define OPENBTF_ENCODER_LEAVE_ONE_OUT_H

#include "bands.h"
#include "decoder/toolkit/json.h"
#include "metrics.h"

#include <openbtf/material.h>
#include <stdio.h>

/* The directions that are left out, as bits. */
enum { ENC_LEFT_VIEW = 1, ENC_LEFT_LIGHT = 2, ENC_LEFT_BOTH = 3 };

/* Means of squared errors: count is 1, or 0 where nothing was measured. */
typedef struct enc_left_out_errors {
    enc_error_sum material; /* decoded without the sample; not measured without a material */
    /* the same without relief, without gloss: measured where it holds the effect and a view is left out */
    enc_error_sum no_relief, no_gloss;
    enc_error_sum data; /* the data themselves, interpolated without the sample */
} enc_left_out_errors;

enum {
    ENC_LEFT_OUT_TEXELS = 1024,
    ENC_LEFT_OUT_PAIRS = 256
}; /* drawn at most: texels, and pairs for each */
/* Texels that are drawn at most of a level: of level 1 a quarter of those of level 0, then half as many
 * each, down to 64. */
#define ENC_LEFT_OUT_OF_LEVEL(level)                                                                       \
    ((level) == 0 ? ENC_LEFT_OUT_TEXELS : (level) < 3 ? ENC_LEFT_OUT_TEXELS >> ((level) + 1) : 64)

typedef struct enc_leave_one_out {
    int views, lights; /* that can be left out (left_out.h) */
    /* By what is left out, entry 0 not used: over all pairs of view and light, and over those of which the
     * view lies in a band of views and the light in one of lights, at [view band * light_bands.count +
     * light band]. */
    enc_left_out_errors error[1 + ENC_LEFT_BOTH];
    enc_left_out_errors band_error[1 + ENC_LEFT_BOTH][BTF_MAX_BANDS * BTF_MAX_BANDS];
    enc_bands view_bands, light_bands;
} enc_leave_one_out;

/* Measures levels 0 .. levels - 1 of `material` (NULL: the data alone), which must have the data's size and
 * directions, beside the data, filtered to the level, into out[levels]: at a subset of texels and of pairs
 * of view and light, spread evenly over the bands, that depends on nothing but the data's extent: about a
 * second of one core for level 0. A further level takes the share of that which its texels drawn are
 * (ENC_LEFT_OUT_OF_LEVEL): levels 1 to 4 together half at most, each level beyond them a sixteenth at most;
 * and filtering takes a pass over the data. Deterministic for any number of threads and ranks. Stage "leave
 * one out". Errors: those of the data and of enc_level_each, BTF_ERROR_MEMORY, BTF_ERROR_INTERRUPTED. */
btf_result enc_leave_one_out_measure(const enc_context *context, const enc_data *data,
                                     const btf_material *material, int levels, enc_leave_one_out *out);

/* Writes the numbers of btf_material_desc.between_errors (FORMAT.md section 7) for a level that was
 * measured with a material; level 0 has the bands in front of its rows. `out` has room for
 * ENC_BETWEEN_NUMBERS. Returns how many: 0 where nothing could be left out. */
enum { ENC_BETWEEN_NUMBERS = 4 + 2 * BTF_MAX_BANDS + 7 * (5 + 2 * BTF_MAX_BANDS * BTF_MAX_BANDS) };
size_t enc_leave_one_out_numbers(const enc_leave_one_out *measured, int level, float *out);

/* Prints a table for people, with a word on what the estimate overstates. Prints nothing where nothing could be
 * left out. */
void enc_leave_one_out_print(const enc_leave_one_out *measured, FILE *out);

/* {"views", "lights": how many can be left out, "view": {"linear", "srgb", "data_linear", "data_srgb"},
 * "light", "both"} under `key`, of a view "linear_without_relief" and "srgb_without_relief" where there is
 * relief, likewise "_without_gloss"; null for what is not measured. */
void enc_leave_one_out_json(json *j, const char *key, const enc_leave_one_out *measured);

#endif
