/* Valid materials of any shape filled with seeded random values, for tests.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TESTS_RANDOM_MATERIAL_H
#define OPENBTF_TESTS_RANDOM_MATERIAL_H

#include <openbtf/material.h>

/* splitmix64: the same numbers on every machine. */
typedef struct random_state {
    uint64_t state;
} random_state;

uint64_t random_next(random_state *r);
uint32_t random_below(random_state *r, uint32_t n); /* 0 .. n-1 */
double random_unit(random_state *r);                /* 0 <= x < 1 */

/* count directions in paper order: rings like UBO2003's while they last (1, 6, 12, ... azimuths at rising
 * theta up to theta_max degrees). out: [count][3]. */
void random_rings(uint32_t count, double theta_max, float *out);
/* count distinct unit vectors spread over the hemisphere at random, theta below theta_max. */
void random_directions(random_state *r, uint32_t count, double theta_max, float *out);
/* The 81 directions of UBO2003 and the 151 of UBO2014. */
void random_ubo2003(float out[81][3]);
void random_ubo2014(float out[151][3]);

/* Chooses heights, steps, level and views of the effect relief, and the share of gloss, at random where desc has those
 * effects, now and then one height everywhere or the bounds of the format. Keeps levels, relief_level and relief_end
 * legal. */
void random_material_relief(random_state *r, btf_material_desc *desc);

/* Fills desc->texture[] and, with info.levels, level_texture[] with values that the rest of desc->info
 * allows, atlas size included for layout paper (its smallest legal one when atlas_width is 0). Free with
 * random_material_free. */
void random_material_fill(random_state *r, btf_material_desc *desc);
void random_material_free(btf_material_desc *desc);

/* The file of a material filled at random: *size bytes, freed with btf_free. Frees desc. */
void *random_material_save(random_state *r, btf_material_desc *desc, size_t *size);

/* A desc of the given shape with scales of 1 (gain 2^-7), heights of -256 to 541 with relief, a share of
 * 1/4 with gloss, directions in rings, no textures yet; directions are freed by random_material_free. */
btf_material_desc random_material_desc(uint32_t width, uint32_t height, uint32_t n_views, uint32_t n_lights,
                                       btf_layout layout, uint32_t effects);

#endif
