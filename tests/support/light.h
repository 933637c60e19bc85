/* Runs of unit tests under the sanitizers: tests that compare numbers of what the others call too are left out there.
 * Include it after cmocka.h.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TESTS_LIGHT_H
#define OPENBTF_TESTS_LIGHT_H

#include <stdbool.h>
#include <stdlib.h>

/* Whether what only repeats is repeated less (tests/meson.build). */
static inline bool light_run(void) {
    return getenv("BTF_TEST_LIGHT") != NULL;
}

/* Runs the tests of an array and, but for light runs, those of a second one; gives the number of those that fail. */
#define RUN_TESTS_AND_NUMBERS(name, tests, numbers)                                                        \
    (cmocka_run_group_tests_name(name, tests, NULL, NULL) +                                                \
     (light_run() ? 0 : cmocka_run_group_tests_name(name ": numbers", numbers, NULL, NULL)))

#endif
