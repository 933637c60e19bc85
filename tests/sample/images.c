/* The images of a scene, written as files. See images.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "images.h"

#include "decoder/toolkit/exr_image.h"
#include "decoder/toolkit/jpeg_image.h"
#include "decoder/toolkit/png_image.h"
#include "decoder/toolkit/progress.h"
#include "directions.h"
#include "encoder/base/stage.h"

#include <errno.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

const char *images_extension(images_format format) {
    static const char *const extensions[] = {
        [IMAGES_PNG] = "png", [IMAGES_PNG16] = "png", [IMAGES_JPEG] = "jpg", [IMAGES_EXR] = "exr"};
    return extensions[format];
}

btf_result images_make_folder(const enc_context *context, const char *path) {
    char *part = strdup(path);
    if (!part) {
        return enc_fail(context, BTF_ERROR_MEMORY, "%s: out of memory", path);
    }
    int failed = 0;
    for (char *at = part + 1; !failed; ++at) {
        if (*at == '/' || *at == '\0') {
            char was = *at;
            *at = '\0';
            if (mkdir(part, 0777) != 0 && errno != EEXIST) {
                failed = errno;
            }
            *at = was;
            if (!was) {
                break;
            }
        }
    }
    free(part);
    if (failed) {
        return enc_fail(context, BTF_ERROR_IO, "%s: cannot make the folder: %s", path, strerror(failed));
    }
    return BTF_OK;
}

/* The least linear values whose sRGB codes (IEC 61966-2-1), rounded to nearest, are 1, 2 .. levels - 1. */
static void make_thresholds(int levels, double *out) {
    for (int code = 1; code < levels; ++code) {
        double coded = (code - 0.5) / (levels - 1);
        out[code - 1] = coded <= 0.04045 ? coded / 12.92 : pow((coded + 0.055) / 1.055, 2.4);
    }
}

/* The code of x: the number of thresholds at or below it. */
static int code_of(double x, const double *thresholds, int levels) {
    int low = 0, high = levels - 1;
    while (low < high) {
        int middle = (low + high) / 2;
        if (x >= thresholds[middle]) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    return low;
}

/* The images of one call: their folder, and the coding of their values. */
typedef struct writer {
    const images_job *to;
    int levels;         /* codes of the format: 256 or 65536 */
    double *thresholds; /* the least value of each code but 0 */
    const sample_pair *pairs; /* those of images_write_pairs, and whether their names begin with a number */
    bool numbered;
} writer;

static btf_result writer_begin(const images_job *to, writer *out_writer) {
    const int levels = to->format == IMAGES_PNG16 ? 65536 : 256;
    *out_writer = (writer){.to = to, .levels = levels, .thresholds = malloc((size_t)levels * sizeof(double))};
    if (!out_writer->thresholds) {
        return enc_fail(to->context, BTF_ERROR_MEMORY, "out of memory");
    }
    make_thresholds(levels, out_writer->thresholds);
    return BTF_OK;
}

static btf_result write_image(const writer *w, const char *path, const float *rgb, void *codes) {
    const sample_options *o = sample_scene_options(w->to->scene);
    const size_t count = 3 * (size_t)o->width * (size_t)o->height;
    if (w->to->format == IMAGES_EXR) {
        return exr_image_write(path, o->width, o->height, rgb, false, w->to->context->log);
    }
    if (w->to->format == IMAGES_PNG16) {
        unsigned short *wide = codes;
        for (size_t i = 0; i < count; ++i) {
            wide[i] = (unsigned short)code_of(rgb[i], w->thresholds, w->levels);
        }
        return png_image_write16(path, o->width, o->height, wide, w->to->context->log);
    }
    unsigned char *bytes = codes;
    for (size_t i = 0; i < count; ++i) {
        bytes[i] = (unsigned char)code_of(rgb[i], w->thresholds, w->levels);
    }
    if (w->to->format == IMAGES_JPEG) {
        return jpeg_image_write(path, o->width, o->height, bytes, w->to->quality, w->to->context->log);
    }
    return png_image_write8(path, o->width, o->height, bytes, w->to->context->log);
}

/* Renders one view and writes its images. images, codes: room for all images of a view, for one coded. */
static btf_result write_view(const writer *w, int view, float *images, void *codes) {
    const sample_options *o = sample_scene_options(w->to->scene);
    btf_result result = sample_scene_view(w->to->scene, view, images, w->to->truth);
    if (result != BTF_OK || view == o->n_views) {
        return result;
    }
    char tv[16], pv[16], tl[16], pl[16], path[PATH_MAX];
    directions_format_angle(o->views[view].theta, tv);
    directions_format_angle(o->views[view].phi, pv);
    snprintf(path, sizeof path, "%s/tv%s_pv%s", w->to->folder, tv, pv);
    result = images_make_folder(w->to->context, path);
    for (int light = 0; light < o->n_lights && result == BTF_OK; ++light) {
        directions_format_angle(o->lights[light].theta, tl);
        directions_format_angle(o->lights[light].phi, pl);
        snprintf(path, sizeof path, "%s/tv%s_pv%s/%05d tl%s pl%s tv%s pv%s.%s", w->to->folder, tv, pv,
                 o->n_views * light + view, tl, pl, tv, pv, images_extension(w->to->format));
        const size_t values = 3 * (size_t)o->width * o->height;
        float *image = images + (size_t)light * values;
        sample_camera_expose(&w->to->camera, o->n_views * light + view, values, image);
        result = write_image(w, path, image, codes);
        if (result == BTF_OK && progress_cancelled()) {
            result = BTF_ERROR_INTERRUPTED;
        }
    }
    return result;
}

/* Renders and writes unit `index` of the work; `images` has room for the number of values that write_each was given. */
typedef btf_result write_fn(const writer *w, int index, float *images, void *codes);

/* Calls `write` for 0 .. count - 1 on all threads, up to the first that fails. Errors: those of `write`, BTF_ERROR_MEMORY,
 * which is not on the log yet, and BTF_ERROR_INTERRUPTED. */
static btf_result write_each(const writer *w, int count, size_t values, write_fn *write) {
    const enc_context *context = w->to->context;
    const sample_options *o = sample_scene_options(w->to->scene);
    btf_result result = BTF_OK;
    enc_stage_begin(context, "render", (size_t)count);
#pragma omp parallel num_threads(context->threads)
    {
        float *images = malloc(values * sizeof *images);
        void *codes = malloc(3 * (size_t)o->width * (size_t)o->height * sizeof(unsigned short));
#pragma omp for schedule(dynamic)
        for (int i = 0; i < count; ++i) {
            btf_result one;
#pragma omp critical(sample_write)
            one = result;
            if (one != BTF_OK) {
                continue;
            }
            one = !images || !codes        ? BTF_ERROR_MEMORY
                  : enc_cancelled(context) ? BTF_ERROR_INTERRUPTED
                                           : write(w, i, images, codes);
            if (one != BTF_OK) {
#pragma omp critical(sample_write)
                result = one;
            }
            enc_stage_step(context, 1);
        }
        free(images);
        free(codes);
    }
    enc_stage_end(context);
    return result;
}

btf_result images_write_grid(const images_job *to) {
    const sample_options *o = sample_scene_options(to->scene);
    writer w;
    btf_result result = writer_begin(to, &w);
    if (result != BTF_OK) {
        return result;
    }
    result = write_each(&w, o->n_views + (to->truth ? 1 : 0),
                        3 * (size_t)o->width * (size_t)o->height * (size_t)o->n_lights, write_view);
    free(w.thresholds);
    return result == BTF_ERROR_MEMORY
               ? enc_fail(to->context, result, "out of memory for the %d images of a view", o->n_lights)
               : result;
}

static btf_result write_pair(const writer *w, int i, float *image, void *codes) {
    const sample_options *o = sample_scene_options(w->to->scene);
    char name[PAIRS_NAME], path[PATH_MAX];
    const btf_result result = sample_scene_pair(w->to->scene, &w->pairs[i].view, &w->pairs[i].light, image);
    if (result != BTF_OK) {
        return result;
    }
    sample_camera_expose(&w->to->camera, i, 3 * (size_t)o->width * (size_t)o->height, image);
    pairs_name(&w->pairs[i], w->numbered ? i : -1, name);
    snprintf(path, sizeof path, "%s/%s.%s", w->to->folder, name, images_extension(w->to->format));
    return write_image(w, path, image, codes);
}

btf_result images_write_pairs(const images_job *to, const sample_pair *pairs, int count, bool numbered) {
    const sample_options *o = sample_scene_options(to->scene);
    writer w;
    btf_result result = writer_begin(to, &w);
    if (result != BTF_OK) {
        return result;
    }
    w.pairs = pairs;
    w.numbered = numbered;
    result = write_each(&w, count, 3 * (size_t)o->width * (size_t)o->height, write_pair);
    free(w.thresholds);
    return result == BTF_ERROR_MEMORY ? enc_fail(to->context, result, "out of memory for an image") : result;
}
