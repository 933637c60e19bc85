/* OpenBTF shaders: texture coordinates to texels, in integers (FORMAT.md section 9).
 *
 * SPDX-License-Identifier: MIT
 */

/* Position in 2^-18 of a texel, 0 .. size * 2^18 - 1, of a coordinate that repeats with period 1. A coordinate that
 * is not finite, beyond +-4096 or not normal counts as 0. */
uint btf_coordinate(float c, uint size) {
    uint magnitude = floatBitsToUint(c) & 0x7FFFFFFFu;
    bool usable = magnitude >= 0x00800000u && magnitude <= 0x45800000u;
    float scaled = floor(btf_mul(usable ? c : 0.0, 262144.0));
    return (uint(int(scaled)) & 0x3FFFFu) * size;
}

/* Columns and rows of a level of detail. */
uvec2 btf_size(int level) {
    return uvec2(max(BTF_WIDTH >> level, 1u), max(BTF_HEIGHT >> level, 1u));
}

/* Texels before and after a position, and the weight of the latter in 256ths. */
uvec3 btf_bilinear(uint t, uint size) {
    uint s = t - 131072u;
    if (t < 131072u)
        s += size << 18u;
    uint c0 = s >> 18u;
    uint c1 = c0 + 1u;
    return uvec3(c0, c1 == size ? 0u : c1, (s >> 10u) & 255u);
}

/* The weight of the latter in 256ths as the filter says: its own of a texel's middle half, in between twice as
 * steep. */
uint btf_share(uint weight) {
#if BTF_STEEP
    return uint(clamp(2 * int(weight) - 128, 0, 256));
#else
    return weight;
#endif
}

/* position + shift, wrapped; position < size, shift -128..127. */
uint btf_wrap(uint position, int shift, uint size) {
    int p = int(position) + shift;
    if (size >= 128u) {
        p += p < 0 ? int(size) : 0;
        p -= p >= int(size) ? int(size) : 0;
        return uint(p);
    }
    return uint(p + int(128u * size)) % size;
}
