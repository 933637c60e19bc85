/* Opening and checking Bonn's binary .btf files. See file.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "file.h"

#include "fields.h"

#include <openbtf/reference.h>

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

enum { MOST_DIRECTIONS = 256, MOST_SIDE = 16384, MOST_COMPONENTS = 65536, LEGACY_PVF = 301074 };

static const struct {
    const char *text;
    enc_bonn_kind kind;
    bool rotations, versioned;
} signatures[] = {
    /* the longest first: some begin alike */
    {"!DFMF08FCR", ENC_BONN_DFMF, true, false}, {"!FMF12FCER", ENC_BONN_FMF, true, true},
    {"!BDIF06R2!", ENC_BONN_BDI, true, false},  {"!FMF06FCR", ENC_BONN_FMF, true, false},
    {"!PVF06FCR", ENC_BONN_PVF, true, false},   {"!FMF06FC", ENC_BONN_FMF, false, false},
    {"!PVF06FC", ENC_BONN_PVF, false, false},
};
enum { SIGNATURES = sizeof signatures / sizeof signatures[0] };

static int find_signature(const void *bytes, size_t size) {
    for (int i = 0; i < SIGNATURES; i++) {
        const size_t length = strlen(signatures[i].text);
        if (size >= length && memcmp(bytes, signatures[i].text, length) == 0) {
            return i;
        }
    }
    return -1;
}

bool enc_bonn_is(const char *path) {
    char begin[10];
    struct stat status;
    if (stat(path, &status) != 0 || !S_ISREG(status.st_mode)) {
        return false;
    }
    const int fd = open(path, O_RDONLY | O_CLOEXEC);
    const ssize_t n = fd >= 0 ? read(fd, begin, sizeof begin) : -1;
    if (fd >= 0) {
        close(fd);
    }
    return n > 0 && find_signature(begin, (size_t)n) >= 0;
}

static void read_meta(enc_bonn_cursor *c, enc_bonn_file *f) {
    const uint64_t begin = c->at;
    const uint32_t size = enc_bonn_take_u32(c, "metaSize"), version = enc_bonn_take_u32(c, "metaVersion");
    if (c->result == BTF_OK && (version < 1 || version > 4)) {
        enc_bonn_refuse(c, BTF_ERROR_UNSUPPORTED, c->at - 4, "metaVersion", "must be 1 to 4, not", version);
    }
    enc_bonn_take(c, 240, "measurement setup, image sensor and light source");
    enc_bonn_take(c, 16, "pixels per mm and RGB scale factor");
    if (version >= 2) {
        f->cosine = enc_bonn_take_u32(c, "cosine flag") != 0;
    }
    if (version >= 3) {
        enc_bonn_take(c, enc_bonn_take_u32(c, "size of the measurement XML"), "measurement XML");
    }
    if (version >= 4) {
        const uint32_t channels = enc_bonn_take_u32(c, "channel count");
        if (channels != 3) {
            enc_bonn_refuse(c, BTF_ERROR_UNSUPPORTED, c->at - 4, "channel count",
                            "must be 3 (R, G and B), not", channels);
        }
        for (uint32_t i = 0; i < 3 && c->result == BTF_OK; i++) {
            enc_bonn_take(c, enc_bonn_take_u32(c, "length of a channel name"), "channel name");
        }
    }
    if (c->result == BTF_OK && c->at - begin != size) {
        enc_bonn_refuse(c, BTF_ERROR_BAD_FILE, begin, "metaSize",
                        "does not agree with the length of the block that follows:", size);
    }
}

static void read_direction(enc_bonn_cursor *c, float direction[2], const char *theta, const char *phi) {
    direction[0] = enc_bonn_take_float(c, theta);
    direction[1] = enc_bonn_take_float(c, phi);
}

static void read_directions(enc_bonn_cursor *c, enc_bonn_file *f) {
    f->n_views = enc_bonn_take_count(c, "view count", MOST_DIRECTIONS);
    f->views = calloc(f->n_views, sizeof *f->views);
    if (!f->views) {
        c->result = BTF_ERROR_MEMORY;
    }
    for (uint32_t v = 0; v < f->n_views && c->result == BTF_OK; v++) {
        read_direction(c, f->views[v], "theta of a view", "phi of a view");
        const uint32_t lights = enc_bonn_take_count(c, "light count of a view", MOST_DIRECTIONS);
        if (c->result == BTF_OK && v > 0 && lights != f->n_lights) {
            enc_bonn_refuse(c, BTF_ERROR_UNSUPPORTED, c->at - 4, "light count of a view",
                            "differs from the first view's:", lights);
        }
        if (v == 0) {
            f->n_lights = lights;
            f->lights = calloc(lights, sizeof *f->lights);
            if (!f->lights) {
                c->result = BTF_ERROR_MEMORY;
            }
        }
        for (uint32_t l = 0; l < lights && c->result == BTF_OK; l++) {
            float light[2];
            read_direction(c, light, "theta of a light", "phi of a light");
            if (v == 0) {
                memcpy(f->lights[l], light, sizeof light);
            } else if (c->result == BTF_OK && memcmp(f->lights[l], light, sizeof light) != 0) {
                enc_bonn_refuse(c, BTF_ERROR_UNSUPPORTED, c->at - 8, "light of a view",
                                "differs from the first view's:", light[0]);
            }
        }
    }
}

static void read_size(enc_bonn_cursor *c, enc_bonn_file *f) {
    f->width = enc_bonn_take_count(c, "width", MOST_SIDE);
    f->height = enc_bonn_take_count(c, "height", MOST_SIDE);
}

/* Steps over the texels' own frames, since the surface is a plane here. */
static void read_rotations(enc_bonn_cursor *c) {
    const uint32_t count = enc_bonn_take_u32(c, "rotation count");
    enc_bonn_take(c, 36 * (uint64_t)count, "rotations");
}

/* Steps over `rows` rows of `components` numbers; returns where they begin. */
static uint64_t take_rows(enc_bonn_cursor *c, uint64_t rows, const enc_bonn_matrix *m, const char *field) {
    const uint64_t at = c->at;
    enc_bonn_take(c, rows * m->components * m->scalar, field);
    return at;
}

/* Settles which factor of a matrix of `rows` by `columns`, left or right, has the rows for directions and
 * which those for texels. */
static void settle_sides(enc_bonn_cursor *c, uint64_t at, enc_bonn_matrix *m, uint32_t rows,
                         uint32_t columns, uint64_t directions, uint64_t texels, uint32_t channels,
                         uint64_t left, uint64_t right) {
    if (rows == channels * directions && columns == texels) {
        m->directions = left;
        m->texels = right;
    } else if (rows == channels * texels && columns == directions) {
        m->directions = right;
        m->texels = left;
        m->channel_of_texel = channels > 1;
        m->mean_of_texel = true;
    } else {
        enc_bonn_refuse(c, BTF_ERROR_BAD_FILE, at, "rows and columns",
                        "match neither directions nor texels; rows:", rows);
    }
}

/* Reads one factorisation of a DFMF or FMF file, from its scalar size to its end. */
static void read_factors(enc_bonn_cursor *c, const enc_bonn_file *f, uint32_t channels,
                         enc_bonn_matrix *m) {
    m->scalar = enc_bonn_take_scalar(c);
    m->components = enc_bonn_take_count(c, "component count", MOST_COMPONENTS);
    const uint64_t at = c->at;
    const uint32_t rows = enc_bonn_take_u32(c, "rows"), columns = enc_bonn_take_u32(c, "columns");
    enc_bonn_take(c, (uint64_t)m->components * m->scalar, "singular values");
    const uint64_t left = take_rows(c, rows, m, "left factor"),
                   right = take_rows(c, columns, m, "right factor");
    if (c->result == BTF_OK) {
        settle_sides(c, at, m, rows, columns, (uint64_t)f->n_views * f->n_lights,
                     (uint64_t)f->width * f->height, channels, left, right);
    }
}

static bool allocate_matrices(enc_bonn_cursor *c, enc_bonn_file *f, uint32_t count) {
    f->n_matrices = count;
    f->matrices = c->result == BTF_OK ? calloc(count, sizeof *f->matrices) : NULL;
    if (c->result == BTF_OK && !f->matrices) {
        c->result = BTF_ERROR_MEMORY;
    }
    return c->result == BTF_OK;
}

static void read_dfmf(enc_bonn_cursor *c, enc_bonn_file *f) {
    enc_bonn_take_u32(c, "maximal component count");
    f->model = (int32_t)enc_bonn_take_u32(c, "colour model");
    switch (f->model) {
    case 0:
    case 1:
    case 2:
    case 3:
    case 4:
    case 9:
    case 10:
    case 11:
    case 12:
        break;
    default:
        enc_bonn_refuse(c, BTF_ERROR_UNSUPPORTED, c->at - 4, "colour model",
                        "is not one that this program reads:", f->model);
    }
    for (int i = 0; i < 3; i++) {
        f->mean[i] = enc_bonn_take_float(c, "colour mean");
    }
    for (int i = 0; i < 9; i++) {
        f->matrix[i] = enc_bonn_take_float(c, "colour matrix");
    }
    if (!allocate_matrices(c, f, 3)) {
        return;
    }
    for (int i = 0; i < 3 && c->result == BTF_OK; i++) {
        read_factors(c, f, 1, &f->matrices[i]);
    }
}

static void read_fmf(enc_bonn_cursor *c, enc_bonn_file *f, bool versioned) {
    const unsigned version = versioned ? enc_bonn_take_u8(c, "header version") : 0;
    if (version > 2) {
        enc_bonn_refuse(c, BTF_ERROR_UNSUPPORTED, c->at - 1, "header version", "must be 0 to 2, not",
                        version);
    }
    if (version >= 1) {
        f->logarithm = enc_bonn_take_u32(c, "dynamic range reduction") != 0;
    }
    if (version >= 2) {
        const uint64_t rows = enc_bonn_take_u32(c, "height map rows"),
                       columns = enc_bonn_take_u32(c, "height map columns");
        if (rows > MOST_SIDE || columns > MOST_SIDE) {
            enc_bonn_refuse(c, BTF_ERROR_BAD_FILE, c->at - 8, "height map size",
                            "exceeds what this program reads:", (double)(rows > columns ? rows : columns));
        }
        enc_bonn_take(c, 2 * rows * columns, "height map");
    }
    enc_bonn_take_u32(c, "component count");
    if (allocate_matrices(c, f, 1)) {
        read_factors(c, f, 3, f->matrices);
    }
}

static void check_slots(enc_bonn_cursor *c, const enc_bonn_file *f, uint64_t at, uint32_t slots) {
    if (c->result == BTF_OK && slots != f->n_views) {
        enc_bonn_refuse(c, BTF_ERROR_BAD_FILE, at, "slot count", "differs from the view count:", slots);
    }
}

static void read_pvf(enc_bonn_cursor *c, enc_bonn_file *f, bool legacy) {
    if (!legacy) {
        enc_bonn_take_u32(c, "component count");
        const uint32_t slots = enc_bonn_take_u32(c, "slot count");
        check_slots(c, f, c->at - 4, slots);
    }
    if (!allocate_matrices(c, f, f->n_views)) {
        return;
    }
    for (uint32_t v = 0; v < f->n_views && c->result == BTF_OK; v++) {
        enc_bonn_matrix *m = &f->matrices[v];
        m->scalar = enc_bonn_take_scalar(c);
        m->components = enc_bonn_take_count(c, "component count", MOST_COMPONENTS);
        const uint64_t at = c->at;
        const uint32_t weights = enc_bonn_take_u32(c, "weight count"),
                       dimension = enc_bonn_take_u32(c, "dimension");
        enc_bonn_take(c, (uint64_t)m->components * m->scalar, "eigenvalues");
        m->mean = c->at;
        enc_bonn_take(c, (uint64_t)dimension * m->scalar, "means");
        const uint64_t left = take_rows(c, dimension, m, "components"),
                       right = take_rows(c, weights, m, "weights");
        if (c->result == BTF_OK) {
            settle_sides(c, at, m, dimension, weights, f->n_lights, (uint64_t)f->width * f->height, 3, left,
                         right);
        }
    }
}

/* Lists the ABRDFs that the file holds, in the order of their storage. */
static void read_mask(enc_bonn_cursor *c, enc_bonn_file *f) {
    const size_t texels = (size_t)f->width * f->height;
    const unsigned char *mask = enc_bonn_take(c, texels, "mask");
    f->stored = mask ? malloc(texels * sizeof *f->stored) : NULL;
    if (mask && !f->stored) {
        c->result = BTF_ERROR_MEMORY;
    }
    uint32_t count = 0;
    for (size_t i = 0; i < texels && c->result == BTF_OK; i++) {
        const bool there = f->compression != ENC_BONN_SPARSE || mask[i] != 0;
        f->stored[i] = there ? count++ : UINT32_MAX;
    }
    f->n_missing = (uint32_t)texels - count;
}

static void read_chunks(enc_bonn_cursor *c, enc_bonn_file *f) {
    const uint64_t per_chunk = (uint64_t)f->width * f->lines_per_chunk;
    const uint64_t abrdf = 6 * (uint64_t)f->n_views * f->n_lights;
    const uint64_t stored = (uint64_t)f->width * f->height - f->n_missing;
    f->n_chunks = (uint32_t)((stored + per_chunk - 1) / per_chunk);
    f->chunks = calloc(f->n_chunks ? f->n_chunks : 1, sizeof *f->chunks);
    if (!f->chunks) {
        c->result = BTF_ERROR_MEMORY;
    }
    for (uint32_t i = 0; i < f->n_chunks && c->result == BTF_OK; i++) {
        const uint64_t left = stored - i * per_chunk, whole = (left < per_chunk ? left : per_chunk) * abrdf;
        f->chunks[i].size = enc_bonn_take_u32(c, "chunk size");
        f->chunks[i].offset = c->at;
        if (c->result == BTF_OK && f->compression != ENC_BONN_BZIP && f->chunks[i].size < whole) {
            enc_bonn_refuse(c, BTF_ERROR_BAD_FILE, c->at - 4, "chunk size",
                            "is too small for the chunk's samples:", f->chunks[i].size);
        }
        enc_bonn_take(c, f->chunks[i].size, "chunk");
    }
}

static void read_bdi(enc_bonn_cursor *c, enc_bonn_file *f) {
    f->lines_per_chunk = enc_bonn_take_count(c, "scan lines per chunk", MOST_SIDE);
    f->compression = enc_bonn_take_u8(c, "compression");
    if (f->compression > ENC_BONN_SPARSE) {
        enc_bonn_refuse(c, BTF_ERROR_UNSUPPORTED, c->at - 1, "compression", "must be 0, 1 or 2, not",
                        f->compression);
    }
    if (c->result == BTF_OK) {
        read_mask(c, f);
    }
    read_rotations(c);
    if (c->result == BTF_OK) {
        read_chunks(c, f);
    }
}

/* Reads the header of the first form of PVF, which has no meta block. False: this is another form. */
static bool read_legacy_pvf(enc_bonn_cursor *c, enc_bonn_file *f) {
    if (f->kind != ENC_BONN_PVF || f->size - c->at < 4 || enc_bonn_u32(f->bytes + c->at) != LEGACY_PVF) {
        return false;
    }
    enc_bonn_take(c, 4, "magic number");
    enc_bonn_take_u32(c, "component count");
    read_size(c, f);
    const uint64_t slots = c->at;
    enc_bonn_take_u32(c, "slot count");
    read_directions(c, f);
    if (c->result == BTF_OK && enc_bonn_u32(f->bytes + slots) != f->n_views) {
        enc_bonn_refuse(c, BTF_ERROR_BAD_FILE, slots, "slot count",
                        "differs from the view count:", enc_bonn_u32(f->bytes + slots));
    }
    return true;
}

static btf_result parse(const enc_context *context, enc_bonn_file *f) {
    enc_bonn_cursor c = {.context = context, .path = f->path, .bytes = f->bytes, .size = f->size};
    const int i = find_signature(f->bytes, (size_t)f->size);
    if (i < 0) {
        return enc_fail(context, BTF_ERROR_BAD_FILE, "%s: not a Bonn .btf file: it has no signature of one",
                        f->path);
    }
    strcpy(f->signature, signatures[i].text);
    f->kind = signatures[i].kind;
    c.at = strlen(f->signature);
    const bool legacy = read_legacy_pvf(&c, f);
    if (!legacy) {
        read_meta(&c, f);
        read_directions(&c, f);
        read_size(&c, f);
        if (f->kind == ENC_BONN_BDI) {
            read_bdi(&c, f);
        } else if (signatures[i].rotations) {
            read_rotations(&c);
        }
    }
    if (f->kind == ENC_BONN_DFMF) {
        read_dfmf(&c, f);
    } else if (f->kind == ENC_BONN_FMF) {
        read_fmf(&c, f, signatures[i].versioned);
    } else if (f->kind == ENC_BONN_PVF) {
        read_pvf(&c, f, legacy);
    }
    if (c.result == BTF_OK && c.at != f->size) {
        enc_bonn_refuse(&c, BTF_ERROR_BAD_FILE, c.at, "end of file",
                        "the file goes on; further bytes:", (double)(f->size - c.at));
    }
    return c.result;
}

static btf_result map_file(const enc_context *context, const char *path, enc_bonn_file *f) {
    struct stat status;
    const int fd = open(path, O_RDONLY | O_CLOEXEC);
    if (fd < 0 || fstat(fd, &status) != 0) {
        const int error = errno;
        if (fd >= 0) {
            close(fd);
        }
        return enc_fail(context, BTF_ERROR_IO, "%s: %s", path, strerror(error));
    }
    f->size = (uint64_t)status.st_size;
    void *bytes = f->size > 0 ? mmap(NULL, (size_t)f->size, PROT_READ, MAP_PRIVATE, fd, 0) : MAP_FAILED;
    const int error = f->size > 0 ? errno : EINVAL;
    close(fd);
    if (bytes == MAP_FAILED) {
        return enc_fail(context, BTF_ERROR_IO, "%s: cannot be mapped: %s", path, strerror(error));
    }
    f->bytes = bytes;
    return BTF_OK;
}

btf_result enc_bonn_open(const enc_context *context, const char *path, enc_bonn_file **out_file) {
    enc_bonn_file *f = calloc(1, sizeof *f);
    *out_file = NULL;
    if (f) {
        f->path = strdup(path);
    }
    btf_result result = f && f->path ? map_file(context, path, f) : BTF_ERROR_MEMORY;
    if (result == BTF_OK) {
        result = parse(context, f);
    }
    if (result == BTF_ERROR_MEMORY) {
        enc_log(context, BTF_LOG_ERROR, "%s: out of memory for its tables", path);
    }
    if (result != BTF_OK) {
        enc_bonn_close(&f);
    }
    *out_file = f;
    return result;
}

void enc_bonn_close(enc_bonn_file **file) {
    if (!file || !*file) {
        return;
    }
    enc_bonn_file *f = *file;
    if (f->bytes) {
        munmap((void *)f->bytes, (size_t)f->size);
    }
    free(f->views);
    free(f->lights);
    free(f->matrices);
    free(f->chunks);
    free(f->stored);
    free(f->path);
    free(f);
    *file = NULL;
}

void enc_bonn_numbers(const enc_bonn_file *file, uint64_t offset, unsigned scalar, size_t count,
                      float *out) {
    const unsigned char *at = file->bytes + offset;
    if (scalar == 2) {
        for (size_t i = 0; i < count; i++) {
            out[i] = btf_ref_half((uint16_t)(at[2 * i] | at[2 * i + 1] << 8));
        }
    } else {
        for (size_t i = 0; i < count; i++) {
            out[i] = enc_bonn_number(at + i * scalar, scalar);
        }
    }
}
