/* Images at any directions. See pairs.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "pairs.h"

#include "encoder/input/grid.h"
#include "encoder/input/names.h"
#include "encoder/input/source.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MESSAGE_SIZE = 256, MAX_SIDE = 16384 };

struct enc_pairs_source {
    enc_source *source;
    enc_read_options options;
    enc_decoder *decoder;
    size_t *index;               /* [count]: of the source */
    int file_width, file_height; /* of every image, as in the files */
    enc_rectangle area;          /* the part that is used */
    void *first_file;            /* the first image's file, read to learn the size */
    size_t first_size;
};

static int by_angles(const void *a, const void *b) {
    const enc_direction *x = a, *y = b;
    if (x->theta != y->theta)
        return x->theta < y->theta ? -1 : 1;
    return (x->phi > y->phi) - (x->phi < y->phi);
}

static int by_pair(const void *a, const void *b) {
    const enc_pair *x = a, *y = b;
    const int views = by_angles(&x->view, &y->view);
    return views != 0 ? views : by_angles(&x->light, &y->light);
}

/* The direction that a name gives; xyz is that of its angles. */
static enc_direction named(const enc_read_options *options, double theta, double phi) {
    return enc_direction_from_angles(theta, enc_grid_azimuth(options, theta, phi));
}

/* Distinct directions of one side of the pairs, and the least theta among them. */
static btf_result count_directions(const enc_pair *pair, size_t count, bool lights, size_t *out_distinct,
                                   double *out_theta) {
    enc_direction *list = malloc(count * sizeof *list);
    if (!list)
        return BTF_ERROR_MEMORY;
    for (size_t i = 0; i < count; i++)
        list[i] = lights ? pair[i].light : pair[i].view;
    qsort(list, count, sizeof *list, by_angles);
    *out_distinct = 0;
    for (size_t i = 0; i < count; i++)
        *out_distinct += i == 0 || by_angles(&list[i], &list[i - 1]) != 0;
    *out_theta = list[0].theta;
    free(list);
    return BTF_OK;
}

btf_result enc_pairs_classify(const enc_context *context, const char *path, const enc_read_options *options,
                              enc_image_set *out_set) {
    enc_source *source = NULL;
    size_t count = 0, views = 0, lights = 0;
    double top = 0, unused;
    *out_set = ENC_SET_GRID;
    btf_result result = enc_read_source(context, path, &source);
    enc_pair *pair = result == BTF_OK ? malloc((source->count + 1) * sizeof *pair) : NULL;
    if (result == BTF_OK && !pair)
        result = BTF_ERROR_MEMORY;
    for (size_t i = 0; result == BTF_OK && i < source->count; i++) {
        enc_angles a;
        if (enc_names_parse(source->paths[i], &a))
            pair[count++] = (enc_pair){.view = named(options, a.theta_view, a.phi_view),
                                       .light = named(options, a.theta_light, a.phi_light)};
    }
    if (result == BTF_OK && count > 0)
        result = count_directions(pair, count, false, &views, &top);
    if (result == BTF_OK && count > 0)
        result = count_directions(pair, count, true, &lights, &unused);
    /* A grid is whole, under a view from the top; or it lacks images, which is to be told, not to be taken
     * for something else. Directions drawn at random form far less than half of a grid. */
    if (count > 0 && (2 * count <= views * lights || (count == views * lights && top > ENC_GRID_POLE_DISTANCE)))
        *out_set = ENC_SET_PAIRS;
    free(pair);
    enc_source_close(&source);
    return result;
}

static btf_result check_theta(const enc_context *context, const enc_source *source, size_t i,
                              const char *side, double theta) {
    return theta >= 0.0 && theta < 90.0
               ? BTF_OK
               : enc_fail(context, BTF_ERROR_BAD_FILE,
                          "%s: %s: theta %g of the %s is not at least 0 and below 90", source->location,
                          source->paths[i], theta, side);
}

/* All names, each of which must be understood: a pair that is left out would change the result in silence.
 */
static btf_result parse_names(const enc_context *context, enc_pairs *pairs) {
    const enc_source *source = pairs->source->source;
    const enc_read_options *options = &pairs->source->options;
    if (source->count == 0)
        return enc_fail(context, BTF_ERROR_BAD_FILE,
                        "%s: no JPEG, PNG, HDR or EXR image among its %zu files", source->location,
                        source->n_others);
    pairs->pair = malloc(source->count * sizeof *pairs->pair);
    pairs->source->index = malloc(source->count * sizeof *pairs->source->index);
    if (!pairs->pair || !pairs->source->index)
        return BTF_ERROR_MEMORY;
    for (size_t i = 0; i < source->count; i++) {
        enc_angles a;
        if (!enc_names_parse(source->paths[i], &a))
            return enc_fail(context, BTF_ERROR_BAD_FILE,
                            "%s: %s: the name does not hold tl, pl, tv and pv, each with one angle",
                            source->location, source->paths[i]);
        btf_result result = check_theta(context, source, i, "light", a.theta_light);
        if (result == BTF_OK)
            result = check_theta(context, source, i, "view", a.theta_view);
        if (result != BTF_OK)
            return result;
        pairs->source->index[pairs->count] = i;
        pairs->pair[pairs->count++] = (enc_pair){.view = named(options, a.theta_view, a.phi_view),
                                                 .light = named(options, a.theta_light, a.phi_light),
                                                 .name = source->paths[i]};
    }
    return BTF_OK;
}

static btf_result check_distinct(const enc_context *context, const enc_pairs *pairs) {
    enc_pair *sorted = malloc(pairs->count * sizeof *sorted);
    btf_result result = BTF_OK;
    if (!sorted)
        return BTF_ERROR_MEMORY;
    memcpy(sorted, pairs->pair, pairs->count * sizeof *sorted);
    qsort(sorted, pairs->count, sizeof *sorted, by_pair);
    for (size_t i = 1; i < pairs->count && result == BTF_OK; i++)
        if (by_pair(&sorted[i - 1], &sorted[i]) == 0)
            result = enc_fail(context, BTF_ERROR_BAD_FILE,
                              "%s: two images of view (%g,%g) and light (%g,%g): %s, %s",
                              pairs->source->source->location, sorted[i].view.theta, sorted[i].view.phi,
                              sorted[i].light.theta, sorted[i].light.phi, sorted[i - 1].name, sorted[i].name);
    free(sorted);
    return result;
}

static btf_result report(const enc_context *context, const enc_pairs *pairs, size_t i, btf_result result,
                         const char *message) {
    return enc_fail(context, result, "%s: %s: %s", pairs->source->source->location, pairs->pair[i].name,
                    message[0] ? message : btf_result_text(result));
}

/* Reads the first image to learn the size of all. */
static btf_result settle_size(const enc_context *context, enc_pairs *pairs) {
    enc_pairs_source *s = pairs->source;
    char message[MESSAGE_SIZE] = "";
    enc_image image = {0};
    btf_result result = s->source->read(s->source, s->index[0], &s->first_file, &s->first_size, message,
                                        sizeof message);
    if (result == BTF_OK)
        result = enc_image_decode(s->first_file, s->first_size, &image, message, sizeof message);
    if (result != BTF_OK)
        return report(context, pairs, 0, result, message);
    s->file_width = image.width;
    s->file_height = image.height;
    enc_image_clear(&image);
    const int *crop = s->options.crop, *size = s->options.size;
    s->area = crop[2] ? (enc_rectangle){crop[0], crop[1], crop[2], crop[3]}
                      : (enc_rectangle){0, 0, s->file_width, s->file_height};
    if (s->area.x > s->file_width - s->area.width || s->area.y > s->file_height - s->area.height)
        return enc_fail(context, BTF_ERROR_USAGE,
                        "crop %d,%d,%d,%d does not lie within images of %dx%d pixels", crop[0], crop[1],
                        crop[2], crop[3], s->file_width, s->file_height);
    pairs->width = size[0] ? size[0] : s->area.width;
    pairs->height = size[1] ? size[1] : s->area.height;
    if (pairs->width > MAX_SIDE || pairs->height > MAX_SIDE)
        return enc_fail(context, BTF_ERROR_UNSUPPORTED,
                        "%s: size %dx%d is not usable: each side is 1 to %d (see --size and --crop)",
                        s->source->location, pairs->width, pairs->height, MAX_SIDE);
    return BTF_OK;
}

btf_result enc_pairs_open(const enc_context *context, const char *path, const enc_read_options *options,
                          enc_pairs **out_pairs) {
    enc_pairs *pairs = calloc(1, sizeof *pairs);
    btf_result result = BTF_ERROR_MEMORY;
    *out_pairs = NULL;
    if (pairs && (pairs->source = calloc(1, sizeof *pairs->source))) {
        pairs->source->options = *options;
        pairs->source->decoder = enc_decoder_create(options->transfer, options->gamma);
        result = pairs->source->decoder ? BTF_OK : BTF_ERROR_MEMORY;
    }
    if (result == BTF_OK && options->components > 0)
        result = enc_fail(context, BTF_ERROR_USAGE,
                          "%s: components are those of a Bonn .btf file, and this is none", path);
    if (result == BTF_OK && options->coincident)
        result = enc_fail(context, BTF_ERROR_USAGE,
                          "%s: coincident lights are those of a data set, and these are single images", path);
    if (result == BTF_OK)
        result = enc_read_source(context, path, &pairs->source->source);
    if (result == BTF_OK)
        result = parse_names(context, pairs);
    if (result == BTF_OK)
        result = check_distinct(context, pairs);
    if (result == BTF_OK)
        result = settle_size(context, pairs);
    if (result != BTF_OK)
        enc_pairs_close(&pairs);
    *out_pairs = pairs;
    return result == BTF_ERROR_MEMORY ? enc_fail(context, result, "%s: out of memory", path) : result;
}

void enc_pairs_close(enc_pairs **pairs) {
    if (!pairs || !*pairs)
        return;
    enc_pairs_source *s = (*pairs)->source;
    if (s) {
        free(s->first_file);
        free(s->index);
        enc_decoder_destroy(&s->decoder);
        enc_source_close(&s->source);
        free(s);
    }
    free((*pairs)->pair);
    free(*pairs);
    *pairs = NULL;
}

/* Every sample finite, and where that is asked for at least 0; tells the first that is not. */
static btf_result check_values(const enc_rectangle *area, const float *pixels, bool strict, char *message) {
    const size_t count = 3 * (size_t)area->width * (size_t)area->height;
    for (size_t i = 0; i < count; i++) {
        const bool finite = isfinite(pixels[i]);
        if (finite && !(strict && pixels[i] < 0.0f))
            continue;
        snprintf(message, MESSAGE_SIZE, "column %zu, row %zu, channel %c is %s (%g)",
                 (size_t)area->x + i / 3 % (size_t)area->width,
                 (size_t)area->y + i / 3 / (size_t)area->width, "RGB"[i % 3],
                 finite ? "below 0" : "not a finite number", (double)pixels[i]);
        return BTF_ERROR_BAD_FILE;
    }
    return BTF_OK;
}

static btf_result check_image(const enc_pairs_source *s, const enc_image *image, char *message) {
    if (image->width != s->file_width || image->height != s->file_height) {
        snprintf(message, MESSAGE_SIZE, "%dx%d pixels, but the first image has %dx%d", image->width,
                 image->height, s->file_width, s->file_height);
        return BTF_ERROR_BAD_FILE;
    }
    if (image->xyz && s->options.colour != ENC_COLOUR_XYZ) {
        snprintf(message, MESSAGE_SIZE, "the channels are X, Y, Z: use --colour xyz");
        return BTF_ERROR_BAD_FILE;
    }
    return BTF_OK;
}

/* From a file's bytes to linear radiance: as a data set's images are converted. */
static btf_result convert(const enc_pairs *pairs, size_t i, const void *file, size_t size, float *out,
                          char *message) {
    const enc_pairs_source *s = pairs->source;
    const size_t count = (size_t)s->area.width * (size_t)s->area.height;
    const size_t floats = 3 * (size_t)pairs->width * (size_t)pairs->height;
    const bool resize = pairs->width != s->area.width || pairs->height != s->area.height;
    const float factor = s->options.cosine == ENC_COSINE_MISSING ? pairs->pair[i].light.xyz[2] : 1.0f;
    enc_image image = {0};
    float *pixels = NULL;
    btf_result result = enc_image_decode(file, size, &image, message, MESSAGE_SIZE);
    if (result == BTF_OK)
        result = check_image(s, &image, message);
    if (result == BTF_OK && resize && !(pixels = malloc(3 * count * sizeof *pixels)))
        result = BTF_ERROR_MEMORY;
    if (result == BTF_OK) {
        float *linear = resize ? pixels : out;
        enc_decode_pixels(s->decoder, &image, s->area, linear);
        if (s->options.colour == ENC_COLOUR_XYZ)
            enc_xyz_to_rgb(linear, count);
        result = check_values(&s->area, linear, s->options.strict, message);
        if (result == BTF_OK && s->options.flip_v)
            enc_flip_rows(linear, s->area.width, s->area.height);
    }
    if (result == BTF_OK && resize)
        result = enc_resize_area(pixels, s->area.width, s->area.height, out, pairs->width, pairs->height);
    for (size_t p = 0; result == BTF_OK && p < floats; p++)
        out[p] = out[p] > 0.0f ? out[p] * factor : 0.0f;
    enc_image_clear(&image);
    free(pixels);
    return result;
}

btf_result enc_pairs_read(const enc_context *context, const enc_pairs *pairs, size_t i, float *out) {
    enc_pairs_source *s = pairs->source;
    char message[MESSAGE_SIZE] = "";
    void *file = NULL;
    size_t size = 0;
    btf_result result = BTF_OK;
    if (i == 0 && s->first_file) {
        file = s->first_file;
        size = s->first_size;
        s->first_file = NULL; /* a sequential source gives it only once */
    } else {
        result = s->source->read(s->source, s->index[i], &file, &size, message, sizeof message);
    }
    if (result == BTF_OK)
        result = convert(pairs, i, file, size, out, message);
    free(file);
    return result == BTF_OK ? BTF_OK : report(context, pairs, i, result, message);
}
