/* Bonn's binary .btf files: the checked contents of one, and where its matrices lie.
 *
 * All numbers are little-endian. An ABRDF is all samples of a texel; light runs faster than view, x faster
 * than y. Kinds, with channel c, light l, view v, texel xy = y * width + x:
 *
 *   DFMF  "!DFMF08FCR": one factorisation a channel, decorrelated by a colour model
 *   FMF   "!FMF12FCER", "!FMF06FCR", "!FMF06FC": one factorisation of everything
 *   PVF   "!PVF06FCR", "!PVF06FC": a mean and a factorisation a view
 *   BDI   "!BDIF06R2!": all samples as halfs, in chunks of scan lines, whole, bzipped or sparse
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_BONN_FILE_H
#define OPENBTF_ENCODER_BONN_FILE_H

#include "encoder/base/context.h"
#include <stdint.h>

typedef enum enc_bonn_kind { ENC_BONN_DFMF, ENC_BONN_FMF, ENC_BONN_PVF, ENC_BONN_BDI } enc_bonn_kind;

/* value(r, t) = mean + sum over k of directions[r][k] * texels[t][k]; both row-major, at these offsets of
 * the file. Rows of one side are numbered by direction, of the other by texel; the channel, where a row is
 * one channel's alone, runs fastest. */
typedef struct enc_bonn_matrix {
    unsigned scalar;             /* bytes of a number: 2 (half), 4 or 8 */
    uint32_t components;         /* numbers a row */
    uint64_t directions, texels; /* offsets */
    uint64_t mean;               /* offset of one number a row of the left side, 0: none */
    bool channel_of_texel;       /* rows of the texel side are numbered by texel and channel */
    bool mean_of_texel;          /* the means are numbered as rows of the texel side, else as those of the
                                    direction side */
} enc_bonn_matrix;

enum { ENC_BONN_RAW = 0, ENC_BONN_BZIP = 1, ENC_BONN_SPARSE = 2 };

typedef struct enc_bonn_chunk {
    uint64_t offset; /* of its data */
    uint32_t size;   /* bytes, as they lie in the file */
} enc_bonn_chunk;

typedef struct enc_bonn_file {
    char *path;
    const unsigned char *bytes; /* the whole file, mapped */
    uint64_t size;

    enc_bonn_kind kind;
    char signature[12];
    bool cosine; /* samples hold the cosine of the light's angle already */
    uint32_t n_views, n_lights;
    float (*views)[2], (*lights)[2]; /* theta, phi in radians, in the file's order */
    uint32_t width, height;

    int32_t model; /* colour model; 0 for all kinds but DFMF */
    float mean[3], matrix[9];
    bool logarithm; /* FMF: numbers are log(sample + 1e-5) */

    uint32_t n_matrices; /* 3 of DFMF (R, G, B side by side), 1 of FMF, n_views of PVF */
    enc_bonn_matrix *matrices;

    unsigned compression; /* BDI */
    uint32_t lines_per_chunk, n_chunks;
    enc_bonn_chunk *chunks;
    uint32_t *stored; /* BDI: number of a texel's ABRDF among those stored; UINT32_MAX: missing */
    uint32_t n_missing;
} enc_bonn_file;

/* Whether a file begins like one of Bonn's. */
bool enc_bonn_is(const char *path);

/* Maps and checks a file: every size against its length, every count against every other. Numbers of
 * matrices are checked when they are decoded. Errors, with field, place and value: BTF_ERROR_IO,
 * BTF_ERROR_BAD_FILE, BTF_ERROR_UNSUPPORTED (spectral channels, colour models that are none of RGB's,
 * versions), BTF_ERROR_MEMORY. */
btf_result enc_bonn_open(const enc_context *context, const char *path, enc_bonn_file **out_file);
void enc_bonn_close(enc_bonn_file **file);

/* Reads `count` numbers of `scalar` bytes each, the first of them at `offset` in the file. */
void enc_bonn_numbers(const enc_bonn_file *file, uint64_t offset, unsigned scalar, size_t count,
                      float *out);

#endif
