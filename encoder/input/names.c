/* Reads the light's and the viewer's direction from the names of a BTF's images.
 *
 * SPDX-License-Identifier: MIT
 */
#include "names.h"

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

enum { KEYS = ENC_NAME_KEYS, MAX_DIGITS = 9, MAX_DECIMALS = 15, MAX_EXPONENT = 300 };
static const char keys[KEYS][3] = {"tl", "pl", "tv", "pv"};

/* How far two angles may be apart and still be one value, in degrees. */
static const double same = 1e-3;

/* A stretch of a path. */
typedef struct text {
    const char *p, *end;
} text;

static bool begins(text t, const char *word) {
    const size_t length = strlen(word);
    return (size_t)(t.end - t.p) >= length && strncasecmp(t.p, word, length) == 0;
}

static bool digit_at(text t, size_t offset) {
    return (size_t)(t.end - t.p) > offset && isdigit((unsigned char)t.p[offset]);
}

static size_t separator_length(text t) {
    if (t.p < t.end && strchr(" _-=", *t.p) && *t.p) {
        return 1;
    }
    return begins(t, "\xc2\xa0") ? 2 : 0; /* no-break space */
}

/* The key that a text begins with, or KEYS. */
static int key_of(text t) {
    for (int key = 0; t.end - t.p >= 2 && key < KEYS; key++) {
        if (tolower((unsigned char)t.p[0]) == keys[key][0] &&
            tolower((unsigned char)t.p[1]) == keys[key][1]) {
            return key;
        }
    }
    return KEYS;
}

/* Where a part of a path ends without its extension: ".jpg" is one, ".5" is not. */
static const char *end_without_extension(const char *begin, const char *end) {
    for (const char *p = end; p-- > begin;) {
        if (*p == '.') {
            return p + 1 < end && isalpha((unsigned char)p[1]) ? p : end;
        }
    }
    return end;
}

/* Reads digits, decimals and an exponent without a sign before them: at most MAX_DIGITS before the point,
 * leading zeros aside, and MAX_DECIMALS that count behind it. The locale does not matter. False, with *why,
 * where there are more digits than an angle has; t may then be anywhere. */
static bool read_number(text *t, const char *points, double *out, const char **why) {
    double value = 0.0, scale = 1.0;
    *why = "ten digits before the decimal point are too many for an angle";
    for (int digits = 0; digit_at(*t, 0); t->p++) {
        value = value * 10.0 + (*t->p - '0');
        if (value > 0.0 && digits++ == MAX_DIGITS) {
            return false;
        }
    }
    if (t->p < t->end && *t->p && strchr(points, *t->p) && digit_at(*t, 1)) {
        int digits = 0;
        for (t->p++; digit_at(*t, 0); t->p++) {
            if (digits++ < MAX_DECIMALS) {
                value = value * 10.0 + (*t->p - '0');
                scale *= 10.0;
            }
        }
    }
    value /= scale;
    if (begins(*t, "e-") || begins(*t, "e+")) {
        const bool small = t->p[1] == '-';
        int exponent = 0;
        if (!digit_at(*t, 2)) {
            *why = "the exponent has no digits";
            return false;
        }
        for (t->p += 2; digit_at(*t, 0); t->p++) {
            exponent = exponent < MAX_EXPONENT ? exponent * 10 + (*t->p - '0') : exponent;
        }
        exponent = exponent < MAX_EXPONENT ? exponent : MAX_EXPONENT;
        value = small ? value / pow(10.0, exponent) : value * pow(10.0, exponent);
        *why = "the exponent is too large for an angle";
        if (value >= 1e9) {
            return false;
        }
    }
    *out = value;
    return true;
}

static void skip_unit(text *t) {
    static const char *const units[] = {"degrees", "degree", "deg", "\xc2\xb0", "\xc2\xba", "\xcb\x9a",
                                        "\xb0" /* of Latin 1 */};
    for (size_t i = 0; i < sizeof units / sizeof *units; i++) {
        if (begins(*t, units[i])) {
            t->p += strlen(units[i]);
            return;
        }
    }
}

/* Skips characters after an angle that end it, be they separators or marks such as brackets. */
static void skip_ends(text *t) {
    for (size_t n;; t->p += n) {
        n = separator_length(*t);
        if (n == 0 && (t->p == t->end || !*t->p || !strchr("()[]{}&@#~!$|.,;:+", *t->p))) {
            return;
        }
        n = n > 0 ? n : 1;
    }
}

/* Whether an angle is over at t: what follows cannot be a part of its number. *counter: other digits
 * follow, and no other angle after them. */
static bool is_over(text t, bool *counter, const char **why) {
    *why = NULL;
    if (t.p == t.end || key_of(t) < KEYS) {
        return true;
    }
    text next = t;
    skip_ends(&next);
    if (next.p == t.p) {
        *why = begins(t, "rad") || begins(t, "grad") || begins(t, "gon")
                   ? "angles are read in degrees only"
                   : "the text behind the digits may be a part of the number";
    } else if (digit_at(next, 0)) {
        if (strspn(t.p, ".,;:+") >= (size_t)(next.p - t.p)) {
            *why = "these digits and points are not one number";
        }
        while (digit_at(next, 0)) {
            next.p++;
        }
        skip_ends(&next);
        *counter = true;
        if (!*why && key_of(next) < KEYS) {
            *why = "the digits before the next angle may be decimals";
        }
    }
    return *why == NULL;
}

typedef enum angle_kind { NO_ANGLE, GOOD_ANGLE, BAD_ANGLE } angle_kind;

/* An angle as it stands behind a key. */
typedef struct angle {
    double value;
    bool open_sign, open_point, is_plain, counter;
    bool has_decimals;
    bool like_frame; /* the decimals could be the number of a frame: "30.0105", "30p1" */
    bool is_guess;   /* of a BAD_ANGLE: it may be another word, such as "plm2", so that an angle that can be
                        read outranks it */
    const char *why; /* of a BAD_ANGLE */
} angle;

/* Whether a text begins with a typographic hyphen or dash, of which nobody can say whether it means a
 * minus. */
static bool is_unclear_dash(text t) {
    return t.end - t.p >= 3 && t.p[0] == '\xe2' && t.p[1] == '\x80' && (unsigned char)t.p[2] >= 0x90 &&
           (unsigned char)t.p[2] <= 0x95;
}

/* Whether digits follow something between key and number that may be a sign or a bracket: "plm60",
 * "tl(15)". */
static bool is_unclear_sign(text t, const char **why) {
    static const char *const words[] = {"minus", "neg", "m", "n"};
    const char *const begin = t.p;
    for (size_t i = 0; i < sizeof words / sizeof *words && t.p == begin; i++) {
        if (begins(t, words[i])) {
            t.p += strlen(words[i]);
        }
    }
    if (t.p == begin) {
        while (t.p < t.end && *t.p && strchr("()[]{}&@#~!$|,;:+-'*/", *t.p)) {
            t.p++;
        }
    }
    *why = "the text between key and digits may be a sign";
    return t.p > begin && digit_at(t, 0);
}

/* Judges by the digits after its point whether a number could be a frame's. */
static void judge_decimals(text number, angle *out) {
    const char *point = number.p;
    while (point < number.end && isdigit((unsigned char)*point)) {
        point++;
    }
    const char *end = point + (point < number.end);
    while (end < number.end && isdigit((unsigned char)*end)) {
        end++;
    }
    out->has_decimals = end - point > 1;
    out->like_frame = out->has_decimals && end == number.end &&
                      (*point == 'p' || *point == 'P' || end - point > 3) &&
                      strspn(point + 1, "0") < (size_t)(end - point - 1);
}

/* Reads an angle that follows a key: separators, perhaps a sign, a number. Moves t past it. */
static angle_kind read_angle(text *t, angle *out) {
    const char *const behind_key = t->p;
    *out = (angle){.is_plain = t->p < t->end && *t->p != '-'};
    for (size_t n; (n = separator_length(*t)) > 0;) {
        t->p += n;
    }
    bool negative = t->p - behind_key >= 2 && t->p[-1] == '-';
    out->open_sign = t->p - behind_key == 1 && t->p[-1] == '-';
    if (is_unclear_dash(*t) && digit_at(*t, 3)) {
        out->why = "this dash may be a minus or a separator: write '-' or the minus sign";
        return BAD_ANGLE;
    }
    if (begins(*t, "\xe2\x88\x92") || begins(*t, "\xef\xbc\x8d")) { /* U+2212 and U+FF0D, the minus signs */
        negative = true;
        out->open_sign = false;
        t->p += 3;
    } else if (begins(*t, "+")) {
        out->open_sign = false;
        t->p++;
    }
    if (!digit_at(*t, 0) && !(begins(*t, ".") && digit_at(*t, 1))) {
        return (out->is_guess = is_unclear_sign(*t, &out->why)) ? BAD_ANGLE : NO_ANGLE;
    }
    out->open_point = t->p == behind_key && *t->p == '.';
    const char *const number = t->p;
    if (!read_number(t, ".,pP", &out->value, &out->why)) {
        return BAD_ANGLE;
    }
    judge_decimals((text){number, t->p}, out);
    skip_unit(t);
    if (!is_over(*t, &out->counter, &out->why)) {
        return BAD_ANGLE;
    }
    if (negative) {
        out->value = -out->value;
    }
    return GOOD_ANGLE;
}

/* The keys and angles found in one part of a path. */
typedef struct part {
    bool is_found[KEYS], is_twice[KEYS];
    angle_kind kind[KEYS];
    angle angles[KEYS];
    text where[KEYS]; /* each angle with its key */
} part;

static void scan(const char *begin, const char *end, part *out) {
    const char *behind_angle = begin;
    *out = (part){.is_found = {false}};
    for (const char *p = begin; p + 2 < end;) {
        text t = {p + 2, end};
        angle a;
        const bool is_word = p == behind_angle || !isalpha((unsigned char)p[-1]);
        const int key = is_word ? key_of((text){p, end}) : KEYS;
        const angle_kind kind = key < KEYS ? read_angle(&t, &a) : NO_ANGLE;
        if (kind == NO_ANGLE || (a.is_guess && out->is_found[key])) {
            p++;
            continue;
        }
        if (out->is_found[key] && !out->angles[key].is_guess &&
            (kind != out->kind[key] || a.value != out->angles[key].value)) {
            out->is_twice[key] = true;
        }
        a.like_frame = a.like_frame && t.p == end;
        out->is_found[key] = true;
        out->kind[key] = kind;
        out->angles[key] = a;
        out->where[key] = (text){p, end};
        p = kind == GOOD_ANGLE ? t.p : p + 2;
        behind_angle = p;
    }
}

/* The parts of a path put together, from the last to the first. */
typedef struct collected {
    enc_name *name;
    bool known[KEYS];
    double values[KEYS];
    bool is_twice, like_frame;
    int n_open_points, n_decimals;
} collected;

static void note_bad(enc_name *name, text where, const char *why) {
    size_t length = (size_t)(where.end - where.p);
    if (name->why) {
        return;
    }
    length = length < sizeof name->bad - 1 ? length : sizeof name->bad - 1;
    while (length > 0 && length == sizeof name->bad - 1 &&
           ((unsigned char)where.p[length] & 0xC0) == 0x80) {
        length--; /* keep to whole UTF-8 characters */
    }
    memcpy(name->bad, where.p, length);
    name->bad[length] = '\0';
    name->why = why;
}

/* Takes the angles that are not known yet, and notes whether the others differ. */
static void take(collected *c, const part *from) {
    for (int key = 0; key < KEYS; key++) {
        const angle *a = &from->angles[key];
        if (!from->is_found[key]) {
            continue;
        }
        if (c->known[key]) {
            const double apart = fabs(fabs(a->value) - fabs(c->values[key]));
            if (from->kind[key] == GOOD_ANGLE && !from->is_twice[key] && apart > same) {
                c->name->folders_differ = true;
            }
            continue;
        }
        c->known[key] = true;
        c->values[key] = a->value;
        c->is_twice = c->is_twice || from->is_twice[key];
        c->name->open_sign[key] = a->open_sign;
        c->name->is_plain = c->name->is_plain || a->is_plain;
        c->name->counter = c->name->counter || a->counter;
        c->n_open_points += a->open_point;
        c->n_decimals += a->has_decimals;
        c->like_frame = c->like_frame || a->like_frame;
        if (from->kind[key] == BAD_ANGLE) {
            note_bad(c->name, from->where[key], a->why);
        }
    }
}

enc_name_verdict enc_names_parse(const char *path, enc_name *out_name) {
    collected c = {.name = out_name};
    const char *end = path + strlen(path);
    *out_name = (enc_name){.why = NULL};
    for (bool is_file = true;; is_file = false) {
        part p;
        const char *begin = end;
        while (begin > path && begin[-1] != '/' && begin[-1] != '\\') {
            begin--;
        }
        scan(begin, is_file ? end_without_extension(begin, end) : end, &p);
        take(&c, &p);
        if (begin == path) {
            break;
        }
        end = begin - 1;
    }
    if (c.n_open_points == KEYS) {
        note_bad(out_name, (text){path, path + strlen(path)},
                 "the points behind the keys may be decimal points or separators");
    }
    out_name->like_frame = c.like_frame && c.n_decimals == 1;
    out_name->angles = (enc_angles){c.values[0], c.values[1], c.values[2], c.values[3]};
    if (!(c.known[0] && c.known[1] && c.known[2] && c.known[3]) || c.is_twice) {
        return ENC_NAME_INCOMPLETE;
    }
    return out_name->why ? ENC_NAME_BAD : ENC_NAME_READ;
}

const char *enc_names_key(int key) {
    return keys[key];
}

enc_angles enc_names_angles(const enc_name *name, bool dash_is_minus) {
    enc_angles a = name->angles;
    double *const values[KEYS] = {&a.theta_light, &a.phi_light, &a.theta_view, &a.phi_view};
    for (int key = 0; key < KEYS; key++) {
        if (dash_is_minus && name->open_sign[key]) {
            *values[key] = 0.0 - *values[key]; /* gives no negative zero */
        }
    }
    return a;
}

bool enc_names_number(const char *string, bool comma, double *out) {
    text t = {string, string + strlen(string)};
    const char *why;
    const bool negative = begins(t, "-") || begins(t, "\xe2\x88\x92");
    if (negative) {
        t.p += *t.p == '-' ? 1 : 3;
    } else if (begins(t, "+")) {
        t.p++;
    }
    if ((!digit_at(t, 0) && !(begins(t, ".") && digit_at(t, 1))) ||
        !read_number(&t, comma ? ".," : ".", out, &why)) {
        return false;
    }
    if (begins(t, ".")) {
        t.p++; /* "30." */
    }
    const text behind = t;
    for (size_t n; (n = separator_length(t)) > 0 && *t.p != '-' && *t.p != '_' && *t.p != '=';) {
        t.p += n;
    }
    const char *const unit = t.p;
    skip_unit(&t);
    if (t.p == unit) {
        t = behind;
    }
    *out = negative ? 0.0 - *out : *out;
    return t.p == t.end;
}

static void survey_angle(enc_angle_spread *spread, double angle) {
    const double value = fabs(angle);
    spread->largest = fmax(spread->largest, value);
    if (value > same && fabs(value - round(value)) <= 1e-9) {
        spread->whole++;
    } else if (value > same) {
        spread->broken++;
    }
}

void enc_angles_survey(enc_angle_range *range, const enc_angles *a) {
    survey_angle(&range->theta, a->theta_light);
    survey_angle(&range->theta, a->theta_view);
    survey_angle(&range->phi, a->phi_light);
    survey_angle(&range->phi, a->phi_view);
    range->count++;
    range->beyond += fmax(fabs(a->phi_light), fabs(a->phi_view)) > 360.0 + same;
}

enc_radians enc_angles_look_like_radians(const enc_angle_range *range) {
    const enc_angle_spread *t = &range->theta, *p = &range->phi;
    const double turn = 6.3, right_angle = 1.58; /* just above 2 pi and pi / 2 */
    if (t->largest < turn && p->largest < turn) {
        return t->broken + p->broken > t->whole + p->whole ? ENC_RADIANS_ALL : ENC_RADIANS_NONE;
    }
    if (p->largest < turn && p->broken > p->whole) {
        return ENC_RADIANS_PHI;
    }
    return t->largest < right_angle && t->broken > t->whole ? ENC_RADIANS_THETA : ENC_RADIANS_NONE;
}

bool enc_angles_look_like_indices(const enc_angle_range *range) {
    return range->count > 8 && range->theta.largest < 10.0 && range->theta.broken == 0;
}

/* Whether the extension of a path is in the list (ended by NULL), and nothing in the path is hidden. */
static bool is_visible_with(const char *path, const char *const *extensions) {
    const char *name = path;
    for (const char *slash; (slash = strpbrk(name, "/\\")); name = slash + 1) {
        const size_t length = (size_t)(slash - name);
        const bool here = length == 1 || (length == 2 && name[1] == '.');
        if ((name[0] == '.' && !here) || (length == 8 && memcmp(name, "__MACOSX", 8) == 0)) {
            return false;
        }
    }
    const char *dot = strrchr(name, '.');
    for (; dot && name[0] != '.' && *extensions; extensions++) {
        if (strcasecmp(dot, *extensions) == 0) {
            return true;
        }
    }
    return false;
}

bool enc_names_is_image(const char *path) {
    static const char *const extensions[] = {".jpg", ".jpeg", ".jpe",  ".jfif", ".png",
                                             ".hdr", ".pic",  ".rgbe", ".exr",  NULL};
    return is_visible_with(path, extensions);
}

bool enc_names_is_foreign_image(const char *path) {
    static const char *const extensions[] = {
        ".tif", ".tiff", ".bmp", ".webp", ".gif", ".tga", ".jp2", ".jxl",  ".pfm",  ".ppm",  ".pgm", ".pnm",
        ".dng", ".cr2",  ".cr3", ".nef",  ".arw", ".raw", ".psd", ".heic", ".avif", ".xyze", ".mat", NULL};
    return is_visible_with(path, extensions);
}
