/* A text that grows.
 *
 * SPDX-License-Identifier: MIT
 */
#include "growing.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Room for so many characters more and the 0 behind them. */
static int reserve(btfi_growing *t, size_t length) {
    if (t->failed) {
        return 0;
    }
    if (length >= t->capacity - t->length) {
        size_t capacity = 2 * (t->length + length) + 256;
        char *grown = realloc(t->data, capacity);
        if (!grown) {
            t->failed = 1;
            return 0;
        }
        t->data = grown;
        t->capacity = capacity;
    }
    return 1;
}

void btfi_append(btfi_growing *t, const char *data, size_t length) {
    if (reserve(t, length)) {
        memcpy(t->data + t->length, data, length);
        t->length += length;
        t->data[t->length] = 0;
    }
}

void btfi_print(btfi_growing *t, const char *format, ...) {
    va_list arguments, again;
    va_start(arguments, format);
    va_copy(again, arguments);
    int length = vsnprintf(NULL, 0, format, arguments);
    if (length < 0) {
        t->failed = 1;
    } else if (reserve(t, (size_t)length)) {
        vsnprintf(t->data + t->length, (size_t)length + 1, format, again);
        t->length += (size_t)length;
    }
    va_end(again);
    va_end(arguments);
}
