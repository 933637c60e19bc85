/* OpenBTF: prices of counts, and those that are built in. See openbtf/cost.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include <openbtf/cost.h>

#include <math.h>

/* Fitted by `btf-bench --only costs` to synthetic materials (tests/bench/plan/costs_section.c); decoder/README.md says on which
 * machine, and how well they predict. */
static const btf_cost_model llvmpipe = {
    .struct_size = sizeof llvmpipe,
    .device = "llvmpipe",
    .pixel = 8.6,
    .look_up = 39.6,
    .point = 0.3,
    .move = 11.8,
    .step = 1,
    .fetch = 1.5,
    .byte = 0.061,
    .integer = 0.0222,
    .real = 0.0448,
    .masked = 0.0181,
};

const btf_cost_model *btf_cost_model_builtin(void) {
    return &llvmpipe;
}

double btf_cost_of(const btf_decode_counts *counts, const btf_cost_model *model) {
    const btf_cost_model *prices = model ? model : &llvmpipe;
    double sum = 0;
#define ADD(price, name, count) sum += prices->price * counts->count;
    BTF_COST_LIST(ADD)
#undef ADD
    return fmax(sum, 1e-6);
}
