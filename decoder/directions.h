/* OpenBTF: direction lists with their triangulation and GPU table (FORMAT.md section 6).
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_DIRECTIONS_H
#define OPENBTF_DIRECTIONS_H

#include "result.h"
#include <openbtf/material.h>
#include <stdbool.h>

#pragma GCC visibility push(hidden)

/* Vertices lie in 0 .. 2 * BTFI_PLANE (FORMAT.md section 6). */
enum {
    BTFI_PLANE = 8192,
    BTFI_MAX_GRID = 64,
    BTFI_MAX_RECORDS = 65535,
    BTFI_TABLE_WIDTH = 256,
    BTFI_RECORD_TEXELS = 3 /* of the GPU table */
};

/* A direction list with its triangulation; the owned twin of btf_directions, and its GPU table. */
typedef struct btfi_directions {
    uint32_t count;
    float *xyz;
    uint16_t *vertices;
    uint32_t triangle_count;
    uint16_t *triangles;
    uint32_t hull_count;
    uint16_t *hull;
    uint32_t grid;
    uint16_t *cells;
    size_t cells_length;
    uint16_t *table; /* RGBA16UI, BTFI_TABLE_WIDTH x table_height */
    uint32_t table_height;
} btfi_directions;

/* project(d) of FORMAT.md section 8; d unit within 1e-3, d.z > 0. */
void btfi_project(const float d[3], uint16_t out_q[2]);
/* Makes everything from count directions; `name` is "views" or "lights". */
btf_result btfi_directions_build(const btfi_check *check, const char *name, uint32_t count,
                                 const float *xyz, btfi_directions *out);
/* Checks a list as a file has it (FORMAT.md section 6), of which all fields but the table are set. */
btf_result btfi_directions_check(const btfi_check *check, const char *name,
                                 const btfi_directions *directions);
btf_result btfi_directions_make_table(const btf_log *log, btfi_directions *directions);
void btfi_directions_clear(btfi_directions *directions);

#pragma GCC visibility pop

#endif
