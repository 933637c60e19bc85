/* Images in a zip, tar or 7zip archive, read through libarchive. Nothing is written to disk.
 *
 * SPDX-License-Identifier: MIT
 */
#include "source_archive.h"

#include <archive.h>
#include <archive_entry.h>

#include <locale.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct archive_source {
    enc_source base;
    char *path;
    size_t *ordinals; /* [base.count] position of each image among all entries of the archive */
    size_t n_ordinals_allocated;
    struct archive *handle; /* open from the first read on */
    size_t next;            /* ordinal of the entry whose header comes next */
    locale_t utf8;          /* 0 where there is none */
} archive_source;

/* Formats and compressions that libarchive handles itself: no helper programs are ever started. */
static struct archive *open_handle(const char *path) {
    struct archive *handle = archive_read_new();
    if (!handle) {
        return NULL;
    }
    archive_read_support_format_zip(handle);
    archive_read_support_format_tar(handle);
    archive_read_support_format_7zip(handle);
    archive_read_support_filter_gzip(handle);
    archive_read_support_filter_bzip2(handle);
    archive_read_support_filter_xz(handle);
    archive_read_support_filter_zstd(handle);
    archive_read_support_filter_lz4(handle);
    archive_read_open_filename(handle, path, 1 << 16); /* a failure shows in the first header */
    return handle;
}

/* Enters a UTF-8 locale, since libarchive recodes names for the thread's locale and loses those that do not
 * fit it. Returns what leave_utf8() takes. */
static locale_t enter_utf8(const archive_source *a) {
    return a->utf8 ? uselocale(a->utf8) : (locale_t)0;
}

static void leave_utf8(locale_t before) {
    if (before) {
        uselocale(before);
    }
}

static const char *name_of(struct archive_entry *entry) {
    const char *name = archive_entry_pathname(entry);
    if (!name) {
        name = archive_entry_pathname_utf8(entry);
    }
    return name ? name : "";
}

/* libarchive's text for the last error, on one line. */
static const char *reason(struct archive *handle) {
    const char *text = handle ? archive_error_string(handle) : NULL;
    return text ? text : "cannot be read";
}

static void close_archive(enc_source *source) {
    archive_source *a = (archive_source *)source;
    if (a->handle) {
        archive_read_free(a->handle);
    }
    enc_source_free_paths(source);
    if (a->utf8) {
        freelocale(a->utf8);
    }
    free(a->ordinals);
    free(a->path);
    free(a);
}

/* Goes on to the header of entry `ordinal`, which lies ahead. */
static int seek_entry(archive_source *a, size_t ordinal, struct archive_entry **out_entry) {
    int status = ARCHIVE_OK;
    const locale_t before = enter_utf8(a);
    while (a->next <= ordinal && (status == ARCHIVE_OK || status == ARCHIVE_WARN)) {
        status = archive_read_next_header(a->handle, out_entry);
        a->next++;
    }
    leave_utf8(before);
    return status;
}

static btf_result read_entry(enc_source *source, size_t index, void **out_data, size_t *out_size,
                             char *message, size_t message_size) {
    archive_source *a = (archive_source *)source;
    struct archive_entry *entry = NULL;
    char *data = NULL;
    size_t size = 0;
    btf_result result = BTF_ERROR_MEMORY;
    if (!a->handle && !(a->handle = open_handle(a->path))) {
        return BTF_ERROR_MEMORY;
    }
    const int status = seek_entry(a, a->ordinals[index], &entry);
    if (status != ARCHIVE_OK && status != ARCHIVE_WARN) {
        snprintf(message, message_size, "%s", reason(a->handle));
        return BTF_ERROR_BAD_FILE;
    }
    /* The size in the header is a hint, not to be trusted: a zip written as a stream does not know it yet. */
    size_t allocated = 1 << 16;
    const int64_t declared = archive_entry_size_is_set(entry) ? archive_entry_size(entry) : 0;
    if (declared > (int64_t)ENC_SOURCE_MAX_FILE) {
        snprintf(message, message_size, "more than %zu bytes", ENC_SOURCE_MAX_FILE);
        return BTF_ERROR_UNSUPPORTED;
    }
    if (declared > 0 && declared < (1 << 24)) {
        allocated = (size_t)declared + 1;
    }
    data = malloc(allocated);
    while (data) {
        const la_ssize_t n = archive_read_data(a->handle, data + size, allocated - size);
        if (n < 0) {
            snprintf(message, message_size, "%s", reason(a->handle));
            result = BTF_ERROR_BAD_FILE;
            break;
        }
        if (n == 0) {
            *out_data = data;
            *out_size = size;
            return BTF_OK;
        }
        size += (size_t)n;
        if (size > ENC_SOURCE_MAX_FILE) {
            snprintf(message, message_size, "more than %zu bytes", ENC_SOURCE_MAX_FILE);
            result = BTF_ERROR_UNSUPPORTED;
            break;
        }
        if (size == allocated) {
            char *longer = realloc(data, 2 * allocated);
            if (!longer) {
                break;
            }
            data = longer;
            allocated *= 2;
        }
    }
    free(data);
    return result;
}

static btf_result add_entry(archive_source *a, const char *name, size_t ordinal, size_t *n_allocated) {
    bool is_image;
    char *path = strdup(name);
    if (!path) {
        return BTF_ERROR_MEMORY;
    }
    for (char *p = path; *p; p++) {
        *p = *p == '\\' ? '/' : *p; /* some Windows programs separate folders with it */
    }
    const btf_result result = enc_source_add(&a->base, path, n_allocated, &is_image);
    free(path);
    if (result != BTF_OK || !is_image) {
        return result;
    }
    if (a->n_ordinals_allocated < *n_allocated) {
        size_t *ordinals = realloc(a->ordinals, *n_allocated * sizeof *ordinals);
        if (!ordinals) {
            return BTF_ERROR_MEMORY;
        }
        a->ordinals = ordinals;
        a->n_ordinals_allocated = *n_allocated;
    }
    a->ordinals[a->base.count - 1] = ordinal;
    return BTF_OK;
}

/* Reads only the names: from the central directory of a zip; a tar has to be gone through as a whole. */
static btf_result list_entries(const enc_context *context, archive_source *a) {
    struct archive *handle = open_handle(a->path);
    if (!handle) {
        return BTF_ERROR_MEMORY;
    }
    btf_result result = BTF_OK;
    size_t n_allocated = 0;
    for (size_t ordinal = 0; result == BTF_OK; ordinal++) {
        struct archive_entry *entry;
        const int status = archive_read_next_header(handle, &entry);
        if (status == ARCHIVE_EOF) {
            break;
        }
        if (status != ARCHIVE_OK && status != ARCHIVE_WARN) {
            const char *what = ordinal == 0 ? "neither a directory nor a zip, tar or 7zip archive: "
                                            : "damaged or truncated archive: ";
            result = enc_fail(context, BTF_ERROR_BAD_FILE, "%s: %s%s", a->path, what, reason(handle));
        } else if (enc_cancelled(context)) {
            result = BTF_ERROR_INTERRUPTED;
        } else if ((archive_entry_filetype(entry) == AE_IFREG || archive_entry_filetype(entry) == 0) &&
                   !archive_entry_hardlink(entry)) { /* a link has no bytes of its own */
            result = add_entry(a, name_of(entry), ordinal, &n_allocated);
            if (result == BTF_ERROR_UNSUPPORTED) {
                enc_fail(context, result, "%s: more than %zu files", a->path, ENC_SOURCE_MAX_ENTRIES);
            }
        }
    }
    archive_read_free(handle);
    return result;
}

btf_result enc_source_open_archive(const enc_context *context, const char *path, enc_source **out_source) {
    archive_source *a = calloc(1, sizeof *a);
    if (!a) {
        return BTF_ERROR_MEMORY;
    }
    a->base.is_sequential = true;
    a->base.read = read_entry;
    a->base.close = close_archive;
    a->path = strdup(path);
    a->base.location = a->path;
    a->utf8 = newlocale(LC_CTYPE_MASK, "C.UTF-8", (locale_t)0);
    const locale_t before = enter_utf8(a);
    const btf_result result = a->path ? list_entries(context, a) : BTF_ERROR_MEMORY;
    leave_utf8(before);
    if (result != BTF_OK) {
        close_archive(&a->base);
        return result;
    }
    *out_source = &a->base;
    return BTF_OK;
}
