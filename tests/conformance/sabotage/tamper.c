/* Shader text that is broken on purpose. See tamper.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "tamper.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

char *tamper_text(const char *text, size_t start, size_t most, const char *from, const char *to) {
    const size_t from_length = strlen(from), to_length = strlen(to);
    size_t places = 0;
    for (const char *p = text + start; places < most && (p = strstr(p, from)) != NULL; p += from_length) {
        places++;
    }
    char *made = places ? malloc(strlen(text) + places * to_length + 1) : NULL;
    if (!made) {
        return NULL;
    }
    char *out = made;
    const char *done = text; /* is copied up to here */
    for (const char *p = text + start; places > 0; places--) {
        p = strstr(p, from);
        memcpy(out, done, (size_t)(p - done));
        out += p - done;
        memcpy(out, to, to_length);
        out += to_length;
        done = p += from_length;
    }
    strcpy(out, done);
    return made;
}

static struct {
    const char *name, *from, *to;
    size_t most;
    char *changed;
    int found;
} test;

void tamper_begin(const char *name, const char *from, const char *to, size_t most) {
    test.name = name;
    test.from = from;
    test.to = to;
    test.most = most;
    test.found = 0;
}

const char *tamper_apply(const char *text, size_t start) {
    char *made = test.name ? tamper_text(text, start, test.most, test.from, test.to) : NULL;
    if (!made) {
        return text;
    }
    free(test.changed);
    test.changed = made;
    test.found = 1;
    return made;
}

int tamper_end(uint64_t different) {
    const char *reason = !test.found      ? "its text is not in the decoder"
                         : different == 0 ? "it is not noticed"
                                          : NULL;
    if (reason) {
        fprintf(stderr, "sabotage \"%s\": %s\n", test.name, reason);
    }
    free(test.changed);
    test.changed = NULL;
    test.name = NULL;
    return reason != NULL;
}
