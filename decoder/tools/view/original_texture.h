/* The images that a material was made from, as one array texture in the current GL context.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_VIEW_ORIGINAL_TEXTURE_H
#define OPENBTF_VIEW_ORIGINAL_TEXTURE_H

#include "decoder/tools/context/gl_api.h"
#include "decoder/tools/render/original.h"

/* All zeros: none. */
typedef struct original_texture {
    GLuint name;
    int columns; /* tiles in a row of a layer */
} original_texture;

/* Uploads the images of the material's directions: a layer for each view, in it a tile of the material's size for each
 * light, row by row, in RGB9_E5. Leaves the texture bound to `unit`. Errors, on log: BTF_ERROR_UNSUPPORTED (a layer,
 * or the number of layers, exceeds GL's limits), BTF_ERROR_MEMORY, BTF_ERROR_INTERNAL (GL refuses it otherwise); the
 * texture is still to be cleared then. */
btf_result original_texture_create(const gl_api *gl, int unit, const btf_material *material,
                                   const original *images, const btf_log *log,
                                   original_texture *out_texture);
void original_texture_clear(const gl_api *gl, original_texture *texture);

#endif
