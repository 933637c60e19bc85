/* OpenBTF: how textures lie in the parts of a file.
 *
 * SPDX-License-Identifier: MIT
 */
#include "parts.h"
#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

size_t btfi_pixel_size(btfi_storage storage) {
    return storage == BTFI_STORAGE_FLOAT || storage == BTFI_STORAGE_UINT32 ? 4 : 2;
}

static void add_channel(btfi_part *part, const char *name, uint32_t layer, uint32_t component) {
    assert(part->channel_count < BTFI_MAX_CHANNELS);
    btfi_channel *channel = &part->channels[part->channel_count++];
    snprintf(channel->name, sizeof channel->name, "%s", name);
    channel->layer = (uint16_t)layer;
    channel->component = (uint16_t)component;
}

/* Channels named by single letters, filling components 0, 1, ... */
static void add_letters(btfi_part *part, const char *letters) {
    for (uint32_t i = 0; letters[i]; i++) {
        add_channel(part, (const char[2]){letters[i], 0}, 0, i);
    }
}

static void add_lobe(btfi_part *part, uint32_t lobe, uint32_t layer) {
    static const char *const names[4] = {"Cx", "Cy", "Cz", "n"};
    for (uint32_t i = 0; i < 4; i++) {
        char name[20];
        snprintf(name, sizeof name, "lobe%u.%s", (unsigned)(lobe + 1), names[i]);
        add_channel(part, name, layer, i);
    }
}

static void sbrdf_channels(btfi_part *part, const btf_material_info *info) {
    add_letters(part, "RGB");
    uint32_t lead = part->shape.layers - info->lobes;
    if (info->colour == BTF_COLOUR_MONO) {
        add_channel(part, "rho_d", 0, 3);
    } else {
        for (uint32_t i = 3; i < 3 + 3 * info->lobes; i++) {
            char name[20];
            snprintf(name, sizeof name, "lobe%u.%c", (unsigned)(i / 3), "RGB"[i % 3]);
            add_channel(part, name, i / 4, i % 4);
        }
    }
    for (uint32_t lobe = 0; lobe < info->lobes; lobe++) {
        add_lobe(part, lobe, lead + lobe);
    }
}

/* Makes the part's image a contact sheet of `layers` layers of the texture's width x height. */
static void make_sheet(btfi_part *part, uint32_t layers) {
    uint32_t columns = 1;
    while (columns * columns < layers) {
        columns++;
    }
    part->layers = layers;
    part->columns = columns;
    part->width = columns * part->shape.width;
    part->height = (layers + columns - 1) / columns * part->shape.height;
}

bool btfi_part_of(const btf_material_info *info, uint32_t level, btf_texture_id id, btfi_part *out) {
    btfi_part part = {.name = btfi_texture_name(level, id), .level = level, .id = id};
    part.shape = btf_material_level_shape(info, level, id);
    if (part.shape.format == BTF_FORMAT_NONE || btfi_is_table(id)) {
        return false;
    }
    part.storage = BTFI_STORAGE_UINT8;
    part.width = part.shape.width;
    part.height = part.shape.height;
    part.columns = part.layers = 1;
    switch (id) {
    case BTF_TEXTURE_SBRDF:
        part.storage = info->half_float ? BTFI_STORAGE_HALF : BTFI_STORAGE_FLOAT;
        sbrdf_channels(&part, info);
        break;
    case BTF_TEXTURE_MAPS:
        add_letters(&part, "RGBA");
        break;
    case BTF_TEXTURE_SHADOW:
    case BTF_TEXTURE_GAIN:
        add_letters(&part, "Y");
        make_sheet(&part, part.shape.layers);
        break;
    case BTF_TEXTURE_SHIFT:
    case BTF_TEXTURE_POINTS:
    case BTF_TEXTURE_POINT_LISTS:
        add_letters(&part, "RG");
        make_sheet(&part, part.shape.layers);
        break;
    case BTF_TEXTURE_POINT_INDICES:
        add_letters(&part, "R");
        make_sheet(&part, part.shape.layers);
        break;
    case BTF_TEXTURE_HEIGHTS:
        add_letters(&part, "Y");
        break;
    case BTF_TEXTURE_CENTRES:
        add_letters(&part, "RGB");
        break;
    case BTF_TEXTURE_RESIDUAL_TEXELS:
        part.storage = BTFI_STORAGE_INT8;
        add_letters(&part, "Y");
        make_sheet(&part, info->components);
        break;
    case BTF_TEXTURE_RESIDUAL_DIRECTIONS:
        part.storage = BTFI_STORAGE_INT8;
        add_letters(&part, "RGB");
        make_sheet(&part, info->components);
        break;
    case BTF_TEXTURE_FACTOR_TEXELS:
    case BTF_TEXTURE_FACTOR_DIRECTIONS:
        part.storage = BTFI_STORAGE_UINT32;
        add_letters(&part, "RGBA");
        make_sheet(&part, part.shape.layers);
        break;
    default:
        return false;
    }
    *out = part;
    return true;
}

static btfi_part preview_part(const btf_material_info *info) {
    btfi_part part = {
        .name = {"preview"},
        .id = BTF_TEXTURE_COUNT,
        .shape = {.format = BTF_FORMAT_RGBA16F, .width = info->width, .height = info->height, .layers = 1},
        .storage = BTFI_STORAGE_HALF,
        .width = info->width,
        .height = info->height,
        .columns = 1,
        .layers = 1};
    add_letters(&part, "RGB");
    return part;
}

btfi_part *btfi_parts(const btf_material_info *info, bool preview, int *out_count) {
    int count = 0;
    btfi_part *parts = calloc(BTFI_MAX_PARTS, sizeof *parts);
    if (preview && parts) {
        parts[count++] = preview_part(info);
    }
    for (uint32_t level = 0; level < info->levels && parts; level++) {
        for (int id = 0; id < BTF_TEXTURE_COUNT; id++) {
            count += btfi_part_of(info, level, (btf_texture_id)id, &parts[count]);
        }
    }
    *out_count = count;
    return parts;
}

btfi_run btfi_part_run(const btfi_part *part, int channel, uint32_t x, uint32_t y) {
    const btf_texture *t = &part->shape;
    const btfi_channel *ch = &part->channels[channel];
    uint32_t column = x / t->width, row = y / t->height;
    uint32_t item = row * part->columns + column; /* of the contact sheet */
    uint32_t layer = ch->layer, component = ch->component;
    x -= column * t->width;
    y -= row * t->height;

    btfi_run run = {.count = t->width - x, .stride = btfi_format_channels(t->format)};
    if (item >= part->layers) {
        run.blank = true;
        return run;
    }
    switch (part->id) {
    case BTF_TEXTURE_SHADOW:
    case BTF_TEXTURE_SHIFT:
    case BTF_TEXTURE_GAIN:
    case BTF_TEXTURE_POINTS:
    case BTF_TEXTURE_POINT_LISTS:
    case BTF_TEXTURE_POINT_INDICES:
    case BTF_TEXTURE_FACTOR_TEXELS:
    case BTF_TEXTURE_FACTOR_DIRECTIONS:
        layer = item;
        break;
    case BTF_TEXTURE_RESIDUAL_TEXELS:
        layer = item / 4;
        component = item % 4;
        break;
    case BTF_TEXTURE_RESIDUAL_DIRECTIONS:
        layer = 3 * (item / 4) + ch->component;
        component = item % 4;
        break;
    default:
        break;
    }
    run.offset = (((size_t)layer * t->height + y) * t->width + x) * run.stride + component;
    return run;
}
