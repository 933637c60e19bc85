/* OpenBTF shaders: texture coordinates to texels, in integers (FORMAT.md section 9).
 *
 * SPDX-License-Identifier: MIT
 */

/* A texel is 2^18 positions wide, and so many steps are the period of a texture coordinate. */
#define BTF_BELOW_TEXEL 18u
#define BTF_PERIOD (1u << BTF_BELOW_TEXEL)

/* Position in 2^-18 of a texel, 0 .. size * 2^18 - 1, of a coordinate that repeats with period 1. A coordinate that
 * is not finite, beyond +-4096 or not normal counts as 0. */
uint btf_coordinate(float c, uint size) {
    uint magnitude = floatBitsToUint(c) & BTF_BITS_MAGNITUDE;
    bool usable = magnitude >= BTF_BITS_LEAST_NORMAL && magnitude <= BTF_BITS_4096;
    float scaled = floor(btf_mul(usable ? c : 0.0, float(BTF_PERIOD)));
    return (uint(int(scaled)) & (BTF_PERIOD - 1u)) * size;
}

/* Columns and rows of a level of detail. */
uvec2 btf_size(int level) {
    return uvec2(max(BTF_WIDTH >> level, 1u), max(BTF_HEIGHT >> level, 1u));
}

/* Texels before and after a position, and the weight of the latter in 256ths. */
uvec3 btf_bilinear(uint t, uint size) {
    uint s = t - BTF_PERIOD / 2u;
    if (t < BTF_PERIOD / 2u)
        s += size << BTF_BELOW_TEXEL;
    uint c0 = s >> BTF_BELOW_TEXEL;
    uint c1 = c0 + 1u;
    return uvec3(c0, c1 == size ? 0u : c1, (s >> (BTF_BELOW_TEXEL - 8u)) & 255u);
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
