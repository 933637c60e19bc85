/* RGB images in OpenEXR files through OpenEXRCore.
 *
 * SPDX-License-Identifier: MIT
 */
#include "exr_image.h"

#include "decoder/pixels/exr_choose.h"
#include "decoder/pixels/exr_chroma.h"
#include "decoder/pixels/exr_pixels.h"
#include "decoder/pixels/spectrum.h"
#include "decoder/toolkit/exr/attributes.h"
#include "decoder/toolkit/exr/rgb_part.h"
#include "output.h"

#include <openexr.h>

#include <math.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

/* What OpenEXRCore's callbacks see: the bytes to read, or the stream to write, and the first complaint. */
typedef struct exr_stream {
    const unsigned char *data;
    uint64_t size;
    FILE *stream;
    char text[256];
} exr_stream;

/* The stream this thread is at work on. OpenEXRCore 3.1 may call the error handler with its context locked,
 * and exr_get_user_data would wait for that lock for ever. */
static _Thread_local exr_stream *current;

static void on_error(exr_const_context_t context, exr_result_t code, const char *text) {
    (void)context;
    (void)code;
    if (current && !current->text[0]) {
        snprintf(current->text, sizeof current->text, "%s", text);
    }
}

static int64_t on_size(exr_const_context_t context, void *user) {
    (void)context;
    return (int64_t)((exr_stream *)user)->size;
}

static int64_t on_read(exr_const_context_t context, void *user, void *buffer, uint64_t size,
                       uint64_t offset, exr_stream_error_func_ptr_t fail) {
    (void)context;
    (void)fail;
    const exr_stream *s = user;
    if (offset >= s->size) {
        return 0;
    }
    const uint64_t n = size < s->size - offset ? size : s->size - offset;
    memcpy(buffer, s->data + offset, n);
    return (int64_t)n;
}

static int64_t on_write(exr_const_context_t context, void *user, const void *buffer, uint64_t size,
                        uint64_t offset, exr_stream_error_func_ptr_t fail) {
    FILE *stream = ((exr_stream *)user)->stream;
    if (fseeko(stream, (off_t)offset, SEEK_SET) != 0 || fwrite(buffer, 1, size, stream) != size) {
        fail(context, EXR_ERR_WRITE_IO, "writing failed");
        return -1;
    }
    return (int64_t)size;
}

static btf_result result_of(exr_result_t code) {
    switch (code) {
    case EXR_ERR_SUCCESS:
        return BTF_OK;
    case EXR_ERR_OUT_OF_MEMORY:
        return BTF_ERROR_MEMORY;
    case EXR_ERR_FEATURE_NOT_IMPLEMENTED:
        return BTF_ERROR_UNSUPPORTED;
    default:
        return BTF_ERROR_BAD_FILE;
    }
}

/* An open file being decoded. */
typedef struct reading {
    exr_context_t context;
    exr_choice choice;
    exr_image image;
    image_info *info;
    exr_attr_box2i_t window;
    const exr_attr_chlist_t *list;
    bool tiled;
    exr_attributes attributes;
    int x_step, y_step; /* of chroma */
    size_t bands;       /* of a spectrum, by rising wavelength */
    int *band_channel;
    float (*band_weights)[3];
    char *message;
    size_t message_size;
} reading;

__attribute__((format(printf, 3, 4))) static btf_result fail(const reading *r, btf_result result,
                                                             const char *format, ...) {
    va_list arguments;
    char text[300];
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    snprintf(r->message, r->message_size, "EXR: %s", text);
    return result;
}

/* The channel of the picture that a channel of the file holds, or of a spectrum the band; -1: neither. */
static int role_of(const reading *r, int channel) {
    for (int c = 0; c < (r->choice.kind == EXR_KIND_GREY ? 1 : 3) && r->choice.kind != EXR_KIND_SPECTRUM;
         c++) {
        if (r->choice.channel[c] == channel) {
            return c;
        }
    }
    for (size_t b = 0; b < r->bands; b++) {
        if (r->band_channel[b] == channel) {
            return (int)b;
        }
    }
    return -1;
}

/* Refuses sampling that the picture's channels may not have: chroma alone is subsampled, by 2, all of it
 * alike. */
static btf_result check_sampling(reading *r) {
    const bool chroma = r->choice.kind == EXR_KIND_CHROMA;
    r->x_step = r->y_step = 1;
    if (chroma) {
        const exr_attr_chlist_entry_t *red = &r->list->entries[r->choice.channel[0]];
        r->x_step = red->x_sampling == 2 ? 2 : 1;
        r->y_step = red->y_sampling == 2 ? 2 : 1;
    }
    for (int i = 0; i < r->list->num_channels; i++) {
        const exr_attr_chlist_entry_t *channel = &r->list->entries[i];
        const int role = role_of(r, i);
        const bool free_to_differ = role < 0 && !r->tiled, is_chroma = chroma && role >= 0 && role != 1;
        if (exr_sampling_fits(channel, &r->window) &&
            (free_to_differ || (channel->x_sampling == (is_chroma ? r->x_step : 1) &&
                                channel->y_sampling == (is_chroma ? r->y_step : 1)))) {
            continue;
        }
        return fail(r, BTF_ERROR_UNSUPPORTED,
                    "channel %.40s is subsampled %d x %d; only chroma (RY and BY, both by 2) may be: store "
                    "it at full size",
                    channel->name.str, (int)channel->x_sampling, (int)channel->y_sampling);
    }
    return BTF_OK;
}

/* Converts luminance and chroma to RGB; the weights of R, G and B in the luminance follow from the file's
 * primaries. */
static btf_result finish_chroma(const reading *r) {
    double xyz[9];
    if (!primaries_to_xyz(&r->attributes.primaries, xyz) || !(fabs(xyz[4]) > 1e-6)) {
        return fail(r, BTF_ERROR_BAD_FILE, "the chromaticities span no colour space");
    }
    const float weights[3] = {(float)xyz[3], (float)xyz[4], (float)xyz[5]};
    return exr_chroma_to_rgb(r->image.width, r->image.height, r->x_step, r->y_step, weights,
                             r->image.pixels);
}

typedef struct band {
    double nm;
    int channel;
} band;

static int by_wavelength(const void *a, const void *b) {
    const band *x = a, *y = b;
    return (x->nm > y->nm) - (x->nm < y->nm);
}

/* Finds the bands of the chosen layer and what each one adds to R, G and B. */
static btf_result settle_spectrum(reading *r) {
    const size_t most = (size_t)r->list->num_channels;
    band *bands = calloc(most, sizeof *bands);
    double *nm = calloc(most, sizeof *nm);
    r->band_channel = calloc(most, sizeof *r->band_channel);
    r->band_weights = calloc(most, sizeof *r->band_weights);
    btf_result result = bands && nm && r->band_channel && r->band_weights ? BTF_OK : BTF_ERROR_MEMORY;
    for (int i = 0; i < r->list->num_channels && result == BTF_OK; i++) {
        const char *name = r->list->entries[i].name.str;
        double wavelength;
        size_t length;
        if (exr_wavelength(name, &wavelength, &length) && length == strlen(r->choice.layer) &&
            strncmp(name, r->choice.layer, length) == 0) {
            bands[r->bands++] = (band){wavelength, i};
        }
    }
    if (result == BTF_OK) {
        qsort(bands, r->bands, sizeof *bands, by_wavelength);
    }
    for (size_t b = 0; b < r->bands && result == BTF_OK; b++) {
        nm[b] = bands[b].nm;
        r->band_channel[b] = bands[b].channel;
        if (b > 0 && !(nm[b] > nm[b - 1])) {
            result = fail(r, BTF_ERROR_BAD_FILE, "two channels have the wavelength of %g nm", nm[b]);
        }
    }
    if (result == BTF_OK && (nm[0] > 780.0 || nm[r->bands - 1] < 380.0)) {
        result = fail(r, BTF_ERROR_UNSUPPORTED,
                      "the spectrum of %g to %g nm lies outside of what is visible, 380 to 780 nm", nm[0],
                      nm[r->bands - 1]);
    }
    if (result == BTF_OK) {
        const bool emission = r->choice.layer[0] == 'S';
        spectrum_weights(nm, r->bands, emission, r->band_weights);
        image_note(r->info, IMAGE_NOTE_SPECTRUM,
                   "EXR: %zu bands of %g to %g nm are integrated to Rec. 709 by CIE 1931 (2 degrees) %s",
                   r->bands, nm[0], nm[r->bands - 1], emission ? "as light" : "under D65");
    }
    free(nm);
    free(bands);
    return result;
}

/* The alpha channel in the picture's own layer; -1: none. */
static int find_alpha(const reading *r) {
    const size_t length = strlen(r->choice.layer);
    for (int i = 0; i < r->list->num_channels; i++) {
        const char *name = r->list->entries[i].name.str;
        if (strncmp(name, r->choice.layer, length) != 0 || (length && name[length] != '.') ||
            role_of(r, i) >= 0) {
            continue;
        }
        const char *own = name + length + (length > 0);
        if (strcasecmp(own, "A") == 0 || strcasecmp(own, "alpha") == 0) {
            return i;
        }
    }
    return -1;
}

static btf_result read_samples(reading *r) {
    const size_t n = (size_t)r->image.channels, row = (size_t)r->image.width * n;
    bool clear = false;
    exr_target *targets = calloc((size_t)r->list->num_channels, sizeof *targets);
    r->image.pixels = calloc(row * (size_t)r->image.height, sizeof *r->image.pixels);
    if (!targets || !r->image.pixels) {
        free(targets);
        return BTF_ERROR_MEMORY;
    }
    for (int i = 0; i < r->list->num_channels; i++) {
        const exr_attr_chlist_entry_t *channel = &r->list->entries[i];
        const int role = role_of(r, i);
        if (role >= 0) {
            targets[i] = (exr_target){.out = r->image.pixels + (r->bands ? 0 : role),
                                      .stride = n * (size_t)channel->x_sampling,
                                      .pitch = row * (size_t)channel->y_sampling,
                                      .weights = r->bands ? r->band_weights[role] : NULL};
        }
    }
    const int alpha = find_alpha(r);
    if (alpha >= 0) {
        targets[alpha].below_one = &clear;
    }
    btf_result result =
        result_of(exr_read_pixels(r->context, r->choice.part, &r->window, r->tiled, targets));
    free(targets);
    if (clear) {
        image_note(r->info, IMAGE_NOTE_ALPHA,
                   "EXR: alpha below 1 is not used: colours are taken as they are stored");
    }
    if (result == BTF_OK && r->choice.kind == EXR_KIND_CHROMA) {
        result = finish_chroma(r);
    }
    return result;
}

/* Refuses compressions that are not read, each by its name. */
static btf_result check_compression(const reading *r, exr_compression_t compression) {
    static const char *const unread[] = {[EXR_COMPRESSION_B44] = "B44",
                                         [EXR_COMPRESSION_B44A] = "B44A",
                                         [EXR_COMPRESSION_DWAA] = "DWAA",
                                         [EXR_COMPRESSION_DWAB] = "DWAB"};
    if (compression < EXR_COMPRESSION_B44) {
        return BTF_OK;
    }
    if (compression > EXR_COMPRESSION_DWAB) {
        return fail(r, BTF_ERROR_UNSUPPORTED, "compression %d is not read: store it as ZIP or PIZ",
                    (int)compression);
    }
    /* OpenEXRCore 3.1.5 has no DWA; of B44 it gives wrong values for floats, and fails on small tiles. */
    return fail(r, BTF_ERROR_UNSUPPORTED, "%s compression is not read: store it as ZIP or PIZ",
                unread[compression]);
}

static btf_result check_size(reading *r, size_t max_pixels) {
    const int64_t width = (int64_t)r->window.max.x - r->window.min.x + 1;
    const int64_t height = (int64_t)r->window.max.y - r->window.min.y + 1;
    if (width < 1 || height < 1 || width > (1 << 20) || height > (1 << 20) ||
        (uint64_t)width * (uint64_t)height > max_pixels) {
        return fail(r, BTF_ERROR_UNSUPPORTED,
                    "size %lldx%lld is not usable: at most 1048576 a side and %zu pixels are read",
                    (long long)width, (long long)height, max_pixels);
    }
    r->image.width = (int)width;
    r->image.height = (int)height;
    return BTF_OK;
}

static btf_result decode(reading *r, const char *layer, size_t max_pixels) {
    exr_storage_t storage;
    exr_compression_t compression;
    btf_result result = exr_choose(r->context, layer, &r->choice, r->info, r->message, r->message_size);
    if (result != BTF_OK) {
        return result;
    }
    const int part = r->choice.part;
    exr_result_t code = exr_get_storage(r->context, part, &storage);
    if (code == EXR_ERR_SUCCESS) {
        code = exr_get_compression(r->context, part, &compression);
    }
    if (code == EXR_ERR_SUCCESS) {
        code = exr_get_data_window(r->context, part, &r->window);
    }
    if (code == EXR_ERR_SUCCESS) {
        code = exr_get_channels(r->context, part, &r->list);
    }
    if (code != EXR_ERR_SUCCESS) {
        return result_of(code);
    }
    r->tiled = storage == EXR_STORAGE_TILED;
    r->image.channels = r->choice.kind == EXR_KIND_GREY ? 1 : 3;
    r->image.xyz = r->choice.kind == EXR_KIND_XYZ;
    result = check_compression(r, compression);
    if (result == BTF_OK) {
        result = check_size(r, max_pixels);
    }
    if (result == BTF_OK && r->choice.kind == EXR_KIND_SPECTRUM) {
        result = settle_spectrum(r);
    }
    if (result == BTF_OK) {
        result = check_sampling(r);
    }
    if (result == BTF_OK) {
        result = exr_attributes_heed(r->context, &r->choice, &r->window, &r->attributes, r->info,
                                     r->message, r->message_size);
        r->image.cube = r->attributes.cube;
    }
    current->text[0] = '\0'; /* OpenEXRCore complains of attributes that are not there */
    return result == BTF_OK ? read_samples(r) : result;
}

btf_result exr_image_read(const void *data, size_t size, size_t max_pixels, const char *layer,
                          exr_image *out_image, image_info *info, char *message, size_t message_size) {
    exr_stream stream = {.data = data, .size = size};
    exr_context_initializer_t options = EXR_DEFAULT_CONTEXT_INITIALIZER;
    options.error_handler_fn = on_error;
    options.user_data = &stream;
    options.read_fn = on_read;
    options.size_fn = on_size;
    reading r = {.info = info, .message = message, .message_size = message_size};
    message[0] = '\0';
    current = &stream;
    btf_result result = result_of(exr_start_read(&r.context, "memory", &options));
    if (result == BTF_OK) {
        result = decode(&r, layer, max_pixels);
    }
    exr_finish(&r.context);
    current = NULL;
    free(r.band_channel);
    free(r.band_weights);
    if (result == BTF_OK) {
        *out_image = r.image;
        return BTF_OK;
    }
    free(r.image.pixels);
    if (!message[0]) {
        snprintf(message, message_size, "EXR: %s", stream.text[0] ? stream.text : btf_result_text(result));
    }
    return result;
}

/* A copy whose values fit a half float. */
static float *clamp_to_half(const float *rgb, size_t count) {
    float *copy = malloc(count * sizeof *copy);
    for (size_t i = 0; copy && i < count; i++) {
        copy[i] = fminf(fmaxf(rgb[i], -65504.0f), 65504.0f);
    }
    return copy;
}

btf_result exr_image_write(const char *path, int width, int height, const float *rgb, bool half,
                           btf_log log) {
    float *clamped = NULL;
    if (half) {
        clamped = clamp_to_half(rgb, (size_t)width * (size_t)height * 3);
        if (!clamped) {
            return BTF_ERROR_MEMORY;
        }
        rgb = clamped;
    }
    output *file;
    btf_result result = output_open(path, log, &file);
    if (result != BTF_OK) {
        free(clamped);
        return result;
    }
    exr_stream stream = {.stream = output_stream(file)};
    exr_context_initializer_t options = EXR_DEFAULT_CONTEXT_INITIALIZER;
    options.error_handler_fn = on_error;
    options.user_data = &stream;
    options.write_fn = on_write;
    exr_context_t context = NULL;
    current = &stream;
    exr_result_t code = exr_start_write(&context, path, EXR_WRITE_FILE_DIRECTLY, &options);
    if (code == EXR_ERR_SUCCESS) {
        code = exr_rgb_part_write(context, width, height, rgb, half);
    }
    const exr_result_t finished = exr_finish(&context);
    current = NULL;
    free(clamped);
    if (code == EXR_ERR_SUCCESS) {
        code = finished;
    }
    if (code == EXR_ERR_SUCCESS) {
        return output_commit(&file);
    }
    output_abort(&file);
    if (log.callback) {
        char text[512];
        snprintf(text, sizeof text, "%.200s: EXR: %s", path,
                 stream.text[0] ? stream.text : exr_get_default_error_message(code));
        log.callback(log.user, BTF_LOG_ERROR, text);
    }
    return code == EXR_ERR_OUT_OF_MEMORY ? BTF_ERROR_MEMORY : BTF_ERROR_IO;
}
