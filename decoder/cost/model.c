/* OpenBTF: prices of counts, and those that are built in. See openbtf/cost.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include <openbtf/cost.h>

#include <math.h>

static const btf_cost_model llvmpipe = {
    .struct_size = sizeof llvmpipe,
    .device = "llvmpipe",
    .pixel = 8.3,
    .look_up = 10.7,
    .point = 1.5,
    .move = 5,
    .step = 1,
    .fetch = 1,
    .byte = 0.07,
    .integer = 0.025,
    .real = 0.025,
    .masked = 0.01,
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
