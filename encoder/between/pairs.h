/* Images at any directions: pairs of a view and a light with the image that is true there, such as
 * `btf-sample --between` and renderers write. Unlike a data set they need not form a grid.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_PAIRS_H
#define OPENBTF_ENCODER_PAIRS_H

#include "encoder/input/reader.h"

typedef struct enc_pair {
    enc_direction view, light;
    const char *name; /* the image's path inside the folder or archive; belongs to the pairs */
} enc_pair;

typedef struct enc_pairs_source enc_pairs_source;

typedef struct enc_pairs {
    size_t count; /* at least 1 */
    enc_pair *pair;
    int width, height; /* of every image, after crop and size */
    enc_pairs_source *source;
} enc_pairs;

/* The two kinds of image sets in a folder or an archive, told by the directions that their names say. */
typedef enum enc_image_set {
    ENC_SET_GRID,  /* every view under every light, or more than half of these; enc_read reads it, or names the
                      images that are missing */
    ENC_SET_PAIRS, /* any directions */
} enc_image_set;

/* Tells the two apart without reading an image. Names that cannot be understood are left to the reader that
 * the answer leads to. Errors, on the log: those of enc_read_source, BTF_ERROR_MEMORY. */
btf_result enc_pairs_classify(const enc_context *context, const char *path, const enc_read_options *options,
                              enc_image_set *out_set);

/* Opens a folder or an archive: understands all names and reads the first image, which settles the size;
 * the others are read when asked for. Names and options are those of enc_read; where the names of a
 * folder's images do not tell directions and options have no table, one called directions.csv that lies in
 * it does. Errors, on the log with the file's name: those of enc_read_source; BTF_ERROR_USAGE (options that
 * have no meaning for pairs), BTF_ERROR_BAD_FILE (no name with directions, a theta not in 0..90, one pair
 * twice, a damaged image), BTF_ERROR_UNSUPPORTED, BTF_ERROR_MEMORY. */
btf_result enc_pairs_open(const enc_context *context, const char *path, const enc_read_options *options,
                          enc_pairs **out_pairs);
void enc_pairs_close(enc_pairs **pairs);

/* Image i as linear radiance, out[row][column][3], values below 0 set to 0 (refused where options say
 * strict). To be called from one thread, by rising i. Errors, on the log with the file's name: those of the
 * file, BTF_ERROR_BAD_FILE (another size than the first image's, a value that is not finite),
 * BTF_ERROR_MEMORY. */
btf_result enc_pairs_read(const enc_context *context, const enc_pairs *pairs, size_t i, float *out);

#endif
