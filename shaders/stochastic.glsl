/* OpenBTF shaders: one neighbour in place of all, picked with its weight, and the blend that picks converge to
 * (FORMAT.md section 9, Stochastic decode; filtering after shading of Pharr, Wronski, Salvi and Fajardo 2024).
 *
 * SPDX-License-Identifier: MIT
 */

/* Random numbers of a counter, say (column, row, frame): PCG3D of Jarzynski and Olano, Hash Functions for GPU
 * Rendering, JCGT 9(3), 2020. */
uvec3 btf_random(uvec3 counter) {
    uvec3 r = counter * 1664525u + 1013904223u;
    r.x += r.y * r.z;
    r.y += r.z * r.x;
    r.z += r.x * r.y;
    r ^= r >> 16u;
    r.x += r.y * r.z;
    r.y += r.z * r.x;
    r.z += r.x * r.y;
    return r;
}

#if BTF_STOCHASTIC

uint btf_component(uvec3 list, int i) {
    return i == 0 ? list.x : (i == 1 ? list.y : list.z);
}

/* The one of three that a number below the sum of their weights falls on; never one of weight 0. */
int btf_pick(uvec3 weight, uint number) {
    return number < weight.x ? 0 : (number < weight.x + weight.y ? 1 : 2);
}

/* Prepares all of s but the lights, which may depend on the view; returns the position in 2^-18 of a texel. */
uvec2 btf_set_scene(out btf_setting s, vec2 uv, vec3 l, vec3 v, int level) {
    uvec2 size = btf_size(level);
    uvec2 at = uvec2(btf_coordinate(uv.x, size.x), btf_coordinate(uv.y, size.y));
    s.level = level;
    btf_set_views(s, v, BTF_NEAREST != 0);
    btf_set_factors(s, l, v);
#if BTF_RELIEF
    btf_relief(s.shown, s.views, s.n_views, s.vector, ivec2(at >> 10u), v, level);
#endif
    return at;
}

/* The lights of view a. */
void btf_set_lights(inout btf_setting s, vec3 l, vec3 v, int a) {
    s.n = btf_light_count(BTF_NEAREST != 0);
#if BTF_GLOSS
    s.lights = btf_lights_around(l, v, BTF_ELEMENT(s.vector, a).xyz, BTF_NEAREST != 0);
#else
    s.lights = btf_lights_around(l, v, v, BTF_NEAREST != 0);
#endif
}

/* Keeps light b alone, with the whole weight, of the lights of s. */
void btf_take_light(inout btf_setting s, int b) {
    s.lights = btf_neighbours(uvec3(btf_component(s.lights.index, b)), uvec3(4096u, 0u, 0u));
    s.n = 1;
}

/* Where view a shows the point. */
uvec2 btf_place(btf_setting s, int a, uvec2 at) {
#if BTF_RELIEF
    return uvec2(BTF_ELEMENT(s.shown, a)) << 10u;
#else
    return at;
#endif
}

vec3 btf_scaled(vec3 value) {
#if BTF_BLEND_ROOTS
    value = btf_radiance(value);
#endif
    return btf_mul(value, BTF_RADIANCE_SCALE);
}

/* Radiance of the texels x, of which the filter makes one, in view a under the lights of s. */
vec3 btf_chosen_radiance(btf_setting s, int a, uvec2 x[BTF_TEXELS], uvec4 weight) {
    vec3 value[BTF_TEXELS];
    btf_show_view(value, x, btf_component(s.views.index, a), s);
#if BTF_BILINEAR && BTF_STOCHASTIC < 3
#if BTF_RELIEF
#ifdef BTF_RELIEF_END
    if (s.level >= BTF_RELIEF_END) {
        for (int i = 0; i < BTF_TEXELS; ++i)
            value[i] = btf_scaled(value[i]);
        return btf_filter(value, weight);
    }
#endif
    return btf_scaled(btf_filter(value, weight));
#else
    for (int i = 0; i < BTF_TEXELS; ++i)
        value[i] = btf_scaled(value[i]);
    return btf_filter(value, weight);
#endif
#else
    return btf_scaled(value[0]);
#endif
}

#if BTF_BILINEAR && BTF_STOCHASTIC < 3

/* Radiance in view a: what the filter makes of four texels. */
vec3 btf_view_radiance(btf_setting s, int a, uvec2 at) {
    uvec2 x[BTF_TEXELS], size = btf_size(s.level);
    at = btf_place(s, a, at);
    uvec4 weight = btf_corners(x, btf_bilinear(at.x, size.x), btf_bilinear(at.y, size.y), s.level);
    return btf_chosen_radiance(s, a, x, weight);
}

#else

/* Radiance in view a of one texel, column and row counted from below. */
vec3 btf_texel_radiance(btf_setting s, int a, uvec2 texel) {
    uvec2 x[BTF_TEXELS];
    x[0] = uvec2(texel.x, btf_size(s.level).y - 1u - texel.y);
    return btf_chosen_radiance(s, a, x, uvec4(65536u, 0u, 0u, 0u));
}

#if !BTF_BILINEAR
vec3 btf_view_radiance(btf_setting s, int a, uvec2 at) {
    return btf_texel_radiance(s, a, btf_place(s, a, at) >> 18u);
}
#else

/* Radiance in view a: the texels of the filter are decoded one by one, then blended. */
vec3 btf_view_radiance(btf_setting s, int a, uvec2 at) {
    uvec2 size = btf_size(s.level);
    at = btf_place(s, a, at);
    uvec3 cu = btf_bilinear(at.x, size.x), cv = btf_bilinear(at.y, size.y);
    uint u = btf_share(cu.z), v = btf_share(cv.z);
    vec3 sum = vec3(0.0);
    for (int corner = 0; corner < 4; ++corner) {
        bool right = (corner & 1) != 0, upper = corner > 1;
        uint weight = (right ? u : 256u - u) * (upper ? v : 256u - v);
        if (weight > 0u) {
            vec3 radiance = btf_texel_radiance(s, a, uvec2(right ? cu.y : cu.x, upper ? cv.y : cv.x));
            sum = btf_add(sum, btf_mul(radiance, btf_mul(float(weight), uintBitsToFloat(BTF_BITS_2_TO_MINUS_16))));
        }
    }
    return sum;
}
#endif
#endif

/* Radiance of the choice that random numbers make. */
vec3 btf_choose(vec2 uv, vec3 l, vec3 v, int level, uvec3 random) {
    if (!btf_is_above(l) || !btf_is_above(v))
        return vec3(0.0);
    btf_setting s;
    uvec2 at = btf_set_scene(s, uv, l, v, level);
    int a = btf_pick(s.views.weight, random.x >> 20u);
    btf_set_lights(s, l, v, a);
#if BTF_STOCHASTIC > 1
    btf_take_light(s, btf_pick(s.lights.weight, random.y >> 20u));
#endif
#if BTF_BILINEAR && BTF_STOCHASTIC > 2
    uvec2 size = btf_size(level);
    at = btf_place(s, a, at);
    uvec3 cu = btf_bilinear(at.x, size.x), cv = btf_bilinear(at.y, size.y);
    return btf_texel_radiance(s, a, uvec2((random.z >> 24u) < btf_share(cu.z) ? cu.y : cu.x,
                                          ((random.z >> 16u) & 255u) < btf_share(cv.z) ? cv.y : cv.x));
#else
    return btf_view_radiance(s, a, at);
#endif
}

/* The mean of all choices. */
vec3 btf_blend_choices(vec2 uv, vec3 l, vec3 v, int level) {
    if (!btf_is_above(l) || !btf_is_above(v))
        return vec3(0.0);
    btf_setting s;
    uvec2 at = btf_set_scene(s, uv, l, v, level);
    vec3 sum = vec3(0.0);
    for (int a = 0; a < s.n_views; ++a) {
        uint share = btf_component(s.views.weight, a);
        if (share > 0u) {
            btf_set_lights(s, l, v, a);
#if BTF_STOCHASTIC > 1
            vec3 lit = vec3(0.0);
            btf_setting one = s;
            for (int b = 0; b < s.n; ++b) {
                uint weight = btf_component(s.lights.weight, b);
                if (weight > 0u) {
                    one.lights = s.lights;
                    btf_take_light(one, b);
                    lit = btf_add(lit, btf_mul(btf_view_radiance(one, a, at), btf_view_weight(weight)));
                }
            }
#else
            vec3 lit = btf_view_radiance(s, a, at);
#endif
            sum = btf_add(sum, btf_mul(lit, btf_view_weight(share)));
        }
    }
    return sum;
}

/* A level of detail in 256ths, of those there are. */
int btf_level_256ths(float level) {
    int last = int(BTF_LEVELS) - 1, bits = floatBitsToInt(level);
    if (bits <= 0 || bits > BTF_BITS_INFINITY)
        return 0;
    return level >= float(last) ? last << 8 : int(floor(btf_mul(level, 256.0)));
}

/* btf_evaluate, by one of the neighbours in place of all of them: the mean over random numbers of 32 bits, each as
 * likely as any other, is btf_evaluate_radiance_blend. random.x picks the view, .y the light, .z the texel and the level
 * by their highest bits: btf_random(uvec3(pixel, frame)), or numbers of your own. */
vec3 btf_evaluate_stochastic(vec2 uv, vec3 l, vec3 v, uvec3 random) {
    return btf_choose(uv, l, v, 0, random);
}

/* The same of a level of detail, 0 the finest; beyond the last it is the last. */
vec3 btf_evaluate_stochastic_level(vec2 uv, vec3 l, vec3 v, int level, uvec3 random) {
    return btf_choose(uv, l, v, clamp(level, 0, int(BTF_LEVELS) - 1), random);
}

/* The same between two levels, of which one is picked, too: btf_level(dFdx(uv), dFdy(uv)) as it is. */
vec3 btf_evaluate_stochastic_between(vec2 uv, vec3 l, vec3 v, float level, uvec3 random) {
    int at = btf_level_256ths(level);
    return btf_choose(uv, l, v, (at >> 8) + (int((random.z >> 8u) & 255u) < (at & 255) ? 1 : 0), random);
}

/* The mean of btf_evaluate_stochastic: every neighbour decoded to radiance, then blended. Slow. */
vec3 btf_evaluate_radiance_blend(vec2 uv, vec3 l, vec3 v) {
    return btf_blend_choices(uv, l, v, 0);
}

/* The mean of btf_evaluate_stochastic_level. */
vec3 btf_evaluate_radiance_blend_level(vec2 uv, vec3 l, vec3 v, int level) {
    return btf_blend_choices(uv, l, v, clamp(level, 0, int(BTF_LEVELS) - 1));
}

/* The mean of btf_evaluate_stochastic_between. */
vec3 btf_evaluate_radiance_blend_between(vec2 uv, vec3 l, vec3 v, float level) {
    int at = btf_level_256ths(level), share = at & 255;
    vec3 sum = vec3(0.0);
    for (int i = 0; i < (share > 0 ? 2 : 1); ++i) {
        float weight = btf_mul(float(i > 0 ? share : 256 - share), uintBitsToFloat(BTF_BITS_2_TO_MINUS_8));
        sum = btf_add(sum, btf_mul(btf_blend_choices(uv, l, v, (at >> 8) + i), weight));
    }
    return sum;
}

#endif
