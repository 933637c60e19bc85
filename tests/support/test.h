/* Unit tests that list themselves, on top of cmocka. A file of tests:
 *
 *     TEST(test_a_thing) {
 *         assert_int_equal(1 + 1, 2);
 *     }
 *     RUN_TESTS(NULL, NULL)
 *
 * RUN_TESTS makes the main program: it runs the tests in the order of the file, after the first function and before the
 * second (int name(void **state), 0: it worked). A test cannot be forgotten there, for there is no other list of them;
 * that each file with a test runs its list is a rule of tests/house.py, and a program that ran no test fails, whether it
 * has none or a filter names none. The headers of C that nearly every test needs are included here.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TESTS_TEST_H
#define OPENBTF_TESTS_TEST_H

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h> /* which needs setjmp.h to stdint.h before it */

typedef struct test_list {
    struct CMUnitTest tests[48];
    int lines[48];
    size_t count;
} test_list;
static test_list listed_tests, listed_numbers;
static size_t tests_begun;

/* Constructors run in no particular order: the lines sort the tests. */
static inline void test_add(test_list *list, int line, struct CMUnitTest test) {
    size_t at = list->count++;
    if (at == sizeof list->lines / sizeof *list->lines) {
        fputs("tests/support/test.h: more tests in a file than the list holds\n", stderr);
        abort();
    }
    for (; at > 0 && list->lines[at - 1] > line; at--) {
        list->tests[at] = list->tests[at - 1];
        list->lines[at] = list->lines[at - 1];
    }
    list->tests[at] = test;
    list->lines[at] = line;
}

#define TEST_IN(list, name, set_up, tear_down)                                                             \
    static void name(void **);                                                                             \
    static void name##_counted(void **state) {                                                             \
        tests_begun++;                                                                                     \
        name(state);                                                                                       \
    }                                                                                                      \
    __attribute__((constructor)) static void name##_is_listed(void) {                                      \
        test_add(&list, __LINE__, (struct CMUnitTest){#name, name##_counted, set_up, tear_down, NULL});    \
    }                                                                                                      \
    static void name(__attribute__((unused)) void **no_state)

#define TEST(name) TEST_IN(listed_tests, name, NULL, NULL)
/* With functions that run before and after this test. */
#define TEST_WITH(name, set_up, tear_down) TEST_IN(listed_tests, name, set_up, tear_down)
/* A test that compares numbers of functions which other tests call too; light runs leave it out. */
#define TEST_OF_NUMBERS(name) TEST_IN(listed_numbers, name, NULL, NULL)

/* Whether tests are to repeat less, as under the sanitizers (tests/meson.build). */
static inline bool light_run(void) {
    return getenv("BTF_TEST_LIGHT") != NULL;
}

/* Runs the tests of the file; gives the number of those that fail, at least 1 where none was run. */
static inline int run_listed(const char *name, CMFixtureFunction set_up, CMFixtureFunction tear_down) {
    tests_begun = 0;
    int failed = _cmocka_run_group_tests(name, listed_tests.tests, listed_tests.count, set_up, tear_down);
    if (listed_numbers.count && !light_run()) {
        failed +=
            _cmocka_run_group_tests("numbers", listed_numbers.tests, listed_numbers.count, NULL, NULL);
    }
    if (tests_begun == 0 && failed == 0) {
        fputs("tests/support/test.h: no test was run: the file has none, or the filter names none\n",
              stderr);
        failed = 1;
    }
    return failed;
}

#define RUN_TESTS(set_up, tear_down)                                                                       \
    int main(void) {                                                                                       \
        return run_listed("tests", set_up, tear_down);                                                     \
    }

#endif
