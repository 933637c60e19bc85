/* Accuracy between the samples, of materials and of images that are interpolated there: against truth, and
 * as an estimate from the samples alone, each pair of a view and a light predicted from the other views and
 * lights (encoder/nodes/left_out.h), which lie about twice as far away as the samples around a direction
 * between them.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TESTS_BENCH_BETWEEN_H
#define OPENBTF_TESTS_BENCH_BETWEEN_H

#include <openbtf/reference.h>
#include "encoder/nodes/interpolate.h"
#include "truth.h"

typedef enum bench_between_set {
    BENCH_TRUTH = 0,
    BENCH_ESTIMATE = 1,
    BENCH_BETWEEN_SETS = 2
} bench_between_set;
enum { BENCH_ESTIMATE_PAIRS = 256 };

/* PSNR of values clipped to [0, 1]: linear, sRGB-coded, dB. NAN: not known. */
typedef double bench_between_figures[BENCH_BETWEEN_SETS][2];
void bench_between_unknown(bench_between_figures figures);

typedef struct bench_between bench_between;

/* For codecs of `data`. The estimate takes BENCH_ESTIMATE_PAIRS pairs, drawn with a fixed seed. `data` and
 * `truth` (count 0: none), of one size, must outlive it. Errors, on the log: those of enc_left_out_make and
 * enc_interpolator_create, of the data, BTF_ERROR_MEMORY. */
btf_result bench_between_create(const enc_context *context, const enc_data *data, const bench_truth *truth,
                                bench_between **out_between);
void bench_between_destroy(bench_between **between);
/* Whether a set can be measured: false for truth that is not known, and where no direction can be left out. */
bool bench_between_has(const bench_between *between, bench_between_set set);

/* Measures a material that has the data's directions, by the reference decoder. Errors: BTF_ERROR_MEMORY,
 * BTF_ERROR_INTERRUPTED. */
btf_result bench_between_material(const enc_context *context, const bench_between *between,
                                  const btf_ref_material *material, const btf_ref_options *options,
                                  bench_between_figures out_figures);
/* Measures interpolated images: `images` at the data's directions, such as a codec decodes. The same bits for any
 * number of threads. Errors: those of enc_interpolator_create and of the images, BTF_ERROR_MEMORY,
 * BTF_ERROR_INTERRUPTED. */
btf_result bench_between_images(const enc_context *context, const bench_between *between,
                                const enc_data *images, enc_interpolation kind,
                                bench_between_figures out_figures);

#endif
