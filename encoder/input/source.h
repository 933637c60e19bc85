/* A source of images: a directory or an archive, seen as a list of named byte strings.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_SOURCE_H
#define OPENBTF_ENCODER_SOURCE_H

#include "encoder/base/context.h"

/* The largest image file, and the most files, images or not, that a source may have. */
#ifndef ENC_SOURCE_MAX_FILE /* fuzzers take less */
#define ENC_SOURCE_MAX_FILE ((size_t)1 << 30)
#endif
#define ENC_SOURCE_MAX_ENTRIES ((size_t)1 << 22)

typedef struct enc_source enc_source;
struct enc_source {
    /* The image files (by their extension), with their folders inside the input; the strings belong to the
     * source. Sorted by name in a directory; as they follow one another in an archive. */
    size_t count;
    char **paths;
    size_t n_others;      /* files that are not images */
    size_t n_foreign;     /* of these, images in formats that are not read */
    char *first_foreign;  /* NULL: none */
    bool is_sequential;   /* read in rising order of index, from one thread; else in any order, from any */
    const char *location; /* the folder or archive that holds the paths, for messages */

    /* Reads a whole file: *out_data is malloc'ed, the caller frees. Failures are described in
     * message[message_size], since this may run on a thread that must not log. Errors: BTF_ERROR_IO,
     * BTF_ERROR_BAD_FILE, BTF_ERROR_UNSUPPORTED (size), BTF_ERROR_MEMORY. */
    btf_result (*read)(enc_source *source, size_t index, void **out_data, size_t *out_size, char *message,
                       size_t message_size);
    void (*close)(enc_source *source);
};

void enc_source_close(enc_source **source);

/* Tells the log that an image failed: the source's location, the image's path and `message`, or where that is empty
 * the text of `result`. Returns `result`. */
btf_result enc_source_fail(const enc_context *context, const enc_source *source, size_t index,
                           btf_result result, const char *message);

/* For the kinds of source (source_folder.h, source_archive.h): keeps a copy of a path that names an image,
 * and counts one that does not. n_allocated is the length of source->paths. Errors: BTF_ERROR_UNSUPPORTED
 * (too many), BTF_ERROR_MEMORY. */
btf_result enc_source_add(enc_source *source, const char *path, size_t *n_allocated, bool *out_is_image);
void enc_source_free_paths(enc_source *source);

#endif
