/* Textures as files. See texture_file.h.
 *
 * Headers are put together in memory and followed by the bytes that the library hands out. Sources: Khronos, KTX File
 * Format Specification 2.0, and Data Format Specification 1.3, section 5 (basic descriptor block); Microsoft,
 * Programming Guide for DDS.
 *
 * SPDX-License-Identifier: MIT
 */
#include "texture_file.h"

#include "decoder/toolkit/file.h"
#include "decoder/toolkit/output.h"
#include <string.h>

static const texture_format formats[] = {
    [BTF_FORMAT_R8UI] = {"R8UI", 13, 62, 0x8232, 0x8D94, 0x1401, 1, 1, 'u'},
    [BTF_FORMAT_RG8UI] = {"RG8UI", 20, 50, 0x8238, 0x8228, 0x1401, 2, 1, 'u'},
    [BTF_FORMAT_RGBA8UI] = {"RGBA8UI", 41, 30, 0x8D7C, 0x8D99, 0x1401, 4, 1, 'u'},
    [BTF_FORMAT_RGBA8I] = {"RGBA8I", 42, 32, 0x8D8E, 0x8D99, 0x1400, 4, 1, 'i'},
    [BTF_FORMAT_RGBA16UI] = {"RGBA16UI", 95, 12, 0x8D76, 0x8D99, 0x1403, 4, 2, 'u'},
    [BTF_FORMAT_RGBA16F] = {"RGBA16F", 97, 10, 0x881A, 0x1908, 0x140B, 4, 2, 'f'},
    [BTF_FORMAT_RGBA32F] = {"RGBA32F", 109, 2, 0x8814, 0x1908, 0x1406, 4, 4, 'f'},
    [BTF_FORMAT_RGBA32UI] = {"RGBA32UI", 107, 3, 0x8D70, 0x8D99, 0x1405, 4, 4, 'u'},
};

const texture_format *texture_format_of(btf_format format) {
    return format > BTF_FORMAT_NONE && (size_t)format < sizeof formats / sizeof *formats ? &formats[format]
                                                                                         : NULL;
}

const char *texture_store_name(texture_store store) {
    static const char *const names[] = {"ktx2", "dds", "raw"};
    return names[store];
}

/* A header that grows; 1 KiB holds the longest, of a KTX file with 15 levels. */
typedef struct header {
    unsigned char bytes[1024];
    size_t size;
} header;

static void put(header *h, const void *data, size_t size) {
    memcpy(h->bytes + h->size, data, size);
    h->size += size;
}

static void put_32(header *h, uint32_t value) {
    const unsigned char bytes[4] = {value & 255, value >> 8 & 255, value >> 16 & 255, value >> 24};
    put(h, bytes, 4);
}

static void put_64(header *h, uint64_t value) {
    put_32(h, (uint32_t)value);
    put_32(h, (uint32_t)(value >> 32));
}

static size_t aligned(size_t at, size_t to) {
    return (at + to - 1) / to * to;
}

static void pad(header *h, size_t to) {
    const size_t end = aligned(h->size, to);
    memset(h->bytes + h->size, 0, end - h->size);
    h->size = end;
}

/* Writes key, zero, value, zero; the length in front of them does not count the padding behind. */
static void put_key(header *h, const char *key, const char *value) {
    const size_t key_size = strlen(key) + 1, value_size = strlen(value) + 1;
    put_32(h, (uint32_t)(key_size + value_size));
    put(h, key, key_size);
    put(h, value, value_size);
    pad(h, 4);
}

/* The data format descriptor: one basic block with a sample for each channel. */
static void put_descriptor(header *h, const texture_format *f) {
    enum {
        BLOCK = 24,
        SAMPLE = 16,
        RGBSDA = 1,
        BT709 = 1,
        LINEAR = 1,
        ALPHA = 15,
        SIGNED = 0x40,
        FLOAT = 0x80
    };
    const uint32_t block = BLOCK + SAMPLE * f->channels, texel = f->channels * f->component;
    put_32(h, 4 + block);
    put_32(h, 0);                                  /* vendor Khronos, type basic */
    put_32(h, 2 | block << 16);                    /* version 1.3 of the specification */
    put_32(h, RGBSDA | BT709 << 8 | LINEAR << 16); /* no flags: alpha is not premultiplied */
    put_32(h, 0);                                  /* blocks of 1 x 1 x 1 x 1 */
    put_32(h, texel);                              /* bytes of planes 0 to 3: only plane 0 has any */
    put_32(h, 0);                                  /* and of planes 4 to 7 */
    for (uint32_t c = 0; c < f->channels; c++) {
        const uint32_t bits = 8 * f->component, qualifiers = f->kind == 'f'   ? FLOAT | SIGNED
                                                             : f->kind == 'i' ? SIGNED
                                                                              : 0;
        put_32(h, bits * c | (bits - 1) << 16 | ((c == 3 ? ALPHA : c) | qualifiers) << 24);
        put_32(h, 0); /* position in the block */
        /* The numbers that stand for -1 (in unsigned channels for 0) and for 1; integers are not normalised. */
        put_32(h, f->kind == 'f' ? 0xBF800000u : f->kind == 'i' ? 0xFFFFFFFFu : 0);
        put_32(h, f->kind == 'f' ? 0x3F800000u : 1);
    }
}

/* Levels of a KTX file lie from the coarsest to the finest, each at a multiple of texel and word. */
static void make_ktx2(header *h, const texture_levels *t, const texture_format *f, texture_place *places) {
    static const unsigned char identifier[12] = {0xAB, 'K',  'T',  'X',  ' ',  '2',
                                                 '0',  0xBB, '\r', '\n', 0x1A, '\n'};
    const size_t texel = (size_t)f->channels * f->component, alignment = texel < 4 ? 4 : texel;
    header descriptor = {.size = 0}, keys = {.size = 0};
    put_descriptor(&descriptor, f);
    put_key(&keys, "KTXorientation", "rd"); /* row 0 is the top */
    put_key(&keys, "KTXwriter", "OpenBTF btf-shader " OPENBTF_VERSION);
    const size_t index = 80, descriptor_at = index + 24 * (size_t)t->count,
                 keys_at = descriptor_at + descriptor.size;
    size_t at = keys_at + keys.size;
    for (uint32_t i = t->count; i-- > 0;) {
        at = aligned(at, alignment);
        places[i] = (texture_place){at, t->level[i].size / t->level[i].layers};
        at += t->level[i].size;
    }
    put(h, identifier, sizeof identifier);
    put_32(h, f->vulkan);
    put_32(h, f->component);
    put_32(h, t->level->width);
    put_32(h, t->level->height);
    put_32(h, 0); /* depth */
    put_32(h, t->level->is_array ? t->level->layers : 0);
    put_32(h, 1); /* faces */
    put_32(h, t->count);
    put_32(h, 0); /* not supercompressed */
    put_32(h, (uint32_t)descriptor_at);
    put_32(h, (uint32_t)descriptor.size);
    put_32(h, (uint32_t)keys_at);
    put_32(h, (uint32_t)keys.size);
    put_64(h, 0);
    put_64(h, 0);
    for (uint32_t i = 0; i < t->count; i++) {
        put_64(h, places[i].offset);
        put_64(h, t->level[i].size);
        put_64(h, t->level[i].size);
    }
    put(h, descriptor.bytes, descriptor.size);
    put(h, keys.bytes, keys.size);
}

/* Layers of a DDS file follow one another, each with all its levels, the finest first. */
static void make_dds(header *h, const texture_levels *t, const texture_format *f, texture_place *places) {
    enum {
        CAPS = 1,
        HEIGHT = 2,
        WIDTH = 4,
        PITCH = 8,
        PIXEL_FORMAT = 0x1000,
        MIP_COUNT = 0x20000,
        FOURCC = 4,
        COMPLEX = 8,
        TEXTURE = 0x1000,
        MIPMAP = 0x400000,
        DIMENSION_2D = 3
    };
    const int mips = t->count > 1;
    put(h, "DDS ", 4);
    put_32(h, 124);
    put_32(h, CAPS | HEIGHT | WIDTH | PITCH | PIXEL_FORMAT | (mips ? MIP_COUNT : 0));
    put_32(h, t->level->height);
    put_32(h, t->level->width);
    put_32(h, t->level->width * f->channels * f->component);
    put_32(h, 0); /* depth */
    put_32(h, t->count);
    for (int i = 0; i < 11; i++) {
        put_32(h, 0);
    }
    put_32(h, 32); /* the pixel format: a DX10 header says it */
    put_32(h, FOURCC);
    put(h, "DX10", 4);
    for (int i = 0; i < 5; i++) {
        put_32(h, 0);
    }
    put_32(h, TEXTURE | (mips ? MIPMAP : 0) | (mips || t->level->layers > 1 ? COMPLEX : 0));
    for (int i = 0; i < 4; i++) {
        put_32(h, 0);
    }
    put_32(h, f->dxgi);
    put_32(h, DIMENSION_2D);
    put_32(h, 0);
    put_32(h, t->level->layers);
    put_32(h, 0); /* the meaning of alpha is unknown */
    uint64_t at = h->size, stride = 0;
    for (uint32_t i = 0; i < t->count; i++) {
        stride += t->level[i].size / t->level[i].layers;
    }
    for (uint32_t i = 0; i < t->count; i++) {
        places[i] = (texture_place){at, stride};
        at += t->level[i].size / t->level[i].layers;
    }
}

/* Levels follow one another, the finest first, each at a multiple of 16 bytes. */
static void make_raw(const texture_levels *t, texture_place *places) {
    uint64_t at = 0;
    for (uint32_t i = 0; i < t->count; i++) {
        places[i] = (texture_place){at, t->level[i].size / t->level[i].layers};
        at = aligned(at + t->level[i].size, 16);
    }
}

/* Writes zeros up to an offset, if the file does not reach that far, then the data. */
static int write_at(FILE *stream, uint64_t *at, uint64_t offset, const void *data, size_t size) {
    for (; *at < offset; ++*at) {
        putc(0, stream);
    }
    *at += size;
    return fwrite(data, 1, size, stream) == size;
}

btf_result texture_file_write(const char *path, texture_store store, const texture_levels *texture,
                              btf_log log, texture_place out_places[BTF_MAX_LEVELS], uint64_t *out_bytes) {
    const uint32_t one = 1;
    if (*(const unsigned char *)&one != 1) {
        file_say(&log, "%s: texture files are written on little-endian machines alone", path);
        return BTF_ERROR_UNSUPPORTED;
    }
    const texture_format *format = texture_format_of(texture->level->format);
    header h = {.size = 0};
    if (store == TEXTURE_STORE_KTX2) {
        make_ktx2(&h, texture, format, out_places);
    } else if (store == TEXTURE_STORE_DDS) {
        make_dds(&h, texture, format, out_places);
    } else {
        make_raw(texture, out_places);
    }
    output *file;
    const btf_result result = output_open(path, log, &file);
    if (result) {
        return result;
    }
    FILE *stream = output_stream(file);
    uint64_t at = h.size;
    int good = fwrite(h.bytes, 1, h.size, stream) == h.size;
    if (store == TEXTURE_STORE_DDS) {
        for (uint32_t layer = 0; layer < texture->level->layers && good; layer++) {
            for (uint32_t i = 0; i < texture->count && good; i++) {
                const size_t size = texture->level[i].size / texture->level[i].layers;
                good = write_at(stream, &at, at, (const char *)texture->level[i].data + layer * size, size);
            }
        }
    } else {
        for (uint32_t i = 0; i < texture->count && good; i++) {
            const uint32_t k = store == TEXTURE_STORE_KTX2 ? texture->count - 1 - i : i;
            good =
                write_at(stream, &at, out_places[k].offset, texture->level[k].data, texture->level[k].size);
        }
    }
    *out_bytes = at;
    return output_commit(&file); /* which sees a stream that has failed */
}
