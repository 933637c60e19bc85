/* Counts of fetches, bytes and operations. See decode_cost.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "decode_cost.h"

#include <openbtf/cost.h>

static void fetch(decode_cost *cost, double count, double bytes) {
    cost->fetches += count;
    cost->bytes += count * bytes;
}

/* A step of a march takes 13 operations (shaders/relief.glsl): 4 move, 2 wrap, 3 make a height of its code, the others
 * compare and count down. */
decode_cost decode_cost_of(const btf_material_info *info, const btf_shader_options *shader) {
    enum { STEP = 13 };
    btf_shader_options options = *shader;
    options.struct_size = sizeof options;
    const btf_decode_counts n = btf_count_decode(info, &options);
    return (decode_cost){.fetches = n.fetches + n.steps,
                         .bytes = n.bytes + n.steps,
                         .integers = n.integers + STEP * n.steps,
                         .floats = n.floats};
}

decode_cost decode_cost_pca(int rank) {
    const double groups = (rank + 3) / 4;
    decode_cost cost = {0};
    fetch(&cost, groups * 28, 4);
    fetch(&cost, groups, 16);
    /* U: converted, scaled; each texel of V: converted, weighted, added; three dot products, added. */
    cost.floats = groups * (8 + 27 * 12 + 3 * 8);
    return cost;
}

decode_cost decode_cost_lookup(void) {
    decode_cost cost = {0};
    fetch(&cost, 9, 4);
    cost.floats = 9 * 6;
    return cost;
}

decode_cost decode_cost_phong(void) {
    decode_cost cost = {0};
    fetch(&cost, 2, 4);
    /* The normal unpacked and normalised 12, two dot products 10, reflection 9, power 3, colour 8. */
    cost.floats = 42;
    return cost;
}
