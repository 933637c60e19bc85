/* RGB spaces by their primaries and white, and from one of them to linear Rec. 709.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_PIXELS_PRIMARIES_H
#define OPENBTF_PIXELS_PRIMARIES_H

#include <stdbool.h>
#include <stddef.h>

/* CIE 1931 x, y of red, green, blue and white. */
typedef struct primaries {
    double red[2], green[2], blue[2], white[2];
} primaries;

/* Rec. 709's, which are sRGB's and what OpenEXR assumes: white D65 = (0.3127, 0.3290). */
extern const primaries primaries_rec709;

/* Whether each coordinate is within 0.002 of Rec. 709's: of what files round, nothing else is as near. */
bool primaries_are_rec709(const primaries *p);

/* The row-major matrix from RGB to XYZ, where white has Y = 1. False when the primaries span no space. */
bool primaries_to_xyz(const primaries *p, double out[9]);

/* The row-major matrix from linear RGB of these primaries to linear Rec. 709, white to white: where the
 * whites differ, XYZ is adapted by Bradford's method. False when the primaries span no space. */
bool primaries_to_rec709(const primaries *p, float out[9]);

/* Multiplies `count` pixels of three by a row-major matrix, in place. */
void primaries_apply(const float matrix[9], size_t count, float *pixels);

/* "red (0.713,0.293), green ..., blue ..., white ...". */
void primaries_text(const primaries *p, char *out, size_t size);

#endif
