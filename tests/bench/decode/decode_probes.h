/* Samples of the data, drawn at random, at which decoders are compared with the truth.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TESTS_BENCH_DECODE_PROBES_H
#define OPENBTF_TESTS_BENCH_DECODE_PROBES_H

#include "decode_rig.h"
#include "encoder/data/data.h"
#include "tests/bench/codecs/truth.h"

enum { DECODE_PROBES = RIG_PIXELS };

/* Samples as inputs of a shader, and the expected outputs. */
typedef struct decode_probes {
    uint32_t *inputs; /* [DECODE_PROBES][GPU_INPUTS]; NULL: none */
    float *truth;     /* [DECODE_PROBES][3] */
} decode_probes;

/* Samples of the data, evenly over texels, at random views and lights. Errors: those of the data,
 * BTF_ERROR_MEMORY. */
btf_result decode_probes_create(const enc_context *context, const enc_data *data, decode_probes *p);
/* Probes of truth between the samples. Errors: BTF_ERROR_MEMORY. */
btf_result decode_probes_between(const enc_context *context, const bench_truth *truth, decode_probes *p);
void decode_probes_clear(decode_probes *p);

/* PSNR of decoded[i * pitch .. + 2] against the truth, linear and sRGB-coded, clipped to [0, 1]. */
void decode_probes_compare(const decode_probes *p, const float *decoded, size_t pitch, double *out_linear,
                           double *out_srgb);

#endif
