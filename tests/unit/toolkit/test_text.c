/* Text files (decoder/toolkit/text.h): byte-order marks, line ends, encodings that are refused.
 *
 * SPDX-License-Identifier: MIT
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "decoder/toolkit/text.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static char path[256], said[512];

static void keep(void *user, btf_log_level level, const char *message) {
    (void)user;
    (void)level;
    snprintf(said, sizeof said, "%s", message);
}

static const btf_log log_kept = {keep, NULL};

static int make_path(void **state) {
    (void)state;
    const char *base = getenv("TMPDIR");
    snprintf(path, sizeof path, "%s/btf-text-XXXXXX", base && *base ? base : "/tmp");
    const int fd = mkstemp(path);
    return fd >= 0 ? close(fd) : -1;
}

static int remove_path(void **state) {
    (void)state;
    return remove(path);
}

static btf_result read_bytes(const char *bytes, size_t size, text_file *out) {
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
    said[0] = '\0';
    return text_read(path, 100000, &log_kept, out);
}

static void test_lines(void **state) {
    (void)state;
    static const char *const texts[] = {"a\n\nb c\n", "a\r\n\r\nb c", "a\r\rb c\r",
                                        "\xef\xbb\xbf\x61\n\nb c"};
    static const char *const lines[] = {"a", "", "b c"};
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++) {
        text_file text;
        assert_int_equal(read_bytes(texts[i], strlen(texts[i]), &text), BTF_OK);
        for (size_t k = 0; k < 3; k++) {
            assert_string_equal(text_line(&text), lines[k]);
            assert_int_equal(text.number, k + 1);
        }
        assert_null(text_line(&text));
        text_free(&text);
    }
    text_file text;
    assert_int_equal(read_bytes("", 0, &text), BTF_OK);
    assert_null(text_line(&text));
    text_free(&text);
    assert_int_equal(read_bytes("\xef\xbb\xbf", 3, &text), BTF_OK);
    assert_null(text_line(&text));
    text_free(&text);
}

static void test_long(void **state) {
    (void)state;
    text_file text;
    char *bytes = malloc(100001);
    memset(bytes, 'x', 100001);
    assert_int_equal(read_bytes(bytes, 100000, &text), BTF_OK);
    assert_int_equal(strlen(text_line(&text)), 100000);
    assert_null(text_line(&text));
    text_free(&text);
    assert_int_equal(read_bytes(bytes, 100001, &text), BTF_ERROR_UNSUPPORTED);
    assert_non_null(strstr(said, "larger than 100000 bytes"));
    assert_null(text.data);
    free(bytes);
}

static void test_refused(void **state) {
    (void)state;
    static const struct {
        const char *bytes;
        size_t size;
        btf_result result;
        const char *words;
    } cases[] = {
        {"\xff\xfe"
         "a\0",
         4, BTF_ERROR_UNSUPPORTED, "the text is UTF-16: save it as UTF-8"},
        {"\xfe\xff\0a", 4, BTF_ERROR_UNSUPPORTED, "the text is UTF-16"},
        {"a\0b\0", 4, BTF_ERROR_UNSUPPORTED, "the text is UTF-16"},
        {"\0a\0b", 4, BTF_ERROR_UNSUPPORTED, "the text is UTF-16"},
        {"\xff\xfe\0\0", 4, BTF_ERROR_UNSUPPORTED, "the text is UTF-32"},
        {"\0\0\xfe\xff", 4, BTF_ERROR_UNSUPPORTED, "the text is UTF-32"},
        {"abc\0", 4, BTF_ERROR_BAD_FILE, "bytes of value 0"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        text_file text;
        assert_int_equal(read_bytes(cases[i].bytes, cases[i].size, &text), cases[i].result);
        assert_non_null(strstr(said, cases[i].words));
        assert_non_null(strstr(said, path));
    }
    text_file text;
    assert_int_equal(text_read("/nowhere/at/all", 10, &log_kept, &text), BTF_ERROR_IO);
    assert_int_equal(text_read("/", 10, &log_kept, &text), BTF_ERROR_IO);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_lines, make_path, remove_path),
        cmocka_unit_test_setup_teardown(test_long, make_path, remove_path),
        cmocka_unit_test_setup_teardown(test_refused, make_path, remove_path),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
