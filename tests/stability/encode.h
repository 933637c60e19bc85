/* A whole encode in memory: method, file, reference decoder.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TESTS_STABILITY_ENCODE_H
#define OPENBTF_TESTS_STABILITY_ENCODE_H

#include "hard_data.h"

#include "encoder/job/settings.h"

/* The last is the paper's method without what flow finds. */
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
    double played;  /* largest difference between enc_sample_decoder and `decoded`, relative, but to no less
                       than  1e-3  and 1e-5 of the largest */
} encoded;

/* Options of the methods: small and quick. `brighter` scales what thresholds are absolute (1:
 * defaults). */
enc_paper_options encode_paper_options(encode_method method, float brighter);
enc_factors_settings encode_joint_settings(const enc_data *data, enc_preset preset);

/* Encodes, saves, opens again and decodes. The paper's methods with their fallback, as btf-encode runs
 * them. */
encoded encode(const enc_data *data, encode_method method, int threads, float brighter);
void encode_clear(encoded *e);

/* Analyses `data` and plays the solution back: PSNR against `truth` (of the same shape), clipped to [0,
 * peak]. No file, so that directions may come in any order. The joint method runs at the preset medium, else at fast.
 * Exits on failure. */
double encode_played_psnr(const enc_data *data, const enc_data *truth, encode_method method, float brighter,
                          float peak);

/* PSNR of decoded values against the data, both clipped to [0, peak]. */
double encode_psnr(const enc_data *data, const float *decoded, float peak);

/* The same of the fallback of a method: of each texel the diffuse term alone that fits all of its samples
 * best in the domain of the method, least squares in linear radiance or in its square root; no lobe, no
 * shadow, no shift, no cluster. As a file holds them, albedos are 0 or 2^-24 to 2^24, and of the joint
 * method, which clips to 2^24, so are the samples. */
double encode_psnr_of_diffuse(const enc_data *data, encode_method method, float peak);

/* Whether that is at least what is promised: no worse than the fallback, less 0.01 dB, or than 80 dB, which
 * the paper's methods take for exact; of the joint method, whose codes end at 55 dB of the root, which
 * counts twice at 1, less 0.1 dB, or than 47 dB. */
bool encode_keeps_promise(encode_method method, double psnr, double psnr_of_diffuse);
extern const char encode_promise[];

/* The same of a texture whose every texel is the mean of all, taken in square roots. */
double encode_psnr_of_mean(const enc_data *data, float peak);

#endif
