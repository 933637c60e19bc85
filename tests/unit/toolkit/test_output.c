/* Files are whole or absent (decoder/toolkit/output.h), and the stages of progress.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "decoder/toolkit/output.h"
#include "decoder/toolkit/progress.h"
#include "tests/support/messages.h"
#include "tests/support/temporary.h"
#include "tests/support/test.h"

#include <dirent.h>
#include <fcntl.h>
#include <signal.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

static char target[300];

static int set_up(void **state) {
    const int result = make_temporary_folder(state);
    snprintf(target, sizeof target, "%s/result.bin", temporary_folder);
    last_message[0] = '\0';
    return result;
}

static int files_in_folder(void) {
    int count = 0;
    DIR *listing = opendir(temporary_folder);
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
    assert_int_equal(output_open(target, log_keep, &file), BTF_OK);
    fputs(text, output_stream(file));
    assert_int_equal(output_commit(&file), BTF_OK);
    assert_null(file);
}

TEST_WITH(test_commit, set_up, remove_temporary_folder) {
    output *file;
    write_file("old");
    assert_int_equal(output_open(target, log_keep, &file), BTF_OK);
    fputs("new", output_stream(file));
    fflush(output_stream(file));
    expect_content(target, "old"); /* until the commit */
    expect_content(output_temporary_path(file), "new");
    assert_int_equal(output_commit(&file), BTF_OK);
    expect_content(target, "new");
    assert_int_equal(files_in_folder(), 1);
}

TEST_WITH(test_abort, set_up, remove_temporary_folder) {
    output *file, *none = NULL;
    write_file("old");
    assert_int_equal(output_open(target, log_keep, &file), BTF_OK);
    fputs("half", output_stream(file));
    output_abort(&file);
    assert_null(file);
    output_abort(&none);
    expect_content(target, "old");
    assert_int_equal(files_in_folder(), 1);
}

TEST_WITH(test_two_writers, set_up, remove_temporary_folder) {
    output *a, *b;
    assert_int_equal(output_open(target, log_keep, &a), BTF_OK);
    assert_int_equal(output_open(target, log_keep, &b),
                     BTF_OK); /* must not remove a's file as a stale one */
    fputs("a", output_stream(a));
    fputs("b", output_stream(b));
    assert_int_equal(output_commit(&a), BTF_OK);
    expect_content(target, "a");
    assert_int_equal(output_commit(&b), BTF_OK);
    expect_content(target, "b");
    assert_int_equal(files_in_folder(), 1);
}

TEST_WITH(test_stale_files, set_up, remove_temporary_folder) {
    char dead[400], live[400], other[400];
    snprintf(dead, sizeof dead, "%s/.result.bin.99-0.tmp", temporary_folder);
    snprintf(live, sizeof live, "%s/.result.bin.99-1.tmp", temporary_folder);
    snprintf(other, sizeof other, "%s/.other.bin.99-0.tmp", temporary_folder);
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

/* Opens an output in a child process that then ends by `end`; returns its status, and counts the files that it left. */
static int end_of_child(void (*end)(void), int *out_files) {
    fflush(NULL);
    const pid_t child = fork();
    if (child == 0) {
        output *file;
        if (output_open(target, log_keep, &file) != BTF_OK) {
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
/* Reads beyond the end of a mapped file, which raises SIGBUS. Sanitizers handle that signal themselves. */
static void end_by_short_input(void) {
    char path[400];
    sigaction(SIGBUS, &bus_action, NULL);
    snprintf(path, sizeof path, "%s/.input", temporary_folder);
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

TEST_WITH(test_ends_of_process, set_up, remove_temporary_folder) {
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
    /* only the next writer can remove what a process killed by SIGKILL left */
    status = end_of_child(end_by_sigkill, &files);
    assert_true(WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL);
    assert_int_equal(files, 1);
    write_file("x");
    assert_int_equal(files_in_folder(), 1);
}

TEST_WITH(test_other_targets, set_up, remove_temporary_folder) {
    output *file;
    assert_int_equal(output_open("/dev/null", log_keep, &file), BTF_OK);
    fputs("x", output_stream(file));
    assert_int_equal(output_commit(&file), BTF_OK);
    struct stat status;
    assert_int_equal(stat("/dev/null", &status), 0);
    assert_true(S_ISCHR(status.st_mode));

    int ends[2]; /* a pipe, whose name in /proc leads to no path */
    char name[40], got[8] = "";
    assert_int_equal(pipe(ends), 0);
    snprintf(name, sizeof name, "/proc/self/fd/%d", ends[1]);
    assert_int_equal(output_open(name, log_keep, &file), BTF_OK);
    fputs("piped", output_stream(file));
    assert_int_equal(output_commit(&file), BTF_OK);
    assert_int_equal(read(ends[0], got, sizeof got), 5);
    assert_string_equal(got, "piped");
    close(ends[0]);
    close(ends[1]);

    assert_int_equal(output_open("/dev/full", log_keep, &file), BTF_OK);
    fputs("x", output_stream(file));
    assert_int_equal(output_commit(&file), BTF_ERROR_IO);
    assert_non_null(strstr(last_message, "/dev/full"));

    assert_int_equal(output_open(temporary_folder, log_keep, &file), BTF_ERROR_IO);
    assert_non_null(strstr(last_message, "is a directory"));
    assert_null(file);
    assert_int_equal(output_open("/nowhere/at/all", log_keep, &file), BTF_ERROR_IO);
    assert_non_null(strstr(last_message, "/nowhere/at/all"));

    /* a link stays one */
    char link_path[400];
    write_file("old");
    snprintf(link_path, sizeof link_path, "%s/link", temporary_folder);
    assert_int_equal(symlink("result.bin", link_path), 0);
    assert_int_equal(output_open(link_path, log_keep, &file), BTF_OK);
    fputs("new", output_stream(file));
    assert_int_equal(output_commit(&file), BTF_OK);
    expect_content(target, "new");
    assert_int_equal(lstat(link_path, &status), 0);
    assert_true(S_ISLNK(status.st_mode));
}

TEST_WITH(test_same, set_up, remove_temporary_folder) {
    char other[400], detour[400];
    snprintf(other, sizeof other, "%s/other", temporary_folder);
    snprintf(detour, sizeof detour, "%s/./%s", temporary_folder, strrchr(target, '/') + 1);
    unlink(target);
    assert_true(output_is_same(target, target)); /* the file does not exist yet */
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
    assert_false(output_is_same("/dev/null", "/dev/null")); /* writing there replaces no file */
    assert_false(output_is_same("/nonexistent/x", "/nonexistent/x"));
}

/* SIGINT is caught while a progress exists; afterwards the action before it is restored. */
TEST(test_signals_given_back) {
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

TEST(test_stages) {
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

/* A log that is no terminal gets few lines; with quiet it gets none. */
TEST_WITH(test_plain_lines, set_up, remove_temporary_folder) {
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
    if (output_open("/dev/null", log_keep, &first) == BTF_OK) {
        output_abort(&first);
    }
    sigaction(SIGBUS, NULL, &bus_action);
    return run_listed("tests", NULL, NULL);
}
