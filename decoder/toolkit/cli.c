/* Command lines: options by table, messages, --help, --version, exit codes.
 *
 * SPDX-License-Identifier: MIT
 */
#include "cli.h"
#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#ifndef OPENBTF_VERSION
#define OPENBTF_VERSION "0.2.0"
#endif

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
    print_option('h', "help", "", "print this help and exit");
    print_option(0, "version", "", "print the version and exit");
    if (program->details) {
        printf("\n%s\n", program->details);
    }
    print_exit_codes();
    printf("\nExample:\n  ");
    print_indented(program->example, 2);
}

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

/* Prints a usage error, sets the tool's exit code and returns false. */
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

/* Reads the option at argv[*at]; moves *at to its value where that is the next word. */
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
        cli_wanted w = {""};
        if (!cli_read_value(option, value, &w)) {
            return misuse(program, out_exit_code, "option --%s: '%s' is not %s", option->name, value,
                          w.text);
        }
    }
    if (option->given) {
        *option->given = true;
    }
    return true;
}

/* Opens /dev/null in place of standard streams that are closed: else a file opened later would take a stream's number,
 * and messages would be written into it. It is opened for the wrong direction, so that reading and writing fail as
 * they do on a closed stream. */
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

int cli_run(const cli_program *program, int argc, char **argv,
            btf_result (*run)(const cli_arguments *arguments)) {
    cli_arguments arguments;
    int exit_code;
    if (!cli_parse(program, argc, argv, &arguments, &exit_code)) {
        return exit_code;
    }
    return cli_finish(program, run(&arguments));
}
