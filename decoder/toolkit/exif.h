/* The two things of EXIF that matter here: whether the picture is stored turned, and another colour space.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TOOLS_EXIF_H
#define OPENBTF_TOOLS_EXIF_H

#include <stdbool.h>
#include <stddef.h>

/* The orientation, 1..8, that an EXIF block (JPEG's APP1 after "Exif\0\0", PNG's eXIf) gives for the main
 * image; 1, as stored, when there is none or the block is damaged. */
int exif_orientation(const unsigned char *data, size_t size);

/* Whether it says that the colour space is something but sRGB ("uncalibrated", which is Adobe RGB by what
 * cameras do); false when it says nothing. */
bool exif_colour_is_other(const unsigned char *data, size_t size);

#endif
