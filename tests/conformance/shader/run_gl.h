/* Runs the decoder of a folder of btf-shader in a fragment shader of OpenGL or OpenGL ES.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TEST_RUN_GL_H
#define OPENBTF_TEST_RUN_GL_H

#include "exported.h"

/* `name` is one of context_devices; at most 65536 records. Ends the process as a skipped test (77) without the device,
 * and with 4, after a message, where it refuses something. */
void run_gl(const char *name, const exported *e, uint32_t *records, size_t count);

#endif
