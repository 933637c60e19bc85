/* What the names of a BTF's images say: the light's and the viewer's direction.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_NAMES_H
#define OPENBTF_ENCODER_NAMES_H

#include <stdbool.h>

/* The angles of one image, in degrees as written. */
typedef struct enc_angles {
    double theta_light, phi_light; /* tl, pl */
    double theta_view, phi_view;   /* tv, pv */
} enc_angles;

/* Finds `tl`, `pl`, `tv` and `pv` in a path, each followed by an angle: in any order and case, with spaces,
 * underscores, dashes, equal signs or nothing between key and angle, whole or with a decimal point. A dash
 * right before the digits is a minus sign only if another separator precedes it ("pl_-30"). A key does not
 * count where a letter stands before it. The file's extension is not part of the name. What the file name
 * does not say is taken from the nearest folder that does. Examples: "00008 tl000 pl000 tv030 pv030.jpg",
 * "tv075_pv000/tl07.5-pl60.png". Returns false when one of the four is missing, or when one part of the
 * path gives a key two values. */
bool enc_names_parse(const char *path, enc_angles *out_angles);

/* Whether a path's extension is that of an image format that can be read, and its name does not begin with
 * a dot (as the names of hidden files do). */
bool enc_names_is_image(const char *path);

#endif
