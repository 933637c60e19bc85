/* Shader text that is broken on purpose.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_CONFORMANCE_TAMPER_H
#define OPENBTF_CONFORMANCE_TAMPER_H

#include <stddef.h>
#include <stdint.h>

/* A copy of the text in which the first `most` places of `from` at byte `start` or behind it hold `to`; the caller frees
 * it. NULL where there is no such place, or memory is short. */
char *tamper_text(const char *text, size_t start, size_t most, const char *from, const char *to);

/* Whether a change went unnoticed, 1 or 0, and on stderr why: its words were not `found`, or nothing was `different`. */
int tamper_missed(const char *name, int found, uint64_t different);

#endif
