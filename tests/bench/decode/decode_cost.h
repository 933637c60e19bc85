/* The cost of decoding a pixel, counted by formulas: fetches, their bytes, and operations.
 *
 * Of materials the counts are those of the cost model of plans (openbtf/cost.h): fetches of their textures but the
 * direction tables, and the sums of SBRDF, shadow and residual. The look-up of directions, the cosine, clamp and blend of
 * views are the same for all and left out, and so are addresses. Hidden points are counted with their sources, three
 * neighbours have weights, and a march along a relief takes all of its steps, where most end early. An operation is one
 * number's: a shift, a mask, a product, a sum and a conversion are one each.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TESTS_BENCH_DECODE_COST_H
#define OPENBTF_TESTS_BENCH_DECODE_COST_H

#include <openbtf/material.h>
#include <openbtf/shader.h>

typedef struct decode_cost {
    double fetches, bytes;   /* a pixel; bytes of the texels fetched */
    double integers, floats; /* operations a pixel */
} decode_cost;

/* Of a material decoded as the options say. A fixed view or light is taken for one of the material's own,
 * with one neighbour. */
decode_cost decode_cost_of(const btf_material_info *info, const btf_shader_options *shader);

/* Of `rank` 8-bit components without shift, U fetched once, three views by three lights (bench_body_pca).
 */
decode_cost decode_cost_pca(int rank);

/* Of 3 x 3 images of 4 bytes a texel (bench_body_lookup), and of two maps (bench_body_phong). */
decode_cost decode_cost_lookup(void);
decode_cost decode_cost_phong(void);

#endif
