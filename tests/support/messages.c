/* Logs of tests. See messages.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "messages.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

char last_message[2048], all_messages[8192];
int message_count;

void keep_message(void *user, btf_log_level level, const char *message) {
    (void)user;
    const size_t used = strlen(all_messages);
    snprintf(all_messages + used, sizeof all_messages - used, "%d: %s\n", (int)level, message);
    snprintf(last_message, sizeof last_message, "%s", message);
    message_count += message[0] != 0;
}
const btf_log log_keep = {keep_message, NULL};

void forget_messages(void) {
    last_message[0] = all_messages[0] = '\0';
    message_count = 0;
}

const char *told(const char *format, ...) {
    static char text[512];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    return text;
}

static void print(void *user, btf_log_level level, const char *message) {
    (void)user;
    (void)level;
    fprintf(stderr, "%s\n", message);
}
const btf_log log_print = {print, NULL};
