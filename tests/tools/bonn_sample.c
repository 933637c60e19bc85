/* A small Bonn file for the tests of the tools: 16x16 texels, 7 views and lights, smooth.
 *
 *   bonn_sample FILE
 *
 * SPDX-License-Identifier: MIT
 */
#include "tests/support/bonn_files.h"

#include <math.h>
#include <stdio.h>

enum { SIDE = 16, DIRECTIONS = 7, K = 6 };

static const double directions[DIRECTIONS][2] = {{0, 0},    {40, 0},   {40, 60}, {40, 120},
                                                 {40, 180}, {40, 240}, {40, 300}};

static double of_direction(int view, int light, int channel, unsigned k) {
    const double *v = directions[view], *l = directions[light];
    if (k == 0) {
        return channel == 0 ? log(0.05 + 0.6 * cos(l[0] * M_PI / 180)) : 0.05 * channel;
    }
    return cos(0.05 * k * (v[0] + 0.3 * l[0]) + 0.02 * k * (v[1] - l[1]) + channel) / (1.0 + k);
}

static double of_texel(int x, int y, int channel, int view, unsigned k) {
    (void)view;
    return k == 0 ? 1.0 : 0.3 * sin(2 * M_PI * (k * x + (k / 2 + 1) * y) / SIDE + k + channel);
}

int main(int argc, char **argv) {
    bonn_spec spec = bonn_half_dfmf(SIDE, DIRECTIONS, directions, K);
    spec.direction = of_direction;
    spec.texel = of_texel;
    if (argc != 2 || !bonn_write(argv[1], &spec)) {
        fprintf(stderr, "bonn_sample: cannot write %s\n", argc == 2 ? argv[1] : "without a name");
        return 2;
    }
    return 0;
}
