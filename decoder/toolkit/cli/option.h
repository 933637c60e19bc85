/* An option of a command line: a row of the table that cli.h reads command lines by.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TOOLS_CLI_OPTION_H
#define OPENBTF_TOOLS_CLI_OPTION_H

#include <stdbool.h>

/* The kind of an option's argument, and the type that `value` points to. */
typedef enum cli_type {
    CLI_END = 0, /* ends the table */
    CLI_FLAG,    /* no argument; bool, set to true */
    CLI_STRING,  /* const char * */
    CLI_INT,     /* int, within minimum..maximum when these differ */
    CLI_DOUBLE,  /* double, finite, within minimum..maximum when these differ */
    CLI_CHOICE,  /* int, index into `choices`, e.g. "fast|medium|thorough" */
    CLI_SIZE, /* int[2]: "64x48" (width, height), each within minimum..maximum when these differ, else >= 1 */
    CLI_BYTES,   /* uint64_t: "512M", "2.5GB", "2GiB", "4096": k, M, G, T are powers of 1000, Ki, Mi, Gi, Ti
                  of 1024, with a B behind or not, in any case */
    CLI_ANGLES,  /* double[2]: "30,120" (theta 0..90, phi -360..360, degrees) */
    CLI_EFFECTS, /* uint32_t: btf_effect bits: "none", "all", or some of "shadow,shift,hidden,gain,residual,relief,
                    gloss"; with choices = "auto" also "auto", which gives UINT32_MAX */
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

#endif
