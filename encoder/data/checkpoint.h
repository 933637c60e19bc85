/* Checkpoints: what stages have found, kept in a folder, so that a long encode goes on where it was killed.
 *
 * Every stage is deterministic. On resumption the encode runs from its beginning, and each step whose
 * result is in the folder takes it from there instead of working it out: the bytes that come out are the
 * same. Of the ranks (ranks.h), rank 0 alone reads and writes the folder and tells the others, so
 * that a job may go on with another number of ranks.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_CHECKPOINT_H
#define OPENBTF_ENCODER_CHECKPOINT_H

#include "data.h"

typedef struct enc_checkpoint enc_checkpoint;

/* Opens a folder, made when missing. `options` (text) and the data decide whose checkpoint it is. Without
 * `resume` the folder must hold none; with it, one of the same options and data, or none. Errors, naming
 * the folder: BTF_ERROR_USAGE (there is one, and `resume` is off; it is of other options or data),
 * BTF_ERROR_IO, BTF_ERROR_MEMORY. */
btf_result enc_checkpoint_open(const enc_context *context, const char *folder, const char *options,
                               const enc_data *data, bool resume, enc_checkpoint **out_checkpoint);
/* Closes it; removes its files with `remove_files`, and the folder when that leaves it empty. */
void enc_checkpoint_close(enc_checkpoint **checkpoint, bool remove_files);

/* The result of a step: pieces one after the other. All zeros is an empty one. */
typedef struct enc_blob {
    unsigned char *bytes;
    size_t size, room, at;
    bool failed; /* memory ran out, or more was taken than the blob holds */
} enc_blob;

void enc_blob_clear(enc_blob *blob);
void enc_blob_put(enc_blob *blob, const void *piece, size_t size);
/* Fills `piece`, or sets blob->failed and fills it with zeros. */
void enc_blob_take(enc_blob *blob, void *piece, size_t size);
/* enc_blob_take for `count` numbers. A number outside low..high counts as missing too, since a file that is whole
 * may still hold values that no encode makes. */
void enc_blob_take_floats(enc_blob *blob, float *piece, size_t count, float low, float high);
void enc_blob_take_bytes(enc_blob *blob, uint8_t *piece, size_t count, int low, int high);
/* Ends the taking: whether everything was there, and nothing more. Clears the blob. */
bool enc_blob_taken(enc_blob *blob);

/* The ranks meet in enc_checkpoint_open and enc_checkpoint_get.
 *
 * Whether context->checkpoint holds the result of step `name`: if so, *out_blob holds it and the caller
 * clears it. A damaged file is named in a warning and counts as none. */
bool enc_checkpoint_get(const enc_context *context, const char *name, enc_blob *out_blob);
/* Keeps the result of a step, replacing an earlier one of its name, and clears the blob. Does nothing
 * without context->checkpoint. Errors: BTF_ERROR_IO, BTF_ERROR_MEMORY. */
btf_result enc_checkpoint_put(const enc_context *context, const char *name, enc_blob *blob);

#endif
