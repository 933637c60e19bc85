/* Notices about the images of a data set: one line for each kind, with a count, in place of one for each
 * image.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_NOTICES_H
#define OPENBTF_ENCODER_NOTICES_H

#include "encoder/base/context.h"

typedef struct enc_notices enc_notices;

/* NULL when out of memory. */
enc_notices *enc_notices_create(void);
void enc_notices_destroy(enc_notices **notices);

/* Notes that a file holds something that is ignored, or not understood as its author may think (a warning),
 * or that what the file says changes how it is read (information). `kind` groups files ("colour profile"),
 * which share a level; `text` says of this file, with the value met, what that is and what to do. All three
 * are copied. A file is to be noted once a kind. Callable from any thread; notices may be NULL: nothing is
 * noted. If memory runs out, enc_notices_tell returns BTF_ERROR_MEMORY. */
void enc_notices_add(enc_notices *notices, btf_log_level level, const char *kind, const char *file,
                     const char *text);

/* Logs all notices, each at its level, a line for each kind, and forgets them:
 *
 *     LOCATION: first.png: TEXT
 *     LOCATION: 81 images: first.png: TEXT
 *     LOCATION: 81 images, with other values too: first.png: TEXT
 *
 * `first` is the file whose name comes first in the order of bytes, whatever thread or rank noted it; lines
 * come in the order of their kinds. Like the functions of ranks.h it is met by all ranks, and begins with
 * their agreement on `result`; the notices of all are told together. A rank that leaves tells what it noted
 * itself. Returns the agreed result. Errors beside: BTF_ERROR_MEMORY. */
btf_result enc_notices_tell(const enc_context *context, btf_result result, enc_notices *notices,
                            const char *location);

#endif
