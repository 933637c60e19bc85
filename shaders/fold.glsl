/* OpenBTF shaders: the values that a fold keeps (decoder/README.md, Folding), and the radiance of several lights that
 * were folded together.
 *
 * A fold is made by a variant with the options of the folded one, but without relief, which acts on the folded values,
 * and one texel at a time: texel (column, row) of `folded` holds in R, G and B the bits of these values, A is 0.
 *
 * SPDX-License-Identifier: MIT
 */
#if BTF_FOLDED

/* Radiance of btf_evaluate_level, lit by the light, or the sum of lights, of that number among those that were folded, in
 * layers light * BTF_N_VIEWS onwards (where the view is folded too, light, or light * 3 onwards; of a sum of products
 * light * 4 * BTF_N_VIEWS onwards). */
vec3 btf_evaluate_folded(vec2 uv, vec3 v, int light, int level) {
    if (!btf_is_above(v))
        return vec3(0.0);
    btf_setting s = btf_prepare(vec3(0.0, 0.0, 1.0), v, BTF_NEAREST != 0, clamp(level, 0, int(BTF_LEVELS) - 1));
#if BTF_FOLDED == 1
    s.layer = light * int(BTF_N_VIEWS);
#endif
#if BTF_FOLDED == 2
    s.layer = light;
#endif
#if BTF_FOLDED == 3
    s.layer = light * 3;
#endif
#if BTF_FOLDED == 4
#if BTF_BLEND_ROOTS
    s.layer = light * 4 * int(BTF_N_VIEWS);
#else
    s.layer = light * int(BTF_N_VIEWS);
#endif
#endif
    return btf_evaluate_setting(uv, v, s);
}

#else
#if !BTF_BILINEAR && !BTF_RELIEF && !BTF_STOCHASTIC

/* The value of texel x in a sampled view under the lights of a setting, before views are weighted and blended. */
vec3 btf_fold_value(uvec2 x, uint view, btf_setting s) {
    uvec2 texels[BTF_TEXELS];
    vec3 value[BTF_TEXELS];
    texels[0] = x;
#if BTF_FACTORS && !BTF_FACTORS_BY_VIEW
    vec3 all[BTF_FACTOR_SUMS], residual[BTF_TEXELS];
#if BTF_GLOSS
    btf_neighbours lights[3];
    lights[0] = lights[1] = lights[2] = s.lights;
#else
    btf_neighbours lights = s.lights;
#endif
    btf_factors(all, btf_factor_scene(texels, s.level, uvec3(view), 1, lights, s.n));
    residual[0] = all[0];
    btf_show_view(value, texels, view, residual, s);
#else
    btf_show_view(value, texels, view, s);
#endif
    return value[0];
}

#if BTF_COLOUR == 2 && !BTF_GLOSS
/* The value of texel x in a sampled view under light l. An SBRDF depends on the viewer between samples, and with gloss so
 * do a view's lights: no value of a light alone can be kept there. */
vec3 btf_fold_light(uvec2 x, vec3 l, uint view, int level) {
    if (!btf_is_above(l))
        return vec3(0.0);
    return btf_fold_value(x, view, btf_prepare(l, vec3(0.0, 0.0, 1.0), BTF_NEAREST != 0, level));
}
#endif

/* The value of texel x under light l in neighbour a, 0 to 2, of those around v; 0 where that one weighs nothing. */
vec3 btf_fold_neighbour(uvec2 x, vec3 l, vec3 v, int a, int level) {
    if (!btf_is_above(l) || !btf_is_above(v))
        return vec3(0.0);
    btf_setting s = btf_prepare(l, v, BTF_NEAREST != 0, level);
    uint view = a == 0 ? s.views.index.x : (a == 1 ? s.views.index.y : s.views.index.z);
    uint weight = a == 0 ? s.views.weight.x : (a == 1 ? s.views.weight.y : s.views.weight.z);
    if (weight == 0u)
        return vec3(0.0);
    s.lights = btf_lights_of(s, a);
    return btf_fold_value(x, view, s);
}

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

/* The sum of radiance under several lights, or of what one view shows, or of products of two, with one more. */
vec3 btf_fold_add(vec3 sum, vec3 radiance, vec3 weight) {
    return btf_add(sum, btf_mul(radiance, weight));
}

#if BTF_BLEND_ROOTS
/* A root, or 0 where the decoder takes nothing of it. */
float btf_fold_root(float y) {
    return abs(y) >= uintBitsToFloat(BTF_BITS_2_TO_MINUS_30) ? y : 0.0;
}

/* What stands for the product of the roots that two views show under one light, or for the square of one: in place of
 * roots below 0, what makes the square of their mean that of btf_radiance, which clamps it. */
vec3 btf_fold_product(vec3 a, vec3 b) {
    a = vec3(btf_fold_root(a.x), btf_fold_root(a.y), btf_fold_root(a.z));
    b = vec3(btf_fold_root(b.x), btf_fold_root(b.y), btf_fold_root(b.z));
    vec3 high = max(max(a, b), vec3(0.0));
    vec3 low = max(min(a, b), -high);
    return btf_mul(low, btf_add(high, btf_mul(min(low, vec3(0.0)), 0.5)));
}
#endif

#endif
#endif
