/* Reading a data set of images into a BTF: list, decode in blocks, transpose to texel-major order.
 *
 * SPDX-License-Identifier: MIT
 */
#include "reader.h"

#include "encoder/base/stage.h"
#include "decoder/toolkit/file.h"
#include "encoder/data/extent.h"
#include "encoder/input/bonn/file.h"
#include "encoder/input/bonn/reader.h"
#include "light_positions.h"
#include "grid.h"
#include "notices.h"
#include "radiance.h"
#include "encoder/base/ranks.h"
#include "source_archive.h"
#include "source_folder.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

enum {
    BATCH_FILES = 64,        /* the most files in memory at once, as they are on disk */
    BATCH_BYTES = 64 << 20,  /* bytes of such files from which on no more are taken */
    BLOCK_BYTES = 128 << 20, /* bytes of a block's linear images, at most where the samples lie in memory */
    CHUNK = 16,              /* texels transposed together: one cache line of each plane */
    MESSAGE_SIZE = 480,      /* room for the channels of an OpenEXR file */
};

/* A file of a batch, and its result. */
typedef struct batch_file {
    void *data;
    size_t size;
    btf_result result;
    char message[MESSAGE_SIZE];
    size_t negative; /* samples below 0 */
    image_notes notes;
} batch_file;

typedef struct reader {
    const enc_context *context;
    const enc_read_options *options;
    enc_source *source;
    enc_grid *grid;
    size_t *mine, n_mine; /* items of the grid that this process reads, ascending: its share of the views */
    enc_data *data;
    int threads;
    enc_radiance radiance; /* how images are converted; their size */

    void *first_file; /* the first image's file, read to learn the size */
    size_t first_size;

    size_t block;  /* images in a block */
    float *planes; /* [block][channel][texel] */
    uint64_t negative;
    size_t n_negative_files, first_negative;
    enc_notices *notices; /* about single images */
} reader;

static const char *path_of(const reader *r, size_t item) {
    return r->source->paths[r->grid->items[item].source];
}

/* Reports a failed file from the main thread. */
static btf_result report(const reader *r, size_t item, btf_result result, const char *message) {
    return enc_source_fail(r->context, r->source, r->grid->items[item].source, result, message);
}

btf_result enc_read_check(const enc_context *context, const enc_read_options *o) {
    if (o->transfer == ENC_TRANSFER_GAMMA && !(o->gamma > 0.0 && isfinite(o->gamma))) {
        return enc_fail(context, BTF_ERROR_USAGE, "gamma %g is not above 0", o->gamma);
    }
    if (!isfinite(o->azimuth_offset)) {
        return enc_fail(context, BTF_ERROR_USAGE, "azimuth offset %g is not finite", o->azimuth_offset);
    }
    if ((o->size[0] != 0 || o->size[1] != 0) &&
        (o->size[0] < 1 || o->size[1] < 1 || o->size[0] > ENC_MAX_SIDE || o->size[1] > ENC_MAX_SIDE)) {
        return enc_fail(context, BTF_ERROR_USAGE, "size %dx%d is not usable: each side is 1 to %d",
                        o->size[0], o->size[1], ENC_MAX_SIDE);
    }
    const bool no_crop = o->crop[0] == 0 && o->crop[1] == 0 && o->crop[2] == 0 && o->crop[3] == 0;
    if (!no_crop && (o->crop[0] < 0 || o->crop[1] < 0 || o->crop[2] < 1 || o->crop[3] < 1)) {
        return enc_fail(context, BTF_ERROR_USAGE, "crop %d,%d,%d,%d is not usable", o->crop[0], o->crop[1],
                        o->crop[2], o->crop[3]);
    }
    return BTF_OK;
}

/* Reads the first image, whose size all others must have. */
static btf_result settle_size(reader *r) {
    return enc_radiance_settle_first(r->context, r->options, r->source, r->grid->items[0].source,
                                     &r->first_file, &r->first_size, &r->radiance);
}

/* Copies interleaved pixels to three planes. */
static void store_planes(const reader *r, const float *pixels, float *planes) {
    const size_t texels = (size_t)r->radiance.width * (size_t)r->radiance.height;
    for (size_t c = 0; c < 3; c++) {
        for (size_t t = 0; t < texels; t++) {
            planes[c * texels + t] = pixels[3 * t + c];
        }
    }
}

/* Converts one file to planes[channel][texel]. Runs on any thread; does not log. */
static btf_result convert(const reader *r, size_t item, batch_file *file, float *planes) {
    const float light_z = r->grid->lights[r->grid->items[item].light].xyz[2];
    float *pixels = malloc((size_t)r->radiance.width * (size_t)r->radiance.height * 3 * sizeof *pixels);
    if (!pixels) {
        return BTF_ERROR_MEMORY;
    }
    const btf_result result =
        enc_radiance_convert(&r->radiance, file->data, file->size, light_z, pixels, &file->negative,
                             &file->notes, file->message, sizeof file->message);
    if (result == BTF_OK) {
        store_planes(r, pixels, planes);
    }
    free(pixels);
    return result;
}

static void fetch(const reader *r, size_t item, batch_file *file) {
    if (item == 0 && r->first_file) {
        file->data = r->first_file;
        file->size = r->first_size;
        return;
    }
    file->result = r->source->read(r->source, r->grid->items[item].source, &file->data, &file->size,
                                   file->message, sizeof file->message);
}

static void finish(const reader *r, size_t item, batch_file *file, float *planes) {
    if (file->result == BTF_OK) {
        file->result = convert(r, item, file, planes);
    }
    free(file->data);
    file->data = NULL;
}

/* Keeps the notes of an image about its pixels; each is logged once a data set. */
static void note(reader *r, size_t item, const image_notes *notes) {
    for (int k = 0; k < IMAGE_NOTE_KINDS; k++) {
        const char kind[] = {(char)('A' + k), '\0'}; /* notices are logged in the order of their kinds */
        const btf_log_level level = image_note_warns((image_note_kind)k) ? BTF_LOG_WARNING : BTF_LOG_INFO;
        if (notes->texts[k][0]) {
            enc_notices_add(r->notices, level, kind, path_of(r, item), notes->texts[k]);
        }
    }
}

/* Reads up to `count` images from mine[first] on into the planes; *out_done says how many it was. A
 * sequential source is read by one thread ahead of the decoding. */
static btf_result read_batch(reader *r, size_t first, size_t count, float *planes, size_t *out_done) {
    const size_t plane = (size_t)r->radiance.width * (size_t)r->radiance.height * 3;
    batch_file *files = calloc(BATCH_FILES, sizeof *files);
    if (!files) {
        return BTF_ERROR_MEMORY;
    }
    size_t n = 0;
    if (r->source->is_sequential) {
        size_t bytes = 0;
        while (n < count && n < BATCH_FILES && bytes < BATCH_BYTES &&
               (n == 0 || files[n - 1].result == BTF_OK)) {
            fetch(r, r->mine[first + n], &files[n]);
            bytes += files[n++].size;
        }
    } else {
        n = count < BATCH_FILES ? count : BATCH_FILES;
    }
#pragma omp parallel for schedule(dynamic) num_threads(r->threads)
    for (size_t i = 0; i < n; i++) {
        if (!r->source->is_sequential) {
            fetch(r, r->mine[first + i], &files[i]);
        }
        finish(r, r->mine[first + i], &files[i], planes + i * plane);
    }
    if (n > 0 && r->mine[first] == 0) {
        r->first_file = NULL; /* finish() has freed it */
    }

    btf_result result = BTF_OK;
    for (size_t i = 0; i < n && result == BTF_OK; i++) {
        if (files[i].result != BTF_OK) {
            result = report(r, r->mine[first + i], files[i].result, files[i].message);
        }
        if (files[i].negative > 0 && r->n_negative_files++ == 0) {
            r->first_negative = r->mine[first + i];
        }
        r->negative += files[i].negative;
        note(r, r->mine[first + i], &files[i].notes);
    }
    free(files);
    *out_done = n;
    return result;
}

/* One plane of the block and where it belongs in a texel's samples. */
typedef struct plane_place {
    size_t at;
    const float *plane;
} plane_place;

static int by_place(const void *a, const void *b) {
    const plane_place *x = a, *y = b;
    return (x->at > y->at) - (x->at < y->at);
}

/* Turns a block of images to texel-major order. Neighbouring places are stored as one run. */
static btf_result scatter(reader *r, size_t first, size_t count) {
    const size_t texels = (size_t)r->radiance.width * (size_t)r->radiance.height,
                 lights = (size_t)r->grid->n_lights;
    const size_t n = 3 * count;
    plane_place *places = malloc(n * sizeof *places);
    if (!places) {
        return BTF_ERROR_MEMORY;
    }
    for (size_t i = 0; i < count; i++) {
        const enc_grid_item *item = &r->grid->items[r->mine[first + i]];
        for (size_t c = 0; c < 3; c++) {
            places[3 * i + c] = (plane_place){((size_t)item->view * 3 + c) * lights + (size_t)item->light,
                                              r->planes + (3 * i + c) * texels};
        }
    }
    qsort(places, n, sizeof *places, by_place);

    btf_result result = BTF_OK;
#pragma omp parallel num_threads(r->threads)
    {
        float *turned = malloc(CHUNK * n * sizeof *turned);
        btf_result mine = turned ? BTF_OK : BTF_ERROR_MEMORY;
#pragma omp for schedule(static)
        for (size_t begin = 0; begin < texels; begin += CHUNK) {
            const size_t width = texels - begin < CHUNK ? texels - begin : CHUNK;
            for (size_t i = 0; i < n && mine == BTF_OK; i++) {
                for (size_t t = 0; t < width; t++) {
                    turned[t * n + i] = places[i].plane[begin + t];
                }
            }
            for (size_t t = 0; t < width; t++) {
                for (size_t i = 0, end; i < n && mine == BTF_OK; i = end) {
                    for (end = i + 1; end < n && places[end].at == places[end - 1].at + 1;) {
                        end++;
                    }
                    mine = enc_data_store_run(r->context, r->data, begin + t, places[i].at, end - i,
                                              turned + t * n + i);
                }
            }
        }
        free(turned);
        enc_keep_worse(&result, mine);
    }
    free(places);
    return result;
}

/* The number of images in a block: whole views where that is possible, so that runs are long. */
static size_t block_size(const reader *r) {
    const size_t image = (size_t)r->radiance.width * (size_t)r->radiance.height * 3 * sizeof(float);
    size_t bytes = BLOCK_BYTES;
    if (r->context->memory > 0 && !r->data->samples) {
        bytes = r->context->memory / 2;
    } else if (r->context->memory > 0 && r->context->memory / 8 < bytes) {
        bytes = r->context->memory / 8;
    }
    const size_t lights = (size_t)r->grid->n_lights;
    size_t images = bytes / image;
    if (images > lights) {
        images -= images % lights;
    }
    if (images > r->n_mine) {
        images = r->n_mine;
    }
    return images ? images : 1;
}

/* Lists the images of this process: all of them, or those of its share of the views. */
static btf_result settle_share(reader *r) {
    size_t first, end;
    enc_ranks_range(r->context, (size_t)r->grid->n_views, &first, &end);
    r->mine = malloc(r->grid->count * sizeof *r->mine);
    for (size_t i = 0; i < r->grid->count && r->mine; i++) {
        if ((size_t)r->grid->items[i].view >= first && (size_t)r->grid->items[i].view < end) {
            r->mine[r->n_mine++] = i;
        }
    }
    return r->mine ? BTF_OK : BTF_ERROR_MEMORY;
}

static btf_result read_mine(reader *r) {
    const size_t plane = (size_t)r->radiance.width * (size_t)r->radiance.height * 3;
    r->block = block_size(r);
    r->planes = malloc(r->block * plane * sizeof *r->planes);
    if (!r->planes) {
        return enc_fail(r->context, BTF_ERROR_MEMORY, "out of memory for %zu images of %dx%d", r->block,
                        r->radiance.width, r->radiance.height);
    }
    btf_result result = BTF_OK;
    for (size_t first = 0; first < r->n_mine && result == BTF_OK; first += r->block) {
        const size_t count = r->n_mine - first < r->block ? r->n_mine - first : r->block;
        for (size_t done = 0, n; done < count && result == BTF_OK; done += n) {
            result = enc_cancelled(r->context)
                         ? BTF_ERROR_INTERRUPTED
                         : read_batch(r, first + done, count - done, r->planes + done * plane, &n);
            if (result != BTF_OK) {
                break;
            }
            enc_stage_step(r->context, n);
        }
        if (result == BTF_OK) {
            result = scatter(r, first, count);
        }
    }
    return result;
}

/* Adds up the samples below 0 that the ranks found. */
static btf_result add_negative(reader *r, btf_result result) {
    uint64_t sums[2] = {r->negative, r->n_negative_files};
    const size_t size = (size_t)enc_ranks_count(r->context);
    size_t *first = malloc(size * sizeof *first);
    result = enc_ranks_sum(r->context, result == BTF_OK && !first ? BTF_ERROR_MEMORY : result, sums, 2);
    if (first) {
        first[enc_ranks_own(r->context)] = r->n_negative_files > 0 ? r->first_negative : SIZE_MAX;
    }
    result = enc_ranks_gather(r->context, result, first, sizeof *first, size);
    if (result == BTF_OK) {
        r->negative = sums[0];
        r->n_negative_files = (size_t)sums[1];
        r->first_negative = SIZE_MAX;
        for (size_t i = 0; i < size; i++) {
            r->first_negative = first[i] < r->first_negative ? first[i] : r->first_negative;
        }
    }
    free(first);
    return result;
}

static btf_result read_images(reader *r) {
    btf_result result = settle_share(r);
    enc_stage_begin(r->context, "read", r->n_mine);
    if (result == BTF_OK) {
        result = read_mine(r);
    }
    result = enc_data_complete(r->context, r->data, result);
    result = add_negative(r, result);
    result = enc_notices_tell(r->context, result, r->notices, r->source->location);
    enc_stage_end(r->context);
    return result;
}

static btf_result announce(const reader *r) {
    const unsigned char *file = r->first_file;
    const bool jpeg = r->first_size > 2 && file[0] == 0xFF && file[1] == 0xD8;
    const enc_extent extent = {.width = r->radiance.width,
                               .height = r->radiance.height,
                               .n_views = r->grid->n_views,
                               .n_lights = r->grid->n_lights,
                               .origin = jpeg ? ENC_ORIGIN_JPEG : ENC_ORIGIN_IMAGES,
                               .pixels = (uint64_t)r->grid->count * (uint64_t)r->radiance.file_width *
                                         (uint64_t)r->radiance.file_height};
    return enc_extent_announce(r->context, &extent);
}

btf_result enc_read_source(const enc_context *context, const char *path, enc_source **out_source) {
    struct stat status;
    *out_source = NULL;
    if (stat(path, &status) != 0) {
        return enc_fail(context, BTF_ERROR_IO, "%s: %s", path, strerror(errno));
    }
    if (file_is_exr(path)) {
        return enc_fail(
            context, BTF_ERROR_BAD_FILE,
            "%s: is an OpenEXR file, a material or one image; a data set is a folder or an archive of "
            "images",
            path);
    }
    return S_ISDIR(status.st_mode) ? enc_source_open_directory(context, path, out_source)
                                   : enc_source_open_archive(context, path, out_source);
}

/* Reads a directory or an archive. */
static btf_result read_set(const enc_context *context, const char *input, const enc_read_options *options,
                           enc_data **out_data) {
    reader r = {.context = context, .options = options};
    r.threads = r.context->threads > 0 ? r.context->threads : 1;
    btf_result result = BTF_OK;
    if (options->components > 0) {
        result = enc_fail(context, BTF_ERROR_USAGE,
                          "%s: option components is only for a Bonn .btf file, which this is not", input);
    }
    if (result == BTF_OK) {
        result = enc_read_source(context, input, &r.source);
    }
    if (result == BTF_OK) {
        result = enc_grid_create(context, r.source, options, &r.grid);
    }
    if (result == BTF_OK && !(r.notices = enc_notices_create())) {
        result = BTF_ERROR_MEMORY;
    }
    if (result == BTF_OK) {
        result = settle_size(&r);
    }
    if (result == BTF_OK) {
        result = announce(&r);
    }
    if (result == BTF_OK) {
        result = enc_data_create(context, r.radiance.width, r.radiance.height, r.grid->n_views,
                                 r.grid->views, r.grid->n_lights, r.grid->lights, &r.data);
    }
    if (result == BTF_OK && !(r.data->source = strdup(input))) {
        result = BTF_ERROR_MEMORY;
    }
    if (result == BTF_OK) {
        result = read_images(&r);
    }
    if (result == BTF_OK && r.negative > 0) {
        enc_log(context, BTF_LOG_WARNING,
                "%s: %llu samples below 0 in %zu images were set to 0: first in %s (option strict refuses "
                "them)",
                input, (unsigned long long)r.negative, r.n_negative_files, path_of(&r, r.first_negative));
    }
    if (result == BTF_OK) {
        r.data->negative = r.negative;
        *out_data = r.data;
        r.data = NULL;
    }
    free(r.first_file);
    free(r.planes);
    free(r.mine);
    enc_data_destroy(&r.data);
    enc_radiance_clear(&r.radiance);
    enc_notices_destroy(&r.notices);
    enc_grid_destroy(&r.grid);
    enc_source_close(&r.source);
    return result;
}

btf_result enc_read(const enc_context *context, const char *input, const enc_read_options *options,
                    enc_data **out_data) {
    static const enc_context no_context = {.threads = 1};
    const enc_context *used = context ? context : &no_context;
    *out_data = NULL;
    btf_result result = enc_read_check(used, options);
    if (result == BTF_OK) {
        result = options->names && !options->names_of_some && enc_bonn_is(input)
                     ? enc_fail(used, BTF_ERROR_USAGE,
                                "%s: option names is for images, and this is a Bonn .btf file", input)
                 : enc_bonn_is(input) ? enc_read_bonn(used, input, options, out_data)
                                      : read_set(used, input, options, out_data);
    }
    if (result == BTF_OK && options->coincident) {
        result = enc_coincident_read(used, options->coincident, options, *out_data);
    }
    if (result != BTF_OK) {
        enc_data_destroy(out_data);
    }
    return result;
}
