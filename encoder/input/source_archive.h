/* An archive of images as a source.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_SOURCE_ARCHIVE_H
#define OPENBTF_ENCODER_SOURCE_ARCHIVE_H

#include "source.h"

/* An archive is anything zip, tar or 7zip that libarchive reads; only its list of names is read here, and its
 * files then once, in order. Nothing is ever written to disk, so that names may point anywhere. Errors, named
 * on the log: BTF_ERROR_IO, BTF_ERROR_BAD_FILE, BTF_ERROR_UNSUPPORTED (too many files), BTF_ERROR_MEMORY,
 * BTF_ERROR_INTERRUPTED. */
btf_result enc_source_open_archive(const enc_context *context, const char *path, enc_source **out_source);

#endif
