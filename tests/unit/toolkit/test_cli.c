/* Command lines and JSON of the tools.
 *
 * SPDX-License-Identifier: MIT
 */
#include "decoder/toolkit/cli.h"
#include "decoder/toolkit/json.h"
#include "tests/support/test.h"
#include <unistd.h>

static struct {
    bool flag, given;
    const char *text;
    int number, choice, size[2];
    double real, angles[2];
    uint64_t bytes;
    uint32_t effects, auto_effects;
    char custom;
} values;

static const char *parse_vowel(const char *text, void *value) {
    if (!strchr("aeiou", text[0]) || text[1]) {
        return "a vowel";
    }
    *(char *)value = text[0];
    return NULL;
}

/* clang-format off */
static const cli_option table[] = {
    {.short_name = 'f', .name = "flag", .type = CLI_FLAG, .value = &values.flag, .help = "a flag"},
    {.short_name = 't', .name = "text", .type = CLI_STRING, .value = &values.text, .given = &values.given,
     .help = "text"},
    {.short_name = 'n', .name = "number", .type = CLI_INT, .value = &values.number, .minimum = -3,
     .maximum = 9, .help = "number"},
    {.name = "real", .type = CLI_DOUBLE, .value = &values.real, .help = "real"},
    {.name = "choice", .type = CLI_CHOICE, .choices = "fast|medium", .value = &values.choice,
     .help = "choice"},
    {.name = "size", .type = CLI_SIZE, .value = values.size, .help = "size"},
    {.name = "bytes", .type = CLI_BYTES, .value = &values.bytes, .help = "bytes"},
    {.name = "angles", .type = CLI_ANGLES, .value = values.angles, .help = "angles"},
    {.name = "effects", .type = CLI_EFFECTS, .value = &values.effects, .help = "effects"},
    {.name = "auto-effects", .type = CLI_EFFECTS, .choices = "auto", .value = &values.auto_effects,
     .help = "effects"},
    {.name = "custom", .type = CLI_CUSTOM, .parse = parse_vowel, .value = &values.custom,
     .help = "custom"},
    {.type = CLI_END},
};
/* clang-format on */

static const cli_program program = {
    .name = "btf-test",
    .usage = "FILE [MORE]",
    .summary = "Tests.",
    .details = "Details.",
    .example = "btf-test a",
    .options = table,
    .min_arguments = 1,
    .max_arguments = 2,
};

static char printed[16384]; /* the last call's output on stdout and stderr */

/* Parses the words; returns whether to go on. */
static bool parse(const char *const *words, cli_arguments *arguments, int *exit_code) {
    static char *argv[16];
    int argc = 0;
    argv[argc++] = (char *)(uintptr_t) "btf-test";
    for (; *words; words++) {
        argv[argc++] = (char *)(uintptr_t)*words;
    }
    FILE *file = tmpfile();
    assert_non_null(file);
    fflush(stdout);
    fflush(stderr);
    int out = dup(1), err = dup(2);
    dup2(fileno(file), 1);
    dup2(fileno(file), 2);
    *exit_code = -1;
    bool go_on = cli_parse(&program, argc, argv, arguments, exit_code);
    fflush(stdout);
    fflush(stderr);
    dup2(out, 1);
    dup2(err, 2);
    close(out);
    close(err);
    rewind(file);
    printed[fread(printed, 1, sizeof printed - 1, file)] = 0;
    fclose(file);
    return go_on;
}

#define WORDS(...) ((const char *const[]){__VA_ARGS__, NULL})

static void good(const char *const *words) {
    cli_arguments arguments;
    int exit_code;
    memset(&values, 0, sizeof values);
    if (!parse(words, &arguments, &exit_code)) {
        print_error("refused: %s\n", printed);
        fail();
    }
    assert_string_equal(printed, "");
}

static void bad(const char *const *words, const char *message) {
    cli_arguments arguments;
    int exit_code;
    assert_false(parse(words, &arguments, &exit_code));
    assert_int_equal(exit_code, 1);
    if (!strstr(printed, message)) {
        print_error("expected \"%s\" in \"%s\"\n", message, printed);
    }
    assert_non_null(strstr(printed, message));
    assert_non_null(strstr(printed, "btf-test: error: "));
    assert_non_null(strstr(printed, "--help"));
}

TEST(test_values) {
    good(WORDS("a"));
    assert_false(values.flag);
    good(WORDS("a", "--flag", "--text", "word", "--number=-3", "--real", "2.5e-3", "--choice", "medium"));
    assert_true(values.flag && values.given);
    assert_string_equal(values.text, "word");
    assert_int_equal(values.number, -3);
    assert_true(values.real == 2.5e-3);
    assert_int_equal(values.choice, 1);
    good(WORDS("-n7", "-f", "-t", "x", "a", "--size", "64x48", "--bytes", "2.5Gi", "--angles=30,-120.5"));
    assert_int_equal(values.number, 7);
    assert_int_equal(values.size[0], 64);
    assert_int_equal(values.size[1], 48);
    assert_true(values.bytes == 2684354560u);
    assert_true(values.angles[0] == 30 && values.angles[1] == -120.5);
    good(WORDS("a", "--bytes", "512M", "--effects", "shadow,gain", "--auto-effects", "auto", "--custom",
               "e"));
    assert_true(values.bytes == 512000000);
    assert_int_equal(values.effects, 9);
    assert_true(values.auto_effects == UINT32_MAX);
    assert_int_equal(values.custom, 'e');
    good(WORDS("a", "--effects", "all", "--auto-effects", "none"));
    assert_int_equal(values.effects, 127);
    assert_int_equal(values.auto_effects, 0);
}

TEST(test_arguments) {
    cli_arguments arguments;
    int exit_code;
    assert_true(parse(WORDS("one", "-f", "--", "--two"), &arguments, &exit_code));
    assert_int_equal(arguments.count, 2);
    assert_string_equal(arguments.values[0], "one");
    assert_string_equal(arguments.values[1], "--two");
    assert_true(parse(WORDS("-", "-n", "-2"), &arguments, &exit_code));
    assert_string_equal(arguments.values[0], "-");
    assert_int_equal(values.number, -2);
    bad(WORDS("-f"), "0 arguments given, expected: FILE [MORE]");
    bad(WORDS("a", "b", "c"), "unexpected argument 'c'");
}

TEST(test_mistakes) {
    bad(WORDS("a", "--what"), "unknown option --what");
    bad(WORDS("a", "-z"), "unknown option -z");
    bad(WORDS("a", "--wh\x1b[2Jat\x7f"), "unknown option --wh\\x1b[2Jat\\x7f");
    bad(WORDS("a", "--number"), "option --number: expected N after it");
    bad(WORDS("a", "--number", "10"), "option --number: '10' is not a whole number within -3 to 9");
    bad(WORDS("a", "--number", "1.5"), "'1.5' is not");
    bad(WORDS("a", "--number", "99999999999"), "'99999999999' is not");
    bad(WORDS("a", "-n", ""), "'' is not");
    bad(WORDS("a", "--real", "nan"), "'nan' is not a number");
    bad(WORDS("a", "--real", "1e999"), "'1e999' is not");
    bad(WORDS("a", "--real", " 1"), "' 1' is not");
    bad(WORDS("a", "--text="), "'' is not a text");
    bad(WORDS("a", "--flag=1"), "option --flag takes no value");
    bad(WORDS("a", "--choice", "med"), "'med' is not one of fast|medium");
    bad(WORDS("a", "--size", "64"), "'64' is not WIDTHxHEIGHT");
    bad(WORDS("a", "--size", "0x4"), "'0x4' is not");
    bad(WORDS("a", "--size", "4x4x4"), "'4x4x4' is not");
    static const struct {
        const char *text;
        uint64_t bytes;
    } sizes[] = {{"2GB", 2000000000},
                 {"2GiB", 2147483648u},
                 {"2G", 2000000000},
                 {"2 GB", 2000000000},
                 {"2gb", 2000000000},
                 {"2 g", 2000000000},
                 {"2gib", 2147483648u},
                 {"1.5kB", 1500},
                 {"3KiB", 3072},
                 {"7B", 7},
                 {"7", 7},
                 {"1T", 1000000000000},
                 {"1 TiB", 1099511627776},
                 {"5e3", 5000}};
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        good(WORDS("a", "--bytes", sizes[i].text));
        if (values.bytes != sizes[i].bytes) {
            fail_msg("%s gave %llu", sizes[i].text, (unsigned long long)values.bytes);
        }
    }
    bad(WORDS("a", "--bytes", "5Q"), "'5Q' is not a number of bytes");
    bad(WORDS("a", "--bytes", "5 "), "'5 ' is not a number of bytes");
    bad(WORDS("a", "--bytes", "5iB"), "'5iB' is not a number of bytes");
    bad(WORDS("a", "--bytes", "5GBs"), "'5GBs' is not a number of bytes");
    bad(WORDS("a", "--bytes", "5G B"), "'5G B' is not a number of bytes");
    bad(WORDS("a", "--bytes", "-5"), "'-5' is not");
    bad(WORDS("a", "--angles", "91,0"), "'91,0' is not THETA,PHI");
    bad(WORDS("a", "--angles", "30"), "'30' is not");
    bad(WORDS("a", "--effects", "shadow,shine"), "'shadow,shine' is not none, all, or some of");
    bad(WORDS("a", "--effects", "shadow,"), "is not");
    bad(WORDS("a", "--effects", "auto"), "is not");
    bad(WORDS("a", "--custom", "x"), "option --custom: 'x' is not a vowel");
}

TEST(test_numbers) {
    const char *end;
    double x = 0;
    int n = 0;
    assert_true(cli_parse_int("12x3", "x", &n, &end) && n == 12 && !strcmp(end, "x3"));
    assert_true(cli_parse_double("1.5,", ",", &x, &end) && x == 1.5 && !strcmp(end, ","));
    assert_true(cli_parse_int("-2147483648", "", &n, NULL) && n == -2147483647 - 1);
    const char *const no_int[] = {"", " 1", "4294967297", "99999999999999999999", "1x", "0x1", "1.0", "x"};
    const char *const no_double[] = {"", " 1", "nan", "inf", "1e999", "1,", ",1", "."};
    for (size_t i = 0; i < sizeof no_int / sizeof *no_int; i++) {
        assert_false(cli_parse_int(no_int[i], "", &n, NULL));
    }
    for (size_t i = 0; i < sizeof no_double / sizeof *no_double; i++) {
        assert_false(cli_parse_double(no_double[i], "", &x, NULL));
    }
}

TEST(test_help) {
    cli_arguments arguments;
    int exit_code;
    assert_false(parse(WORDS("--help"), &arguments, &exit_code));
    assert_int_equal(exit_code, 0);
    static const char *const expected[] = {"Usage: btf-test FILE [MORE]",
                                           "-n, --number N",
                                           "--size WxH",
                                           "--choice fast|medium",
                                           "--version",
                                           "Exit codes:",
                                           "3  bad file",
                                           "4  internal error, out of memory",
                                           "Example:\n  btf-test a",
                                           "Details."};
    for (size_t i = 0; i < sizeof expected / sizeof *expected; i++) {
        assert_non_null(strstr(printed, expected[i]));
    }
    assert_false(parse(WORDS("--version"), &arguments, &exit_code));
    assert_int_equal(exit_code, 0);
    assert_non_null(strstr(printed, "btf-test"));
}

TEST(test_effects_text) {
    char buffer[48];
    assert_string_equal(cli_effects_text(0, buffer), "none");
    assert_string_equal(cli_effects_text(31, buffer), "shadow,shift,hidden,gain,residual");
    assert_string_equal(cli_effects_text(16, buffer), "residual");
}

TEST(test_json) {
    json j = {0};
    json_object(&j, NULL);
    json_string(&j, "a\"b", "line\n\ttab \\ \x01 \xC3\xA9 \xFF\xC3");
    json_string(&j, "null", NULL);
    json_array(&j, "numbers");
    json_number(&j, NULL, 0.1);
    json_number(&j, NULL, 1.0 / 3);
    json_number(&j, NULL, NAN);
    json_number(&j, NULL, -INFINITY);
    json_number(&j, NULL, 1e300);
    json_float(&j, NULL, 0.1f);
    json_integer(&j, NULL, -9007199254740993);
    json_end(&j);
    json_array(&j, "empty");
    json_end(&j);
    json_object(&j, "inner");
    json_bool(&j, "yes", true);
    json_null(&j, "nothing");
    json_end(&j);
    json_end(&j);
    assert_string_equal(
        json_text(&j),
        "{\n  \"a\\\"b\": \"line\\n\\ttab \\\\ \\u0001 \xC3\xA9 \xEF\xBF\xBD\xEF\xBF\xBD\",\n"
        "  \"null\": null,\n  \"numbers\": [\n    0.1,\n    0.3333333333333333,\n    null,\n    null,\n"
        "    1e+300,\n    0.1,\n    -9007199254740993\n  ],\n  \"empty\": [],\n  \"inner\": {\n"
        "    \"yes\": true,\n    \"nothing\": null\n  }\n}\n");
    assert_string_equal(json_text(&j) + strlen(json_text(&j)) - 2, "}\n"); /* asked again: the same */
    json_free(&j);
    assert_null(j.text);
}

RUN_TESTS(NULL, NULL)
