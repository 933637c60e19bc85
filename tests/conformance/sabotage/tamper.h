/* Changes the text of shaders on purpose, and tells whether a test noticed.
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

/* Begins a test of whether a change is noticed, one at a time: `from` becomes `to` in the first `most` places of a text. The
 * strings must outlive it. */
void tamper_begin(const char *name, const char *from, const char *to, size_t most);

/* The text with the change made at byte `start` or behind it, valid until the next call; the text itself where the words
 * are not there, and where no test was begun. */
const char *tamper_apply(const char *text, size_t start);

/* Ends the test: 1 where the change went unnoticed, with the reason on stderr (no text held its words, or nothing was
 * `different`), else 0. */
int tamper_end(uint64_t different);

#endif
