/* OpenBTF: what the library's files share and users do not see (prefix btfi_).
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_INTERNAL_H
#define OPENBTF_INTERNAL_H

#include <openbtf/material.h>
#include <stdbool.h>

#pragma GCC visibility push(hidden)

/* The smallest and largest magnitude of a parameter that is not 0 (FORMAT.md section 2). */
#define BTFI_PARAMETER_MIN 0x1p-24f
#define BTFI_PARAMETER_MAX 0x1p24f

/* Vertices lie in 0 .. 2 * BTFI_PLANE (FORMAT.md section 6). */
enum { BTFI_PLANE = 8192, BTFI_MAX_GRID = 64, BTFI_MAX_RECORDS = 65535, BTFI_TABLE_WIDTH = 256 };

/* A direction list with its triangulation; the owned twin of btf_directions, and its GPU table. */
typedef struct btfi_directions {
    uint32_t count;
    float *xyz;
    uint16_t *vertices;
    uint32_t triangle_count;
    uint8_t *triangles;
    uint32_t hull_count;
    uint8_t *hull;
    uint32_t grid;
    uint16_t *cells;
    size_t cells_length;
    uint16_t *table; /* RGBA16UI, BTFI_TABLE_WIDTH x table_height */
    uint32_t table_height;
} btfi_directions;

struct btf_material {
    btf_material_info info;
    char *method, *options, *source; /* never NULL once made */
    void *texture[BTF_MAX_LEVELS]
                 [BTF_TEXTURE_COUNT]; /* those that have a shape; the tables live in views and lights */
    btfi_directions views, lights;
    btf_material_error *errors;
    size_t error_count;
    btf_level_error *level_errors;
    size_t level_error_count;
    float *effect_errors; /* attribute openbtf.effectErrors */
    size_t effect_error_count;
};

/* Where a check reports, and the code that a failure has: BTF_ERROR_BAD_FILE when reading, BTF_ERROR_USAGE
 * when creating. */
typedef struct btfi_check {
    const btf_log *log;
    btf_result code;
} btfi_check;

/* Sends a message to log (which may be NULL) and returns `result`. */
btf_result btfi_fail(const btf_log *log, btf_result result, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* True when x is 0 or of a magnitude that FORMAT.md section 2 allows. */
static inline bool btfi_is_parameter(float x) {
    float magnitude = x < 0 ? -x : x;
    return x == 0 || (magnitude >= BTFI_PARAMETER_MIN && magnitude <= BTFI_PARAMETER_MAX);
}

/* shape.c ------------------------------------------------------------------------------------------------
 */

/* Channels of a texel and bytes of a channel. */
uint32_t btfi_format_channels(btf_format format);
/* The name of a level's texture: "sbrdf", "level1.sbrdf". */
typedef struct btfi_name {
    char text[32];
} btfi_name;
btfi_name btfi_texture_name(uint32_t level, btf_texture_id id);
/* Names of the effects in the order of FORMAT.md section 3; NULL beyond the last. */
const char *btfi_effect_name(int index);
/* Checks everything that info says by itself (FORMAT.md sections 2 to 5, 7), the strings aside. */
btf_result btfi_check_info(const btfi_check *check, const btf_material_info *info);
/* Sums of the textures, as info reports them. */
size_t btfi_gpu_bytes(const btf_material_info *info);

/* atlas.c ------------------------------------------------------------------------------------------------
 */

/* The numbers of FORMAT.md section 5 for info's atlas. */
typedef struct btfi_atlas {
    uint32_t tiles, columns;  /* T, cols */
    uint32_t part, y0, bands; /* tiles in the last, unfilled row; its first row; bands of centres below */
    uint32_t narrow, w0;      /* bands that lose their first part * W columns; their width */
    uint32_t room;            /* centres */
} btfi_atlas;

/* False when the tiles do not fit. */
bool btfi_atlas_plan(const btf_material_info *info, uint32_t width, uint32_t height, btfi_atlas *out);
/* True, and the centre's index, when texel (x, y) of an atlas, outside the tiles, belongs to a centre's
 * column. */
bool btfi_atlas_centre_at(const btf_material_info *info, const btfi_atlas *atlas, uint32_t x, uint32_t y,
                          uint32_t *out_centre);

/* triangulate.c ------------------------------------------------------------------------------------------
 */

/* Delaunay triangulation of count <= 256 distinct vertices (x, y in 0..16384): triangles (room for 2 *
 * count), counter-clockwise, each beginning with its smallest index, sorted; and the closed hull (room for
 * 2 * count), beginning with its smallest index, or there and back when all are collinear. Ties of
 * co-circular vertices go to the diagonal with the smallest index. Errors: BTF_ERROR_MEMORY. */
btf_result btfi_triangulate(uint32_t count, const uint16_t (*vertices)[2], uint8_t (*triangles)[3],
                            uint32_t *out_triangle_count, uint8_t *hull, uint32_t *out_hull_count);

/* directions.c -------------------------------------------------------------------------------------------
 */

/* project(d) of FORMAT.md section 8; d unit within 1e-3, d.z > 0. */
void btfi_project(const float d[3], uint16_t out_q[2]);
/* Makes everything from count directions; `name` is "views" or "lights". */
btf_result btfi_directions_build(const btfi_check *check, const char *name, uint32_t count,
                                 const float *xyz, btfi_directions *out);
/* Checks what a file says of a list (FORMAT.md section 6), all fields but table set; then makes the table.
 */
btf_result btfi_directions_check(const btfi_check *check, const char *name,
                                 const btfi_directions *directions);
btf_result btfi_directions_make_table(const btf_log *log, btfi_directions *directions);
void btfi_directions_clear(btfi_directions *directions);

/* values.c -----------------------------------------------------------------------------------------------
 */

/* Checks every value of every texture of every level against FORMAT.md sections 2 to 5, and turns -0 into
 * +0.
 */
btf_result btfi_check_values(const btfi_check *check, const btf_material_info *info,
                             void *texture[BTF_MAX_LEVELS][BTF_TEXTURE_COUNT]);
btf_result btfi_check_errors(const btfi_check *check, const btf_material_error *errors, size_t count);
btf_result btfi_check_level_errors(const btfi_check *check, uint32_t levels, const btf_level_error *errors,
                                   size_t count);

/* effect_errors.c ----------------------------------------------------------------------------------------
 */

/* Checks the numbers of the attribute openbtf.effectErrors against a (checked) info. */
btf_result btfi_check_effect_errors(const btfi_check *check, const btf_material_info *info,
                                    const float *values, size_t count);

/* material.c ---------------------------------------------------------------------------------------------
 */

/* A copy of a string ("" for NULL), NULL when out of memory. */
char *btfi_copy_string(const char *text, size_t length);
/* An empty material. NULL when out of memory. */
btf_material *btfi_material_new(void);
/* Allocates zeroed textures for material->info. Errors: BTF_ERROR_MEMORY. */
btf_result btfi_material_allocate(const btf_log *log, btf_material *material);
/* Fills the fields of info that follow from the rest, once tables are made. */
void btfi_material_finish(btf_material *material);

#pragma GCC visibility pop

#endif
