/* Reading one of Bonn's binary .btf files into a BTF. See reader.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "reader.h"

#include "decode.h"
#include "encoder/data/extent.h"
#include "encoder/input/grid.h"
#include "encoder/input/named_images.h"
#include "encoder/math/area.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { SOURCES = 16 /* texels of the file that are decoded together for one resized texel */ };

/* The origin of the samples: the file, and the part of it that each texel shows. */
typedef struct bonn_origin {
    enc_data_origin base;
    enc_bonn_file *file;
    enc_bonn_decoder *decoder;
    enc_rectangle area; /* of the file */
    int width, height;  /* of the BTF */
    int n_views, n_lights;
    bool flip_v, strict;
} bonn_origin;

/* The number that the texel at (x, y) of the area has in the file. */
static size_t file_texel(const bonn_origin *o, int x, int y) {
    const int row = o->area.y + (o->flip_v ? o->area.height - 1 - y : y);
    return (size_t)row * o->file->width + (size_t)(o->area.x + x);
}

static btf_result refuse_negative(const enc_context *context, const bonn_origin *o, size_t texel,
                                  float value) {
    return enc_fail(context, BTF_ERROR_BAD_FILE, "%s: column %zu, row %zu holds a value below 0 (%g)",
                    o->file->path, texel % o->file->width, texel / o->file->width, (double)value);
}

static btf_result check_strict(const enc_context *context, const bonn_origin *o, size_t texel, size_t count,
                               const float *samples) {
    for (size_t i = 0; i < count && o->strict; i++) {
        if (samples[i] < 0.0f) {
            return refuse_negative(context, o, texel, samples[i]);
        }
    }
    return BTF_OK;
}

/* Makes one texel as the mean of those that it covers; sources has room for SOURCES of them. */
static btf_result resize(const enc_context *context, const bonn_origin *o, size_t texel, int view,
                         int n_views, float *sources, float *out) {
    const int column = (int)(texel % (size_t)o->width), row = (int)(texel / (size_t)o->width);
    const double area = (double)o->area.width * (double)o->area.height;
    const size_t size = (size_t)n_views * 3 * (size_t)o->n_lights;
    int x0, x1, y0, y1;
    enc_area_span(o->area.width, o->width, column, &x0, &x1);
    enc_area_span(o->area.height, o->height, row, &y0, &y1);
    const int total = (x1 - x0) * (y1 - y0);
    memset(out, 0, size * sizeof *out);
    for (int first = 0; first < total; first += SOURCES) {
        const int n = total - first < SOURCES ? total - first : SOURCES;
        size_t texels[SOURCES];
        for (int i = 0; i < n; i++) {
            texels[i] = file_texel(o, x0 + (first + i) % (x1 - x0), y0 + (first + i) / (x1 - x0));
        }
        btf_result result =
            enc_bonn_decode(context, o->decoder, (size_t)n, texels, view, n_views, size, sources);
        for (int i = 0; i < n && result == BTF_OK; i++) {
            const int x = x0 + (first + i) % (x1 - x0), y = y0 + (first + i) / (x1 - x0);
            const double weight = (double)enc_area_overlap(o->area.width, o->width, column, x) *
                                  (double)enc_area_overlap(o->area.height, o->height, row, y) / area;
            result = check_strict(context, o, texels[i], size, sources + (size_t)i * size);
            for (size_t s = 0; s < size; s++) {
                out[s] += (float)weight * sources[(size_t)i * size + s];
            }
        }
        if (result != BTF_OK) {
            return result;
        }
    }
    return BTF_OK;
}

/* Makes texels first .. first+count-1 in views view .. view+n_views-1. */
static btf_result make(const enc_context *context, const bonn_origin *o, size_t first, size_t count,
                       int view, int n_views, float *out) {
    const size_t size = (size_t)n_views * 3 * (size_t)o->n_lights;
    btf_result result = BTF_OK;
    if (o->width != o->area.width || o->height != o->area.height) {
        float *sources = malloc(SOURCES * size * sizeof *sources);
        if (!sources) {
            return BTF_ERROR_MEMORY;
        }
        for (size_t i = 0; i < count && result == BTF_OK; i++) {
            result = resize(context, o, first + i, view, n_views, sources, out + i * size);
        }
        free(sources);
    } else {
        for (size_t i = 0; i < count && result == BTF_OK; i += SOURCES) {
            const size_t n = count - i < SOURCES ? count - i : SOURCES;
            size_t texels[SOURCES];
            for (size_t t = 0; t < n; t++) {
                texels[t] = file_texel(o, (int)((first + i + t) % (size_t)o->width),
                                       (int)((first + i + t) / (size_t)o->width));
            }
            result = enc_bonn_decode(context, o->decoder, n, texels, view, n_views, size, out + i * size);
            for (size_t t = 0; t < n && result == BTF_OK; t++) {
                result = check_strict(context, o, texels[t], size, out + (i + t) * size);
            }
        }
    }
    for (size_t s = 0; s < count * size && result == BTF_OK; s++) {
        out[s] = out[s] > 0.0f ? out[s] : 0.0f;
    }
    return result;
}

static btf_result make_texels(const enc_context *context, const enc_data_origin *origin, size_t first,
                              size_t count, float *out) {
    const bonn_origin *o = (const bonn_origin *)origin;
    return make(context, o, first, count, 0, o->n_views, out);
}

static btf_result make_profiles(const enc_context *context, const enc_data_origin *origin, int view,
                                size_t first, size_t count, float *out) {
    return make(context, (const bonn_origin *)origin, first, count, view, 1, out);
}

static void close_origin(enc_data_origin *origin) {
    bonn_origin *o = (bonn_origin *)origin;
    enc_bonn_decoder_destroy(&o->decoder);
    enc_bonn_close(&o->file);
    free(o);
}

/* A direction and its number in the file. */
typedef struct numbered {
    double theta, phi;
    int number;
} numbered;

static int paper_order(const void *a, const void *b) {
    const numbered *x = a, *y = b;
    if (x->theta != y->theta) {
        return x->theta < y->theta ? -1 : 1;
    }
    return (x->phi > y->phi) - (x->phi < y->phi);
}

/* Brings a list of (theta, phi) in radians to paper order. Angles are floats: 1e-4 degrees are within their
 * rounding. */
static btf_result order_directions(const enc_context *context, const enc_bonn_file *file,
                                   const enc_read_options *options, const char *what, float (*list)[2],
                                   uint32_t count, enc_direction *out_directions, int *out_order) {
    const double degrees = 180.0 / 3.14159265358979323846;
    numbered sorted[ENC_MAX_DIRECTIONS];
    for (uint32_t i = 0; i < count; i++) {
        const double theta = round((double)list[i][0] * degrees * 1e4) / 1e4;
        const double phi = round((double)list[i][1] * degrees * 1e4) / 1e4;
        if (!(theta >= 0.0 && theta < 90.0)) {
            return enc_fail(context, BTF_ERROR_BAD_FILE,
                            "%s: theta of %s %u is %g degrees, not at least 0 and below 90", file->path,
                            what, i, theta);
        }
        sorted[i] = (numbered){theta, theta == 0.0 ? 0.0 : enc_named_azimuth(options, theta, phi), (int)i};
    }
    qsort(sorted, count, sizeof *sorted, paper_order);
    for (uint32_t i = 0; i < count; i++) {
        if (i > 0 && paper_order(&sorted[i - 1], &sorted[i]) == 0) {
            return enc_fail(context, BTF_ERROR_BAD_FILE, "%s: %ss %d and %d are one direction, (%g,%g)",
                            file->path, what, sorted[i - 1].number, sorted[i].number, sorted[i].theta,
                            sorted[i].phi);
        }
        out_directions[i] = enc_direction_from_angles(sorted[i].theta, sorted[i].phi);
        out_order[i] = sorted[i].number;
    }
    return BTF_OK;
}

static btf_result settle_area(const enc_context *context, bonn_origin *o, const enc_read_options *options) {
    const enc_bonn_file *f = o->file;
    const int *crop = options->crop, *size = options->size;
    o->area = crop[2] ? (enc_rectangle){crop[0], crop[1], crop[2], crop[3]}
                      : (enc_rectangle){0, 0, (int)f->width, (int)f->height};
    if (o->area.x > (int)f->width - o->area.width || o->area.y > (int)f->height - o->area.height) {
        return enc_fail(context, BTF_ERROR_USAGE, "crop %d,%d,%d,%d does not lie within %s's %ux%u texels",
                        crop[0], crop[1], crop[2], crop[3], f->path, f->width, f->height);
    }
    o->width = size[0] ? size[0] : o->area.width;
    o->height = size[1] ? size[1] : o->area.height;
    return BTF_OK;
}

static btf_result prepare(const enc_context *context, bonn_origin *o, const enc_read_options *options,
                          enc_direction *views, enc_direction *lights) {
    const enc_bonn_file *f = o->file;
    int view_order[ENC_MAX_DIRECTIONS], light_order[ENC_MAX_DIRECTIONS];
    float factor[ENC_MAX_DIRECTIONS];
    btf_result result =
        order_directions(context, f, options, "view", f->views, f->n_views, views, view_order);
    if (result == BTF_OK) {
        result =
            order_directions(context, f, options, "light", f->lights, f->n_lights, lights, light_order);
    }
    if (result != BTF_OK) {
        return result;
    }
    if (views[0].theta > ENC_GRID_POLE_DISTANCE) {
        return enc_fail(context, BTF_ERROR_BAD_FILE,
                        "%s: no top view: the view nearest to the surface normal is (%g,%g), more than %g "
                        "degrees from it",
                        f->path, views[0].theta, views[0].phi, ENC_GRID_POLE_DISTANCE);
    }
    const bool missing =
        options->cosine == ENC_COSINE_MISSING || (options->cosine == ENC_COSINE_AUTO && !f->cosine);
    for (uint32_t l = 0; l < f->n_lights; l++) {
        factor[l] = missing ? lights[l].xyz[2] : 1.0f;
    }
    if (missing) {
        enc_log(context, BTF_LOG_INFO,
                "%s: values lack the cosine of the light's angle: they were multiplied by it", f->path);
    }
    if (f->n_missing > 0) {
        enc_log(context, BTF_LOG_WARNING, "%s: %u of %llu texels are missing and read as 0", f->path,
                f->n_missing, (unsigned long long)f->width * f->height);
    }
    return enc_bonn_decoder_create(context, f, view_order, light_order, factor,
                                   (uint32_t)options->components, &o->decoder);
}

btf_result enc_read_bonn(const enc_context *context, const char *input, const enc_read_options *options,
                         enc_data **out_data) {
    enc_direction views[ENC_MAX_DIRECTIONS], lights[ENC_MAX_DIRECTIONS];
    bonn_origin *o = calloc(1, sizeof *o);
    *out_data = NULL;
    if (!o) {
        return BTF_ERROR_MEMORY;
    }
    *o = (bonn_origin){.base = {make_texels, make_profiles, close_origin, 0},
                       .flip_v = options->flip_v,
                       .strict = options->strict};
    btf_result result = enc_bonn_open(context, input, &o->file);
    if (result == BTF_OK) {
        result = settle_area(context, o, options);
    }
    if (result == BTF_OK) {
        result = prepare(context, o, options, views, lights);
    }
    if (result != BTF_OK) {
        close_origin(&o->base);
        return result;
    }
    o->n_views = (int)o->file->n_views;
    o->n_lights = (int)o->file->n_lights;
    enc_log(context, BTF_LOG_INFO, "%s: %s, %ux%u texels, %u views, %u lights", input, o->file->signature,
            o->file->width, o->file->height, o->file->n_views, o->file->n_lights);
    const enc_extent extent = {.width = o->width,
                               .height = o->height,
                               .n_views = o->n_views,
                               .n_lights = o->n_lights,
                               .origin = ENC_ORIGIN_BONN,
                               .components = enc_bonn_decoder_components(o->decoder)};
    o->base.seconds = enc_bonn_sample_seconds(extent.components);
    result = enc_extent_announce(context, &extent);
    if (result != BTF_OK) {
        close_origin(&o->base);
        return result;
    }
    result = enc_data_create_from(context, o->width, o->height, o->n_views, views, o->n_lights, lights,
                                  &o->base, out_data);
    if (result == BTF_OK && !((*out_data)->source = strdup(input))) {
        enc_data_destroy(out_data);
        result = BTF_ERROR_MEMORY;
    }
    return result;
}
