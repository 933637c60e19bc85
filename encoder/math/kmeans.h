/* k-means of rows of floats, the same for any machine and number of threads.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_MATH_KMEANS_H
#define OPENBTF_ENCODER_MATH_KMEANS_H

#include <openbtf/result.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Floats of a row with `dimensions` values: whole vectors of 16, the rest zero. */
static inline size_t enc_kmeans_stride(size_t dimensions) {
    return (dimensions + 15) / 16 * 16;
}

/* Counts the different rows among points[n][stride], compared by their bits. Errors: BTF_ERROR_MEMORY. */
btf_result enc_kmeans_distinct(size_t n, size_t stride, const float *points, size_t *out_distinct);

/* Finds the nearest of centres[k][stride] for each of points[n][stride], k >= 1, by squared Euclidean
 * distance; the lowest index among equals. index[n] holds guesses (below k) and receives the results,
 * out_squares[n] (may be NULL) the squared distances. Returns how many indices changed. Errors:
 * BTF_ERROR_MEMORY. */
btf_result enc_kmeans_nearest(size_t n, size_t stride, const float *points, size_t k, const float *centres,
                              uint32_t *index, float *out_squares, size_t *out_changed);

/* Lloyd's k-means from a k-means++ start (Arthur and Vassilvitskii 2007), 1 <= k <= n: at most `iterations`
 * rounds, fewer when no point changes its centre. An empty cluster restarts at the point farthest from its
 * centre. With data_points the centres returned are the members nearest to the centroids.
 * out_centres[k][stride], index[n]. One thread; several calls may run at once. Errors: BTF_ERROR_MEMORY. */
btf_result enc_kmeans(size_t n, size_t stride, const float *points, size_t k, int iterations, uint64_t seed,
                      bool data_points, float *out_centres, uint32_t *index);

#endif
