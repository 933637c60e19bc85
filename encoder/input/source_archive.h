/* An archive of images as a source.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_SOURCE_ARCHIVE_H
#define OPENBTF_ENCODER_SOURCE_ARCHIVE_H

#include "source.h"

/* Opens an archive: any zip, tar or 7zip that libarchive reads. Only its list of names is read here; its
 * files are read afterwards, once and in order. Nothing is written to disk, so that names which point
 * outside do no harm. Errors, named on the log: BTF_ERROR_IO, BTF_ERROR_BAD_FILE, BTF_ERROR_UNSUPPORTED
 * (too many files), BTF_ERROR_MEMORY, BTF_ERROR_INTERRUPTED. */
btf_result enc_source_open_archive(const enc_context *context, const char *path, enc_source **out_source);

#endif
