/* Directions drawn from an environment map and of the material, in place of lights that stand for the map.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_RENDER_SAMPLED_ENVIRONMENT_H
#define OPENBTF_RENDER_SAMPLED_ENVIRONMENT_H

#include "table.h"
#include <openbtf/material.h>

typedef struct sampled_environment sampled_environment;

/* Prepares `count` directions a sample, 1 at least: half of them, rounded up, in proportion to the luminance of a map
 * (pixels, rotate and gain as light_list_add_environment takes them; copied), the others by the material's own tables
 * (openbtf/sampling.h). Each is weighed by the density that both together give it (multiple importance sampling with
 * the balance heuristic: E. Veach, 1997, section 9.2.2), so that the sum over the directions is on average the map's
 * light, whole, whatever count is. The material must outlive it. Errors, on log: BTF_ERROR_MEMORY,
 * BTF_ERROR_UNSUPPORTED. */
btf_result sampled_environment_create(int width, int height, const float *pixels, double rotate,
                                      double gain, const btf_material *material, int count,
                                      const btf_log *log, sampled_environment **out_environment);
void sampled_environment_destroy(sampled_environment **environment);

/* Directions a sample. */
int sampled_environment_count(const sampled_environment *environment);

/* Turns the map about z, degrees from +x towards +y, from where it was at first. */
void sampled_environment_turn(sampled_environment *environment, double degrees);

/* Fills in inputs and weights as table_light does, for direction `index` of each sample of the rows that begin with
 * first_row: one direction for each sample, weights[][3] = incident radiance over pi and density. A direction depends
 * on the sample's column and row in the picture and on index alone. */
void sampled_environment_light(const sampled_environment *environment, const table_scene *scene, int index,
                               int first_row, int rows, const table_sample *samples, float *inputs,
                               float *weights);

#endif
