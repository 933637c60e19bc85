/* Text over the picture.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_VIEW_OVERLAY_H
#define OPENBTF_VIEW_OVERLAY_H

#include "decoder/tools/context/gl_api.h"

typedef struct overlay overlay;

/* Returns NULL on failure, with the reason on log. */
overlay *overlay_create(const gl_api *gl, const btf_log *log);
void overlay_destroy(overlay **o);

/* Draws lines of text on a dark panel whose top left corner is (x, y) pixels from that of the window;
 * width x height is the window's framebuffer, letters are zoom times 5 x 7. Sets program, blending, unit 0.
 */
void overlay_draw(overlay *o, const char *text, int x, int y, int zoom, int width, int height);

/* The size of that panel in pixels. */
void overlay_size(const char *text, int zoom, int *out_width, int *out_height);

#endif
