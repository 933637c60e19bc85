/* Writes Bonn's binary .btf files of every kind and form for the readers' tests, from numbers that functions give.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TESTS_BONN_FILES_H
#define OPENBTF_TESTS_BONN_FILES_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

typedef enum bonn_form { BONN_DFMF, BONN_FMF, BONN_PVF, BONN_PVF_LEGACY, BONN_BDI } bonn_form;

/* The Bonn file to write. Directions in degrees. */
typedef struct bonn_spec {
    bonn_form form;
    const char *signature;
    int meta_version; /* 1 to 4 */
    bool cosine;
    int channels; /* 0: 3 */
    int width, height, n_views, n_lights;
    const double (*views)[2], (*lights)[2];
    unsigned rotations;

    int32_t model; /* DFMF */
    float mean[3], matrix[9];
    unsigned scalar[3]; /* of each channel (DFMF), else of all: [0] */
    unsigned components[3];
    bool swapped; /* the left side is that of the texels */

    unsigned header_version, logarithm, height_rows, height_columns; /* FMF12 */

    unsigned compression, lines_per_chunk; /* BDI */
    const unsigned char *mask;             /* [height][width] or NULL: all there */

    /* The factor of (direction, channel, component): view < 0 where it is not told apart (never in DFMF,
     * FMF, PVF). */
    double (*direction)(int view, int light, int channel, unsigned component);
    double (*texel)(int x, int y, int channel, int view, unsigned component);
    double (*average)(int view, int light, int channel, int x,
                      int y); /* PVF: of light, or of (x, y) when swapped */
    double (*sample)(int view, int light, int channel, int x, int y); /* BDI */
} bonn_spec;

/* A DFMF file of halves in Bonn's logarithmic YUV (model 11), cosine included: side x side texels, the same
 * n directions for views and lights, k components a channel. Without its factors. */
bonn_spec bonn_half_dfmf(int side, int n, const double (*directions)[2], unsigned k);

/* Writes the file; returns false on failure. Where a kind has the same factor for all channels (or views), the function
 * is called with channel (or view) 0. */
bool bonn_write(const char *path, const bonn_spec *spec);

/* 16-bit code of a number, rounded to nearest even. */
uint16_t bonn_half(double value);

#endif
