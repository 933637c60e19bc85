/* Checkpoints. See checkpoint.h.
 *
 * Each step has a file: 8 bytes of magic, the key, the size, the bytes, and a hash of all before it;
 * numbers lie as the machine has them, since no other machine reads them.
 *
 * SPDX-License-Identifier: MIT
 */
#include "checkpoint.h"

#include "decoder/toolkit/output.h"
#include "encoder/base/ranks.h"

#include <dirent.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static const char extension[] = ".btf-step", magic[9] = "BTFSTEP2";
enum { HEADER = 24, HASHED_TEXELS = 256 };

struct enc_checkpoint {
    char *folder;
    uint64_t key;
    bool leads; /* this rank reads and writes the files, and tells the others */
};

/* FNV-1a over 8 bytes at a time, the rest byte by byte. */
static uint64_t hash(uint64_t h, const void *bytes, size_t size) {
    const unsigned char *p = bytes;
    for (; size >= 8; size -= 8, p += 8) {
        uint64_t word;
        memcpy(&word, p, 8);
        h = (h ^ word) * 0x100000001B3u;
        h ^= h >> 29;
    }
    for (; size > 0; size--) {
        h = (h ^ *p++) * 0x100000001B3u;
    }
    return h;
}
static const uint64_t hash_start = 0xCBF29CE484222325u;

/* Finds the key that says whose checkpoint it is: a hash of the options, the sizes, the directions, and the
 * samples of texels spread over the image. */
static btf_result find_key(const enc_context *context, const char *options, const enc_data *data,
                           uint64_t *out_key) {
    const size_t texels = enc_data_texel_count(data), stride = enc_data_texel_stride(data);
    const size_t count = texels < HASHED_TEXELS ? texels : HASHED_TEXELS;
    const int sizes[4] = {data->width, data->height, data->n_views, data->n_lights};
    uint64_t h = hash(hash_start, options, strlen(options));
    h = hash(h, sizes, sizeof sizes);
    for (int v = 0; v < data->n_views; v++) {
        h = hash(h, data->views[v].xyz, sizeof data->views[v].xyz);
    }
    for (int l = 0; l < data->n_lights; l++) {
        h = hash(h, data->lights[l].xyz, sizeof data->lights[l].xyz);
    }
    for (int v = 0; v < data->n_views && data->moved_light; v++) {
        h = hash(h, data->moved_light[v].actual.xyz,
                 data->moved_light[v].index < 0 ? 0 : 3 * sizeof(float));
    }
    float *buffer = malloc(stride * sizeof *buffer);
    btf_result result = buffer ? BTF_OK : BTF_ERROR_MEMORY;
    for (size_t i = 0; i < count && result == BTF_OK; i++) {
        const float *samples;
        result = enc_data_texels(context, data, i * texels / count, 1, buffer, &samples);
        if (result == BTF_OK) {
            h = hash(h, samples, stride * sizeof *samples);
        }
    }
    free(buffer);
    *out_key = h;
    return result;
}

static char *path_of(const char *folder, const char *name) {
    char *path = malloc(strlen(folder) + strlen(name) + sizeof extension + 1);
    if (path) {
        sprintf(path, "%s/%s%s", folder, name, extension);
    }
    return path;
}

static bool is_step(const char *name) {
    const size_t length = strlen(name), end = sizeof extension - 1;
    return length > end && strcmp(name + length - end, extension) == 0;
}

/* Reads the key of a step's file; false when it has none. */
static bool read_key(const char *path, uint64_t *out_key) {
    char begin[8];
    FILE *file = fopen(path, "rb");
    const bool good = file && fread(begin, 8, 1, file) == 1 && memcmp(begin, magic, 8) == 0 &&
                      fread(out_key, 8, 1, file) == 1;
    if (file) {
        fclose(file);
    }
    return good;
}

/* Refuses a folder that holds steps, if the user did not ask to resume or they have another key. */
static btf_result check_folder(const enc_context *context, const enc_checkpoint *c, bool resume) {
    btf_result result = BTF_OK;
    DIR *folder = opendir(c->folder);
    if (!folder) {
        return enc_fail(context, BTF_ERROR_IO, "%s: %s", c->folder, strerror(errno));
    }
    for (const struct dirent *entry; result == BTF_OK && (entry = readdir(folder));) {
        uint64_t key = 0;
        if (!is_step(entry->d_name)) {
            continue;
        }
        char *path = malloc(strlen(c->folder) + strlen(entry->d_name) + 2);
        if (!path) {
            result = BTF_ERROR_MEMORY;
            break;
        }
        sprintf(path, "%s/%s", c->folder, entry->d_name);
        if (!resume) {
            result = enc_fail(context, BTF_ERROR_USAGE,
                              "%s holds a checkpoint: go on from it with --resume, or remove the folder",
                              c->folder);
        } else if (read_key(path, &key) && key != c->key) {
            result = enc_fail(context, BTF_ERROR_USAGE,
                              "%s holds a checkpoint of other data, of other options or of another version "
                              "of btf-encode: remove the folder",
                              c->folder);
        }
        free(path);
    }
    closedir(folder);
    return result;
}

btf_result enc_checkpoint_open(const enc_context *context, const char *folder, const char *options,
                               const enc_data *data, bool resume, enc_checkpoint **out_checkpoint) {
    enc_checkpoint *c = calloc(1, sizeof *c);
    *out_checkpoint = NULL;
    if (!c || !(c->folder = strdup(folder))) {
        free(c);
        return enc_fail(context, BTF_ERROR_MEMORY, "%s: out of memory", folder);
    }
    btf_result result = BTF_OK;
    c->leads = enc_ranks_leads(context);
    if (c->leads) {
        result = find_key(context, options, data, &c->key);
    }
    if (c->leads && result == BTF_OK) {
        result = output_make_folder(folder, context->log, NULL);
    }
    if (c->leads && result == BTF_OK) {
        result = check_folder(context, c, resume);
    }
    result = enc_ranks_agree(context, result);
    if (result != BTF_OK) {
        enc_checkpoint_close(&c, false);
    }
    *out_checkpoint = c;
    return result;
}

static void remove_steps(const enc_checkpoint *c) {
    DIR *folder = opendir(c->folder);
    if (!folder) {
        return;
    }
    for (const struct dirent *entry; (entry = readdir(folder));) {
        if (is_step(entry->d_name)) {
            unlinkat(dirfd(folder), entry->d_name, 0);
        }
    }
    closedir(folder);
    rmdir(c->folder);
}

void enc_checkpoint_close(enc_checkpoint **checkpoint, bool remove_files) {
    if (!checkpoint || !*checkpoint) {
        return;
    }
    if (remove_files && (*checkpoint)->leads) {
        remove_steps(*checkpoint);
    }
    free((*checkpoint)->folder);
    free(*checkpoint);
    *checkpoint = NULL;
}

void enc_blob_clear(enc_blob *blob) {
    free(blob->bytes);
    *blob = (enc_blob){0};
}

void enc_blob_put(enc_blob *blob, const void *piece, size_t size) {
    if (!blob->failed && size > blob->room - blob->size) {
        const size_t room = 2 * (blob->size + size) + 4096;
        unsigned char *bytes = realloc(blob->bytes, room);
        blob->failed = !bytes;
        if (bytes) {
            blob->bytes = bytes;
            blob->room = room;
        }
    }
    if (blob->failed || size == 0) {
        return;
    }
    memcpy(blob->bytes + blob->size, piece, size);
    blob->size += size;
}

void enc_blob_take(enc_blob *blob, void *piece, size_t size) {
    if (size > blob->size - blob->at) {
        blob->failed = true;
    }
    if (size == 0) {
        return;
    }
    if (blob->failed) {
        memset(piece, 0, size);
        return;
    }
    memcpy(piece, blob->bytes + blob->at, size);
    blob->at += size;
}

void enc_blob_take_floats(enc_blob *blob, float *piece, size_t count, float low, float high) {
    enc_blob_take(blob, piece, count * sizeof *piece);
    for (size_t i = 0; i < count && !blob->failed; i++) {
        blob->failed = !(piece[i] >= low && piece[i] <= high);
    }
}

void enc_blob_take_bytes(enc_blob *blob, uint8_t *piece, size_t count, int low, int high) {
    enc_blob_take(blob, piece, count);
    for (size_t i = 0; i < count && !blob->failed; i++) {
        blob->failed = piece[i] < low || piece[i] > high;
    }
}

bool enc_blob_taken(enc_blob *blob) {
    const bool good = !blob->failed && blob->at == blob->size;
    enc_blob_clear(blob);
    return good;
}

/* Reads a whole file of a step. False: there is none, or *out_why says what is wrong with it. */
static bool read_step(const enc_checkpoint *c, const char *path, enc_blob *out, const char **out_why) {
    unsigned char header[HEADER];
    uint64_t key, size, stored;
    struct stat status;
    FILE *file = fopen(path, "rb");
    *out_why = NULL;
    if (!file) {
        return false;
    }
    bool good = fread(header, HEADER, 1, file) == 1 && memcmp(header, magic, 8) == 0;
    memcpy(&key, header + 8, 8);
    memcpy(&size, header + 16, 8);
    good = good && key == c->key && fstat(fileno(file), &status) == 0 &&
           size == (uint64_t)status.st_size - HEADER - 8;
    if (good) {
        out->bytes = malloc(size ? size : 1);
    }
    good = good && out->bytes && (size == 0 || fread(out->bytes, size, 1, file) == 1) &&
           fread(&stored, 8, 1, file) == 1;
    fclose(file);
    good = good && stored == hash(hash(hash_start, header, HEADER), out->bytes, size);
    if (!good) {
        enc_blob_clear(out);
        *out_why = "this step of the checkpoint is damaged and is computed again";
        return false;
    }
    out->size = out->room = size;
    return true;
}

/* Hands the blob that rank 0 found, if any, to all ranks. False where it found none. */
static bool share_blob(const enc_context *context, bool found, enc_blob *blob) {
    uint64_t size = found ? blob->size : UINT64_MAX;
    btf_result result = enc_ranks_broadcast(context, BTF_OK, &size, sizeof size);
    if (result != BTF_OK || size == UINT64_MAX) {
        return false;
    }
    if (!enc_ranks_leads(context)) {
        *blob = (enc_blob){.bytes = malloc(size ? size : 1), .size = size, .room = size};
        if (!blob->bytes) {
            result = enc_fail(context, BTF_ERROR_MEMORY, "checkpoint: out of memory");
        }
    }
    result = enc_ranks_broadcast(context, result, blob->bytes, size);
    if (result != BTF_OK) {
        enc_blob_clear(blob);
    }
    return result == BTF_OK;
}

/* Reads a step from its file; false where there is none, or a damaged one, of which a warning tells. */
static bool find_step(const enc_context *context, const char *name, enc_blob *out_blob) {
    const char *why;
    char *path = path_of(context->checkpoint->folder, name);
    const bool found = path && read_step(context->checkpoint, path, out_blob, &why);
    if (path && !found && why) {
        enc_log(context, BTF_LOG_WARNING, "%s: %s", path, why);
    }
    free(path);
    return found;
}

bool enc_checkpoint_get(const enc_context *context, const char *name, enc_blob *out_blob) {
    *out_blob = (enc_blob){0};
    if (!context->checkpoint) {
        return false;
    }
    const bool found = enc_ranks_leads(context) && find_step(context, name, out_blob);
    return enc_ranks_count(context) > 1 ? share_blob(context, found, out_blob) : found;
}

static btf_result write_step(const enc_context *context, const char *path, const enc_blob *blob) {
    unsigned char header[HEADER];
    const uint64_t size = blob->size;
    output *file = NULL;
    memcpy(header, magic, 8);
    memcpy(header + 8, &context->checkpoint->key, 8);
    memcpy(header + 16, &size, 8);
    const uint64_t sum = hash(hash(hash_start, header, HEADER), blob->bytes, blob->size);
    btf_result result = output_open(path, context->log, &file);
    if (result != BTF_OK) {
        return result;
    }
    FILE *stream = output_stream(file);
    fwrite(header, HEADER, 1, stream);
    if (blob->size > 0) {
        fwrite(blob->bytes, blob->size, 1, stream);
    }
    fwrite(&sum, 8, 1, stream);
    return output_commit(&file);
}

btf_result enc_checkpoint_put(const enc_context *context, const char *name, enc_blob *blob) {
    btf_result result = BTF_OK;
    if (context->checkpoint && enc_ranks_leads(context)) {
        char *path = path_of(context->checkpoint->folder, name);
        result = !path || blob->failed ? enc_fail(context, BTF_ERROR_MEMORY, "checkpoint: out of memory")
                                       : write_step(context, path, blob);
        free(path);
    }
    enc_blob_clear(blob);
    return result;
}
