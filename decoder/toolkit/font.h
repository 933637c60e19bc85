/* A small bitmap font: 5 x 7 pixels, and one row below the base line, in cells of 6 x 9; ASCII 32..126.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TOOLKIT_FONT_H
#define OPENBTF_TOOLKIT_FONT_H

#include <stdbool.h>

enum { FONT_WIDTH = 6, FONT_HEIGHT = 9 };

/* Whether pixel (x, y) of a character's cell is set, y downwards; characters beyond the font are boxes. */
bool font_pixel(char c, int x, int y);

#endif
