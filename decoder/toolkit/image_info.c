/* What an image file says about the meaning of its pixels.
 *
 * SPDX-License-Identifier: MIT
 */
#include "image_info.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

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

void image_tally_add(image_tally *tally, const image_notes *notes, uint64_t number) {
    for (int k = 0; k < IMAGE_NOTE_KINDS; k++) {
        if (!notes->texts[k][0])
            continue;
        if (tally->kinds[k].images++ == 0) {
            tally->kinds[k].first = number;
            memcpy(tally->kinds[k].text, notes->texts[k], IMAGE_NOTE_SIZE);
        } else if (strcmp(tally->kinds[k].text, notes->texts[k]) != 0) {
            tally->kinds[k].varied = true;
        }
    }
}

void image_tally_merge(image_tally *tally, const image_tally *other) {
    for (int k = 0; k < IMAGE_NOTE_KINDS; k++) {
        if (other->kinds[k].images == 0)
            continue;
        const uint64_t images = tally->kinds[k].images;
        const bool varied = tally->kinds[k].varied || other->kinds[k].varied ||
                            (images > 0 && strcmp(tally->kinds[k].text, other->kinds[k].text) != 0);
        if (images == 0 || other->kinds[k].first < tally->kinds[k].first)
            tally->kinds[k] = other->kinds[k];
        tally->kinds[k].images = images + other->kinds[k].images;
        tally->kinds[k].varied = varied;
    }
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
        log->callback(log->user, image_note_warns((image_note_kind)k) ? BTF_LOG_WARNING : BTF_LOG_INFO, text);
    }
}
