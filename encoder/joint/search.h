/* Search: for every point of one view, the source whose profile times the best gain is nearest.
 *
 * Queries and sources are vectors of k coordinates in one orthonormal basis: c = basis * row, and z
 * likewise, so that |row - g source|^2 = |row|^2 - value, value = 2 g <c, z> - g^2 |z|^2. The largest value
 * over all sources wins, each with the gain code that suits it best.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_JOINT_SEARCH_H
#define OPENBTF_ENCODER_JOINT_SEARCH_H

#include "encoder/math/gemm.h"

#include <openbtf/result.h>
#include <stdbool.h>
#include <stdint.h>

/* Gains that a point may have: code * step, codes low .. high (1 .. 255, or one code where gains are off).
 */
typedef struct joint_gains {
    float step;
    int low, high;
} joint_gains;

/* The best code for a source of squared norm `norm` under the inner product `dot`; *out_value as above. */
static inline int joint_best_gain(const joint_gains *gains, double dot, double norm, double *out_value) {
    const double step = (double)gains->step;
    double code = norm > 0.0 ? dot / (norm * step) + 0.5 : gains->low;
    code = code < gains->low ? gains->low : code > gains->high ? gains->high : (double)(int)code;
    const double gain = code * step;
    *out_value = gain * (2.0 * dot - gain * norm);
    return (int)code;
}

/* Beyond 64x64 texels, sources of the grid that a point looks at and tiles around its own (see
 * search_set.h), so that the cost of a round grows linearly with texels. */
enum { JOINT_GRID_SOURCES = 1024, JOINT_WINDOW = 1 };

/* The texture and the limits of a search. */
typedef struct joint_search {
    int width, height;
    size_t k;
    joint_gains gains;
    size_t sources;   /* sources of the grid beyond 64x64 texels; 0: no bound, every point looks at all */
    int window;       /* tiles around a point's own whose sources it looks at too */
    unsigned phase;   /* place of the grid: another for each search of one data set */
    double tolerance; /* a shift must lower the squared distance by this much of |row|^2 */
    enc_gemm_tile tile;
    int threads;
} joint_search;

/* One view: queries c[texel][k] with energies |row|^2 [texel], sources z[texel][k]. match[texel] and
 * gain[texel] hold the present choice and are replaced only by a better one; the result does not depend on
 * the number of threads. The winner is exact: every source within the rounding error of the product is
 * compared again in double. A point that does not look at all sources looks at its present choice too and
 * at what its four neighbours refer to, moved along, and follows falling distances from source to
 * neighbouring source for two steps. Ties within 1e-9 |row|^2 go to the smaller shift, then to the lower
 * texel. out_value[texel] is the value of the choice.
 * Errors: BTF_ERROR_MEMORY. */
btf_result joint_search_view(const joint_search *search, const float *c, const float *energy,
                             const float *z, uint32_t *match, uint8_t *gain, double *out_value);

/* The same without a search: the gain alone is chosen anew. */
void joint_search_gains(const joint_search *search, const float *c, const float *z, const uint32_t *match,
                        uint8_t *gain, double *out_value);

/* Squared length of the shift from texel x to the source, the shorter way round; false where it does not
 * fit -128 .. 127. */
bool joint_shift(int width, int height, uint32_t texel, uint32_t source, int *out_dx, int *out_dy);

#endif
