/* A folder of files that is whole or absent: it is filled under a temporary name beside its place, then renamed.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_SHADER_FOLDER_H
#define OPENBTF_SHADER_FOLDER_H

#include <openbtf/result.h>
#include <stdbool.h>

typedef struct folder folder;

/* Whether a file of this name is one that the caller writes: a folder is only replaced that holds no others. */
typedef bool folder_is_ours(const char *name);

/* Makes the temporary folder `.NAME.PID-N.tmp` beside `path` and keeps it locked with flock until it is committed or
 * aborted; first removes those that can be locked, for their writers are dead (decoder/temporary.h). NFS does not tell
 * other hosts of a folder's lock: there two hosts must not write one `path` at the same time. Where `path` is there:
 * with `replace` it must be a folder that holds nothing but files of ours, without it an empty one. Errors, on the
 * log: BTF_ERROR_IO, BTF_ERROR_MEMORY. */
btf_result folder_open(const char *path, bool replace, folder_is_ours *is_ours, const btf_log *log,
                       folder **out_folder);

/* The path of a file in the folder while it is being filled; valid until the next call. NULL where it is too long. */
const char *folder_file(folder *f, const char *name);

/* Renames the folder to its place, where the one that was there is exchanged for it and removed; nulls *f. On failure
 * all is as it was before. Errors, on the log: BTF_ERROR_IO. */
btf_result folder_commit(folder **f);

/* Removes the temporary folder and nulls *f. Does nothing where *f is NULL. */
void folder_abort(folder **f);

#endif
