/* Notes on the meaning that an image file gives its pixels. See image_info.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "image_info.h"

#include <ctype.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

void image_note(image_info *info, image_note_kind kind, const char *format, ...) {
    char *text = info->notes.texts[kind];
    if (text[0]) {
        return;
    }
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, IMAGE_NOTE_SIZE, format, arguments);
    va_end(arguments);
    for (; *text; text++) { /* names from a file stay on one line */
        if ((unsigned char)*text < ' ' || *text == 127) {
            *text = '?';
        }
    }
}

void image_info_primaries(image_info *info, const char *source, const primaries *p) {
    char text[160];
    primaries_text(p, text, sizeof text);
    if (primaries_are_rec709(p)) {
        return;
    }
    info->converts = primaries_to_rec709(p, info->to_rec709);
    if (info->converts) {
        snprintf(info->primaries_name, sizeof info->primaries_name, "%.36s %s", source, text);
    } else {
        image_note(info, IMAGE_NOTE_SPACE, "%s %s span no colour space: taken as Rec. 709", source, text);
    }
}

bool image_note_warns(image_note_kind kind) {
    return kind >= IMAGE_NOTE_PROFILE;
}

void image_notes_log(const image_notes *notes, const char *path, const btf_log *log) {
    for (int k = 0; k < IMAGE_NOTE_KINDS && log && log->callback; k++) {
        char text[IMAGE_NOTE_SIZE + 320];
        if (!notes->texts[k][0]) {
            continue;
        }
        snprintf(text, sizeof text, "%.300s: %s", path, notes->texts[k]);
        log->callback(log->user, image_note_warns((image_note_kind)k) ? BTF_LOG_WARNING : BTF_LOG_INFO,
                      text);
    }
}

/* Colour profiles. */

static size_t number(const unsigned char *p) {
    return (size_t)p[0] << 24 | (size_t)p[1] << 16 | (size_t)p[2] << 8 | p[3];
}

/* Reads the text of a tag: counted ASCII in profiles of version 2; in those of version 4 records of UTF-16, of which it
 * takes the first. */
static void read_text(const unsigned char *tag, size_t size, char *out, size_t out_size) {
    size_t used = 0;
    if (size > 12 && memcmp(tag, "desc", 4) == 0) {
        const size_t count = number(tag + 8);
        for (size_t i = 0; i < count && i < size - 12 && tag[12 + i] && used + 1 < out_size; i++) {
            out[used++] = (char)(tag[12 + i] < 127 ? tag[12 + i] : '?');
        }
    } else if (size >= 28 && memcmp(tag, "mluc", 4) == 0 && number(tag + 8) > 0) {
        const size_t length = number(tag + 20), at = number(tag + 24);
        for (size_t i = 0; at < size && i + 1 < length && i + 1 < size - at && used + 1 < out_size;
             i += 2) {
            out[used++] = (char)(tag[at + i] == 0 && tag[at + i + 1] < 127 ? tag[at + i + 1] : '?');
        }
    }
    out[used] = '\0';
}

/* The data of a tag; NULL where the profile has none of that name. */
static const unsigned char *find_tag(const unsigned char *data, size_t size, const char *name,
                                     size_t *out_size) {
    if (size < 132) {
        return NULL;
    }
    const size_t count = number(data + 128), room = (size - 132) / 12;
    for (size_t i = 0; i < count && i < room; i++) {
        const unsigned char *entry = data + 132 + 12 * i;
        const size_t at = number(entry + 4), length = number(entry + 8);
        if (memcmp(entry, name, 4) == 0 && at < size && length <= size - at) {
            *out_size = length;
            return data + at;
        }
    }
    return NULL;
}

static double fixed16(const unsigned char *p) {
    return (double)(int32_t)(uint32_t)number(p) / 65536.0;
}

/* A curve of parametricCurveType at x. */
static bool parametric(const unsigned char *tag, size_t size, double x, double *out) {
    static const size_t counts[] = {1, 3, 4, 5, 7};
    const size_t type = (size_t)tag[8] << 8 | tag[9];
    double p[7] = {1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0}; /* g, a, b, c, d, e, f */
    if (type > 4 || size < 12 + 4 * counts[type]) {
        return false;
    }
    for (size_t i = 0; i < counts[type]; i++) {
        p[i] = fixed16(tag + 12 + 4 * i);
    }
    const double power = pow(fmax(p[1] * x + p[2], 0.0), p[0]);
    if (type < 3) {
        *out = power + (type == 2 ? p[3] : 0.0); /* the points asked for lie above -b / a */
    } else {
        *out = x >= p[4] ? power + (type == 4 ? p[5] : 0.0) : p[3] * x + (type == 4 ? p[6] : 0.0);
    }
    return true;
}

/* Puts x through a tag's curve; false where the tag holds none that is known. */
static bool curve_at(const unsigned char *tag, size_t size, double x, double *out) {
    if (size >= 16 && memcmp(tag, "para", 4) == 0) {
        return parametric(tag, size, x, out);
    }
    if (size < 12 || memcmp(tag, "curv", 4) != 0) {
        return false;
    }
    const size_t count = number(tag + 8);
    if (count > (size - 12) / 2) {
        return false;
    }
    if (count < 2) {
        *out = count ? pow(x, ((size_t)tag[12] << 8 | tag[13]) / 256.0) : x;
        return true;
    }
    const size_t k = (size_t)(x * (double)(count - 1));
    const unsigned char *p = tag + 12 + 2 * k;
    const double t = x * (double)(count - 1) - (double)k;
    *out = ((1.0 - t) * (p[0] << 8 | p[1]) + t * (p[2] << 8 | p[3])) / 65535.0;
    return true;
}

/* Whether a profile's own curves or primaries tell that it is not sRGB, whatever its name. Those of tables
 * tell nothing. */
static bool differs_from_srgb(const unsigned char *data, size_t size) {
    static const char *const curves[] = {"rTRC", "gTRC", "bTRC", "kTRC"};
    static const struct {
        const char *name;
        double xyz[3]; /* under D50, as profiles have it */
    } colours[] = {{"rXYZ", {0.4361, 0.2225, 0.0139}},
                   {"gXYZ", {0.3851, 0.7169, 0.0971}},
                   {"bXYZ", {0.1431, 0.0606, 0.7141}}};
    size_t length;
    double dark, middle;
    for (size_t i = 0; i < sizeof curves / sizeof *curves; i++) {
        const unsigned char *tag = find_tag(data, size, curves[i], &length);
        if (tag && curve_at(tag, length, 0.05, &dark) && curve_at(tag, length, 0.5, &middle) &&
            !(fabs(dark - 0.003936) < 0.001 && fabs(middle - 0.214041) < 0.01)) {
            return true;
        }
    }
    for (size_t i = 0; i < sizeof colours / sizeof *colours; i++) {
        const unsigned char *tag = find_tag(data, size, colours[i].name, &length);
        for (size_t c = 0; c < 3 && tag && length >= 20; c++) {
            if (!(fabs(fixed16(tag + 8 + 4 * c) - colours[i].xyz[c]) < 0.01)) {
                return true;
            }
        }
    }
    return false;
}

/* Whether a text holds a word, in any case, that does not go on before it: "esRGB" and "e-sRGB" are other
 * spaces than "sRGB". */
static bool holds(const char *text, const char *word) {
    for (const char *at = text; *at; at++) {
        if (strncasecmp(at, word, strlen(word)) == 0 &&
            (at == text || !(isalnum((unsigned char)at[-1]) || at[-1] == '-'))) {
            return true;
        }
    }
    return false;
}

static bool names_srgb(const char *text) {
    return (holds(text, "sRGB") || strstr(text, "61966-2.1") || strstr(text, "61966-2-1")) &&
           !strstr(text, "inear") && !strstr(text, "INEAR");
}

void image_info_profile(image_info *info, const char *format, const unsigned char *data, size_t size,
                        const char *name) {
    char text[80];
    size_t length;
    const unsigned char *tag = find_tag(data, size, "desc", &length);
    text[0] = '\0';
    if (tag) {
        read_text(tag, length, text, sizeof text);
    }
    if (!text[0]) {
        snprintf(text, sizeof text, "%s", name && name[0] ? name : "without a name");
    }
    const bool named = names_srgb(text);
    const bool differs = named && differs_from_srgb(data, size);
    if (named && !differs) {
        info->transfer = IMAGE_TRANSFER_SRGB;
        return;
    }
    image_note(info, IMAGE_NOTE_PROFILE,
               "%s: the colour profile \"%s\"%s is not applied: convert the image to sRGB, or give option "
               "transfer",
               format, text, differs ? ", whose curves or primaries are not sRGB's," : "");
}
