/* A log that keeps its messages, for tests of messages.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TESTS_MESSAGES_H
#define OPENBTF_TESTS_MESSAGES_H

#include <openbtf/result.h>

void keep_message(void *user, btf_log_level level, const char *message);
extern const btf_log log_keep; /* {keep_message, NULL} */
/* The last message; all since forget_messages(), a line each (level, text); and how many of them are not empty. */
extern char last_message[2048], all_messages[8192];
extern int message_count;
void forget_messages(void);

/* Formats a text in printf style, such as one that a message must hold; valid until the next call. */
const char *told(const char *format, ...) __attribute__((format(printf, 1, 2)));

/* A log that prints messages, for tests that expect none. */
extern const btf_log log_print;

#endif
