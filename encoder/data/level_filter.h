/* The BTF of a level of detail: the mean, in linear radiance, of what each of its texels covers.
 *
 * Level i has max(1, W >> i) x max(1, H >> i) texels over the same square of texture coordinates. A texel
 * (c, r) of a w x h level covers columns [c W / w, (c + 1) W / w) and rows likewise, so that for odd sizes
 * the texels of level 0 at its edges count with the part that it covers; every texel of a level covers the
 * same area, and the mean over a level is that of level 0.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_LEVEL_FILTER_H
#define OPENBTF_ENCODER_LEVEL_FILTER_H

#include "data.h"

/* Columns (rows) of a level. */
static inline int enc_level_side(int side, int level) {
    return level < 31 && side >> level > 0 ? side >> level : 1;
}

/* Levels down to 1 x 1: 1 + floor(log2(larger side)). */
int enc_level_count(int width, int height);
/* Texels of levels 1 .. count - 1 together. */
size_t enc_level_further_texels(int width, int height, int count);

/* The box filter above, from `from` to width x height, neither larger than that of `from`; sums are in
 * double, texel by texel in row order. The same for any number of threads. Errors: BTF_ERROR_MEMORY,
 * BTF_ERROR_IO, BTF_ERROR_INTERRUPTED; *out_data is NULL then. */
btf_result enc_level_filter(const enc_context *context, const enc_data *from, int width, int height,
                            enc_data **out_data);

/* Calls `fn` with the data of levels 1 .. count - 1, in this order; they live during the call. Each is
 * filtered from the level before where that divides evenly, which gives the same means, else from `data`.
 * Errors: those of enc_level_filter and of `fn`. */
typedef btf_result (*enc_level_fn)(void *user, int level, const enc_data *data);
btf_result enc_level_each(const enc_context *context, const enc_data *data, int count, enc_level_fn fn,
                          void *user);

#endif
