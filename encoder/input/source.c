/* Sources of images: the part that directories and archives share.
 *
 * SPDX-License-Identifier: MIT
 */
#include "source.h"

#include "names.h"

#include <stdlib.h>
#include <string.h>

void enc_source_close(enc_source **source) {
    if (!source || !*source) {
        return;
    }
    (*source)->close(*source);
    *source = NULL;
}

btf_result enc_source_fail(const enc_context *context, const enc_source *source, size_t index,
                           btf_result result, const char *message) {
    return enc_fail(context, result, "%s: %s: %s", source->location, source->paths[index],
                    message[0] ? message : btf_result_text(result));
}

btf_result enc_source_add(enc_source *source, const char *path, size_t *n_allocated, bool *out_is_image) {
    *out_is_image = enc_names_is_image(path);
    if (source->count + source->n_others >= ENC_SOURCE_MAX_ENTRIES) {
        return BTF_ERROR_UNSUPPORTED;
    }
    if (!*out_is_image) {
        source->n_others++;
        if (!enc_names_is_foreign_image(path)) {
            return BTF_OK;
        }
        if (source->n_foreign++ == 0) {
            source->first_foreign = strdup(path);
        }
        return source->first_foreign ? BTF_OK : BTF_ERROR_MEMORY;
    }
    if (source->count == *n_allocated) {
        const size_t n = *n_allocated ? 2 * *n_allocated : 1024;
        char **paths = realloc(source->paths, n * sizeof *paths);
        if (!paths) {
            return BTF_ERROR_MEMORY;
        }
        source->paths = paths;
        *n_allocated = n;
    }
    char *copy = strdup(path);
    if (!copy) {
        return BTF_ERROR_MEMORY;
    }
    source->paths[source->count++] = copy;
    return BTF_OK;
}

void enc_source_free_paths(enc_source *source) {
    for (size_t i = 0; i < source->count; i++) {
        free(source->paths[i]);
    }
    free(source->paths);
    free(source->first_foreign);
}
