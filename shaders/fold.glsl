/* OpenBTF shaders: the values that a fold keeps (decoder/README.md, Folding), and the radiance of several lights that
 * were folded together.
 *
 * A fold is made by a variant with the options of the folded one, but without relief, which acts on the folded values,
 * and one texel at a time: texel (column, row) of `folded` holds in R, G and B the bits of these values, A is 0.
 *
 * SPDX-License-Identifier: MIT
 */
#if BTF_FOLDED

/* Radiance of btf_evaluate_level, lit by the light of that number among those that were folded, in layers
 * light * BTF_N_VIEWS onwards (or, where the view is folded too, light). */
vec3 btf_evaluate_folded(vec2 uv, vec3 v, int light, int level) {
    if (!btf_is_above(v))
        return vec3(0.0);
    btf_setting s = btf_prepare(vec3(0.0, 0.0, 1.0), v, BTF_NEAREST != 0, clamp(level, 0, int(BTF_LEVELS) - 1));
#if BTF_FOLDED == 2
    s.layer = light;
#else
    s.layer = light * int(BTF_N_VIEWS);
#endif
    return btf_evaluate_setting(uv, v, s);
}

#else
#if !BTF_BILINEAR && !BTF_RELIEF && !BTF_STOCHASTIC

#if BTF_COLOUR == 2 && !BTF_GLOSS
/* The value of texel x in a sampled view under light l, before views are weighted and blended. An SBRDF depends on the
 * viewer between samples, and with gloss so do a view's lights: no value of a light alone can be kept there. */
vec3 btf_fold_light(uvec2 x, vec3 l, uint view, int level) {
    if (!btf_is_above(l))
        return vec3(0.0);
    btf_setting s = btf_prepare(l, vec3(0.0, 0.0, 1.0), BTF_NEAREST != 0, level);
    uvec2 texels[BTF_TEXELS];
    vec3 value[BTF_TEXELS];
    texels[0] = x;
#if BTF_FACTORS && !BTF_FACTORS_BY_VIEW
    vec3 all[BTF_FACTOR_SUMS], residual[BTF_TEXELS];
    btf_factors(all, btf_factor_scene(texels, level, uvec3(view), 1, s.lights, s.n));
    residual[0] = all[0];
    btf_show_view(value, texels, view, residual, s);
#else
    btf_show_view(value, texels, view, s);
#endif
    return value[0];
}
#endif

/* Radiance of texel x under light l from v, before filtering. */
vec3 btf_fold_both(uvec2 x, vec3 l, vec3 v, int level) {
    if (!btf_is_above(l) || !btf_is_above(v))
        return vec3(0.0);
    uvec2 texels[BTF_TEXELS];
    vec3 sum[BTF_TEXELS];
    texels[0] = x;
    sum[0] = vec3(0.0);
    btf_texels(sum, texels, btf_prepare(l, v, BTF_NEAREST != 0, level));
    return sum[0];
}

#endif
#endif
