/* Warnings about the images of a data set (encoder/input/notices.h): one line a kind. test_ranks.c has
 * those of several ranks.
 *
 * SPDX-License-Identifier: MIT
 */
#include "encoder/input/notices.h"
#include "tests/support/test.h"

static char said[1024];

static void keep(void *user, btf_log_level level, const char *message) {
    (void)user;
    assert_int_equal(level, BTF_LOG_WARNING);
    snprintf(said + strlen(said), sizeof said - strlen(said), "%s\n", message);
}

static const enc_context context = {.log = {keep, NULL}, .threads = 1};

static void expect(enc_notices *notices, const char *lines) {
    said[0] = '\0';
    assert_int_equal(enc_notices_tell(&context, BTF_OK, notices, "set"), BTF_OK);
    assert_string_equal(said, lines);
}

TEST(test_lines) {
    enc_notices *notices = enc_notices_create();
    expect(notices, "");
    enc_notices_add(notices, BTF_LOG_WARNING, "profile", "b.png", "profile 'A' is not obeyed");
    enc_notices_add(notices, BTF_LOG_WARNING, "gamma", "b.png", "gamma 0.5");
    enc_notices_add(notices, BTF_LOG_WARNING, "profile", "c.png", "profile 'A' is not obeyed");
    enc_notices_add(notices, BTF_LOG_WARNING, "profile", "a.png", "profile 'A' is not obeyed");
    expect(notices, "set: b.png: gamma 0.5\nset: 3 images: a.png: profile 'A' is not obeyed\n");
    expect(notices, ""); /* told once */
    enc_notices_add(notices, BTF_LOG_WARNING, "gamma", "b.png", "gamma 0.5");
    enc_notices_add(notices, BTF_LOG_WARNING, "gamma", "a.png", "gamma 0.6");
    expect(notices, "set: 2 images, with other values too: a.png: gamma 0.6\n");
    enc_notices_destroy(&notices);
    assert_null(notices);
    enc_notices_add(NULL, BTF_LOG_WARNING, "gamma", "a.png", "gamma 0.6");
}

/* The lines do not depend on the order in which threads come. */
TEST(test_threads) {
    enc_notices *notices = enc_notices_create();
#pragma omp parallel for num_threads(8) schedule(dynamic)
    for (int i = 0; i < 800; i++) {
        char file[16], text[16];
        snprintf(file, sizeof file, "%03d.png", 999 - i);
        snprintf(text, sizeof text, "value %d", i / 400);
        enc_notices_add(notices, BTF_LOG_WARNING, i % 2 ? "odd" : "even", file, i % 2 ? text : "same");
    }
    expect(notices,
           "set: 400 images: 201.png: same\nset: 400 images, with other values too: 200.png: value 1\n");
    enc_notices_destroy(&notices);
}

/* A failure is passed on, and what was noted before it is told all the same. */
TEST(test_failure) {
    enc_notices *notices = enc_notices_create();
    enc_notices_add(notices, BTF_LOG_WARNING, "gamma", "a.png", "gamma 0.6");
    said[0] = '\0';
    assert_int_equal(enc_notices_tell(&context, BTF_ERROR_IO, notices, "set"), BTF_ERROR_IO);
    assert_string_equal(said, "set: a.png: gamma 0.6\n");
    enc_notices_destroy(&notices);
}

RUN_TESTS(NULL, NULL)
