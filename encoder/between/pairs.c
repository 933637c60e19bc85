/* Images at any directions. See pairs.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "pairs.h"

#include "encoder/input/grid.h"
#include "encoder/input/image.h"
#include "encoder/input/radiance.h"
#include "encoder/input/source.h"

#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { MESSAGE_SIZE = 480 };

struct enc_pairs_source {
    enc_source *source;
    enc_read_options options;
    char table[PATH_MAX]; /* that the options name where a folder brings one along */
    enc_radiance radiance;
    size_t *index;    /* [count]: of the source */
    void *first_file; /* the first image's file, read to learn the size */
    size_t first_size;
    image_notes reported; /* warnings about images so far: once a kind */
    bool reported_negative;
};

static int by_angles(const void *a, const void *b) {
    const enc_direction *x = a, *y = b;
    if (x->theta != y->theta) {
        return x->theta < y->theta ? -1 : 1;
    }
    return (x->phi > y->phi) - (x->phi < y->phi);
}

static int by_pair(const void *a, const void *b) {
    const enc_pair *x = a, *y = b;
    const int views = by_angles(&x->view, &y->view);
    return views != 0 ? views : by_angles(&x->light, &y->light);
}

/* Distinct directions of one side of the images, and the least theta among them. */
static btf_result count_directions(const enc_grid_image *images, size_t count, bool lights,
                                   size_t *out_distinct, double *out_theta) {
    enc_direction *list = malloc((count + 1) * sizeof *list);
    if (!list) {
        return BTF_ERROR_MEMORY;
    }
    for (size_t i = 0; i < count; i++) {
        list[i] = lights ? images[i].light : images[i].view;
    }
    qsort(list, count, sizeof *list, by_angles);
    *out_distinct = 0;
    for (size_t i = 0; i < count; i++) {
        *out_distinct += i == 0 || by_angles(&list[i], &list[i - 1]) != 0;
    }
    *out_theta = count > 0 ? list[0].theta : 0;
    free(list);
    return BTF_OK;
}

/* Lists the images without logging anything: by their names or, where these tell no directions and the
 * folder has a directions.csv, by that. */
static btf_result list_silently(const enc_context *context, const char *path, const enc_source *source,
                                enc_read_options *options, char table[PATH_MAX],
                                enc_grid_image **out_images, size_t *out_count) {
    const enc_context silent = {.threads = context->threads, .memory = context->memory};
    btf_result result = enc_grid_list(&silent, source, options, out_images, out_count);
    if (result != BTF_ERROR_BAD_FILE || options->names ||
        snprintf(table, PATH_MAX, "%s/directions.csv", path) >= PATH_MAX || access(table, R_OK) != 0) {
        return result;
    }
    enc_read_options by_table = *options;
    by_table.names = table;
    result = enc_grid_list(&silent, source, &by_table, out_images, out_count);
    if (result == BTF_OK) {
        *options = by_table;
    }
    return result;
}

btf_result enc_pairs_classify(const enc_context *context, const char *path, const enc_read_options *options,
                              enc_image_set *out_set) {
    enc_source *source = NULL;
    enc_grid_image *images = NULL;
    enc_read_options own = *options;
    char table[PATH_MAX];
    size_t count = 0, views = 0, lights = 0;
    double top = 0, unused;
    *out_set = ENC_SET_GRID;
    btf_result result = enc_read_source(context, path, &source);
    if (result != BTF_OK) {
        return result;
    }
    result = list_silently(context, path, source, &own, table, &images, &count);
    if (result == BTF_OK) {
        result = count_directions(images, count, false, &views, &top);
    }
    if (result == BTF_OK) {
        result = count_directions(images, count, true, &lights, &unused);
    }
    /* A whole grid has a view from the top. One with more than half of its images counts as a grid all the
     * same, so that the reader can name those it lacks. Directions drawn at random form far less than half
     * of a grid. */
    if (result == BTF_OK &&
        (2 * count <= views * lights || (count == views * lights && top > ENC_GRID_POLE_DISTANCE))) {
        *out_set = ENC_SET_PAIRS;
    }
    free(images);
    enc_source_close(&source);
    return result == BTF_ERROR_BAD_FILE ? BTF_OK : result; /* the reader says what is wrong */
}

/* Lists all images with their directions, in the order of the source. */
static btf_result list_pairs(const enc_context *context, const char *path, enc_pairs *pairs) {
    enc_pairs_source *s = pairs->source;
    enc_grid_image *images = NULL;
    size_t count = 0;
    list_silently(context, path, s->source, &s->options, s->table, &images, &count);
    free(images); /* listed again, now with its messages */
    btf_result result = enc_grid_list(context, s->source, &s->options, &images, &count);
    if (result == BTF_OK) {
        pairs->pair = malloc(count * sizeof *pairs->pair);
        s->index = malloc(count * sizeof *s->index);
        result = pairs->pair && s->index ? BTF_OK : BTF_ERROR_MEMORY;
    }
    for (size_t i = 0; result == BTF_OK && i < count; i++) {
        s->index[i] = images[i].source;
        pairs->pair[pairs->count++] = (enc_pair){
            .view = images[i].view, .light = images[i].light, .name = s->source->paths[images[i].source]};
    }
    free(images);
    return result;
}

static btf_result check_distinct(const enc_context *context, const enc_pairs *pairs) {
    enc_pair *sorted = malloc(pairs->count * sizeof *sorted);
    btf_result result = BTF_OK;
    if (!sorted) {
        return BTF_ERROR_MEMORY;
    }
    memcpy(sorted, pairs->pair, pairs->count * sizeof *sorted);
    qsort(sorted, pairs->count, sizeof *sorted, by_pair);
    for (size_t i = 1; i < pairs->count && result == BTF_OK; i++) {
        if (by_pair(&sorted[i - 1], &sorted[i]) == 0) {
            result = enc_fail(
                context, BTF_ERROR_BAD_FILE, "%s: two images of view (%g,%g) and light (%g,%g): %s, %s",
                pairs->source->source->location, sorted[i].view.theta, sorted[i].view.phi,
                sorted[i].light.theta, sorted[i].light.phi, sorted[i - 1].name, sorted[i].name);
        }
    }
    free(sorted);
    return result;
}

static btf_result report(const enc_context *context, const enc_pairs *pairs, size_t i, btf_result result,
                         const char *message) {
    return enc_source_fail(context, pairs->source->source, pairs->source->index[i], result, message);
}

/* Reads the first image, whose size all others must have. */
static btf_result settle_size(const enc_context *context, enc_pairs *pairs) {
    enc_pairs_source *s = pairs->source;
    const btf_result result = enc_radiance_settle_first(context, &s->options, s->source, s->index[0],
                                                        &s->first_file, &s->first_size, &s->radiance);
    pairs->width = s->radiance.width;
    pairs->height = s->radiance.height;
    return result;
}

btf_result enc_pairs_open(const enc_context *context, const char *path, const enc_read_options *options,
                          enc_pairs **out_pairs) {
    enc_pairs *pairs = calloc(1, sizeof *pairs);
    btf_result result = BTF_ERROR_MEMORY;
    *out_pairs = NULL;
    if (pairs && (pairs->source = calloc(1, sizeof *pairs->source))) {
        pairs->source->options = *options;
        result = BTF_OK;
    }
    if (result == BTF_OK && options->components > 0) {
        result = enc_fail(context, BTF_ERROR_USAGE,
                          "%s: option components is only for a Bonn .btf file, which this is not", path);
    }
    if (result == BTF_OK && options->coincident) {
        result =
            enc_fail(context, BTF_ERROR_USAGE,
                     "%s: option coincident is only for a data set, and these are single images", path);
    }
    if (result == BTF_OK) {
        result = enc_read_source(context, path, &pairs->source->source);
    }
    if (result == BTF_OK) {
        result = list_pairs(context, path, pairs);
    }
    if (result == BTF_OK) {
        result = check_distinct(context, pairs);
    }
    if (result == BTF_OK) {
        result = settle_size(context, pairs);
    }
    if (result != BTF_OK) {
        enc_pairs_close(&pairs);
    }
    *out_pairs = pairs;
    return result == BTF_ERROR_MEMORY ? enc_fail(context, result, "%s: out of memory", path) : result;
}

void enc_pairs_close(enc_pairs **pairs) {
    if (!pairs || !*pairs) {
        return;
    }
    enc_pairs_source *s = (*pairs)->source;
    if (s) {
        free(s->first_file);
        free(s->index);
        enc_radiance_clear(&s->radiance);
        enc_source_close(&s->source);
        free(s);
    }
    free((*pairs)->pair);
    free(*pairs);
    *pairs = NULL;
}

/* Logs the notes of an image about its pixels, unless another image had them before. */
static void tell(const enc_context *context, const enc_pairs *pairs, size_t i, const image_notes *notes) {
    image_notes *reported = &pairs->source->reported;
    for (int k = 0; k < IMAGE_NOTE_KINDS; k++) {
        if (!notes->texts[k][0] || reported->texts[k][0]) {
            continue;
        }
        reported->texts[k][0] = 1;
        enc_log(context, image_note_warns((image_note_kind)k) ? BTF_LOG_WARNING : BTF_LOG_INFO,
                "%s: %s: %s", pairs->source->source->location, pairs->pair[i].name, notes->texts[k]);
    }
}

/* Logs that values below 0 of an image are set to 0, unless another image had such values before. */
static void tell_negative(const enc_context *context, const enc_pairs *pairs, size_t i, size_t negative) {
    if (negative == 0 || pairs->source->reported_negative) {
        return;
    }
    pairs->source->reported_negative = true;
    enc_log(context, BTF_LOG_WARNING,
            "%s: %s: %zu samples below 0 were set to 0, and so are those of further images (option strict "
            "refuses them)",
            pairs->source->source->location, pairs->pair[i].name, negative);
}

/* Fetches the file of image i. The first one was read already: a sequential source gives it only once. */
static btf_result fetch(const enc_pairs *pairs, size_t i, void **out_file, size_t *out_size,
                        char *message) {
    enc_pairs_source *s = pairs->source;
    if (i == 0 && s->first_file) {
        *out_file = s->first_file;
        *out_size = s->first_size;
        s->first_file = NULL;
        return BTF_OK;
    }
    return s->source->read(s->source, s->index[i], out_file, out_size, message, MESSAGE_SIZE);
}

btf_result enc_pairs_read(const enc_context *context, const enc_pairs *pairs, size_t i, float *out) {
    const enc_pairs_source *s = pairs->source;
    char message[MESSAGE_SIZE] = "";
    image_notes notes = {0};
    void *file = NULL;
    size_t size = 0, negative = 0;
    btf_result result = fetch(pairs, i, &file, &size, message);
    if (result == BTF_OK) {
        result = enc_radiance_convert(&s->radiance, file, size, pairs->pair[i].light.xyz[2], out, &negative,
                                      &notes, message, sizeof message);
    }
    free(file);
    if (result != BTF_OK) {
        return report(context, pairs, i, result, message);
    }
    tell(context, pairs, i, &notes);
    tell_negative(context, pairs, i, negative);
    return BTF_OK;
}
