/* Options that several tools which decode have in the same words: members of a cli_option, to which each tool adds
 * .value and, where it is wanted, .given.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TOOLKIT_DECODE_OPTIONS_H
#define OPENBTF_TOOLKIT_DECODE_OPTIONS_H

#include "cli.h"
#include "filter.h"

#include <openbtf/material.h>

/* An int from 0 to BTF_MAX_COMPONENTS. 0 means all components to the library, but none to these tools. */
#define COMPONENTS_OPTION                                                                                  \
    .name = "components", .type = CLI_INT, .minimum = 0, .maximum = BTF_MAX_COMPONENTS,                    \
    .help = "components of the residual to decode, or units where it is factors, as btf-info\n"            \
            "lists them (default all)"

/* An int, by value of btf_interpolation. */
#define INTERPOLATION_OPTION                                                                               \
    .name = "interpolation", .type = CLI_CHOICE, .choices = "linear|nearest",                              \
    .help = "between sampled directions (default linear)"

/* A uint32_t of btf_effect bits. */
#define EFFECTS_OPTION                                                                                     \
    .name = "effects", .type = CLI_EFFECTS, .help = "effects to decode (default: all that the file holds)"

/* An int, by value of btf_filter. */
#define FILTER_OPTION                                                                                      \
    .name = "filter", .type = CLI_CHOICE, .choices = FILTER_CHOICES,                                       \
    .help = "between texels (default texel); steep: bilinear, but a texel keeps its\n"                     \
            "middle half to itself"

/* An int, by value of btf_math. */
#define MATH_OPTION                                                                                        \
    .name = "math", .type = CLI_CHOICE, .choices = "exact|fast",                                           \
    .help = "exact: the same bits on every device (default); fast: the device's own functions"

/* A bool. */
#define QUIET_OPTION                                                                                       \
    .short_name = 'q', .name = "quiet", .type = CLI_FLAG,                                                  \
    .help = "no progress, no information; warnings stay"

#endif
