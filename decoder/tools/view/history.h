/* Pictures of a stochastic decode, accumulated: the mean of all since the last change.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_VIEW_HISTORY_H
#define OPENBTF_VIEW_HISTORY_H

#include "decoder/tools/context/gl_api.h"

/* Samples of a pixel after which a picture that stands still is not drawn again. */
enum { HISTORY_MOST = 4096 };

typedef struct history history;

/* In the current GL context. NULL on failure, told on log. */
history *history_create(const gl_api *gl, const btf_log *log);
void history_destroy(history **h);

/* Forgets all pictures. */
void history_clear(history *h);
/* Samples of a pixel that the mean is of. */
int history_samples(const history *h);

/* Binds a cleared framebuffer of width x height pixels for the next picture; the mean of those before lies
 * in the texture of `unit`. The picture's fragments take the share 1 / (samples + 1) of what they draw
 * (linear radiance, alpha 1) and leave the rest to the mean. After a picture of another size there are none
 * before. Errors: BTF_ERROR_UNSUPPORTED (no framebuffer of floats, told on log). */
btf_result history_begin(history *h, int width, int height, int unit, const btf_log *log);
/* Binds the window's framebuffer again and draws the mean there, times `exposure`, sRGB-coded. */
void history_end(history *h, int unit, float exposure);

#endif
