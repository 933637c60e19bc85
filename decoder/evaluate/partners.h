/* OpenBTF: which sampled views are neighbours of one another, shared out among the layers of a sum of lights.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_EVALUATE_PARTNERS_H
#define OPENBTF_EVALUATE_PARTNERS_H

#include <openbtf/material.h>

#pragma GCC visibility push(hidden)

enum {
    BTFI_PARTNERS = 3,          /* of a view, at most */
    BTFI_PARTNER_BITS = 10,     /* of a code for each */
    BTFI_NO_PARTNER = 1023,     /* in a code: there are fewer */
    BTFI_MOST_PARTNERED = 1023, /* views */
};

/* For each view a code of up to three partners, partner k in bits 10 k onwards: every two views that a look-up can give
 * together are partners, one of them of the other, and no two are twice. So few are always enough: the edges of a
 * planar graph can be directed so that at most three leave each vertex (M. Chrobak and D. Eppstein, Planar Orientations
 * with Low Out-degree and Compaction of Adjacency Matrices, 1991). *out_codes [views->count] is freed with free().
 * Errors: BTF_ERROR_UNSUPPORTED (more than BTFI_MOST_PARTNERED views; a triangulation that does not lie in a plane),
 * BTF_ERROR_MEMORY; *out_codes is NULL then. */
btf_result btfi_fold_partners(const btf_directions *views, uint32_t **out_codes);

/* Partner k of a code, or BTFI_NO_PARTNER. */
static inline uint32_t btfi_partner(uint32_t code, uint32_t k) {
    return code >> (BTFI_PARTNER_BITS * k) & BTFI_NO_PARTNER;
}

#pragma GCC visibility pop

#endif
