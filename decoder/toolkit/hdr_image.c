/* Reading Radiance HDR images (RGBE; G. Ward, "Real Pixels", Graphics Gems II, 1991).
 *
 * SPDX-License-Identifier: MIT
 */
#include "hdr_image.h"

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct cursor {
    const unsigned char *p, *end;
} cursor;

/* Reads a header line of any length, without its end and the blanks before that; text takes as much of its beginning
 * as fits. Returns false at the end of the data. */
static bool read_line(cursor *c, char *text, size_t size) {
    const unsigned char *end = memchr(c->p, '\n', (size_t)(c->end - c->p));
    if (!end) {
        return false;
    }
    size_t length = (size_t)(end - c->p);
    length = length < size - 1 ? length : size - 1;
    memcpy(text, c->p, length);
    c->p = end + 1;
    while (length > 0 &&
           (text[length - 1] == ' ' || text[length - 1] == '\t' || text[length - 1] == '\r')) {
        length--;
    }
    text[length] = '\0';
    return true;
}

/* Reads a new run-length coded scan line, of 4 * width bytes: each component has runs and literals of its own. */
static bool read_new_line(cursor *c, unsigned char *rgbe, int width) {
    for (int component = 0; component < 4; component++) {
        for (int x = 0; x < width;) {
            if (c->end - c->p < 2) {
                return false;
            }
            int count = *c->p++;
            const bool run = count > 128;
            if (run) {
                count -= 128;
            }
            if (count == 0 || count > width - x || c->end - c->p < (run ? 1 : count)) {
                return false;
            }
            for (int i = 0; i < count; i++) {
                rgbe[4 * (x++) + component] = run ? *c->p : c->p[i];
            }
            c->p += run ? 1 : count;
        }
    }
    return true;
}

/* Reads a scan line of flat pixels, in which (1, 1, 1, n) repeats the last pixel n times. Several of these in a row
 * give the digits of the count in base 256, the lowest first. */
static bool read_old_line(cursor *c, unsigned char *rgbe, int width) {
    int shift = 0;
    for (int x = 0; x < width;) {
        if (c->end - c->p < 4) {
            return false;
        }
        if (c->p[0] == 1 && c->p[1] == 1 && c->p[2] == 1) {
            const long count = shift < 24 ? (long)c->p[3] << shift : -1;
            if (x == 0 || count < 0 || count > width - x) {
                return false;
            }
            for (long i = 0; i < count; i++, x++) {
                memcpy(rgbe + 4 * x, rgbe + 4 * (x - 1), 4);
            }
            shift += 8;
        } else {
            memcpy(rgbe + 4 * x++, c->p, 4);
            shift = 0;
        }
        c->p += 4;
    }
    return true;
}

static bool read_scanline(cursor *c, unsigned char *rgbe, int width) {
    if (width >= 8 && width < 32768 && c->end - c->p >= 4 && c->p[0] == 2 && c->p[1] == 2 &&
        ((int)c->p[2] << 8 | c->p[3]) == width) {
        c->p += 4;
        return read_new_line(c, rgbe, width);
    }
    return read_old_line(c, rgbe, width);
}

/* The header, parsed. The image is stored as `lines` lines of `length` pixels, at steps in a picture whose
 * row 0 is at the top. */
typedef struct header {
    int width, height, lines, length;
    int first, line_step, pixel_step; /* pixel numbers */
    bool xyz;
    double scale[3]; /* stored values are multiplied by it */
    int line;        /* the number of the one being read, for messages */
    char text[256];  /* ... and its text */
} header;

/* Reads the `count` numbers of a line "KEY=..." or "KEY =...". Returns false for another key; *out_good says whether
 * the line holds just these numbers. */
static bool read_values(const char *line, const char *key, double *values, int count, bool *out_good) {
    const size_t length = strlen(key);
    if (strncmp(line, key, length) != 0) {
        return false;
    }
    const char *at = line + length + strspn(line + length, " \t");
    if (*at++ != '=') {
        return false;
    }
    *out_good = true;
    for (int i = 0; i < count; i++) {
        char *end;
        values[i] = strtod(at, &end);
        *out_good = *out_good && end != at && isfinite(values[i]);
        at = end;
    }
    at += strspn(at, " \t");
    *out_good = *out_good && *at == '\0';
    return true;
}

/* Takes out of the scale a correction that the writer multiplied in; 0 is taken as 1, as some writers mean it. Returns
 * false where the scale is then of no use. */
static bool undo(double *scale, double value) {
    *scale /= value != 0.0 ? value : 1.0;
    return value >= 0.0 && *scale > 0.0 && isfinite(*scale);
}

/* Reads one line of the header; false where it cannot be used. */
static bool heed_line(header *h, image_info *info) {
    double v[8];
    bool good = true;
    if (strncmp(h->text, "FORMAT=", 7) == 0) {
        const char *format = h->text + 7 + strspn(h->text + 7, " \t");
        h->xyz = strcmp(format, "32-bit_rle_xyze") == 0;
        return h->xyz || strcmp(format, "32-bit_rle_rgbe") == 0;
    }
    if (read_values(h->text, "EXPOSURE", v, 1, &good)) {
        if (good && v[0] == 0.0) {
            image_note(info, IMAGE_NOTE_EXPOSURE, "HDR: EXPOSURE=0 is taken as 1");
        }
        for (int c = 0; c < 3; c++) {
            good = good && undo(&h->scale[c], v[0]);
        }
    } else if (read_values(h->text, "COLORCORR", v, 3, &good)) {
        for (int c = 0; c < 3; c++) {
            good = good && undo(&h->scale[c], v[c]);
        }
    } else if (read_values(h->text, "PRIMARIES", v, 8, &good)) {
        const primaries p = {{v[0], v[1]}, {v[2], v[3]}, {v[4], v[5]}, {v[6], v[7]}};
        if (good) {
            image_info_primaries(info, "HDR PRIMARIES", &p);
        }
    } else if (read_values(h->text, "GAMMA", v, 1, &good)) {
        if (good && v[0] != 1.0) {
            image_note(info, IMAGE_NOTE_GAMMA, "HDR: GAMMA=%g is not applied: values are taken as linear",
                       v[0]);
        }
    } else if (read_values(h->text, "PIXASPECT", v, 1, &good)) {
        if (good && v[0] != 1.0) {
            image_note(info, IMAGE_NOTE_ASPECT,
                       "HDR: PIXASPECT=%g is not applied: pixels are taken as square", v[0]);
        }
    }
    return good;
}

/* The length that a new run-length coded scan line says it has; 0 for any other. */
static int stated_length(const cursor *c) {
    return c->end - c->p >= 4 && c->p[0] == 2 && c->p[1] == 2 && c->p[2] < 128 ? (int)c->p[2] << 8 | c->p[3]
                                                                               : 0;
}

/* ATRIUM's files say "+X W -Y H", which means column after column, but hold rows from the bottom. The length that a
 * scan line states tells the two apart; where both sides are the same, the file is taken for ATRIUM's. */
static bool is_atrium(const header *h, const cursor *c, image_info *info) {
    if (h->width == h->height) {
        image_note(info, IMAGE_NOTE_HEADER,
                   "HDR: \"%.60s\" is read as ATRIUM's files mean it: rows from the bottom", h->text);
    }
    return h->width == h->height || stated_length(c) == h->width;
}

/* Reads the resolution line: which axis is the slower one, and where each one begins. */
static bool heed_resolution(header *h, const cursor *c, image_info *info) {
    char sign[2], axis[2];
    int size[2];
    if (sscanf(h->text, "%c%c %9d %c%c %9d", &sign[0], &axis[0], &size[0], &sign[1], &axis[1], &size[1]) !=
            6 ||
        !strchr("+-", sign[0]) || !strchr("+-", sign[1]) || axis[0] + axis[1] != 'X' + 'Y' ||
        (axis[0] != 'X' && axis[0] != 'Y')) {
        return false;
    }
    bool columns = axis[0] == 'X';
    h->width = size[columns ? 0 : 1];
    h->height = size[columns ? 1 : 0];
    bool right = sign[columns ? 0 : 1] == '+', up = sign[columns ? 1 : 0] == '+';
    if (columns && right && !up && is_atrium(h, c, info)) {
        columns = false;
        up = true;
    }
    const int x = right ? 1 : -1, y = up ? -1 : 1;
    h->lines = columns ? h->width : h->height;
    h->length = columns ? h->height : h->width;
    h->line_step = columns ? x : y; /* in columns and rows; settle_steps() makes pixels of it */
    h->pixel_step = columns ? y : x;
    h->first = (right ? 0 : 1) | (up ? 2 : 0) | (columns ? 4 : 0);
    return true;
}

/* Turns steps in columns and rows into steps in pixels, once the size is known to be usable. */
static void settle_steps(header *h) {
    const bool columns = h->first & 4;
    const int corner = (h->first & 1 ? h->width - 1 : 0) + (h->first & 2 ? (h->height - 1) * h->width : 0);
    *(columns ? &h->pixel_step : &h->line_step) *= h->width;
    h->first = corner;
}

/* Reads up to and including the resolution line. */
static btf_result read_header(cursor *c, size_t max_pixels, header *h, image_info *info, char *message,
                              size_t message_size) {
    for (h->line = 1;; h->line++) {
        if (!read_line(c, h->text, sizeof h->text)) {
            snprintf(message, message_size, "HDR: bad header: it ends within line %d", h->line);
            return BTF_ERROR_BAD_FILE;
        }
        if (h->line > 1 && h->text[0] == '\0') {
            break;
        }
        if (h->line == 1 ? strncmp(h->text, "#?", 2) != 0 : !heed_line(h, info)) {
            snprintf(message, message_size, "HDR: bad header: line %d, \"%.80s\"", h->line, h->text);
            return BTF_ERROR_BAD_FILE;
        }
    }
    h->line++;
    if (!read_line(c, h->text, sizeof h->text)) {
        snprintf(message, message_size, "HDR: bad header: it ends within line %d", h->line);
        return BTF_ERROR_BAD_FILE;
    }
    if (!heed_resolution(h, c, info)) {
        snprintf(message, message_size, "HDR: line %d, resolution \"%.64s\", is not of the form -Y H +X W",
                 h->line, h->text);
        return BTF_ERROR_UNSUPPORTED;
    }
    if (h->width < 1 || h->height < 1 || (size_t)h->width > max_pixels / (size_t)h->height ||
        (size_t)h->width > (size_t)INT32_MAX / (size_t)h->height) {
        snprintf(message, message_size, "HDR: size %dx%d is not usable", h->width, h->height);
        return BTF_ERROR_UNSUPPORTED;
    }
    settle_steps(h);
    if (h->scale[0] != 1.0 || h->scale[1] != 1.0 || h->scale[2] != 1.0) {
        image_note(info, IMAGE_NOTE_EXPOSURE, "HDR: divided by EXPOSURE and COLORCORR, in all %g, %g, %g",
                   1.0 / h->scale[0], 1.0 / h->scale[1], 1.0 / h->scale[2]);
    }
    return BTF_OK;
}

btf_result hdr_image_read(const void *data, size_t size, size_t max_pixels, int *out_width, int *out_height,
                          bool *out_xyz, float **out_pixels, image_info *info, char *message,
                          size_t message_size) {
    cursor c = {data, (const unsigned char *)data + size};
    header h = {.scale = {1.0, 1.0, 1.0}};
    btf_result result = read_header(&c, max_pixels, &h, info, message, message_size);
    if (result != BTF_OK) {
        return result;
    }
    unsigned char *rgbe = malloc((size_t)h.length * 4);
    float *pixels = malloc((size_t)h.width * (size_t)h.height * 3 * sizeof *pixels);
    result = rgbe && pixels ? BTF_OK : BTF_ERROR_MEMORY;
    for (int line = 0; line < h.lines && result == BTF_OK; line++) {
        if (!read_scanline(&c, rgbe, h.length)) {
            snprintf(message, message_size, "HDR: the file is cut short or damaged in scan line %d of %d",
                     line, h.lines);
            result = BTF_ERROR_BAD_FILE;
            break;
        }
        for (int i = 0; i < h.length; i++) {
            float *out =
                pixels + 3 * (h.first + (ptrdiff_t)line * h.line_step + (ptrdiff_t)i * h.pixel_step);
            const double unit = rgbe[4 * i + 3] ? ldexp(1.0, rgbe[4 * i + 3] - (128 + 8)) : 0.0;
            for (int channel = 0; channel < 3; channel++) {
                out[channel] = (float)(rgbe[4 * i + channel] * (unit * h.scale[channel]));
            }
        }
    }
    free(rgbe);
    if (result == BTF_OK) {
        *out_width = h.width;
        *out_height = h.height;
        *out_xyz = h.xyz;
        *out_pixels = pixels;
        if (h.xyz) {
            info->converts = false; /* the primaries are X, Y, Z themselves */
        }
    } else {
        free(pixels);
    }
    return result;
}
