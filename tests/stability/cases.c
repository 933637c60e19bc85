/* Prints the cases of one program, see cases.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "cases.h"

#include <stdarg.h>
#include <stdio.h>

static int n_cases, n_failed, n_skipped;

void cases_title(const char *title) {
    printf("TITLE | %s\n", title);
}

void cases_add(const char *input, const char *expected, bool passed, const char *seen_format, ...) {
    char seen[512];
    va_list arguments;
    va_start(arguments, seen_format);
    vsnprintf(seen, sizeof seen, seen_format, arguments);
    va_end(arguments);
    printf("CASE | %s | %s | %s | %s\n", input, expected, seen, passed ? "pass" : "FAIL");
    fflush(stdout);
    n_cases++;
    n_failed += !passed;
}

void cases_skip(const char *input, const char *expected, const char *reason) {
    printf("CASE | %s | %s | skipped: %s | skip\n", input, expected, reason);
    n_cases++;
    n_skipped++;
}

int cases_result(void) {
    printf("%d cases, %d failed\n", n_cases, n_failed);
    if (n_cases > 0 && n_skipped == n_cases) {
        return 77;
    }
    return n_cases == 0 || n_failed > 0;
}
