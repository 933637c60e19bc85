/* Writes OpenEXR files byte by byte: channels of any sampling, in layers and parts, with any attribute, as the format
 * allows or forbids. An unexpected failure ends the process.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TESTS_EXR_BYTES_H
#define OPENBTF_TESTS_EXR_BYTES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { BYTES_CHANNELS = 4100, BYTES_ATTRIBUTES = 4, BYTES_HALF = 1, BYTES_FLOAT = 2 };

typedef struct bytes_channel {
    const char *name;
    int type; /* BYTES_HALF, BYTES_FLOAT, 0: unsigned */
    int32_t xs, ys;
} bytes_channel;

typedef struct bytes_attribute {
    const char *name, *type;
    const void *value;
    size_t size;
} bytes_attribute;

typedef struct bytes_part {
    const char *name; /* NULL in a file of one part */
    bool deep;        /* the header says so; the pixels are those of a flat part */
    int compression;  /* OpenEXR's number; the blocks are stored plain, as blocks that do not shrink are */
    int x, y, width, height;
    int display[4]; /* corner and size of the display window; all 0: the data window */
    float aspect;   /* 0: 1 */
    int channel_count;
    bytes_channel channels[BYTES_CHANNELS]; /* by name, as the format wants them */
    int attribute_count;
    bytes_attribute attributes[BYTES_ATTRIBUTES];
    /* The sample of channel c at column x, row y of the data window. */
    float (*value)(int c, int x, int y);
} bytes_part;

/* The file of some parts; *out_size bytes, to be freed with free. */
void *exr_bytes(const bytes_part *parts, int count, size_t *out_size);

/* Writes one part that the format allows, compressed by OpenEXRCore; its packing of channels is replaced by ours. */
void exr_bytes_compressed(const char *path, const bytes_part *part);

#endif
