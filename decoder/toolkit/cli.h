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
 *     static btf_result run(const cli_arguments *arguments) { ... }
 *     int main(int argc, char **argv) {
 *         return cli_run(&program, argc, argv, run);
 *     }
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TOOLS_CLI_H
#define OPENBTF_TOOLS_CLI_H

#include "decoder/toolkit/cli/option.h"
#include "decoder/toolkit/cli/values.h"

#include <openbtf/result.h>
#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct cli_program {
    const char *name;    /* "btf-info" */
    const char *usage;   /* the arguments in the usage line: "FILE [--json]" */
    const char *summary; /* a sentence or two */
    const char *details; /* paragraphs after the options; may be NULL */
    const char *example; /* one command a line */
    const cli_option *options;
    int min_arguments, max_arguments; /* numbers of arguments that are no options; maximum -1: any number */
} cli_program;

typedef struct cli_arguments {
    char **values; /* the arguments that are no options, in order (argv, reordered) */
    int count;
} cli_arguments;

/* Reads the command line: "--name value", "--name=value", "-o value", "-oVALUE"; "--" ends the options; "-" is an
 * argument. --help (-h) and --version are always there. Returns true to go on; false when the tool should end with
 * *out_exit_code (--help, --version: 0; a mistake, told on stderr: 1). First opens /dev/null in place of standard
 * streams that are closed, so that no file takes their place. */
bool cli_parse(const cli_program *program, int argc, char **argv, cli_arguments *out_arguments,
               int *out_exit_code);

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

/* A whole tool: reads the command line as cli_parse() does, calls `run` with the arguments that are no options,
 * and returns the exit code of its result as cli_finish() does. */
int cli_run(const cli_program *program, int argc, char **argv,
            btf_result (*run)(const cli_arguments *arguments));

#ifdef __cplusplus
}
#endif
#endif
