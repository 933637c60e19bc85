/* OpenBTF: the temporary file that becomes an output, so that no half file is ever seen under the final
 * name.
 *
 * One rule for all that the library and the tools write: the temporary file of NAME is `.NAME.PID-N.tmp`
 * beside it (of a longer NAME its first 200 bytes), locked with flock for as long as its writer lives;
 * whoever writes NAME next removes those that can be locked, for their writers are dead. The library
 * does not export it: the toolkit has a copy of its own.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TEMPORARY_H
#define OPENBTF_TEMPORARY_H

#include <stdbool.h>
#include <stddef.h>

#pragma GCC visibility push(hidden)

enum { BTFI_TEMPORARY_NAME_BYTES = 200 }; /* of NAME; of 255 that file systems allow, 40 are ours */

/* Whether the file name `entry` reads `.NAME.PID-N.tmp` with digits for PID and N; `length` bytes of `name` count. */
bool btfi_is_temporary_of(const char *entry, const char *name, size_t length);

/* Removes what dead writers of `path` left, then creates and locks a new temporary file. Returns its
 * descriptor, open for reading and writing, or -1 with errno set (EISDIR where the path ends in '/').
 * *out_path is malloc'ed, the caller frees; NULL on error. Rename it to `path` before the descriptor is
 * closed: afterwards it counts as stale. Thread-safe. */
int btfi_temporary_create(const char *path, char **out_path);

#pragma GCC visibility pop

#endif
