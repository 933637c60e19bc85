/* Parts of a set of rows, so that clustering each costs time linear in the rows.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_PAPER_CLUSTER_SPLIT_H
#define OPENBTF_ENCODER_PAPER_CLUSTER_SPLIT_H

#include <openbtf/result.h>
#include <stddef.h>

/* Halves points[n][stride] again and again, across the direction in which they vary most, until no part has
 * more than `most`. The parts hold the rows out_order[n]: part i those from out_first[i] up to, but not
 * including, out_first[i + 1]; out_first has room for n / most * 2 + 3 of them. Returns their number, 1
 * with rows in order for n <= most. Rows in a part ascend. Errors: BTF_ERROR_MEMORY. */
btf_result enc_cluster_split(size_t n, size_t stride, const float *points, size_t most, size_t *out_order,
                             size_t *out_first, size_t *out_parts);

#endif
