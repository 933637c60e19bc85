/* Directions that are left out of the encoding: every second azimuth of the ring nearest to 45 degrees, as views and as
 * lights. They stand for the directions between the samples that renderers ask for, but their truth is known.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TESTS_BENCH_HELD_H
#define OPENBTF_TESTS_BENCH_HELD_H

#include <openbtf/reference.h>
#include "encoder/data/images.h"

enum { BENCH_HELD_SETS = 3 }; /* held view under a sampled light, sampled view under a held light, both */

typedef struct bench_held {
    const enc_data *train;           /* the samples that are encoded */
    enc_data *sets[BENCH_HELD_SETS]; /* NULL: nothing could be held out */
    enc_data *owned;                 /* train where directions were left out, else NULL */
    double theta;                    /* of the ring, degrees */
    int n_views, n_lights;           /* left out */
} bench_held;

/* Splits `data` by copying. Where `wanted` is false, or no ring has several views and lights, train is `data` itself
 * and there are no sets. `data` must outlive it. Errors: BTF_ERROR_MEMORY, BTF_ERROR_IO. */
btf_result bench_held_create(const enc_context *context, const enc_data *data, bool wanted,
                             bench_held *out_held);
void bench_held_clear(bench_held *held);

/* Sampled images, blended at other directions with the neighbours and weights of a material's tables, or
 * the nearest of them. */
typedef struct bench_blend {
    const enc_data *samples;
    const enc_data *shape; /* directions to blend at */
    const btf_ref_material *tables;
    bool nearest;
} bench_blend;

/* `blend` must outlive the source. */
enc_image_source bench_blended_images(const bench_blend *blend);

#endif
