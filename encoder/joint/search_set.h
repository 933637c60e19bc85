/* Which sources a point looks at.
 *
 * Up to JOINT_EXACT of them, all. Beyond, two sets: the sources of the point's own tile of 16 x 16 texels
 * and of the tiles around it within `window`; and a grid of about `sources` over all that a shift reaches.
 * The grid moves with `phase`, so that in the course of the rounds every source comes by. Sources near
 * the best of them is left to the search itself.
 *
 * Points are taken in blocks that share their sources, sources in chunks of 256.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_JOINT_SEARCH_SET_H
#define OPENBTF_ENCODER_JOINT_SEARCH_SET_H

#include <openbtf/result.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum {
    JOINT_EXACT = 4096,  /* texels up to which every point looks at every source: 64x64 */
    JOINT_CHUNK = 256,   /* sources */
    JOINT_QUERIES = 132, /* points of a block at most: a multiple of ENC_GEMM_M */
};

#define JOINT_NO_SOURCE UINT32_MAX

typedef struct joint_search_set {
    size_t texels, chunks, blocks;
    uint32_t *source;      /* [chunk][JOINT_CHUNK] texel of a source, or JOINT_NO_SOURCE */
    uint32_t *query;       /* [texel] points in the order of blocks */
    uint32_t *first_query; /* [block + 1] */
    uint32_t *chunk;       /* chunks in the order of blocks */
    uint32_t *first_chunk; /* [block]: the first of a block's chunks ... */
    uint32_t *chunk_count; /* [block]: ... and their number */
    size_t most_chunks;    /* the largest number */
    bool complete;         /* every point looks at every source */
} joint_search_set;

/* sources 0: all, whatever their number. Free with joint_search_set_clear in any case. Errors:
 * BTF_ERROR_MEMORY.
 */
btf_result joint_search_set_create(int width, int height, size_t sources, int window, unsigned phase,
                                   joint_search_set *out_set);
void joint_search_set_clear(joint_search_set *set);

#endif
