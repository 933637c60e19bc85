/* Reading a data set of images into a BTF.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_READER_H
#define OPENBTF_ENCODER_READER_H

#include "read_options.h"
#include "encoder/data/data.h"

/* Reads a Bonn .btf file (bonn/reader.h), or a directory or an archive of images whose names say tl, pl, tv
 * and pv (names.h, source.h), or of which a table does (names_table.h), into a BTF. Directions are brought
 * to paper order: theta ascending, then phi ascending from 0. The images have to be one full grid of views
 * and lights, of one size, with a view within 5 degrees of the pole.
 *
 * Every image is read and decoded once (the first twice). Memory, besides enc_data's own samples (in memory
 * up to half of context->memory, else in its scratch file): the linear images of one block, 12 bytes a
 * texel each, together at most 128 MB and an eighth of context->memory (half of it when a scratch file is
 * used, so that it is written in long pieces), but at least one image; up to 64 files of 64 MB in all as
 * they are on disk; and for each thread one image as decoded, plus the linear part of it that is used, 12
 * bytes a pixel.
 *
 * Errors, on the log with file names and counts: BTF_ERROR_USAGE (options), BTF_ERROR_IO,
 * BTF_ERROR_BAD_FILE (missing, duplicate or wrong directions, unequal sizes, damaged images, NaN or
 * infinity, negative values when strict), BTF_ERROR_UNSUPPORTED (formats, too many directions),
 * BTF_ERROR_MEMORY, BTF_ERROR_INTERRUPTED. */
btf_result enc_read(const enc_context *context, const char *input, const enc_read_options *options,
                    enc_data **out_data);

/* Whether the numbers of the options are usable. Errors, on the log with the value: BTF_ERROR_USAGE. */
btf_result enc_read_check(const enc_context *context, const enc_read_options *options);

struct enc_source; /* source.h */

/* Opens the path, a directory or an archive, for reading image by image. Errors, named on the log:
 * BTF_ERROR_IO, BTF_ERROR_BAD_FILE, BTF_ERROR_UNSUPPORTED (too many files), BTF_ERROR_MEMORY,
 * BTF_ERROR_INTERRUPTED. */
btf_result enc_read_source(const enc_context *context, const char *path, struct enc_source **out_source);

#endif
