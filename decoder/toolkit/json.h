/* A small JSON writer: builds an indented text in memory.
 *
 *     json j = {0};
 *     json_object(&j, NULL);
 *     json_string(&j, "name", "bricks");
 *     json_array(&j, "psnr");
 *     json_number(&j, NULL, 31.4);
 *     json_end(&j);
 *     json_end(&j);
 *     const char *text = json_text(&j);
 *     json_free(&j);
 *
 * `key` is the member's name inside an object, NULL inside an array and for the outermost value. Closing or
 * naming wrongly is an assert. Numbers are written independently of the locale.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TOOLS_JSON_H
#define OPENBTF_TOOLS_JSON_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

enum { JSON_MAX_DEPTH = 32 };

/* Start with all zeros. */
typedef struct json {
    char *text;
    size_t length, capacity;
    bool failed; /* out of memory */
    int depth;
    char kind[JSON_MAX_DEPTH];   /* '{' or '[' */
    bool filled[JSON_MAX_DEPTH]; /* holds a member already */
} json;

void json_object(json *j, const char *key);
void json_array(json *j, const char *key);
void json_end(json *j); /* closes the innermost object or array */

/* UTF-8; quotes, backslashes and control characters are escaped, bytes that are no UTF-8 replaced by
 * U+FFFD. NULL writes null. */
void json_string(json *j, const char *key, const char *value);
void json_number(json *j, const char *key,
                 double value); /* shortest text that reads back; NaN, infinite: null */
void json_float(json *j, const char *key, float value); /* the same in single precision */
void json_integer(json *j, const char *key, int64_t value);
void json_bool(json *j, const char *key, bool value);
void json_null(json *j, const char *key);

/* The text with a final newline, owned by j; NULL when out of memory. Everything must be closed. */
const char *json_text(json *j);
void json_free(json *j);

#ifdef __cplusplus
}
#endif
#endif
