/* A whole encode in memory: method, file, reference decoder.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TESTS_STABILITY_ENCODE_H
#define OPENBTF_TESTS_STABILITY_ENCODE_H

#include "hard_data.h"

#include "encoder/job/settings.h"

/* The last is the paper's method without the effects that optical flow finds. */
typedef enum encode_method {
    ENCODE_PAPER,
    ENCODE_PAPER_RGB,
    ENCODE_JOINT,
    ENCODE_PAPER_SHADOW
} encode_method;
enum { ENCODE_METHODS = 3 };
extern const char *const encode_names[ENCODE_METHODS + 1];

/* The outcome of an encode. */
typedef struct encoded {
    btf_result result; /* BTF_OK, or what failed */
    void *file;        /* the bytes of the *.btf.exr */
    size_t size;
    float *decoded; /* in the order of the data's samples, by the reference decoder at the sampled
                       directions */
    bool finite;    /* every decoded value is, and >= 0 */
    double played;  /* largest relative difference between enc_sample_decoder and `decoded`; relative to the
                       value, at least to 1e-3 and to 1e-5 of the largest value */
} encoded;

/* Options of the methods for small and quick encodes. `brighter` scales the thresholds that are absolute (1:
 * defaults). */
enc_paper_options encode_paper_options(encode_method method, float brighter);
enc_factors_settings encode_joint_settings(const enc_data *data, enc_preset preset);

/* Encodes, saves, opens again and decodes. The paper's methods run with their fallback, as in btf-encode. */
encoded encode(const enc_data *data, encode_method method, int threads, float brighter);
void encode_clear(encoded *e);

/* Analyses `data` and decodes the solution without a file, so that directions may be in any order. Returns the PSNR
 * against `truth` (of the same shape), clipped to [0, peak]. The joint method runs at the preset medium, the others at
 * fast. Exits on failure. */
double encode_played_psnr(const enc_data *data, const enc_data *truth, encode_method method, float brighter,
                          float peak);

/* PSNR of decoded values against the data, both clipped to [0, peak]. */
double encode_psnr(const enc_data *data, const float *decoded, float peak);

/* The PSNR of a method's fallback: for each texel the diffuse term that best fits all of its samples in the domain of
 * the method, by least squares in linear radiance or its square root; no lobe, no shadow, no shift, no cluster. Albedos
 * are 0 or 2^-24 to 2^24, as in a file. For the joint method, which clips samples to 2^24, samples are clipped too. */
double encode_psnr_of_diffuse(const enc_data *data, encode_method method, float peak);

/* Whether a PSNR is as good as promised. The paper's methods: at least the lesser of the fallback's and of 80 dB, which
 * counts as exact, less 0.01 dB. The joint method: at least the lesser of the fallback's and of 47 dB, less 0.1 dB,
 * since its codes end at 55 dB in the square root, whose errors count twice in radiance near 1. */
bool encode_keeps_promise(encode_method method, double psnr, double psnr_of_diffuse);
extern const char encode_promise[];

/* The same of a texture whose every texel is the mean of all, taken in square roots. */
double encode_psnr_of_mean(const enc_data *data, float peak);

#endif
