/* The two decoders of the CPU, the reference and the evaluator.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TESTS_BENCH_DECODE_CPU_H
#define OPENBTF_TESTS_BENCH_DECODE_CPU_H

#include "decoding.h"

/* Rows of both decoders, in both interpolations of directions and of texels. Errors: BTF_ERROR_MEMORY, those of
 * btf_evaluator_create and of decoding_estimate_material. */
btf_result decode_cpu_run(decoding *d, const decode_material *m);

#endif
