/* Scenes to plan for, and the accuracy that a plan loses there: as the file predicts, and as measured on the data.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TESTS_PLAN_SCENES_H
#define OPENBTF_TESTS_PLAN_SCENES_H

#include "encoder/data/data.h"

#include <openbtf/plan.h>
#include <openbtf/reference.h>

typedef struct plan_scene {
    const char *name;
    btf_scene scene;
} plan_scene;

/* "everything", "top-down", "grazing", "frontal light", "orbit", "still light", "still view", "both
 * still", "far". */
enum { PLAN_SCENES = 9 };
extern const plan_scene plan_scenes[PLAN_SCENES];

/* Packs `solution` into a material with the table of effect errors; levels: of detail (1 for none), for the joint
 * method. */
struct enc_solution;
btf_result plan_pack(const enc_context *context, const enc_data *data, struct enc_solution *solution,
                     btf_layout layout, int levels, btf_material **out_material);

/* Mean squared errors of values clipped to [0, 1], linear and sRGB-coded, against the data area-filtered to
 * the plan's level and interpolated in radiance: of the restriction `small` as planned, and of all of
 * `whole` at that level. At random directions of the scene, down to the outermost ring; the same ones for
 * both. */
btf_result plan_measure(const enc_context *context, const enc_data *data, const btf_material *whole,
                        const btf_material *small, const btf_plan *plan, double planned[2], double full[2]);

/* The reference's options for a plan; and a function that adds the squared errors of a decoded value, clipped to [0,
 * 1], linear and sRGB-coded, to sum. */
btf_ref_options plan_reference_options(const btf_plan *plan);
void plan_add_errors(const double truth[3], const float rgb[3], double sum[2]);

/* A picture of side x side pixels of the scene: u, v, light, view as bits, 8 words each. Neighbouring
 * pixels show neighbouring texels (of the scene's size) under alike directions: views rise along rows and
 * turn along columns, lights the other way round. */
void plan_arguments(const btf_plan *plan, const enc_data *data, size_t side, uint32_t *out);

/* The PSNR in dB of a mean squared error. */
double plan_psnr(double mse);

#endif
