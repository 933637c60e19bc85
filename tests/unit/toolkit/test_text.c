/* Text files (decoder/toolkit/text.h): byte-order marks, line ends, encodings that are refused.
 *
 * SPDX-License-Identifier: MIT
 */
#include "decoder/toolkit/text.h"
#include "tests/support/image_files.h"
#include "tests/support/messages.h"
#include "tests/support/temporary.h"
#include "tests/support/test.h"

#include <unistd.h>

static btf_result read_bytes(const char *bytes, size_t size, text_file *out) {
    write_whole_file(temporary_file, bytes, size);
    last_message[0] = '\0';
    return text_read(temporary_file, 100000, &log_keep, out);
}

TEST_WITH(test_lines, make_temporary_file, remove_temporary_file) {
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

TEST_WITH(test_long, make_temporary_file, remove_temporary_file) {
    text_file text;
    char *bytes = malloc(100001);
    memset(bytes, 'x', 100001);
    assert_int_equal(read_bytes(bytes, 100000, &text), BTF_OK);
    assert_int_equal(strlen(text_line(&text)), 100000);
    assert_null(text_line(&text));
    text_free(&text);
    assert_int_equal(read_bytes(bytes, 100001, &text), BTF_ERROR_UNSUPPORTED);
    assert_non_null(strstr(last_message, "larger than 100000 bytes"));
    assert_null(text.data);
    free(bytes);
}

TEST_WITH(test_refused, make_temporary_file, remove_temporary_file) {
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
        assert_non_null(strstr(last_message, cases[i].words));
        assert_non_null(strstr(last_message, temporary_file));
    }
    text_file text;
    assert_int_equal(text_read("/nowhere/at/all", 10, &log_keep, &text), BTF_ERROR_IO);
    assert_int_equal(text_read("/", 10, &log_keep, &text), BTF_ERROR_IO);
}

RUN_TESTS(NULL, NULL)
