/* OpenBTF shaders: directions to the light in proportion to what the material reflects, and their density (SAMPLING.md).
 *
 * SPDX-License-Identifier: MIT
 */
#if BTF_SAMPLING

#define BTF_BITS_1_OVER_PI 0x3EA2F983u
/* Taylor: sin(pi s / 2) = s (SINE_0 + SINE_1 s^2 + ...), cos(pi s / 2) = 1 + COSINE_1 s^2 + ... for -1/2 <= s <= 1/2. */
#define BTF_SINE_0 0x3FC90FDBu
#define BTF_SINE_1 0xBF255DE7u
#define BTF_SINE_2 0x3DA335E3u
#define BTF_SINE_3 0xBB996966u
#define BTF_SINE_4 0x39283C1Au
#define BTF_COSINE_1 0xBF9DE9E6u
#define BTF_COSINE_2 0x3E81E0F8u
#define BTF_COSINE_3 0xBCAAE9E4u
#define BTF_COSINE_4 0x3A70FA83u

/* 24 bits of a random number, 0 <= x < 1. */
float btf_unit(uint random) {
    return btf_mul(float(random >> 8u), uintBitsToFloat(BTF_BITS_2_TO_MINUS_24));
}

/* A third number, hashed from the two given, with the constants of PCG (M. O'Neill, 2014). */
uint btf_third_number(uint u1, uint u2) {
    uint h = u1 * 747796405u + u2 * 2891336453u + 277803737u;
    h = (h >> 16u ^ h) * 277803737u;
    return h >> 15u ^ h;
}

/* part / whole of 0 <= part < whole, below 1; a whole of 0 stands for 2^32. */
float btf_share(uint part, uint whole) {
    if (whole == 0u)
        return btf_unit(part);
    uint drop = 0u;
    while (whole >> drop >= 16777216u)
        ++drop;
    float p = float(part >> drop), w = float(whole >> drop);
    float down = uintBitsToFloat((254u - (floatBitsToUint(w) >> 23u)) << 23u);
    float share = btf_mul(btf_mul(p, down), btf_reciprocal(btf_mul(w, down)));
    return min(share, uintBitsToFloat(BTF_BITS_BEFORE_1));
}

/* A direction whose density is its cosine over pi: a point of the disc, lifted (N. Malley's method). */
vec3 btf_cosine_direction(float u1, float u2) {
    float quarters = btf_mul(u2, 4.0);
    int quarter = int(quarters);
    float s = btf_add(btf_add(quarters, -float(quarter)), -0.5);
    float square = btf_mul(s, s);
    float p = uintBitsToFloat(BTF_SINE_4), q = uintBitsToFloat(BTF_COSINE_4);
    p = btf_add(btf_mul(p, square), uintBitsToFloat(BTF_SINE_3));
    p = btf_add(btf_mul(p, square), uintBitsToFloat(BTF_SINE_2));
    p = btf_add(btf_mul(p, square), uintBitsToFloat(BTF_SINE_1));
    p = btf_add(btf_mul(p, square), uintBitsToFloat(BTF_SINE_0));
    q = btf_add(btf_mul(q, square), uintBitsToFloat(BTF_COSINE_3));
    q = btf_add(btf_mul(q, square), uintBitsToFloat(BTF_COSINE_2));
    q = btf_add(btf_mul(q, square), uintBitsToFloat(BTF_COSINE_1));
    q = btf_add(btf_mul(q, square), 1.0);
    float sine = btf_mul(s, p), cosine = q;
    float radius = btf_pow(u1, 0.5), height = btf_pow(btf_add(1.0, -u1), 0.5);
    float x = quarter == 0 ? cosine : (quarter == 1 ? -sine : (quarter == 2 ? -cosine : sine));
    float y = quarter == 0 ? sine : (quarter == 1 ? cosine : (quarter == 2 ? -sine : -cosine));
    return vec3(btf_mul(radius, x), btf_mul(radius, y), height);
}

/* l.x a.x + l.y a.y + l.z a.z */
float btf_weighted(vec3 l, vec3 a) {
    vec3 p = btf_mul(l, a);
    return btf_add(btf_add(p.x, p.y), p.z);
}

/* Barycentric coordinates whose density is linear, in proportion to d at the corners: of a point that is spread evenly
 * over the triangle, one of the three turns, chosen by its density. */
vec3 btf_barycentric(float u1, float u2, float u3, vec3 d) {
    if (btf_add(u1, u2) > 1.0) {
        u1 = btf_add(1.0, -u1);
        u2 = btf_add(1.0, -u2);
    }
    vec3 l = vec3(btf_add(btf_add(1.0, -u1), -u2), u1, u2);
    float height = btf_mul(u3, btf_add(btf_add(d.x, d.y), d.z));
    float unturned = btf_weighted(l, d);
    float once = btf_add(unturned, btf_weighted(l.yzx, d));
    return height < unturned ? l : (height < once ? l.yzx : l.zxy);
}

/* The end of a triangle's part of 2^32. */
uint btf_part_end(int triangle, int view) {
    return texelFetch(btf_sampling_triangles, ivec2(triangle, view), 0).x;
}

int btf_nearest_view(vec3 v) {
    return int(btf_nearest(btf_lookup(btf_view_table, BTF_VIEW_GRID, btf_project(v))).index.x);
}

/* The density over the solid angle with which btf_sample_light draws l; 0 where l or v are below the horizon. */
float btf_pdf_light(vec2 uv, vec3 v, vec3 l) {
    if (!btf_is_above(l) || !btf_is_above(v))
        return 0.0;
    int view = btf_nearest_view(v);
    btf_neighbours n = btf_lookup(btf_light_table, BTF_LIGHT_GRID, btf_project(l));
    float density = 0.0;
    if (n.index.x != n.index.z) {
        vec3 d = vec3(texelFetch(btf_sampling_densities, ivec2(int(n.index.x), view), 0).x,
                      texelFetch(btf_sampling_densities, ivec2(int(n.index.y), view), 0).x,
                      texelFetch(btf_sampling_densities, ivec2(int(n.index.z), view), 0).x);
        vec3 weights = vec3(btf_add(float(n.weight.x), 0.5), btf_add(float(n.weight.y), 0.5),
                            btf_add(float(n.weight.z), -1.0));
        density = max(btf_mul(btf_weighted(weights, d), uintBitsToFloat(BTF_BITS_2_TO_MINUS_12)), 0.0);
    }
    float z = min(l.z, 1.0);
    float k = btf_reciprocal(btf_add(z, 1.0));
    density = btf_mul(btf_mul(density, k), k);
    float even = texelFetch(btf_sampling_densities, ivec2(int(BTF_N_LIGHTS), view), 0).x;
    return btf_add(density, btf_mul(btf_mul(even, z), uintBitsToFloat(BTF_BITS_1_OVER_PI)));
}

/* A direction to the light, drawn in proportion to what the material reflects to v, from two numbers of 32 random bits,
 * and its density over the solid angle. uv has no influence so far. A view below the horizon gets the normal and 0. */
vec3 btf_sample_light(vec2 uv, vec3 v, uint u1, uint u2, out float pdf) {
    pdf = 0.0;
    vec3 l = vec3(0.0, 0.0, 1.0);
    if (!btf_is_above(v))
        return l;
    int view = btf_nearest_view(v);
    ivec2 size = textureSize(btf_sampling_triangles, 0);
    uint end = btf_part_end(size.x - 1, view);
    if (u1 >= end) {
        l = btf_cosine_direction(btf_share(u1 - end, 0u - end), btf_unit(u2));
    } else {
        int low = 0, high = size.x - 1;
        while (low < high) {
            int middle = (low + high) / 2;
            if (u1 < btf_part_end(middle, view))
                high = middle;
            else
                low = middle + 1;
        }
        uint begin = low > 0 ? btf_part_end(low - 1, view) : 0u;
        uvec4 row = texelFetch(btf_sampling_triangles, ivec2(low, view), 0);
        uvec3 corners = texelFetch(btf_sampling_triangles, ivec2(low, size.y - 1), 0).xyz;
        vec3 b = btf_barycentric(btf_share(u1 - begin, row.x - begin), btf_unit(u2),
                                 btf_unit(btf_third_number(u1, u2)), uintBitsToFloat(row.yzw));
        float x = btf_mul(btf_add(btf_weighted(b, vec3(corners & 65535u)), -8192.0), uintBitsToFloat(BTF_BITS_2_TO_MINUS_13));
        float y = btf_mul(btf_add(btf_weighted(b, vec3(corners >> 16u)), -8192.0), uintBitsToFloat(BTF_BITS_2_TO_MINUS_13));
        float rr = btf_add(btf_mul(x, x), btf_mul(y, y));
        float k = btf_reciprocal(btf_add(1.0, rr));
        float twice = btf_add(k, k);
        l = vec3(btf_mul(x, twice), btf_mul(y, twice),
                 max(btf_mul(btf_add(1.0, -rr), k), uintBitsToFloat(BTF_BITS_2_TO_MINUS_20)));
    }
    pdf = btf_pdf_light(uv, v, l);
    return l;
}

#endif
