/* Keeps the messages of a part of the work for the report, such as those of reading the data.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_MESSAGES_H
#define OPENBTF_ENCODER_MESSAGES_H

#include "decoder/toolkit/json.h"

#include <openbtf/result.h>
#include <stdbool.h>
#include <stddef.h>

typedef struct enc_message {
    btf_log_level level;
    char *text;
} enc_message;

/* Start with all zeros but `next`, which receives every message as well. Warnings and information are kept in the
 * order in which they came; an error ends the encode, and no report is written. */
typedef struct enc_messages {
    btf_log next;
    enc_message *items;
    size_t count;
    bool lost; /* memory ran out, so that messages are missing */
} enc_messages;

/* A log that keeps messages and passes them on. It takes one message at a time, which enc_log() sees to.
 * `messages` has to outlive it. */
btf_log enc_messages_log(enc_messages *messages);

/* Writes the member `key`: an array of objects of level ("warning", "information") and text. */
void enc_messages_json(json *j, const char *key, const enc_messages *messages);

/* Frees the messages. */
void enc_messages_clear(enc_messages *messages);

#endif
