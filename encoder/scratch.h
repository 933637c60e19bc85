/* Unlinked scratch files, for what does not fit the allowed memory.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_SCRATCH_H
#define OPENBTF_ENCODER_SCRATCH_H

#include "context.h"
#include <stdint.h>

/* Opens an unlinked file of `size` zero bytes in $TMPDIR (default /var/tmp), after a look at the free space
 * there. `what` names its contents in messages. Close it with close(). Errors: BTF_ERROR_IO,
 * BTF_ERROR_MEMORY. */
btf_result enc_scratch_open(const enc_context *context, const char *what, uint64_t size, int *out_fd);

/* Reads or writes `size` bytes at `offset`. Thread-safe. Errors: BTF_ERROR_IO. */
btf_result enc_scratch_read(const enc_context *context, int fd, uint64_t offset, size_t size, void *buffer);
btf_result enc_scratch_write(const enc_context *context, int fd, uint64_t offset, size_t size,
                             const void *buffer);

#endif
