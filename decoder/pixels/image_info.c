/* What an image file says about the meaning of its pixels.
 *
 * SPDX-License-Identifier: MIT
 */
#include "image_info.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

void image_note(image_info *info, image_note_kind kind, const char *format, ...) {
    char *text = info->notes.texts[kind];
    if (text[0])
        return;
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, IMAGE_NOTE_SIZE, format, arguments);
    va_end(arguments);
    for (; *text; text++) /* names from a file stay on one line */
        if ((unsigned char)*text < ' ' || *text == 127)
            *text = '?';
}

void image_info_primaries(image_info *info, const char *source, const primaries *p) {
    char text[160];
    primaries_text(p, text, sizeof text);
    if (primaries_are_rec709(p))
        return;
    info->converts = primaries_to_rec709(p, info->to_rec709);
    if (info->converts)
        snprintf(info->primaries_name, sizeof info->primaries_name, "%.36s %s", source, text);
    else
        image_note(info, IMAGE_NOTE_SPACE, "%s %s span no colour space: taken as Rec. 709", source, text);
}

bool image_note_warns(image_note_kind kind) {
    return kind >= IMAGE_NOTE_PROFILE;
}

void image_notes_log(const image_notes *notes, const char *path, const btf_log *log) {
    for (int k = 0; k < IMAGE_NOTE_KINDS && log && log->callback; k++) {
        char text[IMAGE_NOTE_SIZE + 320];
        if (!notes->texts[k][0])
            continue;
        snprintf(text, sizeof text, "%.300s: %s", path, notes->texts[k]);
        log->callback(log->user, image_note_warns((image_note_kind)k) ? BTF_LOG_WARNING : BTF_LOG_INFO,
                      text);
    }
}

/* Colour profiles. */

static size_t number(const unsigned char *p) {
    return (size_t)p[0] << 24 | (size_t)p[1] << 16 | (size_t)p[2] << 8 | p[3];
}

/* Version 2: counted ASCII; version 4: records of UTF-16, of which the first is taken. */
static void read_text(const unsigned char *tag, size_t size, char *out, size_t out_size) {
    size_t used = 0;
    if (size > 12 && memcmp(tag, "desc", 4) == 0) {
        const size_t count = number(tag + 8);
        for (size_t i = 0; i < count && i < size - 12 && tag[12 + i] && used + 1 < out_size; i++)
            out[used++] = (char)(tag[12 + i] < 127 ? tag[12 + i] : '?');
    } else if (size >= 28 && memcmp(tag, "mluc", 4) == 0 && number(tag + 8) > 0) {
        const size_t length = number(tag + 20), at = number(tag + 24);
        for (size_t i = 0; at < size && i + 1 < length && i + 1 < size - at && used + 1 < out_size; i += 2)
            out[used++] = (char)(tag[at + i] == 0 && tag[at + i + 1] < 127 ? tag[at + i + 1] : '?');
    }
    out[used] = '\0';
}

static void description(const unsigned char *data, size_t size, char *out, size_t out_size) {
    out[0] = '\0';
    if (size < 132)
        return;
    const size_t count = number(data + 128), room = (size - 132) / 12;
    for (size_t i = 0; i < count && i < room; i++) {
        const unsigned char *entry = data + 132 + 12 * i;
        const size_t at = number(entry + 4), length = number(entry + 8);
        if (memcmp(entry, "desc", 4) == 0 && at < size && length <= size - at)
            read_text(data + at, length, out, out_size);
    }
}

/* Whether a text holds a word, in any case. */
static bool holds(const char *text, const char *word) {
    for (; *text; text++)
        if (strncasecmp(text, word, strlen(word)) == 0)
            return true;
    return false;
}

void image_info_profile(image_info *info, const char *format, const unsigned char *data, size_t size,
                        const char *name) {
    char text[80];
    description(data, size, text, sizeof text);
    if (!text[0])
        snprintf(text, sizeof text, "%s", name && name[0] ? name : "without a name");
    if ((holds(text, "sRGB") || holds(text, "61966-2")) && !holds(text, "linear") && !holds(text, "g10")) {
        info->transfer = IMAGE_TRANSFER_SRGB;
        return;
    }
    image_note(info, IMAGE_NOTE_PROFILE,
               "%s: the colour profile \"%s\" is not applied: convert to sRGB, or see --transfer", format,
               text);
}
