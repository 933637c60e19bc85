/* OpenBTF: the layout of an atlas (FORMAT.md section 5).
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ATLAS_H
#define OPENBTF_ATLAS_H

#include <openbtf/material.h>
#include <stdbool.h>

#pragma GCC visibility push(hidden)

/* The numbers of FORMAT.md section 5 for info's atlas. */
typedef struct btfi_atlas {
    uint32_t tiles, columns;  /* T, cols */
    uint32_t part, y0, bands; /* tiles in the last, unfilled row; its first row; bands of centres below */
    uint32_t narrow, w0;      /* bands that lose their first part * W columns; their width */
    uint32_t room;            /* centres */
} btfi_atlas;

/* False when the tiles do not fit. */
bool btfi_atlas_plan(const btf_material_info *info, uint32_t width, uint32_t height, btfi_atlas *out);
/* Returns true, and sets the centre's index, where texel (x, y) of an atlas, outside the tiles, belongs to the column
 * of a centre. */
bool btfi_atlas_centre_at(const btf_material_info *info, const btfi_atlas *atlas, uint32_t x, uint32_t y,
                          uint32_t *out_centre);

#pragma GCC visibility pop

#endif
