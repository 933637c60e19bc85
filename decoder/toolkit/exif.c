/* Statements of EXIF and XMP. See exif.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "exif.h"

#include <stdbool.h>
#include <string.h>

static unsigned long number(const unsigned char *p, int bytes, bool big) {
    unsigned long value = 0;
    for (int i = 0; i < bytes; i++) {
        value = value << 8 | p[big ? i : bytes - 1 - i];
    }
    return value;
}

/* The value of a tag of type SHORT or LONG in the directory at `at`; 0 where there is none. */
static unsigned long find_tag(const unsigned char *data, size_t size, unsigned long at, unsigned long tag) {
    const bool big = data[0] == 'M';
    if (at < 8 || at > size - 2) {
        return 0;
    }
    const size_t entries = number(data + at, 2, big), room = (size - 2 - at) / 12;
    for (size_t i = 0; i < entries && i < room; i++) {
        const unsigned char *entry = data + at + 2 + 12 * i;
        const unsigned long type = number(entry + 2, 2, big);
        if (number(entry, 2, big) == tag && (type == 3 || type == 4)) {
            return number(entry + 8, type == 3 ? 2 : 4, big);
        }
    }
    return 0;
}

static bool is_exif(const unsigned char *data, size_t size) {
    return size >= 8 && (memcmp(data, "MM\0*", 4) == 0 || memcmp(data, "II*\0", 4) == 0);
}

/* Skips the prefix of JPEG's marker, which some writers leave before PNG's block. */
static void skip_prefix(const unsigned char **data, size_t *size) {
    if (*size >= 6 && memcmp(*data, "Exif\0\0", 6) == 0) {
        *data += 6;
        *size -= 6;
    }
}

bool exif_colour_is_other(const unsigned char *data, size_t size) {
    skip_prefix(&data, &size);
    if (!is_exif(data, size)) {
        return false;
    }
    const bool big = data[0] == 'M';
    const unsigned long directory = find_tag(data, size, number(data + 4, 4, big), 0x8769);
    const unsigned long space = directory ? find_tag(data, size, directory, 0xA001) : 0;
    return space != 0 && space != 1;
}

int exif_orientation(const unsigned char *data, size_t size) {
    skip_prefix(&data, &size);
    if (!is_exif(data, size)) {
        return 1;
    }
    const bool big = data[0] == 'M';
    const unsigned long value = find_tag(data, size, number(data + 4, 4, big), 0x112);
    if (value >= 1 && value <= 8) {
        return (int)value;
    }
    return 1;
}

int xmp_orientation(const unsigned char *data, size_t size) {
    static const char tag[] = "tiff:Orientation";
    const size_t length = sizeof tag - 1;
    for (size_t i = 0; i + length < size; i++) {
        if (memcmp(data + i, tag, length) != 0) {
            continue;
        }
        size_t at = i + length;
        while (at < size && data[at] && strchr(" \t\r\n=\"'>", data[at])) {
            at++;
        }
        if (at < size && data[at] >= '2' && data[at] <= '8') {
            return data[at] - '0';
        }
    }
    return 1;
}
