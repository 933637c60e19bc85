/* OpenBTF: how textures lie in the parts of a file (FORMAT.md sections 2 to 4); reader and writer share it.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_PARTS_H
#define OPENBTF_PARTS_H

#include "shape.h"

#pragma GCC visibility push(hidden)

enum {
    BTFI_MAX_PARTS = 9 + 6 * (BTF_MAX_LEVELS - 1), /* layout tight; `paper` has 4 */
    BTFI_MAX_CHANNELS = 3 + 7 * BTF_MAX_LOBES,
};

/* How a channel's values are stored. */
typedef enum btfi_storage {
    BTFI_STORAGE_UINT8, /* HALF in the file, 0..255 */
    BTFI_STORAGE_INT8,  /* HALF in the file, -127..127 */
    BTFI_STORAGE_HALF,
    BTFI_STORAGE_FLOAT,
    BTFI_STORAGE_UINT32,
} btfi_storage;

/* A channel, and the layer and component of the texture that it fills (in a contact sheet, `layer` is not
 * used). */
typedef struct btfi_channel {
    char name[20];
    uint16_t layer, component;
} btfi_channel;

/* One part and its texture. */
typedef struct btfi_part {
    btfi_name name;
    uint32_t level;
    btf_texture_id id;
    btf_texture shape;
    btfi_storage storage;
    uint32_t width, height; /* of the part's image */
    uint32_t columns;       /* of the contact sheet; 1 when it is none */
    uint32_t layers;        /* in the contact sheet; 1 when it is none */
    int channel_count;
    btfi_channel channels[BTFI_MAX_CHANNELS];
} btfi_part;

/* Describes the part that holds a level's texture in a material with this (checked) info; false when there
 * is none. */
bool btfi_part_of(const btf_material_info *info, uint32_t level, btf_texture_id id, btfi_part *out);

/* Lists the parts in the order in which they are written: the picture for viewers, if there is one (its id
 * is BTF_TEXTURE_COUNT), then level after level; returns how many of the BTFI_MAX_PARTS there are. NULL
 * when out of memory; to be freed. */
btfi_part *btfi_parts(const btf_material_info *info, bool preview, int *out_count);

/* A run of texels: `count` pixels of a channel from (x, y) on, at elements offset, offset + stride, ... of
 * the texture. Blank runs of a contact sheet have no texels. */
typedef struct btfi_run {
    bool blank;
    uint32_t count;
    size_t offset, stride;
} btfi_run;

btfi_run btfi_part_run(const btfi_part *part, int channel, uint32_t x, uint32_t y);

/* Bytes of a pixel of the file. */
size_t btfi_pixel_size(btfi_storage storage);

#pragma GCC visibility pop

#endif
