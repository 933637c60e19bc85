/* A file or a folder for one test, in $TMPDIR or /tmp: set-up and tear-down of cmocka.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TESTS_TEMPORARY_H
#define OPENBTF_TESTS_TEMPORARY_H

enum { TEMPORARY_PATH = 256 };
extern char temporary_file[TEMPORARY_PATH], temporary_folder[TEMPORARY_PATH];

/* Makes an empty file. */
int make_temporary_file(void **state);
int remove_temporary_file(void **state);

/* Makes an empty folder; removes it with all that is in it, if the test has left it there. */
int make_temporary_folder(void **state);
int remove_temporary_folder(void **state);

#endif
