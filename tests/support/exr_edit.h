/* Takes OpenEXR files apart, changes them and puts them together again, for tests of what a reader refuses and accepts.
 * An unexpected failure ends the process.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TESTS_EXR_EDIT_H
#define OPENBTF_TESTS_EXR_EDIT_H

#include <openexr.h>
#include <stddef.h>
#include <stdint.h>

enum { EDIT_PARTS = 24, EDIT_CHANNELS = 40, EDIT_ATTRIBUTES = 64 };

typedef struct edit_channel {
    char name[40];
    exr_pixel_type_t type;
    uint8_t *data; /* [height][width] of 2 or 4 bytes */
} edit_channel;

typedef struct edit_part {
    char name[40];
    int width, height;
    int min_x, min_y;                  /* of the data window */
    int display_width, display_height; /* of the display window, from (0, 0) */
    exr_compression_t compression;
    exr_lineorder_t order;
    int channel_count;
    edit_channel channels[EDIT_CHANNELS];
} edit_part;

/* An attribute of part 0 of type int, float, string, floatvector, or (as something else) double. */
typedef struct edit_attribute {
    char name[40];
    exr_attribute_type_t type;
    int32_t i;
    float f;
    char *text;
    float *values;
    int count;
} edit_attribute;

typedef struct edit_file {
    int part_count;
    edit_part parts[EDIT_PARTS];
    int attribute_count;
    edit_attribute attributes[EDIT_ATTRIBUTES];
} edit_file;

/* Takes a file in memory apart; attributes are those that begin with "openbtf.". */
edit_file *edit_load(const void *data, size_t size);
/* Puts it together; *out_data to be freed with free. Pixels are taken as they are, whatever their type. */
void edit_save(const edit_file *file, void **out_data, size_t *out_size);
void edit_free(edit_file *file);

edit_attribute *edit_find_attribute(edit_file *file, const char *name);
/* Sets a string attribute. */
void edit_set_text(edit_file *file, const char *name, const char *text);
void edit_remove_attribute(edit_file *file, const char *name);
edit_part *edit_find_part(edit_file *file, const char *name);
edit_channel *edit_find_channel(edit_file *file, const char *part, const char *channel);
/* Adds a copy of a part, or an empty channel of zeros, under a new name. */
void edit_copy_part(edit_file *file, const char *name, const char *new_name);
void edit_add_channel(edit_part *part, const char *name, exr_pixel_type_t type);
void edit_remove_part(edit_file *file, const char *name);
void edit_remove_channel(edit_part *part, const char *name);
/* Gives a part another size; its pixels are cleared. */
void edit_resize(edit_part *part, int width, int height);

#endif
