/* Image files for the readers' tests, made byte by byte or with features that OpenBTF's own writers never use.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TESTS_IMAGE_FILES_H
#define OPENBTF_TESTS_IMAGE_FILES_H

#include <stdbool.h>
#include <stddef.h>

/* Each writes a file, or fails the running test. Pixels are [row][column][channel], row 0 at the top. */

typedef enum hdr_coding { HDR_FLAT, HDR_OLD_RUNS, HDR_NEW_RUNS } hdr_coding;
/* rgbe: 4 bytes a pixel. `header` holds lines to add, each ended by '\n'; `upwards` writes +Y. */
void write_hdr(const char *path, int width, int height, const unsigned char *rgbe, hdr_coding coding,
               const char *header, bool upwards);

/* Any PNG: libpng's colour type and bit depth; rows as libpng wants them (16 bits big endian). palette: 3 *
 * 256 bytes or NULL. */
void write_png(const char *path, int width, int height, int colour_type, int depth, bool interlaced,
               const unsigned char *pixels, const unsigned char *palette);

/* A two-part EXR whose first part is tiled (8x8) and holds `n` channels of half floats named by the letters
 * of `names`, in rising order; the second part is a scan-line image of one channel. The data window begins
 * at (-3, 5). */
void write_exr_tiled(const char *path, int width, int height, int n, const char *names,
                     const float *pixels);

/* Whole files. *out_size bytes, malloc'ed. */
void *read_whole_file(const char *path, size_t *out_size);
void write_whole_file(const char *path, const void *data, size_t size);

#endif
