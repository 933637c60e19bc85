/* Runs a fuzz target over the files of folders, in builds without libFuzzer.
 *
 *     fuzz-NAME FOLDER...
 *
 * Prints a line for the table of stability cases (tests/stability/table.py). Exits 1 when there is no file;
 * a target that finds something ends the process.
 *
 * SPDX-License-Identifier: MIT
 */
#include "fuzz.h"

#include <dirent.h>
#include <string.h>

/* Runs the target on a file's bytes in a buffer of exactly their size, so that a sanitizer notices a read beyond it. */
static void run_file(const char *path) {
    FILE *file = fopen(path, "rb");
    FUZZ_CHECK(file && fseek(file, 0, SEEK_END) == 0);
    const long size = ftell(file);
    FUZZ_CHECK(size >= 0 && fseek(file, 0, SEEK_SET) == 0);
    uint8_t *data = malloc(size ? (size_t)size : 1);
    FUZZ_CHECK(data && fread(data, 1, (size_t)size, file) == (size_t)size);
    fclose(file);
    LLVMFuzzerTestOneInput(data, (size_t)size);
    free(data);
}

int main(int argc, char **argv) {
    char current[4096];
    int files = 0;
    for (int i = 1; i < argc; i++) {
        struct dirent **entries = NULL;
        const int count = scandir(argv[i], &entries, NULL, alphasort);
        FUZZ_CHECK(count >= 0);
        for (int e = 0; e < count; e++) {
            if (entries[e]->d_name[0] != '.') {
                snprintf(current, sizeof current, "%s/%s", argv[i], entries[e]->d_name);
                printf("%s\n", current);
                fflush(stdout);
                run_file(current);
                files++;
            }
            free(entries[e]);
        }
        free(entries);
    }
    const char *name = argc > 1 ? strrchr(argv[1], '/') : NULL;
    printf("TITLE | The inputs that are kept for each fuzz target, read again.\n");
    printf("CASE | %s: inputs kept | each ends, and none breaks what holds for all | %d files | %s\n",
           name ? name + 1 : "none", files, files ? "pass" : "FAIL");
    return files == 0;
}
