/* Runs the decoder of a folder in Metal's language on the CPU: its text, compiled by a C++ compiler (metal.py).
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TEST_RUN_METAL_H
#define OPENBTF_TEST_RUN_METAL_H

#include "exported.h"

/* `library` is the path of the shared library. Ends the process with 4, after a message, where it cannot be loaded. */
void run_metal(const exported *e, const char *library, uint32_t *records, size_t count);

#endif
