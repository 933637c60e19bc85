/* A mesh in buffers. See mesh_buffers.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "mesh_buffers.h"

#include "decoder/toolkit/file.h"
#include <stddef.h>

void mesh_buffers_create(const gl_api *gl, mesh_buffers *out_buffers) {
    GLuint names[2];
    *out_buffers = (mesh_buffers){0};
    gl->GenVertexArrays(1, &out_buffers->array);
    gl->GenBuffers(2, names);
    out_buffers->vertices = names[0];
    out_buffers->triangles = names[1];
}

void mesh_buffers_clear(const gl_api *gl, mesh_buffers *buffers) {
    const GLuint names[2] = {buffers->vertices, buffers->triangles};
    gl->DeleteBuffers(2, names);
    *buffers = (mesh_buffers){0};
}

btf_result mesh_buffers_set(const gl_api *gl, mesh_buffers *buffers, const mesh *m, const btf_log *log) {
    static const struct {
        GLint count;
        size_t offset;
    } attributes[4] = {{3, offsetof(mesh_vertex, position)},
                       {3, offsetof(mesh_vertex, normal)},
                       {2, offsetof(mesh_vertex, uv)},
                       {4, offsetof(mesh_vertex, tangent)}};
    gl->BindVertexArray(buffers->array);
    gl->BindBuffer(GL_ARRAY_BUFFER, buffers->vertices);
    gl->BufferData(GL_ARRAY_BUFFER, (GLsizeiptr)(m->vertex_count * sizeof *m->vertices), m->vertices,
                   GL_STATIC_DRAW);
    gl->BindBuffer(GL_ELEMENT_ARRAY_BUFFER, buffers->triangles);
    gl->BufferData(GL_ELEMENT_ARRAY_BUFFER, (GLsizeiptr)(3 * sizeof *m->triangles * m->triangle_count),
                   m->triangles, GL_STATIC_DRAW);
    for (GLuint i = 0; i < 4; i++) {
        gl->EnableVertexAttribArray(i);
        gl->VertexAttribPointer(i, attributes[i].count, GL_FLOAT, GL_FALSE, sizeof(mesh_vertex),
                                (const void *)(uintptr_t)attributes[i].offset);
    }
    buffers->index_count = 3 * m->triangle_count;
    if (gl->GetError() == GL_NO_ERROR) {
        return BTF_OK;
    }
    file_say(log, "the mesh does not fit into GL's memory");
    return BTF_ERROR_MEMORY;
}

void mesh_buffers_draw(const gl_api *gl, const mesh_buffers *buffers) {
    gl->BindVertexArray(buffers->array);
    gl->DrawElements(GL_TRIANGLES, (GLsizei)buffers->index_count, GL_UNSIGNED_INT, NULL);
}
