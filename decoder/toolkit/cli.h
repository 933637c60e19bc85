/* Command lines of all tools: a table of options, messages that name option, value and
 * expectation, --help, --version, exit codes, and where messages go.
 *
 *     static struct { const char *out; bool json; } options;
 *     static const cli_option table[] = {
 *         {.short_name = 'o', .name = "output", .arg = "OUT", .type = CLI_STRING, .value = &options.out,
 *          .help = "file to write"},
 *         {.name = "json", .type = CLI_FLAG, .value = &options.json, .help = "print JSON"},
 *         {.type = CLI_END},
 *     };
 *     static const cli_program program = {.name = "btf-info", .usage = "FILE [--json]", .summary = "...",
 *                                         .example = "btf-info bricks.btf.exr", .options = table,
 *                                         .min_arguments = 1, .max_arguments = 1};
 *     int main(int argc, char **argv) {
 *         cli_arguments arguments;
 *         int exit_code;
 *         if (!cli_parse(&program, argc, argv, &arguments, &exit_code))
 *             return exit_code;
 *         return cli_finish(&program, run(arguments.values[0]));
 *     }
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TOOLS_CLI_H
#define OPENBTF_TOOLS_CLI_H

#include <openbtf/result.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The kind of an option's argument, and the type that `value` points to. */
typedef enum cli_type {
    CLI_END = 0, /* ends the table */
    CLI_FLAG,    /* no argument; bool, set to true */
    CLI_STRING,  /* const char * */
    CLI_INT,     /* int, within minimum..maximum when these differ */
    CLI_DOUBLE,  /* double, finite, within minimum..maximum when these differ */
    CLI_CHOICE,  /* int, index into `choices`, e.g. "fast|medium|thorough" */
    CLI_SIZE,  /* int[2]: "64x48" (width, height), each within minimum..maximum when these differ, else >= 1 */
    CLI_BYTES, /* uint64_t: "512M", "2.5GB", "2GiB", "4096": k, M, G, T are powers of 1000, Ki, Mi, Gi, Ti
                  of 1024, with a B behind or not, in any case */
    CLI_ANGLES,  /* double[2]: "30,120" (theta 0..90, phi -360..360, degrees) */
    CLI_EFFECTS, /* uint32_t: "shadow,shift,hidden,gain,residual", "none" or "all" (btf_effect bits); with
                    choices = "auto" also "auto", which gives UINT32_MAX */
    CLI_CUSTOM,  /* of any type, which `parse` reads */
} cli_type;

typedef struct cli_option {
    char short_name;  /* 'o' for -o; 0 for none */
    const char *name; /* "output" for --output; every option has one */
    const char *arg;  /* name of the argument in --help; NULL takes one that suits the type */
    const char *help; /* one line or more ('\n'), without the final full stop; say the default. NULL: --help
                         leaves the option out, as one that is there to be refused with a reason */
    cli_type type;
    void *value;
    const char *only; /* the --method it belongs to, for the program's own checks; NULL: every one */
    bool *given;      /* set to true when the option is met; may be NULL */
    double minimum, maximum;
    const char *choices;
    /* CLI_CUSTOM: reads `text` into `value`; returns NULL, or what was expected ("a list of numbers") */
    const char *(*parse)(const char *text, void *value);
} cli_option;

typedef struct cli_program {
    const char *name;    /* "btf-info" */
    const char *usage;   /* the arguments in the usage line: "FILE [--json]" */
    const char *summary; /* a sentence or two */
    const char *details; /* paragraphs after the options; may be NULL */
    const char *example; /* one command a line */
    const cli_option *options;
    int min_arguments, max_arguments; /* of those that are no options; max -1: any number */
} cli_program;

typedef struct cli_arguments {
    char **values; /* the arguments that are no options, in order (argv, reordered) */
    int count;
} cli_arguments;

/* Reads the command line: "--name value", "--name=value", "-o value", "-oVALUE"; "--" ends the options; "-"
 * is an argument. --help (-h) and --version are always there. Returns true to go on; false when the tool
 * should end with *out_exit_code (--help, --version: 0; a mistake, told on stderr: 1). Standard streams
 * that are closed are taken first, so that no file becomes one. */
bool cli_parse(const cli_program *program, int argc, char **argv, cli_arguments *out_arguments,
               int *out_exit_code);

/* For CLI_CUSTOM: reads a number at the beginning of `text`, finite, of int's range, without space before
 * it. False unless the end of the text or one of `ends` follows, to which *out_end is set (may be NULL). */
bool cli_parse_double(const char *text, const char *ends, double *out, const char **out_end);
bool cli_parse_int(const char *text, const char *ends, int *out, const char **out_end);

/* For CLI_CUSTOM: reads 1 to `most` numbers with commas between them, each as cli_parse_double does.
 * Returns how many, or 0 when the text is anything else; out is then undefined. */
int cli_parse_doubles(const char *text, double *out, int most);

/* Prints one message on stderr: "NAME: error: ...", "NAME: warning: ...", or of level INFO "NAME: ...".
 * Control characters, which the name of a file may hold, are printed as \xNN: a terminal must not obey
 * them. */
void cli_print(const char *program, btf_log_level level, const char *message);

/* Prints "NAME: error: ..." on stderr and returns `result`. */
btf_result cli_error(const cli_program *program, btf_result result, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* A log that prints on stderr, "NAME: error: ..." or "NAME: warning: ..."; messages of level INFO as they
 * are, left out when `quiet`. `program` must stay. */
btf_log cli_log(const cli_program *program, bool quiet);

/* Flushes stdout and returns the exit code: that of `result`, or of BTF_ERROR_IO when stdout cannot be
 * written. */
int cli_finish(const cli_program *program, btf_result result);

/* The words of a mask of btf_effect bits, "shadow,shift" or "none", in buffer (at least 48 bytes); returns
 * it. */
const char *cli_effects_text(uint32_t effects, char *buffer);

/* The word of effect 1 << i; NULL where there is none. */
enum { CLI_EFFECTS_COUNT = 7 };
const char *cli_effect_word(int i);

#ifdef __cplusplus
}
#endif
#endif
