/* Values of options: numbers, choices, sizes, effects, from the text of a command line.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TOOLS_CLI_VALUES_H
#define OPENBTF_TOOLS_CLI_VALUES_H

#include "option.h"

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The kind of argument that an option takes, in words for messages. */
typedef struct cli_wanted {
    char text[200];
} cli_wanted;

/* Reads `text` into option->value by the option's type, which is neither CLI_FLAG nor CLI_END. Returns false,
 * and leaves the value, when the text is not what *out_wanted says. */
bool cli_read_value(const cli_option *option, const char *text, cli_wanted *out_wanted);

/* For CLI_CUSTOM: reads a number at the beginning of `text`, finite, of int's range, without space before it. Returns
 * false unless the end of the text or one of the characters in `ends` follows; *out_end (may be NULL) then points
 * there. */
bool cli_parse_double(const char *text, const char *ends, double *out, const char **out_end);
bool cli_parse_int(const char *text, const char *ends, int *out, const char **out_end);

/* For CLI_CUSTOM: reads 1 to `most` numbers with commas between them, each as cli_parse_double does.
 * Returns how many, or 0 when the text is anything else; out is then undefined. */
int cli_parse_doubles(const char *text, double *out, int most);

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
