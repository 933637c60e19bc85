/* Levels of detail: a material for the area-filtered BTF of each level (level_filter.h), in one file.
 *
 * A level has SBRDF, shadow maps, shifts, gains and texels of the residual of its own; the rest, V, centres
 * and every scale, is that of level 0, so that a shader changes nothing but the mip level that it fetches.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_LEVELS_H
#define OPENBTF_ENCODER_LEVELS_H

#include "encoder/data/level_filter.h"
#include "encoder/model/solution.h"
#include "encoder/nodes/apply.h"
#include "encoder/paper/paper.h"

/* Analyses levels 1 .. count - 1 of `data` for `base`, the solution of level 0. `paper` is NULL for a base
 * of factors; else the whole analysis runs on each level, its centres (as many as fit the atlas of the
 * level's size) go behind those of base, and hidden points are left out where base has none or the file has
 * no room. `data` are samples; `nodes`, where not NULL, fits each level's after filtering. Stage "levels".
 * Errors: those of the stages; *out_levels is zeroed then. */
btf_result enc_levels_fit(const enc_context *context, const enc_data *data, int count,
                          const enc_paper_options *paper, const enc_node_tables *nodes, enc_solution *base,
                          enc_levels *out_levels);

#endif
