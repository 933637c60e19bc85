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

int tamper_missed(const char *name, int found, uint64_t different) {
    if (!found) {
        fprintf(stderr, "sabotage \"%s\": its text is not in the decoder\n", name);
    } else if (different == 0) {
        fprintf(stderr, "sabotage \"%s\" is not caught\n", name);
    }
    return !found || different == 0;
}
