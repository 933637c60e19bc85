/* Files are whole or absent (decoder/toolkit/output.h), and the stages of progress.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "decoder/toolkit/output.h"
#include "decoder/toolkit/progress.h"

#include <dirent.h>
#include <fcntl.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

static char folder[256], target[300], last_message[1024];

static void keep_message(void *user, btf_log_level level, const char *text) {
    (void)user;
    (void)level;
    snprintf(last_message, sizeof last_message, "%s", text);
}
static const btf_log log_to_test = {keep_message, NULL};

static int make_folder(void **state) {
    (void)state;
    const char *base = getenv("TMPDIR");
    snprintf(folder, sizeof folder, "%s/btf-output-XXXXXX", base && *base ? base : "/tmp");
    if (!mkdtemp(folder)) {
        return -1;
    }
    snprintf(target, sizeof target, "%s/result.bin", folder);
    last_message[0] = '\0';
    return 0;
}

static int remove_folder(void **state) {
    (void)state;
    DIR *listing = opendir(folder);
    for (struct dirent *e; listing && (e = readdir(listing));) {
        unlinkat(dirfd(listing), e->d_name, 0);
    }
    closedir(listing);
    return rmdir(folder);
}

static int files_in_folder(void) {
    int count = 0;
    DIR *listing = opendir(folder);
    assert_non_null(listing);
    for (struct dirent *e; (e = readdir(listing));) {
        count += strcmp(e->d_name, ".") != 0 && strcmp(e->d_name, "..") != 0;
    }
    closedir(listing);
    return count;
}

static void expect_content(const char *path, const char *expected) {
    char text[64] = "";
    FILE *f = fopen(path, "rb");
    assert_non_null(f);
    text[fread(text, 1, sizeof text - 1, f)] = '\0';
    fclose(f);
    assert_string_equal(text, expected);
}

static void write_file(const char *text) {
    output *file;
    assert_int_equal(output_open(target, log_to_test, &file), BTF_OK);
    fputs(text, output_stream(file));
    assert_int_equal(output_commit(&file), BTF_OK);
    assert_null(file);
}

static void test_commit(void **state) {
    (void)state;
    output *file;
    write_file("old");
    assert_int_equal(output_open(target, log_to_test, &file), BTF_OK);
    fputs("new", output_stream(file));
    fflush(output_stream(file));
    expect_content(target, "old"); /* until the commit */
    expect_content(output_temporary_path(file), "new");
    assert_int_equal(output_commit(&file), BTF_OK);
    expect_content(target, "new");
    assert_int_equal(files_in_folder(), 1);
}

static void test_abort(void **state) {
    (void)state;
    output *file, *none = NULL;
    write_file("old");
    assert_int_equal(output_open(target, log_to_test, &file), BTF_OK);
    fputs("half", output_stream(file));
    output_abort(&file);
    assert_null(file);
    output_abort(&none);
    expect_content(target, "old");
    assert_int_equal(files_in_folder(), 1);
}

static void test_two_writers(void **state) {
    (void)state;
    output *a, *b;
    assert_int_equal(output_open(target, log_to_test, &a), BTF_OK);
    assert_int_equal(output_open(target, log_to_test, &b),
                     BTF_OK); /* must not take a's file for a stale one */
    fputs("a", output_stream(a));
    fputs("b", output_stream(b));
    assert_int_equal(output_commit(&a), BTF_OK);
    expect_content(target, "a");
    assert_int_equal(output_commit(&b), BTF_OK);
    expect_content(target, "b");
    assert_int_equal(files_in_folder(), 1);
}

static void test_stale_files(void **state) {
    (void)state;
    char dead[400], live[400], other[400];
    snprintf(dead, sizeof dead, "%s/.result.bin.99-0.tmp", folder);
    snprintf(live, sizeof live, "%s/.result.bin.99-1.tmp", folder);
    snprintf(other, sizeof other, "%s/.other.bin.99-0.tmp", folder);
    fclose(fopen(dead, "w"));
    fclose(fopen(other, "w"));
    const int fd = open(live, O_RDWR | O_CREAT, 0666);
    assert_int_equal(flock(fd, LOCK_EX), 0);
    write_file("x");
    assert_int_not_equal(access(dead, F_OK), 0);
    assert_int_equal(access(live, F_OK), 0);
    assert_int_equal(access(other, F_OK), 0);
    close(fd);
    write_file("y");
    assert_int_not_equal(access(live, F_OK), 0);
}

/* Opens a file in a child that then ends in some way, and looks for what it left behind. */
static int end_of_child(void (*end)(void), int *out_files) {
    fflush(NULL);
    const pid_t child = fork();
    if (child == 0) {
        output *file;
        if (output_open(target, log_to_test, &file) != BTF_OK) {
            _exit(99);
        }
        fputs("half", output_stream(file));
        fflush(output_stream(file));
        end();
        _exit(98);
    }
    int status;
    assert_int_equal(waitpid(child, &status, 0), child);
    *out_files = files_in_folder();
    return status;
}

static void end_by_exit(void) {
    exit(3);
}
static void end_by_sigterm(void) {
    raise(SIGTERM);
}
static void end_by_sigint_twice(void) {
    progress *p = progress_create(true);
    raise(SIGINT);
    if (!p || !progress_cancelled()) {
        _exit(97);
    }
    raise(SIGINT);
}
static void end_by_sigkill(void) {
    raise(SIGKILL);
}

/* The action of SIGBUS outside of cmocka, which has handlers of its own while a test runs. */
static struct sigaction bus_action;

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
/* Reads behind the end of a mapped file. A sanitizer handles that itself. */
static void end_by_short_input(void) {
    char path[400];
    sigaction(SIGBUS, &bus_action, NULL);
    snprintf(path, sizeof path, "%s/.input", folder);
    const int fd = open(path, O_RDWR | O_CREAT, 0666);
    unlink(path);
    if (ftruncate(fd, 4096) != 0) {
        _exit(96);
    }
    const volatile char *bytes = mmap(NULL, 4096, PROT_READ, MAP_SHARED, fd, 0);
    if (bytes == MAP_FAILED || ftruncate(fd, 0) != 0) {
        _exit(95);
    }
    _exit(90 + bytes[0]);
}
#endif

static void test_ends_of_process(void **state) {
    (void)state;
    int files;
    int status = end_of_child(end_by_exit, &files);
    assert_true(WIFEXITED(status) && WEXITSTATUS(status) == 3);
    assert_int_equal(files, 0);
    status = end_of_child(end_by_sigterm, &files);
    assert_true(WIFSIGNALED(status) && WTERMSIG(status) == SIGTERM);
    assert_int_equal(files, 0);
    status = end_of_child(end_by_sigint_twice, &files);
    assert_true(WIFSIGNALED(status) && WTERMSIG(status) == SIGINT);
    assert_int_equal(files, 0);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
    status = end_of_child(end_by_short_input, &files);
    assert_true(WIFEXITED(status) && WEXITSTATUS(status) == 2);
    assert_int_equal(files, 0);
#endif
    /* nothing helps against this one but the next writer */
    status = end_of_child(end_by_sigkill, &files);
    assert_true(WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL);
    assert_int_equal(files, 1);
    write_file("x");
    assert_int_equal(files_in_folder(), 1);
}

static void test_other_targets(void **state) {
    (void)state;
    output *file;
    assert_int_equal(output_open("/dev/null", log_to_test, &file), BTF_OK);
    fputs("x", output_stream(file));
    assert_int_equal(output_commit(&file), BTF_OK);
    struct stat status;
    assert_int_equal(stat("/dev/null", &status), 0);
    assert_true(S_ISCHR(status.st_mode));

    int ends[2]; /* a pipe by its name, which leads to no path */
    char name[40], got[8] = "";
    assert_int_equal(pipe(ends), 0);
    snprintf(name, sizeof name, "/proc/self/fd/%d", ends[1]);
    assert_int_equal(output_open(name, log_to_test, &file), BTF_OK);
    fputs("piped", output_stream(file));
    assert_int_equal(output_commit(&file), BTF_OK);
    assert_int_equal(read(ends[0], got, sizeof got), 5);
    assert_string_equal(got, "piped");
    close(ends[0]);
    close(ends[1]);

    assert_int_equal(output_open("/dev/full", log_to_test, &file), BTF_OK);
    fputs("x", output_stream(file));
    assert_int_equal(output_commit(&file), BTF_ERROR_IO);
    assert_non_null(strstr(last_message, "/dev/full"));

    assert_int_equal(output_open(folder, log_to_test, &file), BTF_ERROR_IO);
    assert_non_null(strstr(last_message, "is a directory"));
    assert_null(file);
    assert_int_equal(output_open("/nowhere/at/all", log_to_test, &file), BTF_ERROR_IO);
    assert_non_null(strstr(last_message, "/nowhere/at/all"));

    /* a link stays one */
    char link_path[400];
    write_file("old");
    snprintf(link_path, sizeof link_path, "%s/link", folder);
    assert_int_equal(symlink("result.bin", link_path), 0);
    assert_int_equal(output_open(link_path, log_to_test, &file), BTF_OK);
    fputs("new", output_stream(file));
    assert_int_equal(output_commit(&file), BTF_OK);
    expect_content(target, "new");
    assert_int_equal(lstat(link_path, &status), 0);
    assert_true(S_ISLNK(status.st_mode));
}

static void test_same(void **state) {
    (void)state;
    char other[400], detour[400];
    snprintf(other, sizeof other, "%s/other", folder);
    snprintf(detour, sizeof detour, "%s/./%s", folder, strrchr(target, '/') + 1);
    unlink(target);
    assert_true(output_is_same(target, target)); /* none of them is there yet */
    assert_true(output_is_same(target, detour));
    assert_false(output_is_same(target, other));
    FILE *f = fopen(target, "w");
    assert_non_null(f);
    fclose(f);
    assert_true(output_is_same(target, detour));
    assert_false(output_is_same(target, other));
    assert_false(output_is_same(other, target));
    assert_int_equal(link(target, other), 0);
    assert_true(output_is_same(target, other));
    unlink(other);
    assert_int_equal(symlink(target, other), 0);
    assert_true(output_is_same(other, target));
    unlink(other);
    assert_false(output_is_same("/dev/null", "/dev/null")); /* nothing is replaced there */
    assert_false(output_is_same("/nonexistent/x", "/nonexistent/x"));
}

/* SIGINT is caught while a progress lives, and as before afterwards. */
static void test_signals_given_back(void **state) {
    (void)state;
    struct sigaction before, during, after;
    sigaction(SIGINT, NULL, &before);
    progress *p = progress_create(true);
    assert_non_null(p);
    sigaction(SIGINT, NULL, &during);
    progress_destroy(&p);
    sigaction(SIGINT, NULL, &after);
    assert_true(during.sa_handler != before.sa_handler);
    assert_true(after.sa_handler == before.sa_handler);
}

static void test_stages(void **state) {
    (void)state;
    progress *p = progress_create(true);
    assert_non_null(p);
    progress_begin(p, "read", 1000);
#pragma omp parallel for num_threads(2)
    for (int i = 0; i < 1000; i++) {
        progress_step(p, 1);
    }
    progress_begin(p, "fit", 0); /* ends the stage before */
    usleep(20000);
    progress_end(p);
    progress_end(p);
    progress_begin(p, "read", 1);
    progress_end(p);
    size_t count;
    const progress_stage *stages = progress_stages(p, &count);
    assert_int_equal(count, 2);
    assert_string_equal(stages[0].name, "read");
    assert_string_equal(stages[1].name, "fit");
    assert_true(stages[0].seconds >= 0.0);
    assert_true(stages[1].seconds >= 0.02);
    progress_destroy(&p);
    assert_null(p);
    progress_destroy(&p);
}

/* A log that is no terminal gets few lines, quiet none. */
static void test_plain_lines(void **state) {
    (void)state;
    for (int quiet = 0; quiet < 2; quiet++) {
        fflush(NULL);
        const pid_t child = fork();
        if (child == 0) {
            if (!freopen(target, "w", stderr)) {
                _exit(99);
            }
            progress *p = progress_create(quiet);
            progress_begin(p, "work", 100000);
            for (int i = 0; i < 100000; i++) {
                progress_step(p, 1);
            }
            progress_destroy(&p);
            fflush(stderr);
            _exit(0);
        }
        int status, lines = 0, controls = 0;
        assert_int_equal(waitpid(child, &status, 0), child);
        assert_true(WIFEXITED(status) && WEXITSTATUS(status) == 0);
        FILE *f = fopen(target, "r");
        assert_non_null(f);
        for (int c; (c = getc(f)) != EOF;) {
            lines += c == '\n';
            controls += c == '\r' || c == '\033';
        }
        fclose(f);
        assert_int_equal(controls, 0);
        assert_in_range(lines, quiet ? 0 : 1, quiet ? 0 : 11);
    }
}

int main(void) {
    output *first; /* installs the handlers */
    if (output_open("/dev/null", log_to_test, &first) == BTF_OK) {
        output_abort(&first);
    }
    sigaction(SIGBUS, NULL, &bus_action);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_commit, make_folder, remove_folder),
        cmocka_unit_test_setup_teardown(test_abort, make_folder, remove_folder),
        cmocka_unit_test_setup_teardown(test_two_writers, make_folder, remove_folder),
        cmocka_unit_test_setup_teardown(test_stale_files, make_folder, remove_folder),
        cmocka_unit_test_setup_teardown(test_ends_of_process, make_folder, remove_folder),
        cmocka_unit_test_setup_teardown(test_other_targets, make_folder, remove_folder),
        cmocka_unit_test_setup_teardown(test_same, make_folder, remove_folder),
        cmocka_unit_test(test_signals_given_back),
        cmocka_unit_test(test_stages),
        cmocka_unit_test_setup_teardown(test_plain_lines, make_folder, remove_folder),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
