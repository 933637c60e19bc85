/* Textures of a material as files that other programs load: KTX 2.0, DDS, or the bare bytes.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_SHADER_TEXTURE_FILE_H
#define OPENBTF_SHADER_TEXTURE_FILE_H

#include <openbtf/material.h>

/* The kinds of file, in the order of the option --textures. */
typedef enum texture_store { TEXTURE_STORE_KTX2, TEXTURE_STORE_DDS, TEXTURE_STORE_RAW } texture_store;
#define TEXTURE_STORE_CHOICES "ktx2|dds|raw"

/* A format in the words of others. */
typedef struct texture_format {
    const char *name;             /* as in FORMAT.md: "RG8UI" */
    uint32_t vulkan, dxgi, gl;    /* VkFormat, DXGI_FORMAT, internal format of OpenGL */
    uint32_t gl_layout, gl_type;  /* OpenGL's `format` and `type` of an upload */
    uint32_t channels, component; /* component: bytes of a channel */
    char kind;                    /* 'u' unsigned integer, 'i' signed integer, 'f' float */
} texture_format;

/* NULL for BTF_FORMAT_NONE. */
const texture_format *texture_format_of(btf_format format);

/* A texture with its levels of detail, the finest first; all of one format and number of layers. */
typedef struct texture_levels {
    btf_texture_id id;
    uint32_t count;
    btf_texture level[BTF_MAX_LEVELS];
} texture_levels;

/* Where a level lies in its file: layer i begins at offset + i * stride, rows without gaps. */
typedef struct texture_place {
    uint64_t offset, stride;
} texture_place;

/* "ktx2", "dds" or "raw": the ending of the files. */
const char *texture_store_name(texture_store store);

/* Writes the file and says where each level lies, and its size. Little-endian, as all three kinds are. Errors, on the
 * log with the path: BTF_ERROR_IO, BTF_ERROR_MEMORY, BTF_ERROR_UNSUPPORTED (a machine that is not little-endian). */
btf_result texture_file_write(const char *path, texture_store store, const texture_levels *texture,
                              btf_log log, texture_place out_places[BTF_MAX_LEVELS], uint64_t *out_bytes);

#endif
