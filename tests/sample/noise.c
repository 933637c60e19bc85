/* Seeded periodic noise from an integer hash, in doubles.
 *
 * SPDX-License-Identifier: MIT
 */
#include "noise.h"

#include <math.h>

/* An avalanching permutation of 32-bit integers: two xorshift-multiply rounds. */
static uint32_t mix(uint32_t a) {
    a ^= a >> 16;
    a *= UINT32_C(0x7feb352d);
    a ^= a >> 15;
    a *= UINT32_C(0x846ca68b);
    a ^= a >> 16;
    return a;
}

double noise_hash(uint32_t seed, int i, int j, int k) {
    uint32_t h = mix(seed + UINT32_C(0x9e3779b9));
    h = mix(h ^ (uint32_t)i);
    h = mix(h + (uint32_t)j);
    h = mix(h ^ (uint32_t)k);
    return h / 4294967296.0;
}

static double fade(double t) {
    return t * t * t * (t * (t * 6 - 15) + 10);
}

static int wrap(int i, int n) {
    i %= n;
    return i < 0 ? i + n : i;
}

/* The gradient of lattice point (i, j) times the offset (dx, dy) from it. */
static double corner(uint32_t seed, int i, int j, int nx, int ny, double dx, double dy) {
    int wi = wrap(i, nx), wj = wrap(j, ny);
    double gx = 2 * noise_hash(seed, wi, wj, 0) - 1;
    double gy = 2 * noise_hash(seed, wi, wj, 1) - 1;
    return gx * dx + gy * dy;
}

double noise_gradient(uint32_t seed, double x, double y, int nx, int ny) {
    double px = x * nx, py = y * ny;
    double fx = floor(px), fy = floor(py);
    int i = (int)fx, j = (int)fy;
    double dx = px - fx, dy = py - fy;
    double sx = fade(dx), sy = fade(dy);
    double a = corner(seed, i, j, nx, ny, dx, dy);
    double b = corner(seed, i + 1, j, nx, ny, dx - 1, dy);
    double c = corner(seed, i, j + 1, nx, ny, dx, dy - 1);
    double d = corner(seed, i + 1, j + 1, nx, ny, dx - 1, dy - 1);
    double low = a + sx * (b - a), high = c + sx * (d - c);
    return 1.4 * (low + sy * (high - low));
}

double noise_fractal(uint32_t seed, double x, double y, int nx, int ny, int octaves) {
    double sum = 0, amplitude = 1;
    for (int o = 0; o < octaves; ++o) {
        sum += amplitude * noise_gradient(seed + (uint32_t)o * 101, x, y, nx << o, ny << o);
        amplitude *= 0.5;
    }
    return sum;
}
