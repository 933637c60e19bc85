/* OpenBTF shaders: the low-rank terms of a source, four components a texel (FORMAT.md sections 3 and 9).
 *
 * SPDX-License-Identifier: MIT
 */
#if BTF_COMPONENTS > 0 && !BTF_FACTORS

ivec4 btf_direction_components(uint light, uint view, int layer) {
    return texelFetch(btf_residual_directions, ivec3(int(light), int(view), layer), 0);
}

/* Adds the first `count` components of group g, in order, to the residual of each texel. The sums over
 * lights are the same for all of them. */
void btf_residual_group(inout vec3 r[BTF_TEXELS], int g, int count, uvec2 x[BTF_TEXELS], uint view,
                        btf_neighbours lights, int n, int level) {
    ivec4 red = ivec4(0), green = ivec4(0), blue = ivec4(0);
    for (int b = 0; b < n; ++b) {
        int w = int(lights.weight[b]);
        red += w * btf_direction_components(lights.index[b], view, 3 * g);
        green += w * btf_direction_components(lights.index[b], view, 3 * g + 1);
        blue += w * btf_direction_components(lights.index[b], view, 3 * g + 2);
    }
    vec4 scale = btf_mul(texelFetch(btf_residual_scales, ivec2(g, 0), 0), uintBitsToFloat(BTF_BITS_2_TO_MINUS_12));
    for (int i = 0; i < BTF_TEXELS; ++i) {
        vec4 u = btf_mul(vec4(texelFetch(btf_residual_texels, ivec3(x[i], g), level)), scale);
        r[i] = btf_add(r[i], btf_mul(vec3(red.x, green.x, blue.x), u.x));
        if (count > 1)
            r[i] = btf_add(r[i], btf_mul(vec3(red.y, green.y, blue.y), u.y));
        if (count > 2)
            r[i] = btf_add(r[i], btf_mul(vec3(red.z, green.z, blue.z), u.z));
        if (count > 3)
            r[i] = btf_add(r[i], btf_mul(vec3(red.w, green.w, blue.w), u.w));
    }
}

/* The residuals r of sources x in a view under the first n neighbouring lights (1 or 3). */
void btf_residual(inout vec3 r[BTF_TEXELS], uvec2 x[BTF_TEXELS], uint view, btf_neighbours lights, int n,
                  int level) {
    const int groups = BTF_COMPONENTS / 4;
    for (int g = 0; g < groups; ++g)
        btf_residual_group(r, g, 4, x, view, lights, n, level);
#if BTF_COMPONENTS % 4 != 0
    btf_residual_group(r, groups, BTF_COMPONENTS % 4, x, view, lights, n, level);
#endif
}

#endif
