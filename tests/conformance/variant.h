/* The variants of the decoder: which material, and how it is decoded. Pairwise: every two settings meet
 * somewhere.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_CONFORMANCE_VARIANT_H
#define OPENBTF_CONFORMANCE_VARIANT_H

#include <openbtf/reference.h>
#include "synthetic.h"
#include <openbtf/shader.h>

enum { VARIANT_MAX = 400, VARIANT_NAME = 260 };

typedef struct variant {
    synthetic_spec spec;
    btf_shader_options shader;
    char name[VARIANT_NAME]; /* e.g. "3x5 paper sqrt rgb half J2 shadow,shift K9 k6 linear bilinear" */
} variant;

/* Fills list with variants in which every pair of settings occurs, in an order that a seed gives, those of
 * version 1 first, then those of version 2 with all their mixtures of classes, then packed points, then relief and
 * gloss; returns how many. */
size_t variant_pairwise(uint64_t seed, variant list[VARIANT_MAX]);

/* "texel", "bilinear" or "steep". */
const char *variant_filter_name(btf_filter filter);

/* The reference's options for a shader's. */
btf_ref_options variant_reference_options(const btf_shader_options *shader);

#endif
