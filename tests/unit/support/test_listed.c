/* A program that runs no test fails: one whose filter names none, and one that has none.
 *
 * SPDX-License-Identifier: MIT
 */
#include "tests/support/test.h"

static int first_runs, last_runs;

TEST(first) {
    first_runs++;
}

TEST(last) {
    last_runs++;
}

/* Whether a run under the filter (NULL: none) ends with `failed`, and the tests have run `first` and `last` times so
 * far. */
static bool ends(const char *filter, int failed, int first, int last) {
    cmocka_set_test_filter(filter);
    const int seen = run_listed("tests", NULL, NULL);
    const bool right = seen == failed && first_runs == first && last_runs == last;
    if (!right) {
        printf("filter %s: %d failed, the first test ran %d times and the last %d times\n",
               filter ? filter : "none", seen, first_runs, last_runs);
    }
    return right;
}

int main(void) {
    bool right = ends(NULL, 0, 1, 1);
    right &= ends("la*", 0, 1, 2);
    right &= ends("another", 1, 1, 2);
    listed_tests.count = 0;
    right &= ends(NULL, 1, 1, 2);
    return right ? 0 : 1;
}
