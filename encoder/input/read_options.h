/* How images and the names of their directions are to be understood.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_READ_OPTIONS_H
#define OPENBTF_ENCODER_READ_OPTIONS_H

#include "colour.h"
#include <stdbool.h>

typedef enum enc_colour {
    ENC_COLOUR_AUTO = 0, /* in the primaries that the file names, else linear Rec. 709 */
    ENC_COLOUR_RGB,      /* linear Rec. 709, whatever the file says */
    ENC_COLOUR_XYZ,     /* CIE XYZ, white point D65 (UTIA's EXR) */
} enc_colour;

/* Whether samples hold the cosine of the angle between light and normal. */
typedef enum enc_cosine {
    ENC_COSINE_AUTO = 0, /* as the file says; images do */
    ENC_COSINE_INCLUDED,
    ENC_COSINE_MISSING, /* samples are multiplied by it */
} enc_cosine;

/* How to read images and their names. Zero means default. The steps follow in this order: transfer, colour, crop,
 * flip_v, size, clamping of negative values. */
typedef struct enc_read_options {
    enc_transfer transfer;
    double gamma; /* of ENC_TRANSFER_GAMMA, > 0 */
    enc_colour colour;
    int size[2];           /* width, height: area filter in linear light; 0, 0: as read */
    int crop[4];           /* x, y, width, height in the file's pixels, y from the top; all 0: everything */
    bool flip_v;           /* row 0 of the files is the bottom (-v) */
    bool azimuth_cw;       /* azimuths of the names grow clockwise: phi becomes -phi */
    double azimuth_offset; /* degrees, added after that to every azimuth but those of theta 0 */
    enc_cosine cosine;
    int components;         /* of each factorisation of a Bonn file at most; 0: all */
    const char *layer;      /* of OpenEXR files: the layer, part or channel to read; NULL: the default one
                               (exr_choose.h) */
    const char *coincident; /* table of lights that stood elsewhere (light_positions.h); NULL: none */
    const char *names;      /* table of the images' directions (names_table.h); NULL: names say them */
    bool names_of_some;     /* a data set none of whose images the table names is read by its names */
    bool strict;            /* refuse negative values instead of clamping them to 0 and counting them */
} enc_read_options;

#endif
