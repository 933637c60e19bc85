/* Options that every tool which decodes has in the same words: members of a cli_option, beside which stand .value and, where
 * it is wanted, .given.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TOOLKIT_DECODE_OPTIONS_H
#define OPENBTF_TOOLKIT_DECODE_OPTIONS_H

#include "cli.h"

#include <openbtf/material.h>

/* An int from 0 to BTF_MAX_COMPONENTS; to the library 0 means all, to these tools none. */
#define COMPONENTS_OPTION                                                                                  \
    .name = "components", .type = CLI_INT, .minimum = 0, .maximum = BTF_MAX_COMPONENTS,                    \
    .help = "components of the residual to decode, or units where it is factors, as btf-info\n"            \
            "lists them (default all)"

/* An int, by value of btf_interpolation. */
#define INTERPOLATION_OPTION                                                                               \
    .name = "interpolation", .type = CLI_CHOICE, .choices = "linear|nearest",                              \
    .help = "between sampled directions (default linear)"

#endif
