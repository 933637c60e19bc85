/* OpenBTF: reads a cost model, a JSON object of numbers and strings. See openbtf/cost.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "decoder/result.h"

#include <openbtf/cost.h>

#include <errno.h>
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_BYTES = 65536, VERSION = 1, MOST_WORD = 40 };
static const double dearest = 1e6;

/* The keys: the prices, then the others. */
#define NAME(price, name, count) name,
static const char *const keys[] = {BTF_COST_LIST(NAME) "openbtf_costs", "device", "deviation", "variants"};
#undef NAME
enum { KEYS = sizeof keys / sizeof *keys, PRICES = KEYS - 4, KEY_VERSION = PRICES, KEY_DEVICE };

typedef struct reader {
    const char *text, *at, *end, *name;
    const btf_log *log;
    btf_cost_model *model;
    bool seen[KEYS];
} reader;

/* The price of that number. */
static double *price_of(btf_cost_model *m, int key) {
#define ADDRESS(price, name, count) &m->price,
    double *const prices[PRICES] = {BTF_COST_LIST(ADDRESS)};
#undef ADDRESS
    return prices[key];
}

static void skip_space(reader *r) {
    while (r->at < r->end && memchr(" \t\r\n", *r->at, 4)) {
        r->at++;
    }
}

/* Skips white space; takes the next character if it is c. */
static bool take(reader *r, char c) {
    skip_space(r);
    if (r->at == r->end || *r->at != c) {
        return false;
    }
    r->at++;
    return true;
}

static btf_result expected(const reader *r, const char *what) {
    return btfi_fail(r->log, BTF_ERROR_BAD_FILE, "%s: byte %zu: expected %s", r->name,
                     (size_t)(r->at - r->text), what);
}

/* The byte that an escape stands for, '?' for a character beyond ASCII; 0 for an escape that JSON does not have. */
static char read_escape(reader *r) {
    static const char names[] = "\"\\/bfnrt", bytes[] = "\"\\/\b\f\n\r\t";
    if (r->at == r->end) {
        return 0;
    }
    const char c = *r->at++;
    if (c == 'u') {
        unsigned code = 0;
        for (int i = 0; i < 4; i++, r->at++) {
            static const char digits[] = "0123456789abcdef0123456789ABCDEF";
            const char *digit = r->at < r->end && *r->at ? strchr(digits, *r->at) : NULL;
            if (!digit) {
                return 0;
            }
            code = 16 * code + (unsigned)(digit - digits) % 16;
        }
        return code >= 0x20 && code < 0x7F ? (char)code : '?';
    }
    const char *found = c ? strchr(names, c) : NULL;
    return found ? bytes[found - names] : 0;
}

/* Reads a string, cut off where `out` is full. */
static btf_result read_string(reader *r, const char *what, char *out, size_t size) {
    size_t length = 0;
    if (!take(r, '"')) {
        return expected(r, what);
    }
    while (r->at < r->end && *r->at != '"') {
        char c = *r->at++;
        if ((unsigned char)c < 0x20) {
            return expected(r, "no control character in a string");
        }
        if (c == '\\' && !(c = read_escape(r))) {
            return expected(r, "an escape of JSON");
        }
        if (length + 1 < size) {
            out[length++] = c;
        }
    }
    out[length] = 0;
    return take(r, '"') ? BTF_OK : expected(r, "\" at the end of a string");
}

static int count_digits(reader *r, double *value) {
    int count = 0;
    for (; r->at < r->end && *r->at >= '0' && *r->at <= '9'; r->at++, count++) {
        *value = 10 * *value + (*r->at - '0');
    }
    return count;
}

/* Reads a number, whatever the locale. Where it has more digits than a double holds, the last bits may differ from
 * those of the nearest double. */
static bool read_number(reader *r, double *out) {
    double value = 0, power = 0;
    int decimals = 0;
    skip_space(r);
    const bool negative = take(r, '-'), zero = r->at < r->end && *r->at == '0';
    const int digits = count_digits(r, &value);
    if (digits == 0 || (zero && digits > 1)) {
        return false;
    }
    if (r->at < r->end && *r->at == '.') {
        r->at++;
        if ((decimals = count_digits(r, &value)) == 0) {
            return false;
        }
    }
    if (r->at < r->end && (*r->at == 'e' || *r->at == 'E')) {
        r->at++;
        const bool down = r->at < r->end && *r->at == '-';
        r->at += r->at < r->end && (*r->at == '-' || *r->at == '+');
        if (count_digits(r, &power) == 0) {
            return false;
        }
        power = down ? -power : power;
    }
    const double exponent = power - decimals, magnitude = value == 0 ? 1 : pow(10, fabs(exponent));
    value = exponent < 0 ? value / magnitude
                         : value * magnitude; /* a power of 10 up to 10^22 is exact, its inverse is not */
    *out = negative ? -value : value;
    return true;
}

/* The value as the file writes it, for messages. */
static const char *word_at(const reader *r, const char *from, char out[MOST_WORD + 1]) {
    size_t length = 0;
    while (from < r->end && memchr(" \t\r\n", *from, 4)) {
        from++;
    }
    while (from + length < r->end && length < MOST_WORD && (unsigned char)from[length] > 0x20 &&
           !strchr(",{}[]", from[length])) {
        length++;
    }
    memcpy(out, from, length);
    out[length] = 0;
    return length > 0 ? out : "nothing";
}

static btf_result read_value(reader *r, int key) {
    char word[MOST_WORD + 1];
    double value;
    if (key == KEY_DEVICE) {
        return read_string(r, "a string after \"device\"", r->model->device, sizeof r->model->device);
    }
    const char *from = r->at;
    const bool is_number = read_number(r, &value);
    skip_space(r);
    if (is_number && r->at < r->end && *r->at != ',' && *r->at != '}' && strchr(" \t\r\n", r->at[-1])) {
        return expected(r, ", or }");
    }
    if (!is_number || (r->at < r->end && *r->at != ',' && *r->at != '}')) {
        return btfi_fail(r->log, BTF_ERROR_BAD_FILE, "%s: %s is %s, not a number", r->name, keys[key],
                         word_at(r, from, word));
    }
    if (key == KEY_VERSION && value != VERSION) {
        return btfi_fail(r->log, BTF_ERROR_BAD_FILE, "%s: openbtf_costs is %s; this library reads %d",
                         r->name, word_at(r, from, word), VERSION);
    }
    if (!(value >= 0 && value <= dearest)) {
        return btfi_fail(r->log, BTF_ERROR_BAD_FILE, "%s: %s is %s, not within 0 to %g", r->name, keys[key],
                         word_at(r, from, word), dearest);
    }
    if (key < PRICES) {
        *price_of(r->model, key) = value;
    }
    return BTF_OK;
}

static btf_result read_member(reader *r) {
    char name[MOST_WORD + 1];
    btf_result result = read_string(r, "a key in quotes", name, sizeof name);
    if (result) {
        return result;
    }
    int key = 0;
    while (key < KEYS && strcmp(name, keys[key]) != 0) {
        key++;
    }
    if (key == KEYS) {
        return btfi_fail(r->log, BTF_ERROR_BAD_FILE, "%s: unknown key \"%s\"", r->name, name);
    }
    if (r->seen[key]) {
        return btfi_fail(r->log, BTF_ERROR_BAD_FILE, "%s: %s is there twice", r->name, name);
    }
    r->seen[key] = true;
    if (!take(r, ':')) {
        return expected(r, "a colon");
    }
    return read_value(r, key);
}

static btf_result read_object(reader *r) {
    btf_result result;
    if (!take(r, '{')) {
        return expected(r, "{, the start of a cost model");
    }
    do {
        if ((result = read_member(r))) {
            return result;
        }
    } while (take(r, ','));
    if (!take(r, '}')) {
        return expected(r, ", or }");
    }
    skip_space(r);
    return r->at == r->end ? BTF_OK : expected(r, "the end of the file");
}

btf_result btf_cost_model_read(const char *text, size_t size, const char *name, const btf_log *log,
                               btf_cost_model *out_model) {
    btf_cost_model model = {.struct_size = sizeof model};
    reader r = {text, text, text + size, name, log, &model, {false}};
    double sum = 0;
    if (size > MOST_BYTES) {
        return btfi_fail(log, BTF_ERROR_BAD_FILE, "%s: %zu bytes; a cost model has %d at most", name, size,
                         MOST_BYTES);
    }
    const btf_result result = read_object(&r);
    if (result) {
        return result;
    }
    for (int key = 0; key <= KEY_VERSION; key++) {
        if (!r.seen[key]) {
            return btfi_fail(log, BTF_ERROR_BAD_FILE, "%s: %s is missing", name, keys[key]);
        }
    }
    for (int i = 0; i < PRICES; i++) {
        sum += *price_of(&model, i);
    }
    if (sum == 0) {
        return btfi_fail(log, BTF_ERROR_BAD_FILE, "%s: every price is 0", name);
    }
    *out_model = model;
    return BTF_OK;
}

btf_result btf_cost_model_open(const char *path, const btf_log *log, btf_cost_model *out_model) {
    FILE *file = fopen(path, "rb");
    if (!file) {
        return btfi_fail(log, BTF_ERROR_IO, "%s: %s", path, strerror(errno));
    }
    char *text = malloc(MOST_BYTES + 1);
    const size_t size = text ? fread(text, 1, MOST_BYTES + 1, file) : 0;
    const int error = ferror(file) ? errno : 0;
    fclose(file);
    btf_result result = !text   ? btfi_fail(log, BTF_ERROR_MEMORY, "%s: out of memory", path)
                        : error ? btfi_fail(log, BTF_ERROR_IO, "%s: %s", path, strerror(error))
                                : btf_cost_model_read(text, size, path, log, out_model);
    free(text);
    return result;
}
