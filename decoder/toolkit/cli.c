/* Command lines: options by table, messages, --help, --version, exit codes.
 *
 * SPDX-License-Identifier: MIT
 */
#include "cli.h"
#include <ctype.h>
#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <openbtf/material.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#ifndef OPENBTF_VERSION
#define OPENBTF_VERSION "0.2.0"
#endif

static const char *const effect_words[CLI_EFFECTS_COUNT] = {"shadow",   "shift",  "hidden", "gain",
                                                            "residual", "relief", "gloss"};

void cli_print(const char *program, btf_log_level level, const char *message) {
    static const char *const kinds[] = {"error: ", "warning: ", ""};
    char *safe = malloc(4 * strlen(message) + 1), *to = safe;
    for (const char *c = message; safe && *c; c++) {
        if (((unsigned char)*c < ' ' && *c != '\n' && *c != '\t') || *c == 0x7f) {
            to += sprintf(to, "\\x%02x", (unsigned)*c);
        } else {
            *to++ = *c;
        }
    }
    if (safe) {
        *to = 0;
    }
    fprintf(stderr, "%s: %s%s\n", program, kinds[level], safe ? safe : "out of memory for a message");
    free(safe);
}

static void print_error(const char *program, const char *format, va_list arguments)
    __attribute__((format(printf, 2, 0)));

static void print_error(const char *program, const char *format, va_list arguments) {
    char *message = NULL;
    if (vasprintf(&message, format, arguments) < 0) {
        message = NULL;
    }
    cli_print(program, BTF_LOG_ERROR, message ? message : format);
    free(message);
}

btf_result cli_error(const cli_program *program, btf_result result, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    print_error(program->name, format, arguments);
    va_end(arguments);
    return result;
}

static void log_all(void *user, btf_log_level level, const char *message) {
    cli_print(((const cli_program *)user)->name, level, message);
}

static void log_quiet(void *user, btf_log_level level, const char *message) {
    if (level != BTF_LOG_INFO) {
        log_all(user, level, message);
    }
}

btf_log cli_log(const cli_program *program, bool quiet) {
    return (btf_log){quiet ? log_quiet : log_all, (void *)(uintptr_t)program};
}

int cli_finish(const cli_program *program, btf_result result) {
    bool failed = ferror(stdout) != 0;
    errno = 0;
    if (fflush(stdout) != 0 || failed) {
        cli_error(program, BTF_ERROR_IO, "standard output: %s", errno ? strerror(errno) : "write failed");
        result = result ? result : BTF_ERROR_IO;
    }
    return btf_result_exit_code(result);
}

const char *cli_effect_word(int i) {
    return i >= 0 && i < CLI_EFFECTS_COUNT ? effect_words[i] : NULL;
}

const char *cli_effects_text(uint32_t effects, char *buffer) {
    buffer[0] = 0;
    for (int i = 0; i < CLI_EFFECTS_COUNT; i++) {
        if (effects & 1u << i) {
            if (buffer[0]) {
                strcat(buffer, ",");
            }
            strcat(buffer, effect_words[i]);
        }
    }
    return buffer[0] ? buffer : strcpy(buffer, "none");
}

/* --help
 * --------------------------------------------------------------------------------------------------- */

static const char *argument_name(const cli_option *option) {
    static const char *const names[] = {
        [CLI_STRING] = "TEXT", [CLI_INT] = "N",      [CLI_DOUBLE] = "X",     [CLI_SIZE] = "WxH",
        [CLI_BYTES] = "SIZE",  [CLI_ANGLES] = "T,P", [CLI_EFFECTS] = "LIST", [CLI_CUSTOM] = "VALUE"};
    if (option->type == CLI_FLAG) {
        return "";
    }
    if (option->arg) {
        return option->arg;
    }
    return option->type == CLI_CHOICE ? option->choices : names[option->type];
}

/* Prints text, each further line indented. */
static void print_indented(const char *text, int indent) {
    for (; *text; text++) {
        putchar(*text);
        if (*text == '\n') {
            printf("%*s", indent, "");
        }
    }
    putchar('\n');
}

static void print_option(char short_name, const char *name, const char *argument, const char *help) {
    enum { COLUMN = 28 };
    int length = printf(short_name ? "  -%c, " : "      ", short_name);
    length += printf("--%s%s%s", name, *argument ? " " : "", argument);
    if (length >= COLUMN) {
        putchar('\n');
        length = 0;
    }
    printf("%*s", COLUMN - length, "");
    print_indented(help, COLUMN);
}

static void print_exit_codes(void) {
    static const struct {
        int code;
        const char *text;
    } results[] = {
#define EXIT_CODE(name, value, exit_code, text) {exit_code, text},
        BTF_RESULT_LIST(EXIT_CODE)
#undef EXIT_CODE
    };
    const int count = (int)(sizeof results / sizeof *results);
    printf("\nExit codes:\n");
    for (int i = 0; i < count; i++) {
        bool seen = false;
        for (int k = 0; k < i; k++) {
            seen = seen || results[k].code == results[i].code;
        }
        if (seen) {
            continue;
        }
        printf("  %3d  %s", results[i].code, results[i].text);
        for (int k = i + 1; k < count; k++) {
            if (results[k].code == results[i].code) {
                printf(", %s", results[k].text);
            }
        }
        putchar('\n');
    }
}

static void print_help(const cli_program *program) {
    printf("Usage: %s %s\n\n%s\n\nOptions:\n", program->name, program->usage, program->summary);
    for (const cli_option *option = program->options; option->type != CLI_END; option++) {
        if (option->help) {
            print_option(option->short_name, option->name, argument_name(option), option->help);
        }
    }
    print_option('h', "help", "", "print this and end");
    print_option(0, "version", "", "print the version and end");
    if (program->details) {
        printf("\n%s\n", program->details);
    }
    print_exit_codes();
    printf("\nExample:\n  ");
    print_indented(program->example, 2);
}

/* Values
 * --------------------------------------------------------------------------------------------------- */

/* The kind of argument that an option takes, in words for messages. */
typedef struct wanted {
    char text[200];
} wanted;

static void __attribute__((format(printf, 2, 3))) want(wanted *w, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(w->text, sizeof w->text, format, arguments);
    va_end(arguments);
}

static bool has_range(const cli_option *option) {
    return option->minimum < option->maximum;
}

static bool in_range(const cli_option *option, double x) {
    return !has_range(option) || (x >= option->minimum && x <= option->maximum);
}

/* Numbers are read by strtod and strtol, which skip leading space and know "inf": both are refused here. */
static bool starts_number(const char *text) {
    return strchr("+-.0123456789", *text) && *text;
}

bool cli_parse_double(const char *text, const char *ends, double *out, const char **end) {
    char *stop;
    if (!starts_number(text)) {
        return false;
    }
    *out = strtod(text, &stop);
    if (end) {
        *end = stop;
    }
    return stop != text && isfinite(*out) && (strchr(ends, *stop) != NULL || *stop == 0);
}

int cli_parse_doubles(const char *text, double *out, int most) {
    for (int count = 0; count < most;) {
        const char *end;
        if (!cli_parse_double(text, ",", &out[count++], &end)) {
            return 0;
        }
        if (*end == '\0') {
            return count;
        }
        text = end + 1;
    }
    return 0;
}

bool cli_parse_int(const char *text, const char *ends, int *out, const char **end) {
    char *stop;
    errno = 0;
    if (!starts_number(text)) {
        return false;
    }
    long value = strtol(text, &stop, 10);
    if (end) {
        *end = stop;
    }
    *out = (int)value;
    return stop != text && errno == 0 && *out == value && (strchr(ends, *stop) != NULL || *stop == 0);
}

static bool read_int(const cli_option *option, const char *text, wanted *w) {
    int value;
    want(w, "a whole number");
    if (has_range(option)) {
        want(w, "a whole number within %.0f to %.0f", option->minimum, option->maximum);
    }
    if (!cli_parse_int(text, "", &value, NULL) || !in_range(option, value)) {
        return false;
    }
    *(int *)option->value = value;
    return true;
}

static bool read_double(const cli_option *option, const char *text, wanted *w) {
    double value;
    want(w, "a number");
    if (has_range(option)) {
        want(w, "a number within %g to %g", option->minimum, option->maximum);
    }
    if (!cli_parse_double(text, "", &value, NULL) || !in_range(option, value)) {
        return false;
    }
    *(double *)option->value = value;
    return true;
}

static bool read_choice(const cli_option *option, const char *text, wanted *w) {
    size_t length = strlen(text);
    want(w, "one of %s", option->choices);
    const char *choice = option->choices;
    for (int i = 0; choice; i++) {
        const char *end = strchr(choice, '|');
        size_t size = end ? (size_t)(end - choice) : strlen(choice);
        if (size == length && !memcmp(choice, text, size)) {
            *(int *)option->value = i;
            return true;
        }
        choice = end ? end + 1 : NULL;
    }
    return false;
}

static bool read_size(const cli_option *option, const char *text, wanted *w) {
    int width, height;
    const char *end;
    want(w, "WIDTHxHEIGHT, for instance 64x64");
    if (has_range(option)) {
        want(w, "WIDTHxHEIGHT, each within %.0f to %.0f", option->minimum, option->maximum);
    }
    if (!cli_parse_int(text, "x", &width, &end) || *end != 'x' ||
        !cli_parse_int(end + 1, "", &height, NULL) || width < 1 || height < 1 || !in_range(option, width) ||
        !in_range(option, height)) {
        return false;
    }
    ((int *)option->value)[0] = width;
    ((int *)option->value)[1] = height;
    return true;
}

/* The bytes of a unit: "", "B", or k, M, G, T (powers of 1000) or Ki, Mi, Gi, Ti (of 1024) with a B behind
 * it or not, in any case, after blanks or none. 0 for anything else. */
static double unit_bytes(const char *text) {
    static const char prefixes[] = "kmgt";
    double factor = 1;
    if (*text == ' ' && !text[strspn(text, " ")]) {
        return 0;
    }
    text += strspn(text, " ");
    const char *prefix = *text ? strchr(prefixes, tolower((unsigned char)*text)) : NULL;
    if (prefix) {
        const bool binary = tolower((unsigned char)text[1]) == 'i';
        for (const char *p = prefixes; p <= prefix; p++) {
            factor *= binary ? 1024 : 1000;
        }
        text += binary ? 2 : 1;
    }
    text += tolower((unsigned char)*text) == 'b';
    return *text ? 0 : factor;
}

static bool read_bytes(const cli_option *option, const char *text, wanted *w) {
    double value;
    const char *end;
    want(w, "a number of bytes, for instance 512M, 2.5GB (powers of 1000) or 2GiB (of 1024)");
    if (has_range(option)) {
        want(w,
             "a number of bytes within %.0f to %.0f, for instance 512M, 2.5GB (powers of 1000) or 2GiB (of "
             "1024)",
             option->minimum, option->maximum);
    }
    if (!cli_parse_double(text, " BbKkMmGgTt", &value, &end) || value < 0) {
        return false;
    }
    const double factor = unit_bytes(end);
    value *= factor;
    if (factor == 0 || value >= 0x1p63 || !in_range(option, value)) {
        return false;
    }
    *(uint64_t *)option->value = (uint64_t)value;
    return true;
}

static bool read_angles(const cli_option *option, const char *text, wanted *w) {
    double angles[2];
    want(w, "THETA,PHI in degrees, theta within 0 to 90, phi within -360 to 360");
    if (cli_parse_doubles(text, angles, 2) != 2 || angles[0] < 0 || angles[0] > 90 || angles[1] < -360 ||
        angles[1] > 360) {
        return false;
    }
    memcpy(option->value, angles, sizeof angles);
    return true;
}

static bool read_effects(const cli_option *option, const char *text, wanted *w) {
    uint32_t effects = 0;
    want(w, "%s, or some of shadow,shift,hidden,gain,residual,relief,gloss",
         option->choices ? "auto, none, all" : "none, all");
    if (option->choices && !strcmp(text, option->choices)) {
        *(uint32_t *)option->value = UINT32_MAX;
        return true;
    }
    if (!strcmp(text, "all")) {
        effects = BTF_EFFECT_ALL;
    } else if (strcmp(text, "none")) {
        for (const char *word = text; word;) {
            size_t size = strcspn(word, ",");
            int i = 0;
            while (i < CLI_EFFECTS_COUNT &&
                   (strlen(effect_words[i]) != size || memcmp(effect_words[i], word, size))) {
                i++;
            }
            if (i == CLI_EFFECTS_COUNT) {
                return false;
            }
            effects |= 1u << i;
            word = word[size] ? word + size + 1 : NULL;
        }
    }
    *(uint32_t *)option->value = effects;
    return true;
}

static bool read_value(const cli_option *option, const char *text, wanted *w) {
    const char *expected;
    switch (option->type) {
    case CLI_STRING:
        want(w, "a text");
        if (!*text) {
            return false;
        }
        *(const char **)option->value = text;
        return true;
    case CLI_INT:
        return read_int(option, text, w);
    case CLI_DOUBLE:
        return read_double(option, text, w);
    case CLI_CHOICE:
        return read_choice(option, text, w);
    case CLI_SIZE:
        return read_size(option, text, w);
    case CLI_BYTES:
        return read_bytes(option, text, w);
    case CLI_ANGLES:
        return read_angles(option, text, w);
    case CLI_EFFECTS:
        return read_effects(option, text, w);
    case CLI_CUSTOM:
        expected = option->parse(text, option->value);
        want(w, "%s", expected ? expected : "");
        return expected == NULL;
    case CLI_END:
    case CLI_FLAG:
        break;
    }
    return false;
}

/* Parsing
 * -------------------------------------------------------------------------------------------------- */

static const cli_option *find_option(const cli_program *program, const char *name, size_t length,
                                     char short_name) {
    for (const cli_option *option = program->options; option->type != CLI_END; option++) {
        if (name ? strlen(option->name) == length && !memcmp(option->name, name, length)
                 : option->short_name == short_name) {
            return option;
        }
    }
    return NULL;
}

/* Ends the tool with a usage error. */
static bool __attribute__((format(printf, 3, 4)))
misuse(const cli_program *program, int *out_exit_code, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    print_error(program->name, format, arguments);
    va_end(arguments);
    fprintf(stderr, "Try '%s --help'.\n", program->name);
    *out_exit_code = btf_result_exit_code(BTF_ERROR_USAGE);
    return false;
}

/* One option at argv[*at]; moves *at over its value. */
static bool parse_option(const cli_program *program, int argc, char **argv, int *at, int *out_exit_code) {
    const char *word = argv[*at], *value = NULL;
    const bool is_long = word[1] == '-';
    const char *name = word + 2;
    size_t length = is_long ? strcspn(name, "=") : 0;
    const cli_option *option = find_option(program, is_long ? name : NULL, length, word[1]);
    if (!option) {
        return misuse(program, out_exit_code, "unknown option %s", word);
    }
    if (is_long && name[length] == '=') {
        value = name + length + 1;
    } else if (!is_long && word[2]) {
        value = word + 2;
    }
    if (option->type == CLI_FLAG) {
        if (value) {
            return misuse(program, out_exit_code, "option --%s takes no value, but has '%s'", option->name,
                          value);
        }
        *(bool *)option->value = true;
    } else {
        if (!value && *at + 1 >= argc) {
            return misuse(program, out_exit_code, "option --%s: expected %s after it", option->name,
                          argument_name(option));
        }
        if (!value) {
            value = argv[++*at];
        }
        wanted w = {""};
        if (!read_value(option, value, &w)) {
            return misuse(program, out_exit_code, "option --%s: '%s' is not %s", option->name, value,
                          w.text);
        }
    }
    if (option->given) {
        *option->given = true;
    }
    return true;
}

/* A file opened later must not become a closed standard stream, or messages are written into it. The file that
 * takes its place fails as a closed one does. */
static void reserve_standard_streams(void) {
    for (int fd = STDIN_FILENO; fd <= STDERR_FILENO; fd++) {
        if (fcntl(fd, F_GETFD) < 0) {
            (void)!open("/dev/null", fd == STDIN_FILENO ? O_WRONLY : O_RDONLY);
        }
    }
}

bool cli_parse(const cli_program *program, int argc, char **argv, cli_arguments *out_arguments,
               int *out_exit_code) {
    reserve_standard_streams();
    int count = 0;
    bool options_end = false;
    for (int i = 1; i < argc; i++) {
        char *word = argv[i];
        if (options_end || word[0] != '-' || word[1] == 0) {
            argv[1 + count++] = word;
        } else if (!strcmp(word, "--")) {
            options_end = true;
        } else if (!strcmp(word, "--help") || !strcmp(word, "-h")) {
            print_help(program);
            *out_exit_code = cli_finish(program, BTF_OK);
            return false;
        } else if (!strcmp(word, "--version")) {
            printf("%s (OpenBTF) %s\n", program->name, OPENBTF_VERSION);
            *out_exit_code = cli_finish(program, BTF_OK);
            return false;
        } else if (!parse_option(program, argc, argv, &i, out_exit_code)) {
            return false;
        }
    }
    *out_arguments = (cli_arguments){argv + 1, count};
    if (count < program->min_arguments) {
        return misuse(program, out_exit_code, "%d argument%s given, expected: %s", count,
                      count == 1 ? "" : "s", program->usage);
    }
    if (program->max_arguments >= 0 && count > program->max_arguments) {
        return misuse(program, out_exit_code, "unexpected argument '%s', expected: %s",
                      out_arguments->values[program->max_arguments], program->usage);
    }
    return true;
}
