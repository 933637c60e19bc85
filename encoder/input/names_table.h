/* The directions of images from a table (--names), for data sets whose names do not give them.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_NAMES_TABLE_H
#define OPENBTF_ENCODER_NAMES_TABLE_H

#include "encoder/base/context.h"
#include "names.h"
#include "source.h"

typedef struct enc_names_table enc_names_table;

/* Reads a table (csv.h) of file, theta_v, phi_v, theta_l, phi_l, degrees, and finds its files among those
 * of the source. A line of names before the first image may give the columns another order and add others.
 * A file stands with or without its folders: "a.png", "folder/a.png", "SET/folder/a.png".
 *
 * Warnings tell how many images the table lacks, and how many of its files are not there. Errors, on the
 * log with table, line and value: those of text_read; BTF_ERROR_BAD_FILE (a line that has not these fields,
 * a theta that is not at least 0 and below 90, an image twice, a file name that several images have, no
 * image of the source at all unless `may_miss_all`), BTF_ERROR_MEMORY. */
btf_result enc_names_table_read(const enc_context *context, const char *path, const enc_source *source,
                                bool may_miss_all, enc_names_table **out_table);
void enc_names_table_destroy(enc_names_table **table);

/* The angles of an image of the source, or NULL. */
const enc_angles *enc_names_table_angles(const enc_names_table *table, size_t index);

/* The number of images of the source that the table names. */
size_t enc_names_table_count(const enc_names_table *table);

#endif
