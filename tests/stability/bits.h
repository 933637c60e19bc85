/* Materials whose parameters are chosen bit patterns.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TESTS_STABILITY_BITS_H
#define OPENBTF_TESTS_STABILITY_BITS_H

#include "tests/conformance/random.h"
#include "tests/conformance/synthetic.h"
#include <stdbool.h>

/* One class of bit patterns of a float parameter. */
typedef struct bit_class {
    const char *name;
    uint32_t bits;
    int legal; /* FORMAT.md section 2: 0, or of magnitude 2^-24 .. 2^24 */
} bit_class;

extern const bit_class bit_classes[];
extern const size_t bit_class_count;

/* A copy of a material that may be changed before it is made: desc points into its own textures. */
typedef struct bits_desc {
    btf_material_desc desc;
    void *texture[BTF_TEXTURE_COUNT];
} bits_desc;

/* From a synthetic material; exits on failure. */
void bits_begin(const synthetic_spec *spec, bits_desc *out);
void bits_end(bits_desc *d);

/* Every parameter, scale and factor of a view of the material becomes a random legal one of bit_classes
 * (halves: 2^-14, 65504, 1, their neighbours and 0). */
void bits_fill(random_state *r, bits_desc *d);

/* Decodes `count` random and extreme arguments by every combination of options; false when a value is NaN, infinite or
 * negative, or when a second run gives other bits. */
bool bits_decode(const btf_material *material, uint64_t seed, int count);

/* Kinds of material that together have every effect, layout, domain, store of the residual, blend and kind of
 * parameter. From BITS_FACTORS on the residual is stored as factors of all classes, with codes at their bounds. */
enum { BITS_FACTORS = 8, BITS_SPECS = 12 };
synthetic_spec bits_spec(int index);

#endif
