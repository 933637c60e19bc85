/* Prints the lines of stability tests from which table.py makes tests/stability/README.md.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TESTS_STABILITY_CASES_H
#define OPENBTF_TESTS_STABILITY_CASES_H

#include <stdbool.h>

/* The subject of the program, one sentence: the heading's text in the table. */
void cases_title(const char *title);

/* One case: the input, the expected outcome (both the same in every run; the input is unique within the program),
 * whether it came, and in printf style what was seen. None of them may hold a '|'. */
void cases_add(const char *input, const char *expected, bool passed, const char *seen_format, ...)
    __attribute__((format(printf, 4, 5)));

/* A case that this machine cannot run, with the reason. */
void cases_skip(const char *input, const char *expected, const char *reason);

/* For main: 0 when no case failed and one passed, 77 when all were skipped, else 1. */
int cases_result(void);

#endif
