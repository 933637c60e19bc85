/* A text that grows.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_WGSL_GROWING_H
#define OPENBTF_WGSL_GROWING_H

#include <stddef.h>

#pragma GCC visibility push(hidden)

/* All zeros is an empty one. Once memory runs out, `failed` stays set and nothing more is appended. */
typedef struct btfi_growing {
    char *data; /* 0-terminated, malloc'ed; NULL while nothing was appended */
    size_t length, capacity;
    int failed;
} btfi_growing;

/* Appends `length` characters. */
void btfi_append(btfi_growing *t, const char *data, size_t length);

/* Appends a formatted text of any length. */
void btfi_print(btfi_growing *t, const char *format, ...) __attribute__((format(printf, 2, 3)));

#pragma GCC visibility pop

#endif
