/* The one thing of EXIF that matters here: whether the picture is stored turned.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TOOLS_EXIF_H
#define OPENBTF_TOOLS_EXIF_H

#include <stddef.h>

/* The orientation, 1..8, that an EXIF block (JPEG's APP1 after "Exif\0\0", PNG's eXIf) gives for the main
 * image; 1, as stored, when there is none or the block is damaged. */
int exif_orientation(const unsigned char *data, size_t size);

#endif
