/* Copies of the hot loops for wider vectors, chosen when the program starts.
 *
 * The loops that bear the mark hold no float sums across lanes and are not contracted, so that all copies
 * give the same bits.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_MATH_CLONES_H
#define OPENBTF_ENCODER_MATH_CLONES_H

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#define ENC_CLONES __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define ENC_CLONES
#endif

#endif
