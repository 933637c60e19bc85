/* Unlinked scratch files, for data that do not fit the allowed memory.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_SCRATCH_H
#define OPENBTF_ENCODER_SCRATCH_H

#include "context.h"
#include <stdint.h>

/* Predicted core seconds to read a float from a scratch file, on one core of an AMD EPYC (Zen 4). */
#define ENC_SCRATCH_SECONDS 1.5e-9

/* Opens an unlinked file of `size` zero bytes in $TMPDIR (default /var/tmp), after checking the free space
 * there. `what` names its contents in messages. Close it with close(). Errors: BTF_ERROR_IO,
 * BTF_ERROR_MEMORY. */
btf_result enc_scratch_open(const enc_context *context, const char *what, uint64_t size, int *out_fd);

/* Finds the folder for scratch files and checks the free space there. *out_folder is owned by the
 * environment. Errors: BTF_ERROR_IO. */
btf_result enc_scratch_folder(const enc_context *context, uint64_t size, const char **out_folder);

/* Opens one scratch file for all ranks, which rank 0 makes in the folder that enc_scratch_folder finds.
 * Where the ranks are on one machine, the file has no name afterwards, and *out_path is NULL. Else it keeps
 * its name until it is removed; the next rank 0 on that machine removes files that a dead one left. After
 * an error no file stays. Errors: BTF_ERROR_IO, naming rank, machine and folder; BTF_ERROR_MEMORY. */
btf_result enc_scratch_open_shared(const enc_context *context, const char *what, uint64_t size, int *out_fd,
                                   char **out_path);
/* Waits until all ranks have written their parts; from then on each can read what any of them wrote. Ranks other
 * than 0 forget *io_path, which rank 0 is to remove. Errors: `result`, BTF_ERROR_IO. */
btf_result enc_scratch_written(const enc_context *context, btf_result result, int *io_fd, char **io_path);

/* Reads or writes `size` bytes at `offset`. Thread-safe. Errors: BTF_ERROR_IO. */
btf_result enc_scratch_read(const enc_context *context, int fd, uint64_t offset, size_t size, void *buffer);
btf_result enc_scratch_write(const enc_context *context, int fd, uint64_t offset, size_t size,
                             const void *buffer);

#endif
