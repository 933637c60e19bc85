/* A directory of images as a source.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_SOURCE_FOLDER_H
#define OPENBTF_ENCODER_SOURCE_FOLDER_H

#include "source.h"

/* Searches a directory recursively. Links to folders are followed, to a depth of 32, but for those
 * that lead back. Entries that cannot be opened (no permission, a dangling link, a pipe) are left out with
 * a warning. Errors, named on the log: BTF_ERROR_IO, BTF_ERROR_UNSUPPORTED (too many files),
 * BTF_ERROR_MEMORY, BTF_ERROR_INTERRUPTED. */
btf_result enc_source_open_directory(const enc_context *context, const char *path, enc_source **out_source);

#endif
