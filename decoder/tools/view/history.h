/* Accumulates pictures of a stochastic decode: shows the mean of all since the last change.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_VIEW_HISTORY_H
#define OPENBTF_VIEW_HISTORY_H

#include "decoder/tools/context/gl_api.h"

/* Once a pixel has so many samples, a picture that stands still is not drawn again. */
enum { HISTORY_MOST = 4096 };

typedef struct history history;

/* Makes a history in the current GL context. Returns NULL on failure, with the reason on log. */
history *history_create(const gl_api *gl, const btf_log *log);
void history_destroy(history **h);

/* Forgets all pictures. */
void history_clear(history *h);
/* The number of samples of a pixel whose mean is shown. */
int history_samples(const history *h);

/* Binds a cleared framebuffer of width x height pixels for the next picture; the mean of the pictures before is the
 * texture of `unit`. A fragment of the picture writes 1 / (samples + 1) of what it draws (linear radiance, alpha 1)
 * plus the rest of that mean. A picture of another size begins a new mean. Errors: BTF_ERROR_UNSUPPORTED (no
 * framebuffer of floats, told on log). */
btf_result history_begin(history *h, int width, int height, int unit, const btf_log *log);
/* Binds the window's framebuffer again and draws the mean there, times `exposure`, sRGB-coded. */
void history_end(history *h, int unit, float exposure);

#endif
