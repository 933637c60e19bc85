/* Readers of texture files. See texture_load.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "texture_load.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Fails with the rule that is broken. */
#define RULE(condition, text)                                                                              \
    do {                                                                                                   \
        if (!(condition)) {                                                                                \
            fprintf(stderr, "%s: %s\n", name, text);                                                       \
            return false;                                                                                  \
        }                                                                                                  \
    } while (0)

static uint32_t word(const unsigned char *at) {
    return (uint32_t)at[0] | (uint32_t)at[1] << 8 | (uint32_t)at[2] << 16 | (uint32_t)at[3] << 24;
}

static uint64_t long_word(const unsigned char *at) {
    return word(at) | (uint64_t)word(at + 4) << 32;
}

static uint32_t half(uint32_t size, uint32_t level) {
    return size >> level ? size >> level : 1;
}

unsigned char *load_file(const char *path, size_t *out_size) {
    FILE *file = fopen(path, "rb");
    unsigned char *bytes = NULL;
    long size = 0;
    if (file && fseek(file, 0, SEEK_END) == 0 && (size = ftell(file)) >= 0 &&
        fseek(file, 0, SEEK_SET) == 0) {
        bytes = malloc((size_t)size + 1);
    }
    if (!bytes || fread(bytes, 1, (size_t)size, file) != (size_t)size) {
        fprintf(stderr, "%s: cannot be read\n", path);
        free(bytes);
        bytes = NULL;
    } else {
        bytes[size] = 0;
    }
    if (file) {
        fclose(file);
    }
    *out_size = (size_t)size;
    return bytes;
}

void loaded_free(loaded *t) {
    for (int i = 0; i < LOADED_LEVELS; i++) {
        free(t->data[i]);
        t->data[i] = NULL;
    }
}

/* Vulkan's formats that may occur: channels, bytes of a channel, and its kind. */
static const struct ktx_format {
    uint32_t vulkan, channels, bytes;
    char kind;
} ktx_formats[] = {
    {13, 1, 1, 'u'},  /* VK_FORMAT_R8_UINT */
    {20, 2, 1, 'u'},  /* VK_FORMAT_R8G8_UINT */
    {41, 4, 1, 'u'},  /* VK_FORMAT_R8G8B8A8_UINT */
    {42, 4, 1, 's'},  /* VK_FORMAT_R8G8B8A8_SINT */
    {95, 4, 2, 'u'},  /* VK_FORMAT_R16G16B16A16_UINT */
    {97, 4, 2, 'f'},  /* VK_FORMAT_R16G16B16A16_SFLOAT */
    {107, 4, 4, 'u'}, /* VK_FORMAT_R32G32B32A32_UINT */
    {109, 4, 4, 'f'}, /* VK_FORMAT_R32G32B32A32_SFLOAT */
};

/* Khronos Data Format 1.3, section 5: the one basic block that an uncompressed format has, and its samples. */
static bool check_descriptor(const char *name, const unsigned char *d, size_t size,
                             const struct ktx_format *f) {
    RULE(size >= 4 && word(d) == size, "dfdTotalSize is not dfdByteLength");
    RULE(size == 4 + 24 + 16 * (size_t)f->channels,
         "the descriptor has another number of samples than channels");
    RULE((word(d + 4) & 0x1FFFF) == 0 && word(d + 4) >> 17 == 0, "not a basic block of Khronos");
    RULE((word(d + 8) & 0xFFFF) == 2, "not version 1.3 of the data format");
    RULE(word(d + 8) >> 16 == size - 4, "descriptorBlockSize");
    RULE(d[12] == 1, "colorModel is not RGBSDA");
    RULE(d[13] == 1, "colorPrimaries are not BT.709");
    RULE(d[14] == 1, "transferFunction is not linear");
    RULE(d[15] == 0, "flags");
    RULE(word(d + 16) == 0, "texelBlockDimension is not of single texels");
    RULE(d[20] == f->channels * f->bytes, "bytesPlane0 is not the size of a texel");
    RULE(d[21] == 0 && d[22] == 0 && d[23] == 0 && word(d + 24) == 0, "more than one plane");
    for (uint32_t c = 0; c < f->channels; c++) {
        const unsigned char *s = d + 28 + 16 * c;
        const uint32_t bits = 8 * f->bytes;
        RULE((word(s) & 0xFFFF) == bits * c && s[2] == bits - 1, "bits of a channel");
        RULE((s[3] & 15) == (c == 3 ? 15u : c), "channelId");
        RULE(s[3] >> 4 == (f->kind == 'f' ? 0xC : f->kind == 's' ? 4 : 0), "qualifiers of a channel");
        RULE(word(s + 4) == 0, "samplePosition");
        RULE(word(s + 8) == (f->kind == 'f'   ? 0xBF800000u
                             : f->kind == 's' ? 0xFFFFFFFFu
                                              : 0u),
             "sampleLower");
        RULE(word(s + 12) == (f->kind == 'f' ? 0x3F800000u : 1u), "sampleUpper");
    }
    return true;
}

/* KTX 2.0, section 3.12: keys in order, each with its value; KTXorientation says where row 0 is. */
static bool check_keys(const char *name, const unsigned char *keys, size_t size) {
    const char *last = "";
    bool top = false;
    for (size_t at = 0; at < size;) {
        RULE(size - at >= 4, "a key's length is cut off");
        const size_t length = word(keys + at);
        const char *key = (const char *)keys + at + 4;
        RULE(length >= 2 && length <= size - at - 4, "a key's length is beyond the key/value data");
        const char *end = memchr(key, 0, length);
        RULE(end != NULL, "a key does not end");
        RULE(strcmp(last, key) < 0, "keys are not in order");
        const char *value = end + 1;
        if (!strcmp(key, "KTXorientation")) {
            RULE((size_t)(value - key) + 3 == length && !memcmp(value, "rd", 3),
                 "KTXorientation is not rd");
            top = true;
        }
        last = key;
        for (size_t i = 4 + length; i % 4; i++) {
            RULE(at + i < size && keys[at + i] == 0, "padding behind a value");
        }
        at += (4 + length + 3) / 4 * 4;
    }
    RULE(top, "no KTXorientation");
    return true;
}

bool load_ktx2(const char *name, const unsigned char *bytes, size_t size, loaded *out) {
    static const unsigned char identifier[12] = {0xAB, 0x4B, 0x54, 0x58, 0x20, 0x32,
                                                 0x30, 0xBB, 0x0D, 0x0A, 0x1A, 0x0A};
    const struct ktx_format *f = NULL;
    *out = (loaded){0};
    RULE(size >= 80 && !memcmp(bytes, identifier, 12), "no KTX 2.0 identifier");
    for (size_t i = 0; i < sizeof ktx_formats / sizeof *ktx_formats; i++) {
        f = ktx_formats[i].vulkan == word(bytes + 12) ? &ktx_formats[i] : f;
    }
    RULE(f != NULL, "vkFormat is none that a material has");
    RULE(word(bytes + 16) == f->bytes, "typeSize is not the size of a channel");
    RULE(word(bytes + 28) == 0, "pixelDepth is not 0");
    RULE(word(bytes + 36) == 1, "faceCount is not 1");
    RULE(word(bytes + 44) == 0, "supercompressionScheme is not 0");
    out->vulkan = f->vulkan;
    out->texel = (size_t)f->channels * f->bytes;
    out->width = word(bytes + 20);
    out->height = word(bytes + 24);
    out->is_array = word(bytes + 32) > 0;
    out->layers = out->is_array ? word(bytes + 32) : 1;
    out->levels = word(bytes + 40);
    RULE(out->width > 0 && out->height > 0, "pixelWidth or pixelHeight is 0");
    RULE(out->levels >= 1 && out->levels <= LOADED_LEVELS, "levelCount");
    const size_t descriptor_at = word(bytes + 48), descriptor_size = word(bytes + 52),
                 keys_at = word(bytes + 56), keys_size = word(bytes + 60);
    RULE(long_word(bytes + 64) == 0 && long_word(bytes + 72) == 0, "global data of a supercompression");
    RULE(descriptor_at == 80 + 24 * (size_t)out->levels,
         "the descriptor does not follow the index of levels");
    RULE(keys_at == descriptor_at + descriptor_size, "key/value data do not follow the descriptor");
    RULE(keys_at + keys_size <= size, "key/value data are beyond the file");
    if (!check_descriptor(name, bytes + descriptor_at, descriptor_size, f) ||
        !check_keys(name, bytes + keys_at, keys_size)) {
        return false;
    }
    /* Section 3.9.3: the coarsest level comes first, each at a multiple of lcm(texel, 4). */
    size_t end = keys_at + keys_size;
    const size_t multiple = out->texel % 4 == 0 ? out->texel : 4;
    for (uint32_t i = out->levels; i-- > 0;) {
        const unsigned char *entry = bytes + 80 + 24 * i;
        const uint64_t at = long_word(entry), length = long_word(entry + 8);
        const size_t expected =
            (size_t)half(out->width, i) * half(out->height, i) * out->layers * out->texel;
        RULE(length == expected && long_word(entry + 16) == expected, "byteLength of a level");
        RULE(at % multiple == 0, "a level is not aligned");
        RULE(at >= end && at - end < multiple, "a level does not follow the one before");
        RULE(at + length <= size, "a level is beyond the file");
        for (; end < at; end++) {
            RULE(bytes[end] == 0, "padding before a level");
        }
        out->size[i] = expected;
        out->data[i] = malloc(expected);
        RULE(out->data[i] != NULL, "out of memory");
        memcpy(out->data[i], bytes + at, expected);
        end = (size_t)(at + length);
    }
    RULE(end == size, "bytes behind the last level");
    return true;
}

/* DXGI_FORMAT and bytes of a texel. */
static const uint32_t dxgi_formats[][2] = {{2, 16}, {3, 16}, {10, 8}, {12, 8},
                                           {30, 4}, {32, 4}, {50, 2}, {62, 1}};

/* Microsoft's DDS with the header DX10: layer by layer, each with its levels. */
bool load_dds(const char *name, const unsigned char *bytes, size_t size, loaded *out) {
    *out = (loaded){0};
    RULE(size >= 148 && !memcmp(bytes, "DDS ", 4) && word(bytes + 4) == 124, "no DDS header");
    const uint32_t flags = word(bytes + 8), caps = word(bytes + 108);
    RULE((flags & 0x1007) == 0x1007, "dwFlags lack caps, height, width or pixel format");
    RULE(word(bytes + 76) == 32 && word(bytes + 80) == 4 && !memcmp(bytes + 84, "DX10", 4),
         "no DX10 header");
    RULE((caps & 0x1000) != 0, "dwCaps lack the texture");
    out->height = word(bytes + 12);
    out->width = word(bytes + 16);
    out->levels = flags & 0x20000 ? word(bytes + 28) : 1;
    RULE(out->levels == 1 || (caps & 0x400008) == 0x400008, "dwCaps lack the levels");
    RULE(out->levels >= 1 && out->levels <= LOADED_LEVELS, "dwMipMapCount");
    out->dxgi = word(bytes + 128);
    RULE(word(bytes + 132) == 3, "resourceDimension is not 2D");
    RULE(word(bytes + 136) == 0, "miscFlag");
    out->layers = word(bytes + 140);
    out->is_array = out->layers > 1;
    for (size_t i = 0; i < sizeof dxgi_formats / sizeof *dxgi_formats; i++) {
        out->texel = dxgi_formats[i][0] == out->dxgi ? dxgi_formats[i][1] : out->texel;
    }
    RULE(out->texel > 0, "dxgiFormat is none that a material has");
    RULE(!(flags & 8) || word(bytes + 20) == out->width * out->texel, "dwPitchOrLinearSize");
    size_t at = 148;
    for (uint32_t layer = 0; layer < out->layers; layer++) {
        for (uint32_t i = 0; i < out->levels; i++) {
            const size_t one = (size_t)half(out->width, i) * half(out->height, i) * out->texel;
            if (layer == 0) {
                out->size[i] = one * out->layers;
                out->data[i] = malloc(out->size[i]);
                RULE(out->data[i] != NULL, "out of memory");
            }
            RULE(one <= size - at, "a layer is beyond the file");
            memcpy(out->data[i] + layer * one, bytes + at, one);
            at += one;
        }
    }
    RULE(at == size, "bytes behind the last layer");
    return true;
}
