/* OpenBTF shaders: the entry points (FORMAT.md section 9).
 *
 * SPDX-License-Identifier: MIT
 */

vec3 btf_evaluate_directions(vec2 uv, vec3 l, vec3 v, bool nearest) {
    if (!btf_is_above(l) || !btf_is_above(v))
        return vec3(0.0);
    btf_setting s = btf_prepare(l, v, nearest);
    uint tu = btf_coordinate(uv.x, BTF_WIDTH), tv = btf_coordinate(uv.y, BTF_HEIGHT);
#if BTF_BILINEAR
    uvec3 cu = btf_bilinear(tu, BTF_WIDTH), cv = btf_bilinear(tv, BTF_HEIGHT);
    vec3 sum = vec3(0.0);
    for (uint i = 0u; i < 4u; ++i) {
        bool right = (i & 1u) != 0u, above = (i & 2u) != 0u;
        uint w = (right ? cu.z : 256u - cu.z) * (above ? cv.z : 256u - cv.z);
        uvec2 x = uvec2(right ? cu.y : cu.x, BTF_HEIGHT - 1u - (above ? cv.y : cv.x));
        sum = btf_add(sum, btf_mul(btf_texel(x, s), btf_mul(float(w), uintBitsToFloat(0x37800000u))));
    }
    return sum;
#else
    return btf_texel(uvec2(tu >> 18u, BTF_HEIGHT - 1u - (tv >> 18u)), s);
#endif
}

/* Linear radiance (Rec. 709 primaries, cosine included) of the material at texture coordinates uv, lit from
 * l and seen from v, under a light of unit irradiance / pi at normal incidence. l and v are unit vectors of
 * the tangent frame: x along +u, y along +v, z the normal. Below the horizon (l.z or v.z <= 0, or not
 * finite) it is 0. */
vec3 btf_evaluate(vec2 uv, vec3 l, vec3 v) {
    return btf_evaluate_directions(uv, l, v, BTF_NEAREST != 0);
}

/* The same with the nearest sampled view and light in place of interpolation between three. */
vec3 btf_evaluate_nearest(vec2 uv, vec3 l, vec3 v) {
    return btf_evaluate_directions(uv, l, v, true);
}
