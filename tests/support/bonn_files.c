/* Writing Bonn's binary .btf files. See bonn_files.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "bonn_files.h"

#include <archive.h>
#include <archive_entry.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

uint16_t bonn_half(double value) {
    const double magnitude = fabs(value);
    const unsigned sign = signbit(value) ? 0x8000u : 0;
    if (isnan(value)) {
        return 0x7E00;
    }
    if (magnitude >= 65520.0) {
        return (uint16_t)(sign | 0x7C00u);
    }
    if (magnitude < 0x1p-14) { /* denormals; rounding up to the least normal number gives its code */
        return (uint16_t)(sign | (unsigned)nearbyint(magnitude * 0x1p24));
    }
    int exponent;
    const double mantissa = frexp(magnitude, &exponent);
    const unsigned rounded = (unsigned)nearbyint(mantissa * 2048.0);
    return (uint16_t)(sign | (((unsigned)(exponent + 14) << 10) + (rounded - 1024)));
}

static void put_u32(FILE *file, uint32_t value) {
    const unsigned char bytes[4] = {(unsigned char)value, (unsigned char)(value >> 8),
                                    (unsigned char)(value >> 16), (unsigned char)(value >> 24)};
    fwrite(bytes, 1, 4, file);
}

static void put_number(FILE *file, double value, unsigned scalar) {
    const uint16_t half = scalar == 2 ? bonn_half(value) : 0;
    const float single = (float)value;
    const void *from = scalar == 2   ? (const void *)&half
                       : scalar == 4 ? (const void *)&single
                                     : (const void *)&value;
    fwrite(from, 1, scalar, file);
}

static void put_text(FILE *file, const char *text, size_t size) {
    char padded[80] = {0};
    strncpy(padded, text, sizeof padded - 1);
    fwrite(padded, 1, size, file);
}

static void put_meta(FILE *file, const bonn_spec *s) {
    static const char xml[] = "<measurement/>";
    static const char *const names[] = {"R", "G", "B", "400nm"};
    const int channels = s->channels ? s->channels : 3;
    uint32_t size = 4 + 4 + 240 + 4 + 12;
    if (s->meta_version >= 2) {
        size += 4;
    }
    if (s->meta_version >= 3) {
        size += 4 + sizeof xml - 1;
    }
    if (s->meta_version >= 4) {
        size += 4;
    }
    for (int c = 0; s->meta_version >= 4 && c < channels; c++) {
        size += 4 + (uint32_t)strlen(names[c < 4 ? c : 3]);
    }
    put_u32(file, size);
    put_u32(file, (uint32_t)s->meta_version);
    put_text(file, "setup", 80);
    put_text(file, "sensor", 80);
    put_text(file, "light", 80);
    for (int i = 0; i < 4; i++) {
        put_number(file, 1.0, 4);
    }
    if (s->meta_version >= 2) {
        put_u32(file, s->cosine);
    }
    if (s->meta_version >= 3) {
        put_u32(file, sizeof xml - 1);
        fwrite(xml, 1, sizeof xml - 1, file);
    }
    if (s->meta_version >= 4) {
        put_u32(file, (uint32_t)channels);
    }
    for (int c = 0; s->meta_version >= 4 && c < channels; c++) {
        const char *name = names[c < 4 ? c : 3];
        put_u32(file, (uint32_t)strlen(name));
        fwrite(name, 1, strlen(name), file);
    }
}

static void put_direction(FILE *file, const double direction[2]) {
    const double radians = 3.14159265358979323846 / 180.0;
    put_number(file, direction[0] * radians, 4);
    put_number(file, (direction[1] >= 180.0 ? direction[1] - 360.0 : direction[1]) * radians, 4);
}

static void put_directions(FILE *file, const bonn_spec *s) {
    put_u32(file, (uint32_t)s->n_views);
    for (int v = 0; v < s->n_views; v++) {
        put_direction(file, s->views[v]);
        put_u32(file, (uint32_t)s->n_lights);
        for (int l = 0; l < s->n_lights; l++) {
            put_direction(file, s->lights[l]);
        }
    }
}

static void put_rotations(FILE *file, const bonn_spec *s) {
    put_u32(file, s->rotations);
    for (unsigned i = 0; i < 9 * s->rotations; i++) {
        put_number(file, i % 4 == 0, 4);
    }
}

/* One side of a factorisation: rows of directions (views first .. first+n-1), or of texels; `by_channel`
 * rows run over the three channels fastest, else all are of `channel`. */
static void put_directions_side(FILE *file, const bonn_spec *s, int first, int n, bool by_channel,
                                int channel, unsigned k, unsigned scalar) {
    for (int v = first; v < first + n; v++) {
        for (int l = 0; l < s->n_lights; l++) {
            for (int c = 0; c < (by_channel ? 3 : 1); c++) {
                for (unsigned i = 0; i < k; i++) {
                    put_number(file, s->direction(v, l, by_channel ? c : channel, i), scalar);
                }
            }
        }
    }
}

static void put_texels_side(FILE *file, const bonn_spec *s, int view, bool by_channel, int channel,
                            unsigned k, unsigned scalar) {
    for (int y = 0; y < s->height; y++) {
        for (int x = 0; x < s->width; x++) {
            for (int c = 0; c < (by_channel ? 3 : 1); c++) {
                for (unsigned i = 0; i < k; i++) {
                    put_number(file, s->texel(x, y, by_channel ? c : channel, view, i), scalar);
                }
            }
        }
    }
}

/* Scalar size to end of one factorisation; the left side holds the channels' rows where there are three. */
static void put_factors(FILE *file, const bonn_spec *s, int channels, int channel, unsigned k,
                        unsigned scalar) {
    const bool three = channels == 3;
    const uint32_t directions = (uint32_t)(s->n_views * s->n_lights),
                   texels = (uint32_t)(s->width * s->height);
    fputc((int)scalar, file);
    put_u32(file, k);
    put_u32(file, (uint32_t)channels * (s->swapped ? texels : directions));
    put_u32(file, s->swapped ? directions : texels);
    for (unsigned i = 0; i < k; i++) {
        put_number(file, 1.0, scalar);
    }
    if (s->swapped) {
        put_texels_side(file, s, 0, three, channel, k, scalar);
        put_directions_side(file, s, 0, s->n_views, false, three ? 0 : channel, k, scalar);
    } else {
        put_directions_side(file, s, 0, s->n_views, three, channel, k, scalar);
        put_texels_side(file, s, 0, false, three ? 0 : channel, k, scalar);
    }
}

static void put_dfmf(FILE *file, const bonn_spec *s) {
    unsigned most = 0;
    for (int c = 0; c < 3; c++) {
        most = s->components[c] > most ? s->components[c] : most;
    }
    put_u32(file, most);
    put_u32(file, (uint32_t)s->model);
    for (int i = 0; i < 3; i++) {
        put_number(file, s->mean[i], 4);
    }
    for (int i = 0; i < 9; i++) {
        put_number(file, s->matrix[i], 4);
    }
    for (int c = 0; c < 3; c++) {
        put_factors(file, s, 1, c, s->components[c], s->scalar[c]);
    }
}

static void put_fmf(FILE *file, const bonn_spec *s) {
    if (strcmp(s->signature, "!FMF12FCER") == 0) {
        fputc((int)s->header_version, file);
        if (s->header_version >= 1) {
            put_u32(file, s->logarithm);
        }
        if (s->header_version >= 2) {
            put_u32(file, s->height_rows);
            put_u32(file, s->height_columns);
            for (unsigned i = 0; i < s->height_rows * s->height_columns; i++) {
                put_number(file, i, 2);
            }
        }
    }
    put_u32(file, s->components[0]);
    put_factors(file, s, 3, 0, s->components[0], s->scalar[0]);
}

static void put_pvf(FILE *file, const bonn_spec *s) {
    const unsigned k = s->components[0], scalar = s->scalar[0];
    const uint32_t lights = (uint32_t)s->n_lights, texels = (uint32_t)(s->width * s->height);
    for (int v = 0; v < s->n_views; v++) {
        fputc((int)scalar, file);
        put_u32(file, k);
        put_u32(file, s->swapped ? lights : texels);
        put_u32(file, 3 * (s->swapped ? texels : lights));
        for (unsigned i = 0; i < k; i++) {
            put_number(file, 1.0, scalar);
        }
        for (uint32_t i = 0; i < (s->swapped ? texels : lights); i++) {
            for (int c = 0; c < 3; c++) {
                put_number(file,
                           s->swapped ? s->average(v, 0, c, (int)i % s->width, (int)i / s->width)
                                      : s->average(v, (int)i, c, 0, 0),
                           scalar);
            }
        }
        if (s->swapped) {
            put_texels_side(file, s, v, true, 0, k, scalar);
            put_directions_side(file, s, v, 1, false, 0, k, scalar);
        } else {
            put_directions_side(file, s, v, 1, true, 0, k, scalar);
            put_texels_side(file, s, v, false, 0, k, scalar);
        }
    }
}

/* Bytes as bzip2, malloc'ed. */
static unsigned char *squeeze(const unsigned char *bytes, size_t size, size_t *out_size) {
    const size_t room = 2 * size + 4096;
    unsigned char *out = malloc(room);
    struct archive *writer = archive_write_new();
    struct archive_entry *entry = archive_entry_new();
    archive_write_add_filter_bzip2(writer);
    archive_write_set_format_raw(writer);
    archive_write_set_bytes_per_block(writer, 0);
    archive_write_open_memory(writer, out, room, out_size);
    archive_entry_set_filetype(entry, AE_IFREG);
    archive_entry_set_pathname(entry, "chunk");
    archive_write_header(writer, entry);
    archive_write_data(writer, bytes, size);
    archive_entry_free(entry);
    archive_write_free(writer);
    return out;
}

static void put_chunk(FILE *file, const bonn_spec *s, const unsigned char *bytes, size_t size) {
    if (s->compression != 1) {
        put_u32(file, (uint32_t)size);
        fwrite(bytes, 1, size, file);
        return;
    }
    size_t squeezed_size = 0;
    unsigned char *squeezed = squeeze(bytes, size, &squeezed_size);
    put_u32(file, (uint32_t)squeezed_size);
    fwrite(squeezed, 1, squeezed_size, file);
    free(squeezed);
}

static void put_bdi(FILE *file, const bonn_spec *s) {
    const size_t abrdf = 6 * (size_t)s->n_views * (size_t)s->n_lights;
    const size_t per_chunk = (size_t)s->width * s->lines_per_chunk;
    unsigned char *chunk = malloc(per_chunk * abrdf);
    size_t held = 0;
    put_u32(file, s->lines_per_chunk);
    fputc((int)s->compression, file);
    for (int i = 0; i < s->width * s->height; i++) {
        fputc(s->mask ? s->mask[i] : 1, file);
    }
    put_rotations(file, s);
    for (int i = 0; i < s->width * s->height; i++) {
        if (s->compression == 2 && s->mask && !s->mask[i]) {
            continue;
        }
        unsigned char *at = chunk + held++ * abrdf;
        for (int v = 0; v < s->n_views; v++) {
            for (int l = 0; l < s->n_lights; l++) {
                for (int c = 0; c < 3; c++, at += 2) {
                    const uint16_t half = bonn_half(s->sample(v, l, c, i % s->width, i / s->width));
                    at[0] = (unsigned char)half;
                    at[1] = (unsigned char)(half >> 8);
                }
            }
        }
        if (held == per_chunk) {
            put_chunk(file, s, chunk, held * abrdf);
            held = 0;
        }
    }
    if (held > 0) {
        put_chunk(file, s, chunk, held * abrdf);
    }
    free(chunk);
}

bonn_spec bonn_half_dfmf(int side, int n, const double (*directions)[2], unsigned k) {
    /* clang-format off */
    return (bonn_spec){
        .form = BONN_DFMF, .signature = "!DFMF08FCR", .meta_version = 3, .cosine = true, .width = side,
        .height = side, .n_views = n, .n_lights = n, .views = directions, .lights = directions, .model = 11,
        .scalar = {2, 2, 2}, .components = {k, k, k},
    };
    /* clang-format on */
}

bool bonn_write(const char *path, const bonn_spec *s) {
    FILE *file = fopen(path, "wb");
    if (!file) {
        return false;
    }
    fwrite(s->signature, 1, strlen(s->signature), file);
    if (s->form == BONN_PVF_LEGACY) {
        put_u32(file, 301074);
        put_u32(file, s->components[0]);
        put_u32(file, (uint32_t)s->width);
        put_u32(file, (uint32_t)s->height);
        put_u32(file, (uint32_t)s->n_views);
        put_directions(file, s);
    } else {
        put_meta(file, s);
        put_directions(file, s);
        put_u32(file, (uint32_t)s->width);
        put_u32(file, (uint32_t)s->height);
        if (s->form != BONN_BDI && s->signature[strlen(s->signature) - 1] == 'R') {
            put_rotations(file, s);
        }
        if (s->form == BONN_PVF) {
            put_u32(file, s->components[0]);
            put_u32(file, (uint32_t)s->n_views);
        }
    }
    if (s->form == BONN_DFMF) {
        put_dfmf(file, s);
    } else if (s->form == BONN_FMF) {
        put_fmf(file, s);
    } else if (s->form == BONN_BDI) {
        put_bdi(file, s);
    } else {
        put_pvf(file, s);
    }
    const bool good = !ferror(file);
    return fclose(file) == 0 && good;
}
