/* What the names of a BTF's images say: the light's and the viewer's direction.
 *
 * SPDX-License-Identifier: MIT
 */
#include "names.h"

#include <ctype.h>
#include <stddef.h>
#include <string.h>
#include <strings.h>

enum { KEYS = 4, MAX_DIGITS = 9 };
static const char keys[KEYS][2] = {{'t', 'l'}, {'p', 'l'}, {'t', 'v'}, {'p', 'v'}};

static bool is_separator(char c) {
    return c == ' ' || c == '_' || c == '-' || c == '=';
}

/* Where a part of a path ends when its extension is left away: ".jpg" is one, ".5" is not. */
static const char *end_without_extension(const char *begin, const char *end) {
    for (const char *p = end; p-- > begin;)
        if (*p == '.')
            return p + 1 < end && isalpha((unsigned char)p[1]) ? p : end;
    return end;
}

/* Reads digits[.digits] at *p: at most MAX_DIGITS before the point, leading zeros aside, and as many that
 * count behind it. No locale has a say. */
static bool read_number(const char **p, const char *end, double *out) {
    const char *s = *p;
    if (s == end || !isdigit((unsigned char)*s))
        return false;
    double value = 0.0, divisor = 1.0;
    for (int digits = 0; s < end && isdigit((unsigned char)*s); s++) {
        value = value * 10.0 + (*s - '0');
        if (value > 0.0 && digits++ == MAX_DIGITS)
            return false;
    }
    if (s + 1 < end && *s == '.' && isdigit((unsigned char)s[1])) {
        int digits = 0;
        for (s++; s < end && isdigit((unsigned char)*s); s++) {
            if (digits++ < MAX_DIGITS) {
                value = value * 10.0 + (*s - '0');
                divisor *= 10.0;
            }
        }
    }
    *out = value / divisor;
    *p = s;
    return true;
}

/* Reads an angle that follows a key: separators, a sign perhaps, a number. */
static bool read_angle(const char **p, const char *end, double *out) {
    const char *s = *p;
    while (s < end && is_separator(*s))
        s++;
    const bool negative = s - *p >= 2 && s[-1] == '-';
    if (!read_number(&s, end, out))
        return false;
    if (negative)
        *out = -*out;
    *p = s;
    return true;
}

/* Scans one part of a path for keys that are not known yet. Returns false on two values for one key. */
static bool scan(const char *begin, const char *end, double values[KEYS], bool known[KEYS]) {
    double found[KEYS];
    bool is_found[KEYS] = {false};
    for (const char *p = begin; p + 2 < end;) {
        const char *after = p + 2;
        double angle = 0.0;
        int key = KEYS;
        if (p == begin || !isalpha((unsigned char)p[-1]))
            for (key = 0; key < KEYS; key++)
                if (tolower((unsigned char)p[0]) == keys[key][0] &&
                    tolower((unsigned char)p[1]) == keys[key][1])
                    break;
        if (key == KEYS || !read_angle(&after, end, &angle)) {
            p++;
            continue;
        }
        if (is_found[key] && found[key] != angle)
            return false;
        is_found[key] = true;
        found[key] = angle;
        p = after;
    }
    for (int key = 0; key < KEYS; key++) {
        if (is_found[key] && !known[key]) {
            known[key] = true;
            values[key] = found[key];
        }
    }
    return true;
}

bool enc_names_parse(const char *path, enc_angles *out_angles) {
    double values[KEYS] = {0.0};
    bool known[KEYS] = {false};
    const char *end = path + strlen(path);
    bool is_file = true;
    while (!(known[0] && known[1] && known[2] && known[3])) {
        const char *begin = end;
        while (begin > path && begin[-1] != '/')
            begin--;
        if (!scan(begin, is_file ? end_without_extension(begin, end) : end, values, known))
            return false;
        if (begin == path)
            break;
        end = begin - 1;
        is_file = false;
    }
    *out_angles = (enc_angles){values[0], values[1], values[2], values[3]};
    return known[0] && known[1] && known[2] && known[3];
}

bool enc_names_is_image(const char *path) {
    static const char *const extensions[] = {".jpg", ".jpeg", ".jpe",  ".png",
                                             ".hdr", ".pic",  ".rgbe", ".exr"};
    const char *slash = strrchr(path, '/');
    const char *name = slash ? slash + 1 : path;
    const char *dot = strrchr(name, '.');
    if (!dot || name[0] == '.')
        return false;
    for (size_t i = 0; i < sizeof extensions / sizeof *extensions; i++)
        if (strcasecmp(dot, extensions[i]) == 0)
            return true;
    return false;
}
