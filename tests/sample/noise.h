/* Seeded periodic noise, from which reliefs and their colours are made.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_SAMPLE_NOISE_H
#define OPENBTF_SAMPLE_NOISE_H

#include <stdint.h>

/* A number of [0, 1) that depends on all arguments, uniform over them. */
double noise_hash(uint32_t seed, int i, int j, int k);

/* Gradient noise (Perlin 1985, with the quintic fade of 2002) of nx * ny lattice cells over the unit tile,
 * periodic with period 1 in x and y. About -0.8..0.8, mean 0. */
double noise_gradient(uint32_t seed, double x, double y, int nx, int ny);

/* Sum of `octaves` of noise_gradient, each of twice the frequency and half the amplitude of the one before. */
double noise_fractal(uint32_t seed, double x, double y, int nx, int ny, int octaves);

#endif
