/* Measures the accuracy that a plan loses between the samples, against images of the truth there.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TESTS_BENCH_PLAN_TRUTH_H
#define OPENBTF_TESTS_BENCH_PLAN_TRUTH_H

#include "tests/bench/codecs/truth.h"

#include <openbtf/plan.h>

/* Mean squared errors of values clipped to [0, 1], linear and sRGB-coded, of the restriction `small` as planned and of all
 * of `whole`, at texels of the images whose view and light the scene has: 50,000 to 100,000, evenly over each image, or all where there
 * are fewer; of coarser levels against the images box-filtered to the level. Returns how many images these are: 0, and no
 * errors, where there is none, a direction stands still, or texels of the level cover parts of texels. */
size_t plan_truth(const bench_truth *truth, const btf_material *whole, const btf_material *small,
                  const btf_plan *plan, double planned[2], double full[2]);

#endif
