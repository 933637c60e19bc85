/* Notices about the images of a data set. See notices.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "notices.h"

#include "encoder/base/ranks.h"

#include <pthread.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

typedef struct notice {
    char *kind, *file, *text;
    uint64_t files;
    bool differs; /* the files' texts are not all the same */
    btf_log_level level;
} notice;

struct enc_notices {
    pthread_mutex_t lock;
    notice *items;
    size_t count;
    bool lost; /* out of memory */
};

enc_notices *enc_notices_create(void) {
    enc_notices *n = calloc(1, sizeof *n);
    if (n && pthread_mutex_init(&n->lock, NULL) != 0) {
        free(n);
        n = NULL;
    }
    return n;
}

static void clear(enc_notices *n) {
    for (size_t i = 0; i < n->count; i++) {
        free(n->items[i].kind);
        free(n->items[i].file);
        free(n->items[i].text);
    }
    free(n->items);
    n->items = NULL;
    n->count = 0;
}

void enc_notices_destroy(enc_notices **notices) {
    if (!notices || !*notices) {
        return;
    }
    clear(*notices);
    pthread_mutex_destroy(&(*notices)->lock);
    free(*notices);
    *notices = NULL;
}

/* The notice of a kind, made where there is none yet; NULL when out of memory. */
static notice *of_kind(enc_notices *n, btf_log_level level, const char *kind) {
    for (size_t i = 0; i < n->count; i++) {
        if (strcmp(n->items[i].kind, kind) == 0) {
            return &n->items[i];
        }
    }
    notice *items = realloc(n->items, (n->count + 1) * sizeof *items);
    if (!items) {
        return NULL;
    }
    n->items = items;
    items[n->count] = (notice){.kind = strdup(kind), .level = level};
    return items[n->count].kind ? &items[n->count++] : NULL;
}

/* Adds `files` files with one text, of which `file` is first. */
static bool merge(enc_notices *n, btf_log_level level, const char *kind, const char *file, const char *text,
                  uint64_t files, bool differs) {
    notice *item = of_kind(n, level, kind);
    if (!item) {
        return false;
    }
    item->differs = item->differs || differs || (item->text && strcmp(item->text, text) != 0);
    item->files += files;
    if (item->file && strcmp(item->file, file) <= 0) {
        return true;
    }
    char *new_file = strdup(file), *new_text = strdup(text);
    if (!new_file || !new_text) {
        free(new_file);
        free(new_text);
        return false;
    }
    free(item->file);
    free(item->text);
    item->file = new_file;
    item->text = new_text;
    return true;
}

void enc_notices_add(enc_notices *notices, btf_log_level level, const char *kind, const char *file,
                     const char *text) {
    if (!notices) {
        return;
    }
    pthread_mutex_lock(&notices->lock);
    if (!merge(notices, level, kind, file, text, 1, false)) {
        notices->lost = true;
    }
    pthread_mutex_unlock(&notices->lock);
}

/* Packs notices for other ranks, each as its count, whether texts differ, its level, and three strings with
 * their terminating zeros. */
static char *pack(const enc_notices *n, size_t *out_size) {
    size_t size = 0, at = 0;
    for (size_t i = 0; i < n->count; i++) {
        if (n->items[i].file) {
            size += sizeof n->items[i].files + 2 + strlen(n->items[i].kind) + strlen(n->items[i].file) +
                    strlen(n->items[i].text) + 3;
        }
    }
    char *bytes = malloc(size + 1);
    for (size_t i = 0; i < n->count && bytes; i++) {
        const notice *item = &n->items[i];
        if (!item->file) {
            continue;
        }
        const char *const texts[3] = {item->kind, item->file, item->text};
        memcpy(bytes + at, &item->files, sizeof item->files);
        at += sizeof item->files;
        bytes[at++] = (char)item->differs;
        bytes[at++] = (char)item->level;
        for (int k = 0; k < 3; k++) {
            memcpy(bytes + at, texts[k], strlen(texts[k]) + 1);
            at += strlen(texts[k]) + 1;
        }
    }
    *out_size = size;
    return bytes;
}

static bool unpack(enc_notices *n, const char *bytes, size_t size) {
    for (const char *p = bytes, *end = bytes + size; p < end;) {
        uint64_t files;
        const char *texts[3];
        memcpy(&files, p, sizeof files);
        p += sizeof files;
        const bool differs = *p++;
        const btf_log_level level = (btf_log_level)*p++;
        for (int k = 0; k < 3; k++, p += strlen(p) + 1) {
            texts[k] = p;
        }
        if (!merge(n, level, texts[0], texts[1], texts[2], files, differs)) {
            return false;
        }
    }
    return true;
}

/* Gives every rank the notices of all. */
static btf_result gather(const enc_context *context, btf_result result, enc_notices *n) {
    const size_t ranks = (size_t)enc_ranks_count(context), own = (size_t)enc_ranks_own(context);
    size_t size = 0, *bounds = calloc(ranks + 1, sizeof *bounds), *sizes = calloc(ranks, sizeof *sizes);
    char *mine = pack(n, &size), *all = NULL;
    if (!bounds || !sizes || !mine) {
        if (result == BTF_OK) {
            result = BTF_ERROR_MEMORY;
        }
    } else {
        sizes[own] = size;
    }
    result = enc_ranks_gather(context, result, sizes, sizeof *sizes, ranks);
    for (size_t r = 0; r < ranks && result == BTF_OK; r++) {
        bounds[r + 1] = bounds[r] + sizes[r];
    }
    if (result == BTF_OK && !(all = malloc(bounds[ranks] + 1))) {
        result = BTF_ERROR_MEMORY;
    }
    if (result == BTF_OK) {
        memcpy(all + bounds[own], mine, size);
    }
    result = enc_ranks_gather_bounds(context, result, all, 1, bounds);
    if (result == BTF_OK) {
        clear(n);
        if (!unpack(n, all, bounds[ranks])) {
            result = BTF_ERROR_MEMORY;
        }
    }
    free(all);
    free(mine);
    free(sizes);
    free(bounds);
    return result;
}

static int by_kind(const void *a, const void *b) {
    return strcmp(((const notice *)a)->kind, ((const notice *)b)->kind);
}

btf_result enc_notices_tell(const enc_context *context, btf_result result, enc_notices *notices,
                            const char *location) {
    if (result == BTF_OK && notices->lost) {
        result = BTF_ERROR_MEMORY;
    }
    result = enc_ranks_count(context) > 1 ? gather(context, result, notices) : result;
    if (notices->count > 1) {
        qsort(notices->items, notices->count, sizeof *notices->items, by_kind);
    }
    for (size_t i = 0; i < notices->count; i++) {
        const notice *item = &notices->items[i];
        if (item->file && item->files == 1) {
            enc_log(context, item->level, "%s: %s: %s", location, item->file, item->text);
        } else if (item->file) {
            enc_log(context, item->level, "%s: %llu images%s: %s: %s", location,
                    (unsigned long long)item->files, item->differs ? ", with other values too" : "",
                    item->file, item->text);
        }
    }
    clear(notices);
    return result;
}
