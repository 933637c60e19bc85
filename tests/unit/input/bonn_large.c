/* A Bonn file of the usual size: 400x400 texels, 151 views and lights, 32 components a channel. Prints how long it
 * takes to open and how fast it decodes, and checks values at random places. * bonn_large [FILE] FILE: where the file
 * is kept
 *
 * SPDX-License-Identifier: MIT
 */
#include "tests/support/bonn_files.h"
#include "decoder/toolkit/progress.h"
#include "encoder/input/reader.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

enum { SIDE = 400, DIRECTIONS = 151, K = 32, TILE = 16 };

static double directions[DIRECTIONS][2];

/* The directions of the dome of the University of Bonn. */
static void make_directions(void) {
    static const struct {
        double theta, offset;
        int count;
    } rings[] = {{0, 0, 1},   {11, 15, 6},     {23.5, 0, 12}, {30, 15, 12},    {37.5, 0, 12},
                 {45, 0, 18}, {52.5, 7.5, 18}, {60, 0, 24},   {67.5, 7.5, 24}, {75, 0, 24}};
    int n = 0;
    for (size_t r = 0; r < sizeof rings / sizeof rings[0]; r++) {
        for (int i = 0; i < rings[r].count; i++, n++) {
            directions[n][0] = rings[r].theta;
            directions[n][1] = rings[r].offset + 360.0 * i / rings[r].count;
        }
    }
}

/* A value of -0.5 .. 0.5 for each texel of each component. */
static double rough(int x, int y, int channel, unsigned k) {
    uint32_t h =
        (uint32_t)x * 2654435761u ^ (uint32_t)y * 2246822519u ^ (k * 3 + (uint32_t)channel) * 3266489917u;
    h = (h ^ h >> 15) * 2246822519u;
    return (double)((h ^ h >> 13) >> 8) * 0x1p-24 - 0.5;
}

/* A rough surface: log luminance falls with the angles, components are waves over directions, and waves and noise over
 * texels. Without the noise a few components would code it to 55 dB, and an encode would end after them. */
static double of_direction(int view, int light, int channel, unsigned k) {
    const double *v = directions[view], *l = directions[light];
    if (k == 0) {
        return channel == 0 ? log(0.05 + 0.6 * cos(l[0] * M_PI / 180)) : 0.05 * channel;
    }
    return cos(0.013 * k * (v[0] + 0.3 * l[0]) + 0.01 * k * (v[1] - l[1]) + channel) / (1.0 + k);
}
static double of_texel(int x, int y, int channel, int view, unsigned k) {
    (void)view;
    return k == 0 ? 1.0
                  : 0.2 * sin(2 * M_PI * ((k % 6) * x + (k / 6 + 1) * y) / SIDE + k + channel) +
                        rough(x, y, channel, k);
}

static void log_line(void *user, btf_log_level level, const char *text) {
    (void)user;
    (void)level;
    fprintf(stderr, "%s\n", text);
}

/* Largest difference at places drawn at random, from the factors in double precision; 6e-3 is what halfs
 * leave. */
static double largest_difference(const enc_context *context, const enc_data *data, float *buffer) {
    double largest = 0;
    for (unsigned i = 0; i < 200; i++) {
        const unsigned r = i * 2654435761u;
        const size_t texel = r % (SIDE * SIDE);
        const int v = (int)(r >> 7) % DIRECTIONS, l = (int)(r >> 15) % DIRECTIONS;
        const float *samples;
        if (enc_data_texels(context, data, texel, 1, buffer, &samples) != BTF_OK) {
            return INFINITY;
        }
        double c[3] = {0};
        for (int channel = 0; channel < 3; channel++) {
            for (unsigned k = 0; k < K; k++) {
                c[channel] += of_direction(v, l, channel, k) *
                              of_texel((int)texel % SIDE, (int)texel / SIDE, channel, 0, k);
            }
        }
        const double y = exp(c[0]) - 1e-5, red = y + 1.13983 * c[2] * (y + 1e-5);
        largest =
            fmax(largest, fabs(fmax(red, 0) - (double)samples[(size_t)v * 3 * DIRECTIONS + (size_t)l]));
    }
    return largest;
}

int main(int argc, char **argv) {
    char name[] = "/var/tmp/btf-large-XXXXXX";
    const char *path = argc > 1 ? argv[1] : name;
    const enc_context context = {.log = {log_line, NULL}, .threads = 2, .memory = (size_t)1 << 30};
    const enc_read_options options = {0};
    enc_data *data = NULL;
    make_directions();
    const int fd = argc > 1 ? -1 : mkstemp(name);
    if (argc < 2 && (fd < 0 || close(fd) != 0)) {
        return perror(name), 1;
    }
    bonn_spec spec = bonn_half_dfmf(SIDE, DIRECTIONS, (const double(*)[2])directions, K);
    spec.direction = of_direction;
    spec.texel = of_texel;
    double begin = progress_clock();
    if (!bonn_write(path, &spec)) {
        return perror(path), 1;
    }
    printf("written in %.1f s\n", progress_clock() - begin);
    begin = progress_clock();
    btf_result result = enc_read(&context, path, &options, &data);
    printf("opened in %.2f s\n", progress_clock() - begin);
    const size_t stride = (size_t)3 * DIRECTIONS * DIRECTIONS;
    float *buffer = malloc(TILE * stride * sizeof *buffer);
    if (result != BTF_OK || !buffer) {
        return 1;
    }
    const double core = progress_core_clock();
    for (size_t row = 0; row < TILE && result == BTF_OK; row++) {
        const float *samples;
        result = enc_data_texels(&context, data, row * SIDE, TILE, buffer, &samples);
    }
    const double seconds = progress_core_clock() - core;
    printf("a tile of %dx%d texels: %.2f core s, %.1f million samples a core second\n", TILE, TILE, seconds,
           TILE * TILE * (double)stride / seconds * 1e-6);
    const double difference = largest_difference(&context, data, buffer);
    printf("largest difference of 200 samples: %.2g\n", difference);
    free(buffer);
    enc_data_destroy(&data);
    if (argc < 2) {
        remove(path);
    }
    return result == BTF_OK && difference < 6e-3 ? 0 : 1;
}
