/* OpenBTF: the errors that a file's tables (FORMAT.md section 7) tell of a scene.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_PLAN_TABLE_H
#define OPENBTF_PLAN_TABLE_H

#include "decoder/checks/effect_errors.h"

#include <openbtf/plan.h>
#include <stdbool.h>

#pragma GCC visibility push(hidden)

/* Which directions a row compares at: its third number. */
typedef enum btfi_row_kind {
    BTFI_ROW_BETWEEN,  /* any, decoded by interpolation */
    BTFI_ROW_NEAREST,  /* the same, decoded by the nearest samples */
    BTFI_ROW_SAMPLES,  /* view and light are samples */
    BTFI_ROW_AT_VIEW,  /* the view is a sample, the light is interpolated */
    BTFI_ROW_AT_LIGHT, /* the light is a sample, the view is interpolated */
    BTFI_ROW_KINDS
} btfi_row_kind;

enum { BTFI_ROW_SLOTS = 1024 };

/* Rows by what was decoded, so that each is found without a look at the others: of those of a slot, first[slot] is the
 * number of the last plus 1, next[row] likewise of the one before it; 0: no more. Of several rows of the same way to
 * decode the first counts. */
typedef struct btfi_rows {
    btf_effect_errors table;
    uint16_t first[BTFI_ROW_SLOTS], next[BTFI_MOST_EFFECT_ROWS];
} btfi_rows;

/* The tables of a material, and how much each of their bands counts in a scene. */
typedef struct btfi_error_table {
    btfi_rows errors, differences;
    double at_view, at_light; /* 0: between samples, 1: at a sample */
    double view[BTF_MAX_BANDS], light[BTF_MAX_BANDS];
} btfi_error_table;

/* A way to decode, and what the tables predict for it in a scene: mean squared errors, linear and sRGB-coded. */
typedef struct btfi_way {
    uint32_t effects, components;
    btf_interpolation interpolation;
    double mse[2];    /* against the data, interpolated */
    double growth[2]; /* of the full decode's error where the scene looks (growth.h) */
} btfi_way;

/* Fills in *out; the rows stay the material's. Differences of other bands than the errors', whose rows have another
 * length, are passed over. */
void btfi_error_table_open(const btf_material *material, const btf_scene *scene, btfi_error_table *out);

/* The row of a level, effects, components and directions; NULL where it was not measured. */
const float *btfi_find_row(const btfi_rows *rows, uint32_t level, uint32_t effects, uint32_t components,
                           btfi_row_kind kind);

/* The row of the level, effects and components of `row` at directions of a kind; `row` itself where there is none. */
const float *btfi_row_of_kind(const btfi_rows *rows, const float *row, btfi_row_kind kind);

static inline btfi_row_kind btfi_kind_of(const float *row) {
    return (btfi_row_kind)row[2];
}

static inline uint32_t btfi_level_of(const float *row) {
    return (uint32_t)row[3];
}

/* Adds the errors of a row, weighted by the bands. */
void btfi_add_errors(const btfi_error_table *table, const float *row, double mse[2]);

/* How much a scene is one of two samples, a view that is a sample, a light that is one, neither: adds up to 1. */
enum { BTFI_SHARES = 4 };
void btfi_find_shares(const btfi_error_table *table, double share[BTFI_SHARES]);

/* The kind of row that each of the shares is measured by. */
extern const btfi_row_kind btfi_share_kinds[BTFI_SHARES];

/* The way that a row of kind BTFI_ROW_BETWEEN or BTFI_ROW_NEAREST describes; its growth is not filled in. */
btfi_way btfi_read_way(const btfi_error_table *table, const float *row);

/* The share of a range's solid angle that each of `count` bands has; the outermost band goes on to the horizon, the
 * first to the pole. */
void btfi_band_weights(const btf_range *range, uint32_t count, const float *limits,
                       double weight[BTF_MAX_BANDS]);

#pragma GCC visibility pop

#endif
