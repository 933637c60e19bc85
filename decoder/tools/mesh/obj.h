/* Meshes read from Wavefront OBJ.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_MESH_OBJ_H
#define OPENBTF_MESH_OBJ_H

#include "mesh.h"

/* Reads an OBJ file: v, vt, vn, f (polygons, concave or not, with any number of corners; negative indices, "v/t",
 * "v/t/n"); other statements and a byte-order mark are skipped. Every corner needs texture coordinates. Where any
 * corner has no normal, those of the file are not used and all normals are averaged over faces by area. Tangents
 * follow from uv. The mesh is centred and scaled into the unit sphere. Messages name file, line and value. At most
 * 2^24 corners and 1 GB. Errors: BTF_ERROR_IO, BTF_ERROR_BAD_FILE, BTF_ERROR_UNSUPPORTED (size, UTF-16),
 * BTF_ERROR_MEMORY. */
btf_result mesh_read_obj(const char *path, const btf_log *log, mesh **out_mesh);

/* Reads an OBJ file from text[size]; `name` stands for its path in messages. */
btf_result mesh_parse_obj(const char *name, const char *text, size_t size, const btf_log *log,
                          mesh **out_mesh);

#endif
