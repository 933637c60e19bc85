/* manifest.json: what is in a folder of btf-shader, for programs that load it.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_SHADER_MANIFEST_H
#define OPENBTF_SHADER_MANIFEST_H

#include "languages.h"
#include "texture_file.h"
#include <openbtf/plan.h>

/* A texture as it was written. */
typedef struct manifest_texture {
    texture_levels levels;
    char file[48];
    texture_place places[BTF_MAX_LEVELS];
    uint64_t bytes; /* of the file */
} manifest_texture;

typedef struct manifest {
    const btf_material *material; /* that was written: with a plan, its restriction */
    const btf_shader_options *options;
    const btf_plan *plan; /* NULL: none */
    language language;
    texture_store store;
    const char *text; /* the decoder as it was written, or NULL for SPIR-V */
    size_t text_bytes;
    manifest_texture textures[BTF_TEXTURE_COUNT];
    int texture_count;
} manifest;

/* Writes the manifest. Errors, on the log: BTF_ERROR_IO, BTF_ERROR_MEMORY. */
btf_result manifest_write(const char *path, const manifest *m, btf_log log);

#endif
