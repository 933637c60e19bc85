/* OpenBTF shaders: a texel from all its parts (FORMAT.md section 9, "One texel"); with bilinear filtering
 * four texels at a time, so that what depends on directions alone is fetched once.
 *
 * SPDX-License-Identifier: MIT
 */

/* The part that does not depend on the texel. */
struct btf_setting {
    btf_neighbours views, lights;
#if BTF_GLOSS
    btf_neighbours lights_of[3]; /* each view has its own */
#endif
#if BTF_RELIEF || BTF_GLOSS
    vec4 vector[3]; /* of each view */
#endif
#if BTF_RELIEF
    ivec2 shown[3]; /* where each view shows the point that is seen */
#endif
    int n;        /* lights in use: 1 to 3 */
    int n_views;  /* views in use: 1 to 3 */
    vec3 product; /* l * v, by component */
    float cosine; /* l.z, its root in the square-root domain */
#if BTF_FACTORS
    float horizon; /* 1 down to the outermost sampled light, from there on falling to 0 with the cosine */
#endif
    int level;    /* of detail */
#if BTF_FOLDED
    int layer; /* of btf_folded: the first of the light */
#endif
};

/* The views around v, or the nearest of them, and their vectors. */
void btf_set_views(inout btf_setting s, vec3 v, bool nearest) {
#if BTF_FIXED_VIEW > 0
    s.views = btf_neighbours(BTF_FIXED_VIEW_INDEX, BTF_FIXED_VIEW_WEIGHT);
    s.n_views = BTF_FIXED_VIEW;
#else
    s.views = btf_lookup(btf_view_table, BTF_VIEW_GRID, btf_project(v));
    s.n_views = 3;
#endif
    if (nearest) {
        s.views = btf_nearest(s.views);
        s.n_views = 1;
    }
#if BTF_RELIEF || BTF_GLOSS
    s.vector[0] = s.vector[1] = s.vector[2] = btf_view_vector(s.views.index.x);
    if (s.n_views > 1) {
        s.vector[1] = btf_view_vector(s.views.index.y);
        s.vector[2] = btf_view_vector(s.views.index.z);
    }
#endif
#if BTF_FOLDED == 3
    /* Layers hold them by their places. */
#if BTF_FIXED_VIEW > 0
    s.views.index = BTF_FIXED_VIEW_LAYER;
#else
    s.views.index = uvec3(0u, 1u, 2u);
#endif
#endif
}

/* Lights in use at most. */
int btf_light_count(bool nearest) {
#if BTF_GLOSS
    return nearest ? 1 : 3;
#else
#if BTF_FIXED_LIGHT > 0
    return nearest ? 1 : BTF_FIXED_LIGHT;
#else
    return nearest ? 1 : 3;
#endif
#endif
}

/* The lights around l, or the nearest of them, as a view of this vector has them. A function of its own that changes no
 * setting: softpipe mistakes a setting that is changed by a call in a loop. */
btf_neighbours btf_lights_around(vec3 l, vec3 v, vec3 vector, bool nearest) {
#if BTF_GLOSS
    btf_neighbours lights = btf_lookup(btf_light_table, BTF_LIGHT_GRID, btf_gloss(l, v, vector));
#else
#if BTF_FIXED_LIGHT > 0
    btf_neighbours lights = btf_neighbours(BTF_FIXED_LIGHT_INDEX, BTF_FIXED_LIGHT_WEIGHT);
#else
    btf_neighbours lights = btf_lookup(btf_light_table, BTF_LIGHT_GRID, btf_project(l));
#endif
#endif
    if (nearest)
        lights = btf_nearest(lights);
    return lights;
}

/* Sets the factors that depend on the directions alone: l * v, cosine and horizon. */
void btf_set_factors(inout btf_setting s, vec3 l, vec3 v) {
    s.product = btf_mul(l, v);
#if BTF_DOMAIN_SQRT
    s.cosine = btf_pow(l.z, 0.5);
#else
    s.cosine = l.z;
#endif
#if BTF_FACTORS
    float q = btf_mul(l.z, BTF_HORIZON_SCALE);
    s.horizon = 1.0;
    if (q < 1.0)
#if BTF_DOMAIN_SQRT
        s.horizon = btf_pow(q, 0.5);
#else
        s.horizon = q;
#endif
#endif
}

btf_setting btf_prepare(vec3 l, vec3 v, bool nearest, int level) {
    btf_setting s;
    s.level = level;
#if BTF_FOLDED
    s.layer = 0;
#endif
    btf_set_views(s, v, nearest);
    s.n = btf_light_count(nearest);
#if BTF_GLOSS
    for (int a = 0; a < s.n_views; ++a) {
        btf_neighbours lights = btf_lights_around(l, v, BTF_ELEMENT(s.vector, a).xyz, nearest);
        if (a == 0)
            s.lights_of[0] = lights;
        else if (a == 1)
            s.lights_of[1] = lights;
        else
            s.lights_of[2] = lights;
    }
    s.lights = s.lights_of[0];
#else
    s.lights = btf_lights_around(l, v, v, nearest);
#endif
    btf_set_factors(s, l, v);
    return s;
}

/* The lights of view a. */
btf_neighbours btf_lights_of(btf_setting s, int a) {
    btf_neighbours lights = s.lights;
#if BTF_GLOSS
    lights = s.lights_of[0];
    if (a == 1)
        lights = s.lights_of[1];
    if (a == 2)
        lights = s.lights_of[2];
#endif
    return lights;
}

float btf_clamp(float y) {
    return y >= uintBitsToFloat(BTF_BITS_2_TO_MINUS_30) ? min(y, 4294967296.0) : 0.0;
}

/* Radiance, before radianceScale, of the model's value y: its square in the square-root domain. */
vec3 btf_radiance(vec3 y) {
    y = vec3(btf_clamp(y.x), btf_clamp(y.y), btf_clamp(y.z));
#if BTF_DOMAIN_SQRT
    y = btf_mul(y, y);
#endif
    return y;
}

/* Radiance, before radianceScale, of a source with a residual and a gain code; its root, which may be
 * negative, where views are blended as roots. */
vec3 btf_source_radiance(uvec2 source, vec3 residual, uint gain, btf_setting s) {
    vec3 y = vec3(0.0);
#if BTF_COLOUR != 2
    y = btf_lafortune(source, s.product, s.level);
#if BTF_SHADOW
    y = btf_mul(y, btf_shadow_factor(source, s.lights, s.n, s.level));
#endif
#endif
#if BTF_FACTORS
    residual = btf_mul(residual, s.horizon);
#if BTF_COLOUR != 2
    y = btf_add(btf_mul(y, s.cosine), residual);
#else
    y = residual;
#endif
#else
#if BTF_COMPONENTS > 0
#if BTF_COLOUR != 2
    y = btf_add(y, residual);
#else
    y = residual;
#endif
#endif
    y = btf_mul(y, s.cosine);
#endif
#if BTF_GAIN
#if BTF_POINTS
    y = btf_mul(y, btf_add(BTF_GAIN_BASE, btf_mul(float(gain), BTF_GAIN_STEP)));
#else
#if BTF_CODE_ZERO
    if (gain != 0u)
        y = btf_mul(y, btf_mul(float(gain), BTF_GAIN_SCALE));
#else
    y = btf_mul(y, btf_mul(float(gain), BTF_GAIN_SCALE));
#endif
#endif
#endif
#if BTF_BLEND_ROOTS
    return clamp(y, vec3(-4294967296.0), vec3(4294967296.0)); /* else the views could add up to inf - inf */
#else
    return btf_radiance(y);
#endif
}

/* Radiance of each texel x in one sampled view; its root where views are blended as roots. */
void btf_show_view(out vec3 radiance[BTF_TEXELS], uvec2 x[BTF_TEXELS], uint view,
#if BTF_FACTORS && !BTF_FACTORS_BY_VIEW
                   vec3 residual[BTF_TEXELS],
#endif
                   btf_setting s) {
#if BTF_FOLDED
    for (int i = 0; i < BTF_TEXELS; ++i)
        radiance[i] = btf_folded_value(x[i], s.layer + int(view), s.level);
#else
    uvec3 codes[BTF_TEXELS];
    uvec2 source[BTF_TEXELS];
#if !BTF_FACTORS || BTF_FACTORS_BY_VIEW
    vec3 residual[BTF_TEXELS];
#endif
    bool visible = false;
    for (int i = 0; i < BTF_TEXELS; ++i) {
        codes[i] = btf_view_codes(x[i], view, s.level);
        source[i] = btf_source(x[i], codes[i], s.level);
#if !BTF_FACTORS || BTF_FACTORS_BY_VIEW
        residual[i] = vec3(0.0);
#endif
        visible = visible || codes[i].x != 0u;
    }
#if BTF_COMPONENTS > 0 && (!BTF_FACTORS || BTF_FACTORS_BY_VIEW)
#if BTF_HIDDEN
    if (visible)
#endif
#if BTF_FACTORS
        btf_factors(residual, btf_factor_scene(source, s.level, uvec3(view), 1, s.lights, s.n));
#else
        btf_residual(residual, source, view, s.lights, s.n, s.level);
#endif
#endif
    for (int i = 0; i < BTF_TEXELS; ++i) {
#if BTF_HIDDEN
        if (codes[i].x == 0u)
            radiance[i] = btf_centre_radiance(btf_centre_index(codes[i]), s.lights, s.n);
        else
#endif
            radiance[i] = btf_source_radiance(source[i], residual[i], codes[i].x, s);
    }
#endif
}

#if BTF_BILINEAR && BTF_STOCHASTIC < 3
/* Four texels as the filter blends them, of weights in 65536ths. */
vec3 btf_filter(vec3 radiance[BTF_TEXELS], uvec4 weight) {
    vec3 sum = btf_mul(radiance[0], btf_mul(float(weight[0]), uintBitsToFloat(BTF_BITS_2_TO_MINUS_16)));
    for (int i = 1; i < BTF_TEXELS; ++i)
        sum = btf_add(sum, btf_mul(radiance[i], btf_mul(float(weight[i]), uintBitsToFloat(BTF_BITS_2_TO_MINUS_16))));
    return sum;
}

/* The texels around a position and their weights; cu and cv of its coordinates, from btf_bilinear. */
uvec4 btf_corners(out uvec2 x[BTF_TEXELS], uvec3 cu, uvec3 cv, int level) {
    uint rows = btf_size(level).y;
    x[0] = uvec2(cu.x, rows - 1u - cv.x);
    x[1] = uvec2(cu.y, rows - 1u - cv.x);
    x[2] = uvec2(cu.x, rows - 1u - cv.y);
    x[3] = uvec2(cu.y, rows - 1u - cv.y);
    uint u = btf_share(cu.z), v = btf_share(cv.z);
    return uvec4(256u - u, u, 256u - u, u) * uvec4(uvec2(256u - v), uvec2(v));
}
#endif

float btf_view_weight(uint weight) {
    return btf_mul(float(weight), uintBitsToFloat(BTF_BITS_2_TO_MINUS_12));
}

#if !BTF_STOCHASTIC
#if BTF_RELIEF

/* The texels around the position where a view shows the point, or the texel that holds it; and their weights. */
uvec4 btf_shown_texels(out uvec2 x[BTF_TEXELS], ivec2 shown, int level) {
    uvec2 at = uvec2(shown), size = btf_size(level);
#if BTF_BILINEAR
    return btf_corners(x, btf_bilinear(at.x << 10u, size.x), btf_bilinear(at.y << 10u, size.y), level);
#else
    x[0] = uvec2(at.x >> 8u, size.y - 1u - (at.y >> 8u));
    return uvec4(65536u, 0u, 0u, 0u);
#endif
}

#if BTF_FACTORS
/* The residual at the texels that each view shows, [view][texel]. */
void btf_shown_factors(out vec3 residual[BTF_FACTOR_SUMS], btf_setting s) {
    uvec2 source[BTF_FACTOR_SUMS];
    for (int a = 0; a < s.n_views; ++a) {
        uvec2 x[BTF_TEXELS];
        btf_shown_texels(x, BTF_ELEMENT(s.shown, a), s.level);
        for (int i = 0; i < BTF_TEXELS; ++i)
            source[a * BTF_TEXELS + i] = btf_source(x[i], btf_view_codes(x[i], s.views.index[a], s.level), s.level);
    }
#if BTF_GLOSS
    btf_factors(residual, btf_factor_scene(source, s.level, s.views.index, s.n_views, s.lights_of, s.n));
#else
    btf_factors(residual, btf_factor_scene(source, s.level, s.views.index, s.n_views, s.lights, s.n));
#endif
}
#endif

/* Radiance: the neighbouring views, each as it shows the point that is seen, blended. At a level where relief has ended
 * the views of each texel are blended first, then texels, as without relief; of one texel both are the same. */
vec3 btf_shifted_views(btf_setting s) {
    vec3 sum = vec3(0.0);
#if BTF_BILINEAR
#ifdef BTF_RELIEF_END
    vec3 unmoved[BTF_TEXELS];
    for (int i = 0; i < BTF_TEXELS; ++i)
        unmoved[i] = vec3(0.0);
#endif
#endif
#if BTF_FACTORS
    vec3 all[BTF_FACTOR_SUMS];
    btf_shown_factors(all, s);
#endif
    for (int a = 0; a < s.n_views; ++a) {
        uvec2 x[BTF_TEXELS];
        vec3 radiance[BTF_TEXELS];
        s.lights = btf_lights_of(s, a);
        uvec4 weight = btf_shown_texels(x, BTF_ELEMENT(s.shown, a), s.level);
        if (s.views.weight[a] > 0u) {
#if BTF_FACTORS
            vec3 residual[BTF_TEXELS];
            for (int i = 0; i < BTF_TEXELS; ++i)
                residual[i] = all[a * BTF_TEXELS + i];
            btf_show_view(radiance, x, s.views.index[a], residual, s);
#else
            btf_show_view(radiance, x, s.views.index[a], s);
#endif
#if BTF_BILINEAR
#ifdef BTF_RELIEF_END
            for (int i = 0; i < BTF_TEXELS; ++i)
                unmoved[i] = btf_add(unmoved[i], btf_mul(radiance[i], btf_view_weight(s.views.weight[a])));
#endif
            radiance[0] = btf_filter(radiance, weight);
#endif
            sum = btf_add(sum, btf_mul(radiance[0], btf_view_weight(s.views.weight[a])));
        }
    }
#if BTF_BILINEAR
#ifdef BTF_RELIEF_END
    if (s.level >= BTF_RELIEF_END) {
        uvec2 x[BTF_TEXELS];
        uvec4 weight = btf_shown_texels(x, s.shown[0], s.level);
        for (int i = 0; i < BTF_TEXELS; ++i) {
#if BTF_BLEND_ROOTS
            unmoved[i] = btf_radiance(unmoved[i]);
#endif
            unmoved[i] = btf_mul(unmoved[i], BTF_RADIANCE_SCALE);
        }
        return btf_filter(unmoved, weight);
    }
#endif
#endif
#if BTF_BLEND_ROOTS
    sum = btf_radiance(sum);
#endif
    return btf_mul(sum, BTF_RADIANCE_SCALE);
}

#else

/* Adds the radiance of each texel in one sampled view, weighted, to its sum. */
void btf_add_view(inout vec3 sum[BTF_TEXELS], vec3 radiance[BTF_TEXELS], uint weight) {
    for (int i = 0; i < BTF_TEXELS; ++i)
        sum[i] = btf_add(sum[i], btf_mul(radiance[i], btf_view_weight(weight)));
}

/* Radiance of each texel x: the neighbouring views, blended. */
void btf_texels(inout vec3 sum[BTF_TEXELS], uvec2 x[BTF_TEXELS], btf_setting s) {
#if BTF_FOLDED == 2
    for (int i = 0; i < BTF_TEXELS; ++i)
        sum[i] = btf_folded_value(x[i], s.layer, s.level);
#else
#if BTF_FOLDED == 4 && BTF_BLEND_ROOTS
    for (int i = 0; i < BTF_TEXELS; ++i)
        sum[i] = btf_mul(btf_folded_sum(x[i], s.views, s.n_views, s.layer, s.level), BTF_RADIANCE_SCALE);
#else
#if BTF_FACTORS && !BTF_FACTORS_BY_VIEW
    vec3 all[BTF_FACTOR_SUMS];
#if BTF_GLOSS
    btf_factors(all, btf_factor_scene(x, s.level, s.views.index, s.n_views, s.lights_of, s.n));
#else
    btf_factors(all, btf_factor_scene(x, s.level, s.views.index, s.n_views, s.lights, s.n));
#endif
#endif
    for (int a = 0; a < s.n_views; ++a) {
        vec3 radiance[BTF_TEXELS];
        s.lights = btf_lights_of(s, a);
#if BTF_FACTORS && !BTF_FACTORS_BY_VIEW
        vec3 residual[BTF_TEXELS];
        for (int i = 0; i < BTF_TEXELS; ++i)
            residual[i] = all[a * BTF_TEXELS + i];
        if (s.views.weight[a] > 0u) {
            btf_show_view(radiance, x, s.views.index[a], residual, s);
            btf_add_view(sum, radiance, s.views.weight[a]);
        }
#else
        if (s.views.weight[a] > 0u) {
            btf_show_view(radiance, x, s.views.index[a], s);
            btf_add_view(sum, radiance, s.views.weight[a]);
        }
#endif
    }
    for (int i = 0; i < BTF_TEXELS; ++i) {
#if BTF_BLEND_ROOTS
        sum[i] = btf_radiance(sum[i]);
#endif
        sum[i] = btf_mul(sum[i], BTF_RADIANCE_SCALE);
    }
#endif
#endif
}

#endif
#endif
