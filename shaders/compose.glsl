/* OpenBTF shaders: one texel from all its parts (FORMAT.md section 9, "One texel").
 *
 * SPDX-License-Identifier: MIT
 */

/* What does not depend on the texel. */
struct btf_setting {
    btf_neighbours views, lights;
    int n;        /* neighbours in use: 1 or 3 */
    vec3 product; /* l * v, by component */
    float cosine; /* l.z, its root in the square-root domain */
};

btf_setting btf_prepare(vec3 l, vec3 v, bool nearest) {
    btf_setting s;
    s.views = btf_lookup(btf_view_table, BTF_VIEW_GRID, btf_project(v));
    s.lights = btf_lookup(btf_light_table, BTF_LIGHT_GRID, btf_project(l));
    s.n = 3;
    if (nearest) {
        s.views = btf_nearest(s.views);
        s.lights = btf_nearest(s.lights);
        s.n = 1;
    }
    s.product = btf_mul(l, v);
#if BTF_DOMAIN_SQRT
    s.cosine = btf_pow(l.z, 0.5);
#else
    s.cosine = l.z;
#endif
    return s;
}

float btf_clamp(float y) {
    return y >= uintBitsToFloat(0x30800000u) ? min(y, 4294967296.0) : 0.0;
}

/* Radiance, before radianceScale, of a source with a gain code. */
vec3 btf_source_radiance(uvec2 source, uint gain, uint view, btf_setting s) {
    vec3 y = vec3(0.0);
#if BTF_COLOUR != 2
    y = btf_lafortune(source, s.product);
#if BTF_SHADOW
    y = btf_mul(y, btf_shadow_factor(source, s.lights, s.n));
#endif
#endif
#if BTF_COMPONENTS > 0
#if BTF_COLOUR != 2
    y = btf_add(y, btf_residual(source, view, s.lights, s.n));
#else
    y = btf_residual(source, view, s.lights, s.n);
#endif
#endif
    y = btf_mul(y, s.cosine);
#if BTF_GAIN
#if BTF_CODE_ZERO
    if (gain != 0u)
        y = btf_mul(y, btf_mul(float(gain), BTF_GAIN_SCALE));
#else
    y = btf_mul(y, btf_mul(float(gain), BTF_GAIN_SCALE));
#endif
#endif
    y = vec3(btf_clamp(y.x), btf_clamp(y.y), btf_clamp(y.z));
#if BTF_DOMAIN_SQRT
    y = btf_mul(y, y);
#endif
    return y;
}

/* Radiance, before radianceScale, of texel x in one sampled view. */
vec3 btf_view_radiance(uvec2 x, uint view, btf_setting s) {
    uvec3 codes = btf_view_codes(x, view);
#if BTF_HIDDEN
    if (codes.x == 0u)
        return btf_centre_radiance(btf_centre_index(codes), s.lights, s.n);
#endif
    return btf_source_radiance(btf_source(x, codes), codes.x, view, s);
}

/* Radiance of texel x: the neighbouring views, blended. */
vec3 btf_texel(uvec2 x, btf_setting s) {
    vec3 sum = vec3(0.0);
    for (int a = 0; a < s.n; ++a) {
        uint w = s.views.weight[a];
        if (w > 0u) {
            float weight = btf_mul(float(w), uintBitsToFloat(0x39800000u));
            sum = btf_add(sum, btf_mul(btf_view_radiance(x, s.views.index[a], s), weight));
        }
    }
    return btf_mul(sum, BTF_RADIANCE_SCALE);
}
