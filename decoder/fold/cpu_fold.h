/* OpenBTF: what the folds that are made on the CPU share.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_CPU_FOLD_H
#define OPENBTF_CPU_FOLD_H

#include "decoder/evaluate/source.h"
#include <openbtf/shader.h>

#pragma GCC visibility push(hidden)

/* Checks a fold of so many lights, makes an evaluator of the material, and allocates the whole texture; *out_info is filled in.
 * Errors, on log: those of btf_fold_check and btf_evaluator_create, BTF_ERROR_MEMORY; nothing is left then. */
btf_result btfi_fold_whole(const btf_material *material, const btf_shader_options *options, uint32_t lights,
                           const btf_log *log, btf_material_info *out_info, btf_evaluator **out_evaluator,
                           uint32_t **out_texels);

/* How the texels of a fold are decoded. */
btfi_way btfi_fold_way(const btf_evaluator *evaluator, const btf_shader_options *options);

/* Leaves of a situation one sampled view, under the lights of the neighbour at a place. */
void btfi_fold_one_view(btfi_situation *situation, int place, uint32_t view);

/* The values that a row's texels show in the first view of a situation, before views are blended: out [width][4], the
 * bits of R, G and B, then 0. */
void btfi_fold_values(const btf_evaluator *evaluator, const btfi_way *way, const btfi_situation *situation,
                      uint32_t level, uint32_t row, uint32_t *out);

#pragma GCC visibility pop

#endif
