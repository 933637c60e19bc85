/* Messages that the report keeps. See messages.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "messages.h"

#include <stdlib.h>
#include <string.h>

static void keep(void *user, btf_log_level level, const char *text) {
    enc_messages *m = user;
    if (m->next.callback) {
        m->next.callback(m->next.user, level, text);
    }
    if (level != BTF_LOG_WARNING && level != BTF_LOG_INFO) {
        return;
    }
    enc_message *items = realloc(m->items, (m->count + 1) * sizeof *items);
    char *copy = items ? strdup(text) : NULL;
    if (items) {
        m->items = items;
    }
    if (copy) {
        m->items[m->count++] = (enc_message){level, copy};
    }
    m->lost = m->lost || !copy;
}

btf_log enc_messages_log(enc_messages *messages) {
    return (btf_log){keep, messages};
}

void enc_messages_json(json *j, const char *key, const enc_messages *messages) {
    json_array(j, key);
    for (size_t i = 0; i < messages->count; i++) {
        json_object(j, NULL);
        json_string(j, "level", messages->items[i].level == BTF_LOG_WARNING ? "warning" : "information");
        json_string(j, "text", messages->items[i].text);
        json_end(j);
    }
    json_end(j);
    j->failed = j->failed || messages->lost;
}

void enc_messages_clear(enc_messages *messages) {
    for (size_t i = 0; i < messages->count; i++) {
        free(messages->items[i].text);
    }
    free(messages->items);
    messages->items = NULL;
    messages->count = 0;
}
