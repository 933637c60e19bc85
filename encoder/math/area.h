/* How much of each pixel of a row a pixel of another row covers, in whole numbers, for area filters. Both
 * rows are as long as `from * to` parts, one of `from` pixels and one of `to`.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_MATH_AREA_H
#define OPENBTF_ENCODER_MATH_AREA_H

#include <stdint.h>

/* Parts of pixel k of a row of `from` pixels that lie in pixel c of a row of `to`; over all k they sum to
 * `from`. */
static inline int64_t enc_area_overlap(int from, int to, int c, int k) {
    const int64_t left = (int64_t)c * from > (int64_t)k * to ? (int64_t)c * from : (int64_t)k * to;
    const int64_t right =
        (int64_t)(c + 1) * from < (int64_t)(k + 1) * to ? (int64_t)(c + 1) * from : (int64_t)(k + 1) * to;
    return right > left ? right - left : 0;
}

/* The pixels *first .. *end - 1 of the row of `from` that pixel c of the row of `to` touches. */
static inline void enc_area_span(int from, int to, int c, int *first, int *end) {
    *first = (int)((int64_t)c * from / to);
    *end = (int)(((int64_t)(c + 1) * from + to - 1) / to);
}

#endif
