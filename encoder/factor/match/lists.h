/* Short lists: a texel takes its sources and gains, in all views, from a list of a few.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_FACTOR_MATCH_LISTS_H
#define OPENBTF_ENCODER_FACTOR_MATCH_LISTS_H

#include "encoder/factor/matrix.h"
#include "match.h"

/* Some columns and rows of texels, around the edge of the texture where they are too many. */
typedef struct enc_match_area {
    int x, y, width, height;
} enc_match_area;

static inline size_t enc_match_area_texels(const enc_match_area *area) {
    return (size_t)area->width * (size_t)area->height;
}

/* The texel of a place in an area, and the place of a texel that is there. */
static inline size_t enc_match_texel(const enc_match *match, const enc_match_area *area, size_t place) {
    const int x = area->x + (int)place % area->width, y = area->y + (int)place / area->width;
    return (size_t)(y % match->height) * (size_t)match->width + (size_t)(x % match->width);
}

static inline size_t enc_match_place(const enc_match *match, const enc_match_area *area, size_t texel) {
    const int x = (int)(texel % (size_t)match->width) - area->x,
              y = (int)(texel / (size_t)match->width) - area->y;
    return (size_t)(y < 0 ? y + match->height : y) * (size_t)area->width +
           (size_t)(x < 0 ? x + match->width : x);
}

/* Coordinates of profiles in the leading directions of their view: of all points of a block of texels, and
 * of every source that one of these reaches. */
typedef struct enc_match_coordinates {
    size_t k;
    enc_match_area block, sources;
    float *query;  /* [view][place in block][k] of the samples */
    float *source; /* [view][place in sources][k] of profiles as the factors give them */
    float *norm;   /* [view][place in sources] their squared lengths */
} enc_match_coordinates;

/* The number of blocks of a texture, and one of them without its coordinates. */
int enc_match_blocks(const enc_match *match);
enc_match_coordinates enc_match_block(const enc_match *match, size_t k, int block);
/* Bytes of the coordinates of a block at most; whole: with the sources of the whole texture. */
uint64_t enc_match_block_memory(int width, int height, size_t views, size_t k, bool whole);

/* Makes room for the coordinates of all views. Errors: BTF_ERROR_MEMORY. */
btf_result enc_match_coordinates_create(const enc_context *context, size_t views,
                                        enc_match_coordinates *io_coordinates);
void enc_match_coordinates_clear(enc_match_coordinates *coordinates);

/* The inner product of k coordinates, in one order for any width of vectors. */
float enc_match_dot(size_t k, const float *a, const float *b);

/* Chooses for each texel of the block, among the pairs of source and gain that its views have, the
 * `entries` that leave the least error one after the other, and gives each view the best of them; with 0
 * entries, pairs stay. Does not count users. Adds to *io_error the squared error left, in the same
 * coordinates as a search. Errors: BTF_ERROR_MEMORY. */
btf_result enc_match_restrict(const enc_context *context, const enc_match_coordinates *at, size_t entries,
                              enc_match *io_match, double *io_error);

#endif
