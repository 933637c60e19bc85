/* OpenBTF shaders: a source as low-bit factors (FORMAT.md sections 3 and 9). A unit of w is one texel of 128 bits
 * for a view and a light; each of its four words holds 4 to 16 codes, and u has as many for the texel.
 *
 * The dot product of the codes of w and u is taken without unpacking w. A field is 16 bits of a word (8 bits in
 * class 4). With w masked to one code a field, and u expanded once a pixel to one signed level a field, the
 * integer product of the two words has in its top field the sum of the products of w's fields with u's fields
 * in reverse order. The file stores u reversed, so that this is the dot product; the products of all
 * shifts add up before the top field is taken out with one shift.
 *   - Codes of w are 0 .. max where their levels are 2 code - max. The sum starts with -max/2 times the sum of
 *     the levels of u, which makes it half of the dot product, a whole number: a word has 8 or 16 components, all
 *     of odd levels.
 *   - Lower fields may be negative and then borrow 1 from the top one: half a field is added before the shift.
 *   - Bounds. Half a dot product of a word is at most 15300, 900, 360 and 72 in the classes 1 to 4. 16 bits hold two
 *     words of class 1 and all four of the classes 2 and 3, 8 bits hold one word of class 4; what lies below the
 *     top field is smaller than half of it: at most 30600 of 32768, 7.1 of 8.4 million in class 4. All of it
 *     is exact modulo 2^32.
 *
 * SPDX-License-Identifier: MIT
 */
#if BTF_FACTORS

/* Without shift all views see the same texel, whose u is then expanded once for all of them. */
#if BTF_SHIFT
#define BTF_FACTOR_VIEWS 1
#else
#define BTF_FACTOR_VIEWS 3
#endif
#define BTF_FACTOR_SUMS (BTF_FACTOR_VIEWS * BTF_TEXELS)

/* Where and under which directions factors are evaluated. */
struct btf_factor_place {
    uvec2 x[BTF_TEXELS];
    int level;
    uvec3 views;
    int n_views;
    btf_neighbours lights;
    int n;
};

/* u of a unit for a texel: levels in fields for each shift of w, and the sum of a word before its products. */
struct btf_factor_u {
    uvec4 q[8];
    uvec4 start;
};

/* One code a field becomes its signed level, 2 code - max; the mask is max in each field. */
uvec4 btf_factor_levels(uvec4 u, int shift, uint mask) {
    return ((u >> uint(shift)) & mask) * 2u - mask;
}

uvec4 btf_factor_fetch(uvec2 x, int layer, int level) {
    return texelFetch(btf_factor_texels, ivec3(ivec2(x), layer), level);
}

/* u of the unit of class c whose first layer is given. */
btf_factor_u btf_factor_expand(int c, uvec2 x, int layer, int level) {
    btf_factor_u u;
    uvec4 t = btf_factor_fetch(x, layer, level);
    if (c == 0) {
        u.q[0] = t;
        return u;
    }
    uvec4 sum = uvec4(0u);
    int steps = c == 3 ? 8 : 4;
    for (int s = 0; s < steps; ++s) {
        if (c == 1)
            u.q[s] = btf_factor_levels(s == 2 ? t = btf_factor_fetch(x, layer + 1, level) : t, 8 * (s & 1), 0x00FF00FFu);
        if (c == 2 || c == 3)
            u.q[s] = btf_factor_levels(s == 4 ? t = btf_factor_fetch(x, layer + 1, level) : t, 4 * (s & 3), 0x000F000Fu);
        if (c == 4)
            u.q[s] = btf_factor_levels(t, 2 * s, 0x03030303u);
        sum += u.q[s];
    }
    if (c == 4)
        u.start = uvec4((ivec4(sum * 0x01010101u + 0x00800000u) >> 25) * -3) << 24u;
    else
        u.start = uvec4((ivec4(sum * 0x00010001u + 0x8000u) >> 17) * (c == 3 ? -3 : -15)) << 16u;
    return u;
}

/* The products of the four words, summed over shifts. */
uvec4 btf_factor_products(int c, uvec4 w, btf_factor_u u) {
    uint mask = c == 4 ? 0x03030303u : c == 3 ? 0x00030003u : 0x000F000Fu;
    uint step = c < 3 ? 4u : 2u;
    uvec4 t = (w & mask) * u.q[0];
    t += ((w >> step) & mask) * u.q[1];
    t += ((w >> (2u * step)) & mask) * u.q[2];
    t += ((w >> (3u * step)) & mask) * u.q[3];
    if (c == 3) {
        t += ((w >> 8u) & mask) * u.q[4];
        t += ((w >> 10u) & mask) * u.q[5];
        t += ((w >> 12u) & mask) * u.q[6];
        t += ((w >> 14u) & mask) * u.q[7];
    }
    return t;
}

/* Half of the dot product of each word, all of it in class 0. */
ivec4 btf_factor_words(int c, uvec4 w, btf_factor_u u) {
    if (c == 0) {
        ivec4 v = ivec4(w), t = ivec4(u.q[0]);
        return (v >> 24) * (t >> 24) + ((v << 8) >> 24) * ((t << 8) >> 24) +
               ((v << 16) >> 24) * ((t << 16) >> 24) + ((v << 24) >> 24) * ((t << 24) >> 24);
    }
    uvec4 t = btf_factor_products(c, w, u) + u.start;
    if (c == 4)
        return ivec4(t + 0x00800000u) >> 24;
    return ivec4(t + 0x8000u) >> 16;
}

/* Half of the dot product of a unit. */
int btf_factor_whole(int c, uvec4 w, btf_factor_u u) {
    if (c == 4) {
        ivec4 d = btf_factor_words(c, w, u);
        return d.x + d.y + d.z + d.w;
    }
    uvec4 t = btf_factor_products(c, w, u) + u.start;
    uvec2 two = t.xy + t.zw;
    if (c == 1) {
        ivec2 d = ivec2(two + 0x8000u) >> 16;
        return d.x + d.y;
    }
    return int(two.x + two.y + 0x8000u) >> 16;
}

/* w of a unit for all views and lights, fetched before any is used. */
void btf_factor_directions_of(out uvec4 w[3 * BTF_FACTOR_VIEWS], int unit, btf_factor_place at) {
    for (int a = 0; a < at.n_views; ++a)
        for (int b = 0; b < at.n; ++b)
            w[3 * a + b] = texelFetch(btf_factor_directions, ivec3(int(at.lights.index[b]), int(at.views[a]), unit), 0);
}

/* Adds the units of class c, whose first unit and first layer of u are given, to the sums (Y, C1, C2) of their
 * tier, [view][texel]. The first `mixed` are evaluated word by word. */
void btf_factor_class(inout vec3 p[BTF_FACTOR_SUMS], int c, int unit, int layer, int units, int mixed, int c1,
                      int c12, btf_factor_place at) {
    int layers = c == 1 || c == 3 ? 2 : 1;
    int shift = c == 0 || c == 1 ? 4 : 0;
    float unit_scale = uintBitsToFloat(c == 0 ? 0x3B800000u : c == 1 ? 0x3C000000u : 0x3A000000u);
    uvec4 w[3 * BTF_FACTOR_VIEWS];
    for (int g = 0; g < mixed; ++g) {
        btf_factor_directions_of(w, unit + g, at);
        vec4 scale = btf_mul(texelFetch(btf_factor_scales, ivec2(unit + g, 0), 0), unit_scale);
        for (int i = 0; i < BTF_TEXELS; ++i) {
            btf_factor_u u = btf_factor_expand(c, at.x[i], layer + layers * g, at.level);
            for (int a = 0; a < at.n_views; ++a) {
                ivec4 e = ivec4(0);
                for (int b = 0; b < at.n; ++b)
                    e += int(at.lights.weight[b]) * btf_factor_words(c, w[3 * a + b], u);
                vec4 y = btf_mul(vec4(e >> shift), scale);
                for (int k = 0; k < 4; ++k) {
                    vec3 word = 4 * g + k >= c12 ? vec3(y[k], 0.0, 0.0)
                                : 4 * g + k < c1 ? vec3(0.0, y[k], 0.0)
                                                 : vec3(0.0, 0.0, y[k]);
                    p[a * BTF_TEXELS + i] = btf_add(p[a * BTF_TEXELS + i], word);
                }
            }
        }
    }
    for (int g = mixed; g < units; ++g) {
        btf_factor_directions_of(w, unit + g, at);
        float scale = btf_mul(texelFetch(btf_factor_scales, ivec2(unit + g, 0), 0).x, unit_scale);
        for (int i = 0; i < BTF_TEXELS; ++i) {
            btf_factor_u u = btf_factor_expand(c, at.x[i], layer + layers * g, at.level);
            for (int a = 0; a < at.n_views; ++a) {
                int e = 0;
                for (int b = 0; b < at.n; ++b)
                    e += int(at.lights.weight[b]) * btf_factor_whole(c, w[3 * a + b], u);
                p[a * BTF_TEXELS + i].x = btf_add(p[a * BTF_TEXELS + i].x, btf_mul(float(e >> shift), scale));
            }
        }
    }
}

/* Adds a tier's sums, times the factors of their view, to the channels; empties them for the next tier. */
void btf_factor_tier(inout vec3 channels[BTF_FACTOR_SUMS], inout vec3 p[BTF_FACTOR_SUMS], int tier, btf_factor_place at) {
    for (int a = 0; a < at.n_views; ++a) {
        vec3 scale = texelFetch(btf_factor_views, ivec2(tier, int(at.views[a])), 0).xyz;
        for (int i = a * BTF_TEXELS; i < (a + 1) * BTF_TEXELS; ++i) {
            channels[i] = btf_add(channels[i], btf_mul(p[i], scale));
            p[i] = vec3(0.0);
        }
    }
}

#define BTF_MIXED(c1, c2, units) min((c1 + c2 + 3) / 4, units)

/* The residual of each view and texel, [view][texel]. */
void btf_factors(out vec3 r[BTF_FACTOR_SUMS], btf_factor_place at) {
    vec3 p[BTF_FACTOR_SUMS];
    for (int i = 0; i < BTF_FACTOR_SUMS; ++i)
        r[i] = p[i] = vec3(0.0);
    const int u1 = BTF_FACTOR_UNITS_0, u2 = u1 + BTF_FACTOR_UNITS_1, u3 = u2 + BTF_FACTOR_UNITS_2, u4 = u3 + BTF_FACTOR_UNITS_3;
    const int l1 = BTF_FACTOR_UNITS_0, l2 = l1 + 2 * BTF_FACTOR_UNITS_1, l3 = l2 + BTF_FACTOR_UNITS_2, l4 = l3 + 2 * BTF_FACTOR_UNITS_3;
#if BTF_FACTOR_UNITS_0 > 0
    btf_factor_class(p, 0, 0, 0, BTF_FACTOR_UNITS_0, BTF_FACTOR_UNITS_0, BTF_FACTOR_C1_0, BTF_FACTOR_C1_0 + BTF_FACTOR_C2_0, at);
    btf_factor_tier(r, p, 0, at);
#endif
#if BTF_FACTOR_UNITS_1 > 0
    btf_factor_class(p, 1, u1, l1, BTF_FACTOR_UNITS_1, BTF_MIXED(BTF_FACTOR_C1_1, BTF_FACTOR_C2_1, BTF_FACTOR_UNITS_1), BTF_FACTOR_C1_1, BTF_FACTOR_C1_1 + BTF_FACTOR_C2_1, at);
#endif
#if BTF_FACTOR_UNITS_2 > 0
    btf_factor_class(p, 2, u2, l2, BTF_FACTOR_UNITS_2, BTF_MIXED(BTF_FACTOR_C1_2, BTF_FACTOR_C2_2, BTF_FACTOR_UNITS_2), BTF_FACTOR_C1_2, BTF_FACTOR_C1_2 + BTF_FACTOR_C2_2, at);
#endif
#if BTF_FACTOR_UNITS_1 + BTF_FACTOR_UNITS_2 > 0
    btf_factor_tier(r, p, 1, at);
#endif
#if BTF_FACTOR_UNITS_3 > 0
    btf_factor_class(p, 3, u3, l3, BTF_FACTOR_UNITS_3, BTF_MIXED(BTF_FACTOR_C1_3, BTF_FACTOR_C2_3, BTF_FACTOR_UNITS_3), BTF_FACTOR_C1_3, BTF_FACTOR_C1_3 + BTF_FACTOR_C2_3, at);
#endif
#if BTF_FACTOR_UNITS_4 > 0
    btf_factor_class(p, 4, u4, l4, BTF_FACTOR_UNITS_4, BTF_MIXED(BTF_FACTOR_C1_4, BTF_FACTOR_C2_4, BTF_FACTOR_UNITS_4), BTF_FACTOR_C1_4, BTF_FACTOR_C1_4 + BTF_FACTOR_C2_4, at);
#endif
#if BTF_FACTOR_UNITS_3 + BTF_FACTOR_UNITS_4 > 0
    btf_factor_tier(r, p, 2, at);
#endif
    for (int i = 0; i < BTF_FACTOR_SUMS; ++i)
        r[i] = vec3(btf_add(btf_add(r[i].x, r[i].y), r[i].z), btf_add(r[i].x, -btf_add(r[i].z, r[i].z)),
                    btf_add(btf_add(r[i].x, -r[i].y), r[i].z));
}

#endif
