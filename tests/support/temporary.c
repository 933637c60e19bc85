/* Files and folders of tests. See temporary.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "temporary.h"

#include <ftw.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

char temporary_file[TEMPORARY_PATH], temporary_folder[TEMPORARY_PATH];

static char *name_of(char *path) {
    const char *base = getenv("TMPDIR");
    snprintf(path, TEMPORARY_PATH, "%s/btf-test-XXXXXX", base && *base ? base : "/tmp");
    return path;
}

int make_temporary_file(void **state) {
    (void)state;
    const int file = mkstemp(name_of(temporary_file));
    return file < 0 ? -1 : close(file);
}

int remove_temporary_file(void **state) {
    (void)state;
    return unlink(temporary_file);
}

int make_temporary_folder(void **state) {
    (void)state;
    return mkdtemp(name_of(temporary_folder)) ? 0 : -1;
}

static int remove_entry(const char *path, const struct stat *status, int flag, struct FTW *ftw) {
    (void)status;
    (void)flag;
    (void)ftw;
    return remove(path);
}

int remove_temporary_folder(void **state) {
    (void)state;
    return access(temporary_folder, F_OK) != 0
               ? 0
               : nftw(temporary_folder, remove_entry, 8, FTW_DEPTH | FTW_PHYS);
}
