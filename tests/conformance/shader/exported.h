/* A folder of btf-shader in memory: its manifest, its text and its textures, each checked against the others.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TEST_EXPORTED_H
#define OPENBTF_TEST_EXPORTED_H

#include "texture_load.h"
#include <openbtf/reference.h>
#include <openbtf/material.h>

typedef struct exported_texture {
    char name[40], sampler[80];
    uint32_t binding, set;
    uint32_t vulkan, gl_internal, gl_layout, gl_type;
    bool is_array;
    loaded data;
} exported_texture;

typedef struct exported {
    char language[16], prefix[40];
    unsigned char *text; /* the decoder, followed by a zero byte */
    size_t text_size;
    uint32_t levels;
    uint32_t first_level; /* of the material that was written, where a plan left finer ones out */
    int picks;            /* 0, or BTF_REF_PICK_VIEW to _ALL */
    btf_ref_options options;
    float fixed_view[3], fixed_light[3];
    bool has_fixed_view, has_fixed_light;
    int texture_count;
    exported_texture textures[BTF_TEXTURE_COUNT];
} exported;

/* A record of an evaluation, of twelve words, as the entry point of SPIR-V has them: texture coordinates (2 floats), light
 * (3), view (3), level (a float), three random numbers; the last three become the result. */
enum { RECORD = 12, RESULT = 9 };

/* False, with a message on stderr, where a file is missing, breaks its format, or is not as the manifest says. */
bool exported_open(const char *folder, exported *out);
void exported_close(exported *e);

/* How many levels of textures hold other bytes than the material's, with a message on stderr for each. */
int exported_differences(const exported *e, const btf_material *material);

#endif
