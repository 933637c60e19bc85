/* Decoding of Bonn's binary .btf files. See decode.h.
 *
 * A view's light profiles of a block of texels are one small matrix product a channel: the direction side
 * is packed once, the texel side is read from the file block by block.
 *
 * SPDX-License-Identifier: MIT
 */
#include "decode.h"

#include "colour.h"
#include "encoder/math/gemm.h"
#include "fields.h"

#include <archive.h>
#include <archive_entry.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { BLOCK = 5 * ENC_GEMM_M }; /* texels of one product */

struct enc_bonn_decoder {
    const enc_bonn_file *file;
    int *view_order, *light_order;
    float *light_factor;
    uint32_t *components;    /* [matrix]: the count of its components that are used */
    uint32_t most;           /* the greatest of these counts */
    float **packed;          /* [view * 3 + channel]: direction side, as right operand of lights */
    float *means;            /* of a PVF with a mean for each light: [view][channel][light]; else NULL */
    unsigned char *expanded; /* of a bzipped BDI: its chunks unpacked, one after the other; else NULL */
};

static const enc_bonn_matrix *matrix_of(const enc_bonn_file *f, size_t view, size_t channel,
                                        size_t *out_index) {
    const size_t i = f->kind == ENC_BONN_DFMF ? channel : f->kind == ENC_BONN_FMF ? 0 : view;
    *out_index = i;
    return &f->matrices[i];
}

/* The row of a matrix's direction side, for a view and a light as the file numbers them. */
static size_t direction_row(const enc_bonn_file *f, const enc_bonn_matrix *m, size_t view, size_t light,
                            size_t channel) {
    const size_t direction = f->kind == ENC_BONN_PVF ? light : view * f->n_lights + light;
    return f->kind == ENC_BONN_DFMF || m->channel_of_texel ? direction : 3 * direction + channel;
}

static size_t texel_row(const enc_bonn_matrix *m, size_t texel, size_t channel) {
    return m->channel_of_texel ? 3 * texel + channel : texel;
}

static btf_result check_finite(const enc_context *context, const enc_bonn_file *f, size_t count,
                               const float *numbers, const char *what, size_t view, size_t light) {
    for (size_t i = 0; i < count; i++) {
        if (!isfinite(numbers[i])) {
            return enc_fail(context, BTF_ERROR_BAD_FILE,
                            "%s: %s of view %zu, light %zu: number %zu is not finite (%g)", f->path, what,
                            view, light, i, (double)numbers[i]);
        }
    }
    return BTF_OK;
}

/* Packs the direction side of one view and channel, a row of components for each light, and sets the lights'
 * means. */
static btf_result pack_directions(const enc_context *context, enc_bonn_decoder *d, size_t view,
                                  size_t channel, float *rows) {
    const enc_bonn_file *f = d->file;
    size_t index;
    const enc_bonn_matrix *m = matrix_of(f, view, channel, &index);
    const size_t k = d->components[index], lights = f->n_lights;
    const uint64_t stride = (uint64_t)m->components * m->scalar;
    for (size_t l = 0; l < lights; l++) {
        const size_t light = (size_t)d->light_order[l];
        const size_t row = direction_row(f, m, view, light, channel);
        enc_bonn_numbers(f, m->directions + row * stride, m->scalar, k, rows + l * k);
        btf_result result = check_finite(context, f, k, rows + l * k, "component", view, light);
        if (result == BTF_OK && d->means && !m->mean_of_texel) {
            float *mean = d->means + (view * 3 + channel) * lights + l;
            enc_bonn_numbers(f, m->mean + row * m->scalar, m->scalar, 1, mean);
            result = check_finite(context, f, 1, mean, "mean", view, light);
        }
        if (result != BTF_OK) {
            return result;
        }
    }
    float *packed = enc_gemm_alloc(enc_gemm_panels(lights, ENC_GEMM_N) * ENC_GEMM_N * k);
    if (!packed) {
        return BTF_ERROR_MEMORY;
    }
    enc_gemm_pack_rows(lights, k, rows, k, ENC_GEMM_N, packed);
    d->packed[view * 3 + channel] = packed;
    return BTF_OK;
}

static btf_result prepare_matrices(const enc_context *context, enc_bonn_decoder *d, uint32_t components) {
    const enc_bonn_file *f = d->file;
    const size_t planes = 3 * (size_t)f->n_views;
    d->components = calloc(f->n_matrices, sizeof *d->components);
    d->packed = calloc(planes, sizeof *d->packed);
    if (f->kind == ENC_BONN_PVF) {
        d->means = calloc(planes * f->n_lights, sizeof *d->means);
    }
    if (!d->components || !d->packed || (f->kind == ENC_BONN_PVF && !d->means)) {
        return BTF_ERROR_MEMORY;
    }
    for (uint32_t i = 0; i < f->n_matrices; i++) {
        const uint32_t all = f->matrices[i].components;
        d->components[i] = components > 0 && components < all ? components : all;
        if (d->components[i] > d->most) {
            d->most = d->components[i];
        }
    }
    float *rows = malloc((size_t)f->n_lights * d->most * sizeof *rows);
    btf_result result = rows ? BTF_OK : BTF_ERROR_MEMORY;
    for (size_t i = 0; i < planes && result == BTF_OK; i++) {
        result = pack_directions(context, d, i / 3, i % 3, rows);
    }
    free(rows);
    return result;
}

/* Unpacks a bzipped chunk, which must give exactly `size` bytes. */
static btf_result expand_chunk(const enc_context *context, const enc_bonn_file *f, uint32_t index,
                               unsigned char *out, size_t size) {
    struct archive *reader = archive_read_new();
    struct archive_entry *entry;
    bool good = false;
    if (!reader) {
        return BTF_ERROR_MEMORY;
    }
    if (archive_read_support_filter_bzip2(reader) >= ARCHIVE_WARN &&
        archive_read_support_format_raw(reader) == ARCHIVE_OK &&
        archive_read_open_memory(reader, f->bytes + f->chunks[index].offset, f->chunks[index].size) ==
            ARCHIVE_OK &&
        archive_filter_code(reader, 0) >= 0 && archive_read_next_header(reader, &entry) == ARCHIVE_OK) {
        size_t done = 0;
        for (la_ssize_t n = 1; done < size && n > 0; done += (size_t)(n > 0 ? n : 0)) {
            n = archive_read_data(reader, out + done, size - done);
        }
        char more;
        good = done == size && archive_read_data(reader, &more, 1) == 0;
    }
    archive_read_free(reader);
    return good ? BTF_OK
                : enc_fail(context, BTF_ERROR_BAD_FILE,
                           "%s: chunk %u at byte %llu is damaged: its %zu bytes cannot be unpacked",
                           f->path, index, (unsigned long long)f->chunks[index].offset, size);
}

static size_t abrdf_size(const enc_bonn_file *f) {
    return 3 * (size_t)f->n_views * f->n_lights;
}

static btf_result expand_all(const enc_context *context, enc_bonn_decoder *d) {
    const enc_bonn_file *f = d->file;
    const size_t per_chunk = (size_t)f->width * f->lines_per_chunk, abrdf = 2 * abrdf_size(f);
    const size_t stored = (size_t)f->width * f->height - f->n_missing;
    d->expanded = malloc(stored * abrdf);
    if (!d->expanded) {
        return enc_fail(context, BTF_ERROR_MEMORY, "%s: out of memory for %.2f GB of unpacked samples",
                        f->path, (double)(stored * abrdf) * 1e-9);
    }
    btf_result result = BTF_OK;
    for (uint32_t i = 0; i < f->n_chunks && result == BTF_OK; i++) {
        const size_t first = i * per_chunk, left = stored - first;
        result = enc_cancelled(context) ? BTF_ERROR_INTERRUPTED
                                        : expand_chunk(context, f, i, d->expanded + first * abrdf,
                                                       (left < per_chunk ? left : per_chunk) * abrdf);
    }
    return result;
}

static int *copy_order(const int *order, size_t count) {
    int *copy = malloc(count * sizeof *copy);
    if (copy) {
        memcpy(copy, order, count * sizeof *copy);
    }
    return copy;
}

btf_result enc_bonn_decoder_create(const enc_context *context, const enc_bonn_file *file,
                                   const int *view_order, const int *light_order, const float *light_factor,
                                   uint32_t components, enc_bonn_decoder **out_decoder) {
    enc_bonn_decoder *d = calloc(1, sizeof *d);
    *out_decoder = NULL;
    if (!d) {
        return BTF_ERROR_MEMORY;
    }
    d->file = file;
    d->view_order = copy_order(view_order, file->n_views);
    d->light_order = copy_order(light_order, file->n_lights);
    d->light_factor = malloc(file->n_lights * sizeof *d->light_factor);
    btf_result result = d->view_order && d->light_order && d->light_factor ? BTF_OK : BTF_ERROR_MEMORY;
    if (result == BTF_OK) {
        memcpy(d->light_factor, light_factor, file->n_lights * sizeof *d->light_factor);
        if (file->kind != ENC_BONN_BDI) {
            result = prepare_matrices(context, d, components);
        } else if (file->compression == ENC_BONN_BZIP) {
            result = expand_all(context, d);
        }
    }
    if (result == BTF_ERROR_MEMORY) {
        enc_log(context, BTF_LOG_ERROR, "%s: out of memory for its directions", file->path);
    }
    if (result != BTF_OK) {
        enc_bonn_decoder_destroy(&d);
    }
    *out_decoder = d;
    return result;
}

uint32_t enc_bonn_decoder_components(const enc_bonn_decoder *decoder) {
    return decoder->most;
}

void enc_bonn_decoder_destroy(enc_bonn_decoder **decoder) {
    if (!decoder || !*decoder) {
        return;
    }
    enc_bonn_decoder *d = *decoder;
    for (size_t i = 0; d->packed && i < 3 * (size_t)d->file->n_views; i++) {
        free(d->packed[i]);
    }
    free(d->packed);
    free(d->components);
    free(d->means);
    free(d->view_order);
    free(d->light_order);
    free(d->light_factor);
    free(d->expanded);
    free(d);
    *decoder = NULL;
}

/* Multiplies out the light profiles of `count` texels in the file's view `view`: out[i][channel][light], `pitch`
 * floats from one texel to the next. rows, packed: room for a block. */
static void multiply(const enc_bonn_decoder *d, enc_gemm_tile tile, size_t count, const size_t *texels,
                     size_t view, size_t pitch, float *rows, float *packed, float *out) {
    const enc_bonn_file *f = d->file;
    const size_t lights = f->n_lights;
    for (size_t channel = 0; channel < 3; channel++) {
        size_t index;
        const enc_bonn_matrix *m = matrix_of(f, view, channel, &index);
        const size_t k = d->components[index];
        const uint64_t stride = (uint64_t)m->components * m->scalar;
        for (size_t i = 0; i < count; i++) {
            enc_bonn_numbers(f, m->texels + texel_row(m, texels[i], channel) * stride, m->scalar, k,
                             rows + i * k);
        }
        enc_gemm_pack_rows(count, k, rows, k, ENC_GEMM_M, packed);
        enc_gemm_multiply(tile, count, lights, k, packed, d->packed[view * 3 + channel],
                          out + channel * lights, pitch, 0);
        for (size_t i = 0; i < count && d->means; i++) {
            float of_texel = 0.0f;
            if (m->mean_of_texel) {
                enc_bonn_numbers(f, m->mean + texel_row(m, texels[i], channel) * m->scalar, m->scalar, 1,
                                 &of_texel);
            }
            const float *of_light = d->means + (view * 3 + channel) * lights;
            for (size_t l = 0; l < lights; l++) {
                out[i * pitch + channel * lights + l] += m->mean_of_texel ? of_texel : of_light[l];
            }
        }
    }
}

/* Copies the light profiles of a BDI, which stores samples; 0 where the file lacks the texel. */
static void fetch(const enc_bonn_decoder *d, size_t count, const size_t *texels, size_t view, size_t pitch,
                  float *out) {
    const enc_bonn_file *f = d->file;
    const size_t lights = f->n_lights, per_chunk = (size_t)f->width * f->lines_per_chunk;
    for (size_t i = 0; i < count; i++) {
        const uint32_t stored = f->stored[texels[i]];
        for (size_t l = 0; l < lights; l++) {
            const size_t light = (size_t)d->light_order[l], at = 2 * 3 * (view * lights + light);
            const unsigned char *from = stored == UINT32_MAX ? NULL
                                        : d->expanded        ? d->expanded + 2 * abrdf_size(f) * stored
                                                      : f->bytes + f->chunks[stored / per_chunk].offset +
                                                            2 * abrdf_size(f) * (stored % per_chunk);
            for (size_t c = 0; c < 3; c++) {
                out[i * pitch + c * lights + l] = from ? enc_bonn_number(from + at + 2 * c, 2) : 0.0f;
            }
        }
    }
}

/* Turns values as the file codes them into radiance. */
static btf_result finish(const enc_context *context, const enc_bonn_decoder *d, size_t texel, size_t view,
                         float *profile) {
    const enc_bonn_file *f = d->file;
    const size_t lights = f->n_lights;
    if (f->model != 0 || f->logarithm) {
        enc_bonn_colour(f->logarithm ? 12 : f->model, f->mean, f->matrix, lights, lights, profile);
    }
    for (size_t i = 0; i < 3 * lights; i++) {
        profile[i] *= d->light_factor[i % lights];
        if (!isfinite(profile[i])) {
            return enc_fail(
                context, BTF_ERROR_BAD_FILE,
                "%s: column %zu, row %zu, view %zu, light %d, channel %c is not a finite number (%g)",
                f->path, texel % f->width, texel / f->width, view, d->light_order[i % lights],
                "RGB"[i / lights], (double)profile[i]);
        }
    }
    return BTF_OK;
}

btf_result enc_bonn_decode(const enc_context *context, const enc_bonn_decoder *d, size_t count,
                           const size_t *texels, int first_view, int n_views, size_t pitch, float *out) {
    const enc_bonn_file *f = d->file;
    const size_t profile = 3 * (size_t)f->n_lights, k = d->most ? d->most : 1;
    const enc_gemm_tile tile = enc_gemm_select();
    const size_t room = (BLOCK * k + 15) / 16 * 16; /* `packed` stands behind, aligned to 64 bytes */
    float *rows = enc_gemm_alloc(room + BLOCK * k);
    btf_result result = rows ? BTF_OK : BTF_ERROR_MEMORY;
    for (size_t first = 0; first < count && result == BTF_OK; first += BLOCK) {
        const size_t n = count - first < BLOCK ? count - first : BLOCK;
        for (int v = 0; v < n_views && result == BTF_OK; v++) {
            const size_t view = (size_t)d->view_order[first_view + v];
            float *block = out + first * pitch + (size_t)v * profile;
            if (f->kind == ENC_BONN_BDI) {
                fetch(d, n, texels + first, view, pitch, block);
            } else {
                multiply(d, tile, n, texels + first, view, pitch, rows, rows + room, block);
            }
            for (size_t i = 0; i < n && result == BTF_OK; i++) {
                result = finish(context, d, texels[first + i], view, block + i * pitch);
            }
        }
    }
    free(rows);
    return result;
}
