/* OpenBTF: how much the error grows where a scene looks, by what a plan leaves out.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_PLAN_GROWTH_H
#define OPENBTF_PLAN_GROWTH_H

#include "table.h"

#pragma GCC visibility push(hidden)

/* Fills in way->growth: how much the full decode's error grows by decoding as `row` says, against the truth; `full` is
 * the row of the full decode. At samples the data are the truth. Between them what is left out adds its own squared
 * difference, since it knows nothing of the error that interpolation makes there: against the data, interpolated,
 * growth is too little where relief moves texels, for then what is left out blurs, and so do these data. Where the file
 * has no differences, their place takes the mean of both growths, of which that at samples is too much, or the growth
 * against the data where it is more (nearest directions). */
void btfi_find_growth(const btfi_error_table *table, const float *row, const float *full, btfi_way *way);

/* The error of the full decode of a level by the file's table of errors between the samples: of the row where those of
 * view and light are left out that are no samples. False where the table says nothing of the level. */
bool btfi_find_between(const btf_material *material, const btf_scene *scene, const btfi_error_table *table,
                       uint32_t level, double mse[2]);

/* Sets growth[] to the share by which the error of a level grows where `effect`, relief or gloss, is not decoded; false
 * where the table does not say. A view or light that is left out stands at double the gap: there the error by which
 * either moves what is seen, which grows with the square of the gap, is four times that between the samples, and the
 * whole error twice (btfi_errors_to_tolerate), so that half of the growth remains. BRICKS64, all directions, gloss:
 * 1.07/0.34 dB left out, 0.62/0.09 dB in images between the samples, 0.57/0.17 by this. */
bool btfi_find_without(const btf_material *material, const btf_scene *scene, const btfi_error_table *table,
                       uint32_t level, btf_effect effect, double growth[2]);

/* The errors that the tolerance is a share of: those of the full decode where the scene looks. Returns whether that is
 * between the samples, by a file that says what is lost there. */
bool btfi_errors_to_tolerate(const btf_material *material, const btf_scene *scene,
                             const btfi_error_table *table, uint32_t level, const btfi_way *full,
                             double base[2]);

#pragma GCC visibility pop

#endif
