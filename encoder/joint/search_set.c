/* Tiles, grids and blocks (see search_set.h).
 *
 * SPDX-License-Identifier: MIT
 */
#include "search_set.h"

#include <math.h>
#include <stdlib.h>

enum {
    TILE = 16,     /* TILE * TILE == JOINT_CHUNK */
    FARTHEST = 127 /* of a shift, along each axis */
};

/* Texels along one axis: tiles of them, and cells of the grid, TILE grid points wide. */
typedef struct axis {
    int size, tiles;
    int stride, offset; /* of the grid */
    int points, cells;  /* grid points, and cells of TILE of them */
} axis;

static axis axis_make(int size, int stride, int offset) {
    const int points = offset < size ? (size - offset + stride - 1) / stride : 0;
    return (axis){size, (size + TILE - 1) / TILE, stride, offset, points, (points + TILE - 1) / TILE};
}

/* Whether the cell has points within reach of the tile, the texture being periodic. */
static bool cell_in_reach(const axis *a, int tile, int cell) {
    if (a->size <= 2 * FARTHEST + 1)
        return true;
    const int first = a->offset + cell * TILE * a->stride, last_point = cell * TILE + TILE - 1;
    const int last = a->offset + (last_point < a->points ? last_point : a->points - 1) * a->stride;
    const int from = tile * TILE - FARTHEST, to = tile * TILE + TILE - 1 + FARTHEST;
    for (int turn = -a->size; turn <= a->size; turn += a->size)
        if (first + turn <= to && last + turn >= from)
            return true;
    return false;
}

static btf_result allocate(joint_search_set *r, size_t texels, size_t chunks, size_t blocks, size_t lists) {
    r->texels = texels;
    r->chunks = chunks;
    r->blocks = blocks;
    r->source = malloc(chunks * JOINT_CHUNK * sizeof *r->source);
    r->query = malloc(texels * sizeof *r->query);
    r->first_query = malloc((blocks + 1) * sizeof *r->first_query);
    r->chunk = malloc(lists * sizeof *r->chunk);
    r->first_chunk = malloc(blocks * sizeof *r->first_chunk);
    r->chunk_count = malloc(blocks * sizeof *r->chunk_count);
    return r->source && r->query && r->first_query && r->chunk && r->first_chunk && r->chunk_count
               ? BTF_OK
               : BTF_ERROR_MEMORY;
}

/* Every point looks at every source. */
static btf_result complete(size_t texels, joint_search_set *r) {
    const size_t chunks = (texels + JOINT_CHUNK - 1) / JOINT_CHUNK;
    const size_t blocks = (texels + JOINT_QUERIES - 1) / JOINT_QUERIES;
    const btf_result result = allocate(r, texels, chunks, blocks, chunks);
    if (result != BTF_OK)
        return result;
    r->complete = true;
    r->most_chunks = chunks;
    for (size_t i = 0; i < chunks * JOINT_CHUNK; i++)
        r->source[i] = i < texels ? (uint32_t)i : JOINT_NO_SOURCE;
    for (size_t i = 0; i < texels; i++)
        r->query[i] = (uint32_t)i;
    for (size_t i = 0; i < chunks; i++)
        r->chunk[i] = (uint32_t)i;
    for (size_t b = 0; b < blocks; b++) {
        r->first_query[b] = (uint32_t)(b * JOINT_QUERIES);
        r->first_chunk[b] = 0;
        r->chunk_count[b] = (uint32_t)chunks;
    }
    r->first_query[blocks] = (uint32_t)texels;
    return BTF_OK;
}

/* The sources of one tile, or of one cell of the grid. */
static void fill_chunk(const axis *x, const axis *y, int column, int row, bool grid, uint32_t *out) {
    for (int j = 0; j < TILE; j++)
        for (int i = 0; i < TILE; i++) {
            int cx = column * TILE + i, cy = row * TILE + j;
            if (grid) {
                cx = x->offset + cx * x->stride;
                cy = y->offset + cy * y->stride;
            }
            out[j * TILE + i] = cx < x->size && cy < y->size
                                    ? (uint32_t)cy * (uint32_t)x->size + (uint32_t)cx
                                    : JOINT_NO_SOURCE;
        }
}

/* Tiles around `tile`, then cells in its reach, along one axis; without repetition. Returns how many. */
static int near_tiles(const axis *a, int tile, int window, int *out) {
    const int count = 2 * window + 1 < a->tiles ? 2 * window + 1 : a->tiles;
    for (int i = 0; i < count; i++)
        out[i] = (tile - window + i + a->tiles) % a->tiles;
    return count;
}

static int near_cells(const axis *a, int tile, int *out) {
    int count = 0;
    for (int i = 0; i < a->cells; i++)
        if (cell_in_reach(a, tile, i))
            out[count++] = i;
    return count;
}

/* The sources that a tile's points look at; out may be NULL. */
static size_t list_chunks(const axis *x, const axis *y, int column, int row, int window, int *columns,
                          int *rows, uint32_t *out) {
    size_t count = 0;
    for (int set = 0; set < 2; set++) {
        const int across =
            set == 0 ? near_tiles(x, column, window, columns) : near_cells(x, column, columns);
        const int down = set == 0 ? near_tiles(y, row, window, rows) : near_cells(y, row, rows);
        const uint32_t first = set == 0 ? 0 : (uint32_t)(x->tiles * y->tiles);
        const int pitch = set == 0 ? x->tiles : x->cells;
        for (int j = 0; j < down; j++)
            for (int i = 0; i < across; i++, count++)
                if (out)
                    out[count] = first + (uint32_t)(rows[j] * pitch + columns[i]);
    }
    return count;
}

/* Blocks of points: each tile's, halved. */
static void fill_blocks(const axis *x, const axis *y, int window, int *columns, int *rows,
                        joint_search_set *r) {
    size_t block = 0, points = 0, lists = 0;
    for (int row = 0; row < y->tiles; row++)
        for (int column = 0; column < x->tiles; column++) {
            const size_t count = list_chunks(x, y, column, row, window, columns, rows, r->chunk + lists);
            const uint32_t *tile = r->source + (size_t)(row * x->tiles + column) * JOINT_CHUNK;
            for (int half = 0; half < 2; half++, block++) {
                r->first_query[block] = (uint32_t)points;
                r->first_chunk[block] = (uint32_t)lists;
                r->chunk_count[block] = (uint32_t)count;
                for (int i = 0; i < JOINT_CHUNK / 2; i++) {
                    const uint32_t texel = tile[half * JOINT_CHUNK / 2 + i];
                    if (texel != JOINT_NO_SOURCE)
                        r->query[points++] = texel;
                }
            }
            lists += count;
            r->most_chunks = count > r->most_chunks ? count : r->most_chunks;
        }
    r->first_query[block] = (uint32_t)points;
}

/* Grid points this far apart make about `sources` of them in what a shift reaches. */
static int grid_stride(int width, int height, size_t sources) {
    const double across = width < 256 ? width : 256, down = height < 256 ? height : 256;
    const int stride = (int)ceil(sqrt(across * down / (double)sources));
    return stride > 1 ? stride : 1;
}

btf_result joint_search_set_create(int width, int height, size_t sources, int window, unsigned phase,
                                   joint_search_set *out_set) {
    const size_t texels = (size_t)width * (size_t)height;
    *out_set = (joint_search_set){0};
    if (sources == 0 || texels <= JOINT_EXACT)
        return complete(texels, out_set);
    /* all stride * stride offsets in turn, neither axis still for long */
    const int stride = grid_stride(width, height, sources),
              turn = (int)(phase % (unsigned)(stride * stride));
    const axis x = axis_make(width, stride, turn % stride),
               y = axis_make(height, stride, (3 * (turn % stride) + turn / stride) % stride);
    const int most = (x.tiles > y.tiles ? x.tiles : y.tiles) + 2 * window + 1;
    int *columns = malloc(2 * (size_t)most * sizeof *columns), *rows = columns + most;
    size_t lists = 0;
    if (!columns)
        return BTF_ERROR_MEMORY;
    for (int row = 0; row < y.tiles; row++)
        for (int column = 0; column < x.tiles; column++)
            lists += list_chunks(&x, &y, column, row, window, columns, rows, NULL);
    const size_t tiles = (size_t)x.tiles * (size_t)y.tiles, cells = (size_t)x.cells * (size_t)y.cells;
    const btf_result result = allocate(out_set, texels, tiles + cells, 2 * tiles, lists);
    if (result == BTF_OK) {
        for (size_t i = 0; i < tiles; i++)
            fill_chunk(&x, &y, (int)i % x.tiles, (int)i / x.tiles, false,
                       out_set->source + i * JOINT_CHUNK);
        for (size_t i = 0; i < cells; i++)
            fill_chunk(&x, &y, (int)i % x.cells, (int)i / x.cells, true,
                       out_set->source + (tiles + i) * JOINT_CHUNK);
        fill_blocks(&x, &y, window, columns, rows, out_set);
    }
    free(columns);
    return result;
}

void joint_search_set_clear(joint_search_set *set) {
    free(set->source);
    free(set->query);
    free(set->first_query);
    free(set->chunk);
    free(set->first_chunk);
    free(set->chunk_count);
    *set = (joint_search_set){0};
}
