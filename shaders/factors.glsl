/* OpenBTF shaders: the residual of a source as factors of 8, 4 or 2 bits (FORMAT.md sections 3 and 9). A unit is one
 * texel of 128 bits of w for a view and a light: four words of 4, 8 or 16 codes. u has as many codes for each texel.
 *
 * Codes of w are not unpacked: one integer product does the work of several. Words count as fields of 16 bits (8 in
 * class 4). Masked, a word of w has one code in each field; u, expanded once, has one signed level in each.
 * The top field of the product of two such words is the sum of the products of w's fields with u's in reverse
 * order, for which the file stores u reversed. Shifting w brings up its next codes; products of all shifts
 * are summed before the top field is taken out, which then is the dot product of codes of w and levels of u.
 *   - Levels of w are 2 code - most, not codes. So the sum starts at -most / 2 times the sum of u's levels, and
 *     the top field becomes half of the dot product: of 8 or 16 products of odd numbers, hence a whole number.
 *   - Levels are negative too, and a negative lower field takes 1 from the top one. Half a unit of the top field,
 *     added before it is shifted down, gives that back, as long as all lower fields are less than this half.
 *   - Bounds: half of the dot product of a word is at most 15300, 900, 360 and 72 in classes 1, 2, 3 and 4; the top
 *     field holds two words of class 1, four of 2 or 3, one of class 4. Lower fields come to at most 30600 of
 *     32768 and, in class 4, 0.85 of a half. Integers wrap at 2^32, which changes nothing in the top field.
 *
 * SPDX-License-Identifier: MIT
 */
#if BTF_FACTORS

/* Masks of one code of so many bits, and a one, in each field of so many; half a unit of the top field. */
#define BTF_CODES_2_IN_8 0x03030303u
#define BTF_CODES_2_IN_16 0x00030003u
#define BTF_CODES_4_IN_16 0x000F000Fu
#define BTF_CODES_8_IN_16 0x00FF00FFu
#define BTF_ONES_IN_8 0x01010101u
#define BTF_ONES_IN_16 0x00010001u
#define BTF_HALF_TOP_OF_8 0x00800000u
#define BTF_HALF_TOP_OF_16 0x8000u

/* Views that are evaluated at once, for which u is then fetched and expanded once. With a shift each has sources of its
 * own; with relief, too, but those of all three are known beforehand. A stochastic decode has one view. */
#if BTF_FACTORS_BY_VIEW
#define BTF_FACTOR_VIEWS 1
#else
#define BTF_FACTOR_VIEWS 3
#endif
#define BTF_FACTOR_SUMS (BTF_FACTOR_VIEWS * BTF_TEXELS)
#define BTF_FACTOR_GLOSS (BTF_GLOSS && !BTF_FACTORS_BY_VIEW)
#define BTF_FACTOR_RELIEF (BTF_RELIEF && !BTF_FACTORS_BY_VIEW)
#if BTF_FACTOR_RELIEF
#define BTF_FACTOR_SOURCES BTF_FACTOR_SUMS
#else
#define BTF_FACTOR_SOURCES BTF_TEXELS
#endif

/* Sources, with relief [view][texel], and the views and lights (1 to 3 each) under which they are seen. */
struct btf_factor_scene {
    uvec2 x[BTF_FACTOR_SOURCES];
    int level; /* of detail */
    uvec3 views;
    int n_views;
#if BTF_FACTOR_GLOSS
    btf_neighbours lights[3]; /* of each view */
#else
    btf_neighbours lights;
#endif
    int n;
};

/* u of a unit at a source: its levels for each shift of w, and where the sums of products start. */
struct btf_factor_levels {
    uvec4 q[8];
    uvec4 start;
};

int btf_factor_shifts(int c) {
    return c == 3 ? 8 : 4;
}

/* The codes of w that shift s brings up, one in each field; in class 0 a signed byte, for u as well. */
uvec4 btf_factor_codes(int c, uvec4 w, int s) {
    if (c == 0)
        return uvec4(ivec4(w << uint(24 - 8 * s)) >> 24);
    int bits = c < 3 ? 4 : 2;
    return (w >> uint(bits * s)) & (c == 4 ? BTF_CODES_2_IN_8 : (c == 3 ? BTF_CODES_2_IN_16 : BTF_CODES_4_IN_16));
}

/* u of a unit of class c, whose first layer is given, at source x. */
btf_factor_levels btf_factor_expand(int c, bool whole, uvec2 x, int layer, int level) {
    btf_factor_levels u;
    uvec4 texel = texelFetch(btf_factor_texels, ivec3(ivec2(x), layer), level), next = texel;
    if (c == 1 || c == 3)
        next = texelFetch(btf_factor_texels, ivec3(ivec2(x), layer + 1), level);
    uint mask = c == 1 ? BTF_CODES_8_IN_16 : (c == 4 ? BTF_CODES_2_IN_8 : BTF_CODES_4_IN_16);
    int bits = c == 1 ? 8 : (c == 4 ? 2 : 4), of_texel = c == 1 ? 2 : 4;
    uvec4 sum = uvec4(0u);
    for (int s = 0; s < btf_factor_shifts(c); ++s) {
        uvec4 from = s < of_texel ? texel : next;
        uvec4 codes = (from >> uint(bits * (s % of_texel))) & mask;
        u.q[s] = c == 0 ? btf_factor_codes(0, texel, s) : codes * 2u - mask;
        sum += u.q[s];
    }
    if (whole && c != 4) {
        sum.xy += sum.zw;
        if (c != 1)
            sum.x += sum.y;
    }
    /* The product with ones in all fields has the sum of levels in its top field: an even number. */
    if (c == 0)
        u.start = uvec4(0u);
    else if (c == 4)
        u.start = (uvec4((ivec4(sum * BTF_ONES_IN_8 + BTF_HALF_TOP_OF_8) >> 25) * -3) << 24u) + BTF_HALF_TOP_OF_8;
    else
        u.start = (uvec4((ivec4(sum * BTF_ONES_IN_16 + BTF_HALF_TOP_OF_16) >> 17) * (c == 3 ? -3 : -15)) << 16u) +
                  BTF_HALF_TOP_OF_16;
    return u;
}

/* Half of the dot product of each word from its sum t of products; in class 0 all of it. */
ivec4 btf_factor_words(int c, uvec4 t, uvec4 start) {
    return ivec4(t + start) >> (c == 0 ? 0 : (c == 4 ? 24 : 16));
}

/* Half of the dot product of a whole unit. */
int btf_factor_unit(int c, uvec4 t, uvec4 start) {
    if (c == 4) {
        ivec4 words = btf_factor_words(c, t, start);
        return (words.x + words.y) + (words.z + words.w);
    }
    uvec2 pair = t.xy + t.zw;
    if (c == 1) {
        ivec2 pairs = ivec2(pair + start.xy) >> 16;
        return pairs.x + pairs.y;
    }
    return int((pair.x + pair.y) + start.x) >> 16;
}

/* A unit, whole or mixed, of class c for a view: the half dot products (in x where it is whole), summed over lights.
 * Of w all fetches come first, to be under way together, and each code is brought up once for all texels. */
void btf_factor_lights(out ivec4 e[BTF_TEXELS], int c, bool whole, int unit, btf_factor_levels u[BTF_TEXELS], uint view,
                       btf_neighbours lights, int n) {
    uvec4 w[3], t[BTF_TEXELS];
    for (int b = 0; b < n; ++b)
        w[b] = texelFetch(btf_factor_directions, ivec3(int(lights.index[b]), int(view), unit), 0);
    for (int i = 0; i < BTF_TEXELS; ++i)
        e[i] = ivec4(0);
    for (int b = 0; b < n; ++b) {
        int weight = int(lights.weight[b]);
        for (int i = 0; i < BTF_TEXELS; ++i)
            t[i] = uvec4(0u);
        for (int s = 0; s < btf_factor_shifts(c); ++s) {
            uvec4 codes = btf_factor_codes(c, w[b], s);
            for (int i = 0; i < BTF_TEXELS; ++i)
                t[i] += codes * u[i].q[s];
        }
        for (int i = 0; i < BTF_TEXELS; ++i)
            if (whole)
                e[i].x += weight * btf_factor_unit(c, t[i], u[i].start);
            else
                e[i] += weight * btf_factor_words(c, t[i], u[i].start);
    }
}

/* Turns the sums of n views by one, so that the next view's are the first. */
void btf_factor_turn(inout vec3 p[BTF_FACTOR_SUMS], int n) {
#if !BTF_FACTORS_BY_VIEW
    for (int i = 0; i < BTF_TEXELS; ++i) {
        vec3 first = p[i], second = p[BTF_TEXELS + i];
        if (n > 1)
            p[i] = second;
        if (n > 2) {
            p[BTF_TEXELS + i] = p[2 * BTF_TEXELS + i];
            p[2 * BTF_TEXELS + i] = first;
        } else if (n > 1)
            p[BTF_TEXELS + i] = first;
    }
#endif
}

/* Adds units of class c, whole or mixed ones, to the sums p (Y, C1, C2) of their tier, [view][texel]. Words before c1
 * are of C1, those from there to before c2 of C2. first is (first unit, first layer of u), afterwards those of what
 * follows.
 * The loops over units and views are meant to stay loops, as copies of their body take a compiler seconds. So views take
 * turns at the first places of p, as an index that varies would put p into memory, and a zero that no compiler knows
 * (weights are at most 4096) is added to their number. They test at their end: a rasteriser on a CPU runs a body once
 * more, masked, where the test is in front. */
void btf_factor_units(inout vec3 p[BTF_FACTOR_SUMS], inout ivec2 first, int c, bool whole, int units, int c1, int c2,
                      btf_factor_scene at) {
    if (units == 0)
        return;
    /* FORMAT.md shifts whole dot products by 4, 5, 1, 0 and 0: these are halves, but in class 0. */
    int shift = c < 2 ? 4 : 0, g = 0;
#if BTF_FACTOR_GLOSS
    btf_neighbours lights = at.lights[0];
#else
    btf_neighbours lights = at.lights;
#endif
    int n_views = BTF_FACTOR_VIEWS > 1 ? at.n_views + int(lights.weight.x >> 13u) : 1;
    float power = uintBitsToFloat(c == 0 ? BTF_BITS_2_TO_MINUS_8
                                         : (c == 1 ? BTF_BITS_2_TO_MINUS_7 : BTF_BITS_2_TO_MINUS_11));
    btf_factor_levels u[BTF_TEXELS];
    ivec4 e[BTF_TEXELS];
    do {
        vec4 scale = btf_mul(texelFetch(btf_factor_scales, ivec2(first.x, 0), 0), power);
#if !BTF_FACTOR_RELIEF
        for (int i = 0; i < BTF_TEXELS; ++i)
            u[i] = btf_factor_expand(c, whole, at.x[i], first.y, at.level);
#endif
        uvec3 views = at.views;
        int a = 0;
        do {
#if BTF_FACTOR_RELIEF
            for (int i = 0; i < BTF_TEXELS; ++i)
                u[i] = btf_factor_expand(
                    c, whole, a == 0 ? at.x[i] : (a == 1 ? at.x[BTF_TEXELS + i] : at.x[2 * BTF_TEXELS + i]), first.y,
                    at.level);
#endif
#if BTF_FACTOR_GLOSS
            lights = at.lights[0];
            if (a == 1)
                lights = at.lights[1];
            if (a == 2)
                lights = at.lights[2];
#endif
            btf_factor_lights(e, c, whole, first.x, u, views.x, lights, at.n);
            for (int i = 0; i < BTF_TEXELS; ++i) {
                vec4 y = btf_mul(vec4(e[i] >> shift), scale);
                if (whole)
                    p[i].x = btf_add(p[i].x, y.x);
                else
                    for (int k = 0; k < 4; ++k) {
                        int word = 4 * g + k;
                        vec3 term = word < c1 ? vec3(0.0, y[k], 0.0) : vec3(0.0, 0.0, y[k]);
                        if (word >= c2)
                            term = vec3(y[k], 0.0, 0.0);
                        p[i] = btf_add(p[i], term);
                    }
            }
            btf_factor_turn(p, at.n_views);
            views = views.yzx;
        } while (++a < n_views);
        first += ivec2(1, c == 1 || c == 3 ? 2 : 1);
    } while (++g < units);
}

/* A class: its mixed units, then its whole ones. */
void btf_factor_class(inout vec3 p[BTF_FACTOR_SUMS], inout ivec2 first, int c, int mixed, int whole, int c1, int c2,
                      btf_factor_scene at) {
    btf_factor_units(p, first, c, false, mixed, c1, c2, at);
    btf_factor_units(p, first, c, true, whole, c1, c2, at);
}

/* Adds the sums p of a tier, times the factors of their view, to r, and empties them. */
void btf_factor_tier(inout vec3 r[BTF_FACTOR_SUMS], inout vec3 p[BTF_FACTOR_SUMS], int tier, btf_factor_scene at) {
    for (int a = 0; a < at.n_views; ++a) {
        vec3 factor = texelFetch(btf_factor_views, ivec2(tier, int(at.views[a])), 0).xyz;
        for (int i = 0; i < BTF_TEXELS; ++i) {
            r[a * BTF_TEXELS + i] = btf_add(r[a * BTF_TEXELS + i], btf_mul(p[a * BTF_TEXELS + i], factor));
            p[a * BTF_TEXELS + i] = vec3(0.0);
        }
    }
}

/* The residual of each source in each view, [view][texel]. */
void btf_factors(out vec3 r[BTF_FACTOR_SUMS], btf_factor_scene at) {
    vec3 p[BTF_FACTOR_SUMS];
    for (int i = 0; i < BTF_FACTOR_SUMS; ++i)
        r[i] = p[i] = vec3(0.0);
    ivec2 first = ivec2(0);
    /* n units of class c, the first m of them word by word. */
#define BTF_FACTOR_CLASS(c, n, m, c1, c2) btf_factor_class(p, first, c, m, n - (m), c1, c1 + c2, at)
#if BTF_FACTOR_UNITS_0 > 0
    BTF_FACTOR_CLASS(0, BTF_FACTOR_UNITS_0, BTF_FACTOR_UNITS_0, BTF_FACTOR_C1_0, BTF_FACTOR_C2_0);
    btf_factor_tier(r, p, 0, at);
#endif
#if BTF_FACTOR_UNITS_1 > 0
    BTF_FACTOR_CLASS(1, BTF_FACTOR_UNITS_1, (BTF_FACTOR_C1_1 + BTF_FACTOR_C2_1 + 3) / 4, BTF_FACTOR_C1_1,
                     BTF_FACTOR_C2_1);
#endif
#if BTF_FACTOR_UNITS_2 > 0
    BTF_FACTOR_CLASS(2, BTF_FACTOR_UNITS_2, (BTF_FACTOR_C1_2 + BTF_FACTOR_C2_2 + 3) / 4, BTF_FACTOR_C1_2,
                     BTF_FACTOR_C2_2);
#endif
#if BTF_FACTOR_UNITS_1 + BTF_FACTOR_UNITS_2 > 0
    btf_factor_tier(r, p, 1, at);
#endif
#if BTF_FACTOR_UNITS_3 > 0
    BTF_FACTOR_CLASS(3, BTF_FACTOR_UNITS_3, (BTF_FACTOR_C1_3 + BTF_FACTOR_C2_3 + 3) / 4, BTF_FACTOR_C1_3,
                     BTF_FACTOR_C2_3);
#endif
#if BTF_FACTOR_UNITS_4 > 0
    BTF_FACTOR_CLASS(4, BTF_FACTOR_UNITS_4, (BTF_FACTOR_C1_4 + BTF_FACTOR_C2_4 + 3) / 4, BTF_FACTOR_C1_4,
                     BTF_FACTOR_C2_4);
#endif
#if BTF_FACTOR_UNITS_3 + BTF_FACTOR_UNITS_4 > 0
    btf_factor_tier(r, p, 2, at);
#endif
    for (int i = 0; i < BTF_FACTOR_SUMS; ++i) {
        float y = r[i].x, c1 = r[i].y, c2 = r[i].z;
        r[i] = vec3(btf_add(btf_add(y, c1), c2), btf_add(y, -btf_add(c2, c2)), btf_add(btf_add(y, -c1), c2));
    }
}

#endif
