/* A folded shader on a rig, beside that of any other variant.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TESTS_BENCH_RIG_FOLD_H
#define OPENBTF_TESTS_BENCH_RIG_FOLD_H

#include "tests/bench/decode/decode_rig.h"

#include <openbtf/fold.h>

/* The shader of options->fold, and the fold of options->fixed_light and fixed_view, which is made here and which the
 * caller destroys after the variant. Program 0: failed, with a message. Other variants' textures stay bound where they
 * use units before RIG_FOLD_UNITS. */
enum { RIG_FOLD_UNITS = GPU_FIRST_UNIT + BTF_TEXTURE_COUNT / 2 };
rig_variant rig_folded_create(decode_rig *rig, const btf_material *material,
                              const btf_shader_options *options, btf_gl_fold **out_fold);

#endif
