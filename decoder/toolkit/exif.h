/* Reads two statements of EXIF: whether the picture is stored turned, and whether its colour space is not sRGB. Of XMP
 * it reads the first of these.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TOOLS_EXIF_H
#define OPENBTF_TOOLS_EXIF_H

#include <stdbool.h>
#include <stddef.h>

/* The orientation, 1..8, that an EXIF block (JPEG's APP1, PNG's eXIf), with or without "Exif\0\0" before it,
 * gives for the main image; 1, as stored, when there is none or the block is damaged. */
int exif_orientation(const unsigned char *data, size_t size);

/* Whether an EXIF block says that the colour space is something but sRGB ("uncalibrated", by which cameras mean Adobe
 * RGB); false when it says nothing. */
bool exif_colour_is_other(const unsigned char *data, size_t size);

/* The orientation, 1..8, that a text of XMP gives as tiff:Orientation; 1 when there is none. */
int xmp_orientation(const unsigned char *data, size_t size);

#endif
