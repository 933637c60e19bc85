/* A mesh in the buffers of the current GL context.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_VIEW_MESH_BUFFERS_H
#define OPENBTF_VIEW_MESH_BUFFERS_H

#include "decoder/tools/context/gl_api.h"
#include "decoder/tools/mesh/mesh.h"

typedef struct mesh_buffers {
    GLuint array, vertices, triangles;
    uint32_t index_count; /* 0: no mesh yet */
} mesh_buffers;

void mesh_buffers_create(const gl_api *gl, mesh_buffers *out_buffers);
void mesh_buffers_clear(const gl_api *gl, mesh_buffers *buffers);

/* Takes a copy of a mesh in the place of the one before. Its vertices have the attributes 0 to 3: position, normal, uv,
 * tangent with the sign of the bitangent. Errors, on log: BTF_ERROR_MEMORY. */
btf_result mesh_buffers_set(const gl_api *gl, mesh_buffers *buffers, const mesh *m, const btf_log *log);
void mesh_buffers_draw(const gl_api *gl, const mesh_buffers *buffers);

#endif
