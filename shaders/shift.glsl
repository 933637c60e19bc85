/* OpenBTF shaders: the point of a texel in a view: gain code and shift bytes (FORMAT.md section 3).
 *
 * SPDX-License-Identifier: MIT
 */
#define BTF_READS_CODE (BTF_GAIN || BTF_HIDDEN || (BTF_SHIFT && BTF_CODE_ZERO))
#define BTF_READS_SHIFT (BTF_SHIFT || BTF_HIDDEN)

/* (gain code, first shift byte, second shift byte); (128, 0, 0) where they are not decoded. Of packed points
 * (code of the gain, columns + 32, rows + 32). */
uvec3 btf_view_codes(uvec2 x, uint view, int level) {
    uvec3 codes = uvec3(128u, 0u, 0u);
#if BTF_READS_CODE || BTF_READS_SHIFT
#if BTF_POINTS
#if BTF_POINTS == 2
    uint entry = (texelFetch(btf_point_indices, ivec3(x, view >> 1u), level).x >> ((view & 1u) << 2u)) & 15u;
    uvec2 bytes = texelFetch(btf_point_lists, ivec3(x, entry), level).xy;
#else
    uvec2 bytes = texelFetch(btf_points, ivec3(x, view), level).xy;
#endif
    uint point = bytes.x + 256u * bytes.y;
    codes = uvec3(point >> 12u, point & 63u, (point >> 6u) & 63u);
#else
#if BTF_LAYOUT_TIGHT
#if BTF_READS_CODE
    codes.x = texelFetch(btf_gain, ivec3(x, view), level).x;
#endif
#if BTF_READS_SHIFT
    codes.yz = texelFetch(btf_shift, ivec3(x, view), level).xy;
#endif
#else
    codes = texelFetch(btf_maps, ivec2(btf_tile(view, x)), 0).yzw;
#endif
#endif
#endif
    return codes;
}

/* The two's complement of a byte. */
int btf_signed_byte(uint b) {
    return int(b ^ 128u) - 128;
}

/* The shift that a code says. */
int btf_shift_of(uint code) {
#if BTF_POINTS
    return int(code) - 32;
#else
    return btf_signed_byte(code);
#endif
}

/* The source of texel x: x itself where the file has no shift for it. */
uvec2 btf_source(uvec2 x, uvec3 codes, int level) {
#if BTF_SHIFT
#if BTF_CODE_ZERO
    if (codes.x == 0u)
        return x;
#endif
    uvec2 size = btf_size(level);
    return uvec2(btf_wrap(x.x, btf_shift_of(codes.y), size.x),
                 btf_wrap(x.y, btf_shift_of(codes.z), size.y));
#else
    return x;
#endif
}
