/* OpenBTF shaders: reads folded values (decoder/README.md, Folding): for a light that never changes, or light and view,
 * a texture holds the decoder's own values, bit for bit.
 *
 * SPDX-License-Identifier: MIT
 */
#if BTF_FOLDED

/* The folded value of texel x, in a layer of the texture. */
vec3 btf_folded_value(uvec2 x, int layer, int level) {
    return uintBitsToFloat(texelFetch(btf_folded, ivec3(ivec2(x), layer), level).xyz);
}

#endif
