/* Times read back from a report (encoder/report/stage_times.h): the ways in which a file may be written, and the
 * messages about one that is not a report.
 *
 * SPDX-License-Identifier: MIT
 */
#include "encoder/report/stage_times.h"
#include "tests/support/messages.h"
#include "tests/support/test.h"

#include <unistd.h>

static const enc_context context = {.log = {keep_message, NULL}, .threads = 1};

/* Reads `length` bytes of text as a report. */
static btf_result read_bytes(const char *text, size_t length, enc_report_times *out) {
    char path[] = "stage-times-XXXXXX";
    const int fd = mkstemp(path);
    assert_true(fd >= 0);
    assert_int_equal(write(fd, text, length), length);
    close(fd);
    last_message[0] = '\0';
    const btf_result result = enc_report_times_read(&context, path, out);
    unlink(path);
    assert_int_equal(result != BTF_OK, strstr(last_message, path) != NULL); /* the file is named */
    return result;
}

static void refused(const char *text, const char *said) {
    enc_report_times times;
    assert_int_equal(read_bytes(text, strlen(text), &times), BTF_ERROR_BAD_FILE);
    if (!strstr(last_message, said)) {
        fail_msg("%s: '%s' does not say '%s'", text, last_message, said);
    }
}

/* A report is read with its members in any order, with any spaces and escapes. */
TEST(test_any_writing) {
    static const char *const texts[] = {
        "{\"method\": \"joint\", \"core_seconds\": {\"total\": 2.5, \"read\": 0.5}, "
        "\"predicted_core_seconds\": {\"read\": 1e-1}}",
        "\xef\xbb\xbf{\"predicted_core_seconds\":{\"r\\u0065ad\":0.1},\"trials\":[{\"core_seconds\":1}],"
        "\r\n"
        "\"core_seconds\"\t:\n{\"read\"\n:5E-1,\"total\":25e-1},\"input\":\"a \\\"core_seconds\\\": {\","
        "\"method\":\"joint\"}\n\n"};
    for (int i = 0; i < 2; i++) {
        enc_report_times times;
        assert_int_equal(read_bytes(texts[i], strlen(texts[i]), &times), BTF_OK);
        assert_string_equal(times.method, "joint");
        assert_int_equal(times.measured.count, 2);
        assert_int_equal(times.predicted.count, 1);
        assert_true(enc_stage_time(&times.measured, "total") == 2.5);
        assert_true(enc_stage_time(&times.measured, "read") == 0.5);
        assert_true(enc_stage_time(&times.predicted, "read") == 0.1);
        assert_true(isnan(enc_stage_time(&times.predicted, "total")));
    }
}

TEST(test_not_json) {
    enc_report_times times;
    refused("", "line 1: is not JSON");
    refused("{\"method\": \"joint\",\n\"core_seconds\": {\"total\": 1,}\n}", "line 2: is not JSON");
    refused("{\"method\": \"joint\"}\n\n{}", "line 3: is not JSON");
    refused("[1, 2]", "not a JSON object");
    static const char zero[] = "{}\0{}";
    assert_int_equal(read_bytes(zero, sizeof zero - 1, &times), BTF_ERROR_BAD_FILE);
    assert_non_null(strstr(last_message, "is not JSON"));
    char *deep = calloc(1, 20001);
    memset(deep, '[', 10000);
    memset(deep + 10000, ']', 10000);
    refused(deep, "is not JSON");
    free(deep);
}

TEST(test_members) {
#define REPORT(method, measured, predicted)                                                                \
    "{\"method\": " method ", \"core_seconds\": " measured ", \"predicted_core_seconds\": " predicted "}"
    refused("{}", "member method is missing");
    refused(REPORT("7", "{\"total\": 1}", "{\"read\": 1}"), "member method is not");
    refused("{\"method\": \"joint\"}", "member core_seconds is missing");
    refused(REPORT("\"joint\"", "[1]", "{\"read\": 1}"), "member core_seconds is not an object");
    refused(REPORT("\"joint\"", "{}", "{\"read\": 1}"), "member core_seconds is empty");
    refused(REPORT("\"joint\"", "{\"read\": 1}", "{\"read\": 1}"), "member core_seconds.total is missing");
    static const char *const wrong[] = {"\"1\"", "null", "true", "-1", "1e999", "{}"};
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        char text[200];
        snprintf(text, sizeof text, REPORT("\"joint\"", "{\"total\": 1}", "{\"read\": %s}"), wrong[i]);
        refused(text, "member predicted_core_seconds.read is not a number of at least 0");
    }
    refused("{\"method\": \"joint\", \"core_seconds\": {\"total\": 1}}",
            "member predicted_core_seconds is missing");
    refused(REPORT("\"joint\"", "{\"total\": 1}",
                   "{\"a-stage-whose-name-has-more-than-sixty-three-letters-which-none-has\": 1}"),
            "longer than a stage's");
}

/* One stage more than there is room for. */
TEST(test_many_stages) {
    char text[4096] = "{\"method\": \"joint\", \"core_seconds\": {\"total\": 1";
    for (int i = 0; i < ENC_STAGE_TIMES; i++) {
        sprintf(text + strlen(text), ", \"s%d\": 1", i);
    }
    strcat(text, "}}");
    refused(text, "member core_seconds lists more stages");
}

TEST(test_no_file) {
    enc_report_times times;
    assert_int_equal(enc_report_times_read(&context, "/nonexistent/report.json", &times), BTF_ERROR_IO);
    assert_non_null(strstr(last_message, "/nonexistent/report.json: No such file"));
    assert_int_equal(enc_report_times_read(&context, "/", &times), BTF_ERROR_IO);
    assert_non_null(strstr(last_message, "/: Is a directory"));
}

RUN_TESTS(NULL, NULL)
