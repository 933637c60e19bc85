/* libopenbtf_input: the encoder's readers behind openbtf/input.h.
 *
 * Images of a folder are read one by one when asked for. An archive is read front to back, so it is read whole when it
 * is opened; the samples of a Bonn file are made from its factors, a view at a time.
 *
 * SPDX-License-Identifier: MIT
 */
#include <openbtf/input.h>

#include "decoder/toolkit/exr_image.h"
#include "decoder/toolkit/output.h"
#include "encoder/input/bonn/file.h"
#include "encoder/input/grid.h"
#include "encoder/input/radiance.h"
#include "encoder/input/reader.h"
#include "encoder/input/source.h"

#include <omp.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

enum { DEFAULT_MEMORY = 1 << 30, MESSAGE_SIZE = 480 };

/* A folder whose images are read when asked for. */
typedef struct image_set {
    enc_source *source;
    enc_grid *grid;
    enc_radiance radiance;
    size_t *source_of; /* [view][light], index into the source's paths */
} image_set;

struct btf_input {
    enc_read_options options;
    char *names, *layer; /* copies of the caller's strings */
    image_set set;       /* its source is NULL where samples lie in `data` */
    enc_data *data;
    pthread_mutex_t lock; /* guards the members below */
    int kept_view;        /* whose images `kept` holds; -1: none */
    float *kept;          /* [light][texel][channel] */

    int width, height, n_views, n_lights;
    float *views, *lights;              /* [count][3] */
    double *view_angles, *light_angles; /* [count][2] */
};

static enc_context context_of(const btf_log *log, size_t memory) {
    enc_context context = {.threads = omp_get_max_threads(), .memory = memory ? memory : DEFAULT_MEMORY};
    if (log) {
        context.log = *log;
    }
    return context;
}

/* Copies directions to the form that the header gives them. */
static btf_result copy_directions(const enc_direction *list, int count, float **out_xyz,
                                  double **out_angles) {
    *out_xyz = malloc(3 * (size_t)count * sizeof **out_xyz);
    *out_angles = malloc(2 * (size_t)count * sizeof **out_angles);
    if (!*out_xyz || !*out_angles) {
        return BTF_ERROR_MEMORY;
    }
    for (int i = 0; i < count; i++) {
        memcpy(*out_xyz + 3 * i, list[i].xyz, sizeof list[i].xyz);
        (*out_angles)[2 * i] = list[i].theta;
        (*out_angles)[2 * i + 1] = list[i].phi;
    }
    return BTF_OK;
}

static btf_result take_directions(btf_input *input, const enc_direction *views, int n_views,
                                  const enc_direction *lights, int n_lights) {
    input->n_views = n_views;
    input->n_lights = n_lights;
    const btf_result result = copy_directions(views, n_views, &input->views, &input->view_angles);
    return result == BTF_OK ? copy_directions(lights, n_lights, &input->lights, &input->light_angles)
                            : result;
}

/* Reads the names of a folder, and the size of its first image. */
static btf_result open_set(const enc_context *context, btf_input *input) {
    image_set *set = &input->set;
    void *file = NULL;
    size_t size = 0;
    btf_result result = enc_grid_create(context, set->source, &input->options, &set->grid);
    if (result == BTF_OK) {
        result = enc_radiance_settle_first(context, &input->options, set->source, set->grid->items[0].source,
                                           &file, &size, &set->radiance);
    }
    free(file);
    if (result != BTF_OK) {
        return result;
    }
    set->source_of = malloc(set->grid->count * sizeof *set->source_of);
    if (!set->source_of) {
        return BTF_ERROR_MEMORY;
    }
    for (size_t i = 0; i < set->grid->count; i++) {
        const enc_grid_item *item = &set->grid->items[i];
        set->source_of[(size_t)item->view * (size_t)set->grid->n_lights + (size_t)item->light] =
            item->source;
    }
    input->width = set->radiance.width;
    input->height = set->radiance.height;
    return take_directions(input, set->grid->views, set->grid->n_views, set->grid->lights,
                           set->grid->n_lights);
}

static btf_result open_data(const enc_context *context, const char *path, btf_input *input) {
    btf_result result = enc_read(context, path, &input->options, &input->data);
    if (result != BTF_OK) {
        return result;
    }
    const enc_data *data = input->data;
    input->width = data->width;
    input->height = data->height;
    return take_directions(input, data->views, data->n_views, data->lights, data->n_lights);
}

static char *copy_string(const char *string, bool *failed) {
    char *copy = string ? strdup(string) : NULL;
    *failed |= string && !copy;
    return copy;
}

static btf_result take_options(const enc_context *context, const btf_input_options *o, btf_input *input) {
    bool failed = false;
    input->names = copy_string(o->names, &failed);
    input->layer = copy_string(o->layer, &failed);
    if (failed) {
        return BTF_ERROR_MEMORY;
    }
    if ((unsigned)o->transfer > BTF_TRANSFER_GAMMA || (unsigned)o->primaries > BTF_PRIMARIES_XYZ ||
        (unsigned)o->cosine > BTF_COSINE_MISSING) {
        return enc_fail(context, BTF_ERROR_USAGE,
                        "transfer %d, primaries %d or cosine %d is not a value of its enum",
                        (int)o->transfer, (int)o->primaries, (int)o->cosine);
    }
    input->options = (enc_read_options){.transfer = (enc_transfer)o->transfer,
                                        .gamma = o->gamma,
                                        .colour = (enc_colour)o->primaries,
                                        .size = {o->size[0], o->size[1]},
                                        .crop = {o->crop[0], o->crop[1], o->crop[2], o->crop[3]},
                                        .flip_v = o->flip_v,
                                        .azimuth_cw = o->azimuth_cw,
                                        .azimuth_offset = o->azimuth_offset,
                                        .cosine = (enc_cosine)o->cosine,
                                        .layer = input->layer,
                                        .names = input->names,
                                        .strict = o->strict};
    return BTF_OK;
}

static bool is_folder(const char *path) {
    struct stat status;
    return stat(path, &status) == 0 && S_ISDIR(status.st_mode);
}

btf_result btf_input_open(const char *path, const btf_input_options *options, const btf_log *log,
                          btf_input **out_input) {
    const btf_input_options none = {.struct_size = sizeof none};
    const btf_input_options *used = options ? options : &none;
    if (out_input) {
        *out_input = NULL;
    }
    if (!path || !out_input || used->struct_size < sizeof none) {
        return BTF_ERROR_USAGE;
    }
    const enc_context context = context_of(log, used->memory);
    btf_input *input = calloc(1, sizeof *input);
    if (!input) {
        return BTF_ERROR_MEMORY;
    }
    pthread_mutex_init(&input->lock, NULL);
    input->kept_view = -1;
    btf_result result = take_options(&context, used, input);
    if (result == BTF_OK) {
        result = enc_read_check(&context, &input->options);
    }
    if (result == BTF_OK && is_folder(path)) {
        result = enc_read_source(&context, path, &input->set.source);
        if (result == BTF_OK) {
            result = open_set(&context, input);
        }
    } else if (result == BTF_OK) {
        result = open_data(&context, path, input);
    }
    if (result != BTF_OK) {
        btf_input_close(&input);
    }
    *out_input = input;
    return result;
}

btf_result btf_input_get_info(const btf_input *input, btf_input_info *out_info) {
    if (!input || !out_info || out_info->struct_size < sizeof *out_info) {
        return BTF_ERROR_USAGE;
    }
    *out_info = (btf_input_info){.struct_size = out_info->struct_size,
                                 .width = input->width,
                                 .height = input->height,
                                 .n_views = input->n_views,
                                 .n_lights = input->n_lights,
                                 .views = input->views,
                                 .lights = input->lights,
                                 .view_angles = input->view_angles,
                                 .light_angles = input->light_angles,
                                 .lazy = input->set.source != NULL};
    return BTF_OK;
}

/* Reads one image of a folder and converts it as the encoder's reader does. */
static btf_result read_image(const enc_context *context, const btf_input *input, int view, int light,
                             float *out_rgb) {
    const image_set *set = &input->set;
    const size_t item = set->source_of[(size_t)view * (size_t)input->n_lights + (size_t)light];
    void *file = NULL;
    size_t size = 0, negative;
    char message[MESSAGE_SIZE] = "";
    image_notes notes = {0};
    btf_result result = set->source->read(set->source, item, &file, &size, message, sizeof message);
    if (result == BTF_OK) {
        result = enc_radiance_convert(&set->radiance, file, size, input->lights[3 * light + 2], out_rgb,
                                      &negative, &notes, message, sizeof message);
    }
    free(file);
    return result == BTF_OK ? BTF_OK : enc_source_fail(context, set->source, item, result, message);
}

/* Gives one image out of the samples, of which it gathers all images of a view at once and keeps them for
 * the next call. */
static btf_result gather_image(const enc_context *context, btf_input *input, int view, int light,
                               float *out_rgb) {
    const size_t values = 3 * (size_t)input->width * (size_t)input->height;
    btf_result result = BTF_OK;
    pthread_mutex_lock(&input->lock);
    if (!input->kept && !(input->kept = malloc((size_t)input->n_lights * values * sizeof *input->kept))) {
        result = BTF_ERROR_MEMORY;
    }
    if (result == BTF_OK && input->kept_view != view) {
        result = enc_data_view(context, input->data, view, input->kept);
        input->kept_view = result == BTF_OK ? view : -1;
    }
    if (result == BTF_OK) {
        memcpy(out_rgb, input->kept + (size_t)light * values, values * sizeof *out_rgb);
    }
    pthread_mutex_unlock(&input->lock);
    return result;
}

btf_result btf_input_image(btf_input *input, int view, int light, const btf_log *log, float *out_rgb) {
    const enc_context context = context_of(log, 0);
    if (!input || !out_rgb) {
        return BTF_ERROR_USAGE;
    }
    if (view < 0 || view >= input->n_views || light < 0 || light >= input->n_lights) {
        return enc_fail(&context, BTF_ERROR_USAGE,
                        "view %d or light %d is not one of the %d views and %d lights", view, light,
                        input->n_views, input->n_lights);
    }
    return input->set.source ? read_image(&context, input, view, light, out_rgb)
                             : gather_image(&context, input, view, light, out_rgb);
}

void btf_input_close(btf_input **input) {
    if (!input || !*input) {
        return;
    }
    btf_input *i = *input;
    enc_radiance_clear(&i->set.radiance);
    enc_grid_destroy(&i->set.grid);
    enc_source_close(&i->set.source);
    free(i->set.source_of);
    enc_data_destroy(&i->data);
    free(i->kept);
    free(i->views);
    free(i->lights);
    free(i->view_angles);
    free(i->light_angles);
    free(i->names);
    free(i->layer);
    pthread_mutex_destroy(&i->lock);
    free(i);
    *input = NULL;
}

btf_result btf_input_write_image(const char *path, int width, int height, const float *rgb,
                                 const btf_log *log) {
    const btf_log none = {NULL, NULL};
    if (!path || !rgb || width < 1 || height < 1 || width > ENC_MAX_SIDE || height > ENC_MAX_SIDE) {
        return BTF_ERROR_USAGE;
    }
    output_leave_signals(); /* the signals' handlers are the caller's */
    return exr_image_write(path, width, height, rgb, false, log ? *log : none);
}
