/* OpenBTF shaders: the entry points (FORMAT.md section 9).
 *
 * SPDX-License-Identifier: MIT
 */

#if !BTF_STOCHASTIC
/* Radiance at texture coordinates uv, seen from v, with the prepared setting s of light and view. */
vec3 btf_evaluate_setting(vec2 uv, vec3 v, btf_setting s) {
    int level = s.level;
    uvec2 size = btf_size(level);
    uint tu = btf_coordinate(uv.x, size.x), tv = btf_coordinate(uv.y, size.y);
#if BTF_RELIEF
    btf_relief(s.shown, s.views, s.n_views, s.vector, ivec2(tu >> 10u, tv >> 10u), v, level);
    return btf_shifted_views(s);
#else
    uvec2 x[BTF_TEXELS];
    vec3 sum[BTF_TEXELS];
#if BTF_BILINEAR
    uvec4 weight = btf_corners(x, btf_bilinear(tu, size.x), btf_bilinear(tv, size.y), level);
    for (int i = 0; i < BTF_TEXELS; ++i)
        sum[i] = vec3(0.0);
    btf_texels(sum, x, s);
    return btf_filter(sum, weight);
#else
    x[0] = uvec2(tu >> 18u, size.y - 1u - (tv >> 18u));
    sum[0] = vec3(0.0);
    btf_texels(sum, x, s);
    return sum[0];
#endif
#endif
}

vec3 btf_evaluate_directions(vec2 uv, vec3 l, vec3 v, bool nearest, int level) {
    if (!btf_is_above(l) || !btf_is_above(v))
        return vec3(0.0);
    return btf_evaluate_setting(uv, v, btf_prepare(l, v, nearest, level));
}

/* Linear radiance (Rec. 709 primaries, cosine included) of the material at texture coordinates uv, lit from
 * l and seen from v, under a light of unit irradiance / pi at normal incidence. l and v are unit vectors of
 * the tangent frame: x along +u, y along +v, z the normal. Below the horizon (l.z or v.z <= 0, or not
 * finite) it is 0. */
vec3 btf_evaluate(vec2 uv, vec3 l, vec3 v) {
    return btf_evaluate_directions(uv, l, v, BTF_NEAREST != 0, 0);
}

#if !BTF_FOLDED
/* The same with the nearest sampled view and light in place of interpolation between three. */
vec3 btf_evaluate_nearest(vec2 uv, vec3 l, vec3 v) {
    return btf_evaluate_directions(uv, l, v, true, 0);
}
#endif

/* btf_evaluate of a level of detail, 0 the finest; beyond the last it is the last. */
vec3 btf_evaluate_level(vec2 uv, vec3 l, vec3 v, int level) {
    return btf_evaluate_directions(uv, l, v, BTF_NEAREST != 0, clamp(level, 0, int(BTF_LEVELS) - 1));
}
#endif

/* The level of detail, 0 .. levels - 1, at which a texel is as wide as the longer of two steps of uv, dFdx(uv) and
 * dFdy(uv) say; round it to nearest for btf_evaluate_level. Not exact. */
float btf_level(vec2 dx, vec2 dy) {
    vec2 x = dx * vec2(btf_size(0)), y = dy * vec2(btf_size(0));
    return min(0.5 * log2(max(max(dot(x, x), dot(y, y)), 1.0)), float(BTF_LEVELS) - 1.0);
}
