/* OpenBTF shaders: reads folded values (decoder/README.md, Folding): for a light that never changes, or light and view,
 * a texture holds the decoder's own values, bit for bit; for several lights whose views are blended as roots, sums of
 * products of these.
 *
 * SPDX-License-Identifier: MIT
 */
#if BTF_FOLDED

/* The folded value of texel x, in a layer of the texture. */
vec3 btf_folded_value(uvec2 x, int layer, int level) {
    return uintBitsToFloat(texelFetch(btf_folded, ivec3(ivec2(x), layer), level).xyz);
}

#if BTF_FOLDED == 4 && BTF_BLEND_ROOTS
/* The layer, from the first of view a on, of its products with view b: 1 to 3 as A of its own layer names the partners of
 * a, in 10 bits each; 0: b is not one of them. */
int btf_partner_layer(uint partners, uint b) {
    if ((partners & 1023u) == b)
        return 1;
    if (((partners >> 10u) & 1023u) == b)
        return 2;
    return (partners >> 20u) == b ? 3 : 0;
}

/* Twice the sum over lights of the products of two roots of texel x, with their weights in 4096ths. own: A of the layer
 * that each view has of its own. */
vec3 btf_folded_pair(uvec2 x, int layer, int level, uvec2 views, uvec2 own, uvec2 weight) {
    uint owner = views.x;
    int after = btf_partner_layer(own.x, views.y);
    if (after == 0) {
        owner = views.y;
        after = btf_partner_layer(own.y, views.x);
    }
    return btf_mul(btf_folded_value(x, layer + 4 * int(owner) + after, level),
                   btf_mul(float(2u * weight.x * weight.y), uintBitsToFloat(BTF_BITS_2_TO_MINUS_24)));
}

/* Radiance of texel x under all lights that were added up, before radianceScale: the sum over lights of the square of the
 * blended roots, multiplied out. Its weights add up to 1. */
vec3 btf_folded_sum(uvec2 x, btf_neighbours views, int n_views, int layer, int level) {
    vec3 sum = vec3(0.0);
    uvec3 own = uvec3(0u);
    for (int a = 0; a < n_views; ++a) {
        uint weight = views.weight[a];
        if (weight > 0u) {
            uvec4 kept = texelFetch(btf_folded, ivec3(ivec2(x), layer + 4 * int(views.index[a])), level);
            own[a] = kept.w;
            float share = btf_mul(float(weight * weight), uintBitsToFloat(BTF_BITS_2_TO_MINUS_24));
            sum = btf_add(sum, btf_mul(uintBitsToFloat(kept.xyz), share));
        }
    }
    if (views.weight.x > 0u && views.weight.y > 0u)
        sum = btf_add(sum, btf_folded_pair(x, layer, level, views.index.xy, own.xy, views.weight.xy));
    if (views.weight.x > 0u && views.weight.z > 0u)
        sum = btf_add(sum, btf_folded_pair(x, layer, level, views.index.xz, own.xz, views.weight.xz));
    if (views.weight.y > 0u && views.weight.z > 0u)
        sum = btf_add(sum, btf_folded_pair(x, layer, level, views.index.yz, own.yz, views.weight.yz));
    return max(sum, vec3(0.0));
}
#endif

#endif
