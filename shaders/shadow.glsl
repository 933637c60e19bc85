/* OpenBTF shaders: the shadow maps, interpolated between lights (FORMAT.md sections 3 and 9).
 *
 * SPDX-License-Identifier: MIT
 */
#if BTF_SHADOW

uint btf_shadow_code(uvec2 x, uint light, int level) {
#if BTF_LAYOUT_TIGHT
    return texelFetch(btf_shadow, ivec3(x, light), level).x;
#else
    return texelFetch(btf_maps, ivec2(btf_tile(light, x)), 0).x;
#endif
}

/* The factor of the first n neighbouring lights (1 or 3). */
float btf_shadow_factor(uvec2 x, btf_neighbours lights, int n, int level) {
    uint t = 0u;
    for (int b = 0; b < n; ++b)
        t += lights.weight[b] * btf_shadow_code(x, lights.index[b], level);
    return btf_mul(float(t), BTF_SHADOW_SCALE);
}

#endif
