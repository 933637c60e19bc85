/* The command-line options that say how a data set is read, shared by the tools that read one.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_INPUT_OPTIONS_H
#define OPENBTF_ENCODER_INPUT_OPTIONS_H

#include "decoder/toolkit/cli.h"
#include "reader.h"

/* Entries of a cli_option table, which fill `r`, an enc_read_options. */
#define ENC_INPUT_OPTIONS(r)                                                                               \
    {.name = "transfer",                                                                                   \
     .arg = "CURVE",                                                                                       \
     .type = CLI_CUSTOM,                                                                                   \
     .value = &(r),                                                                                        \
     .parse = enc_parse_transfer,                                                                          \
     .help = "how values are coded: srgb, linear or gamma:G; default what a\n"                             \
             "PNG says (cICP, sRGB, gAMA), else srgb for 8 and 16 bit images,\n"                           \
             "linear for HDR and EXR"},                                                                    \
        {.name = "colour",                                                                                 \
         .arg = "SPACE",                                                                                   \
         .type = CLI_CUSTOM,                                                                               \
         .value = &(r),                                                                                    \
         .parse = enc_parse_colour,                                                                        \
         .help = "rgb (linear Rec. 709) or xyz (CIE XYZ D65, as in UTIA's EXR);\n"                         \
                 "default the primaries that a file names, else rgb"},                                     \
        {.name = "layer",                                                                                  \
         .arg = "NAME",                                                                                    \
         .type = CLI_STRING,                                                                               \
         .value = &(r).layer,                                                                              \
         .help = "of OpenEXR files: the layer, part, PART.LAYER or channel to\n"                           \
                 "read, or spectral; default the first part's R, G, B, or the\n"                           \
                 "only ones"},                                                                             \
        {.name = "size",                                                                                   \
         .type = CLI_SIZE,                                                                                 \
         .value = (r).size,                                                                                \
         .minimum = 1,                                                                                     \
         .maximum = 16384,                                                                                 \
         .help = "resize every image (area filter in linear light)"},                                      \
        {.name = "crop",                                                                                   \
         .arg = "X,Y,W,H",                                                                                 \
         .type = CLI_CUSTOM,                                                                               \
         .value = &(r),                                                                                    \
         .parse = enc_parse_crop,                                                                          \
         .help = "use a part of every image, pixels from the top left, or WxH\n"                           \
                 "there; before --size"},                                                                  \
        {.name = "flip-v",                                                                                 \
         .type = CLI_FLAG,                                                                                 \
         .value = &(r).flip_v,                                                                             \
         .help = "image row 0 is the bottom (-v)"},                                                        \
        {.name = "names",                                                                                  \
         .arg = "TABLE",                                                                                   \
         .type = CLI_STRING,                                                                               \
         .value = &(r).names,                                                                              \
         .help = "directions of images whose names do not tell them: lines of\n"                           \
                 "file, theta_v, phi_v, theta_l, phi_l, in degrees"},                                      \
        {.name = "azimuth-cw",                                                                             \
         .type = CLI_FLAG,                                                                                 \
         .value = &(r).azimuth_cw,                                                                         \
         .help = "azimuths in the names grow clockwise"},                                                  \
        {.name = "azimuth-offset",                                                                         \
         .arg = "DEG",                                                                                     \
         .type = CLI_DOUBLE,                                                                               \
         .value = &(r).azimuth_offset,                                                                     \
         .minimum = -360,                                                                                  \
         .maximum = 360,                                                                                   \
         .help = "degrees added to every azimuth; default 0"},                                             \
        {.name = "cosine",                                                                                 \
         .arg = "WHAT",                                                                                    \
         .type = CLI_CUSTOM,                                                                               \
         .value = &(r),                                                                                    \
         .parse = enc_parse_cosine,                                                                        \
         .help = "whether values hold the cosine of the light's angle: included\n"                         \
                 "or missing; default what the file says, else included"},                                 \
        {.name = "components",                                                                             \
         .type = CLI_INT,                                                                                  \
         .value = &(r).components,                                                                         \
         .minimum = 1,                                                                                     \
         .maximum = 65536,                                                                                 \
         .help = "of a Bonn .btf file: use so many of its factors at most; default all"},                  \
        {.name = "coincident",                                                                             \
         .arg = "TABLE",                                                                                   \
         .type = CLI_STRING,                                                                               \
         .value = &(r).coincident,                                                                         \
         .help = "where lights stood that could not stand at the camera: lines of\n"                       \
                 "theta, phi, and theta, phi of the light, in degrees (as UTIA's)"},                       \
    {                                                                                                      \
        .name = "strict", .type = CLI_FLAG, .value = &(r).strict,                                          \
        .help = "refuse negative values instead of clamping them to 0"                                     \
    }

/* Parsers of the options above: see cli_option.parse. */
const char *enc_parse_transfer(const char *text, void *options);
const char *enc_parse_colour(const char *text, void *options);
const char *enc_parse_cosine(const char *text, void *options);
const char *enc_parse_crop(const char *text, void *options);

#endif
