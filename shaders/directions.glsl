/* OpenBTF shaders: the three sampled directions around a direction, and their integer weights (FORMAT.md
 * section 6).
 *
 * SPDX-License-Identifier: MIT
 */
struct btf_neighbours {
    uvec3 index;
    uvec3 weight; /* they sum to 4096 */
};

/* k d.xy in the plane of the triangulation: 0..16384 each. */
ivec2 btf_plane(vec3 d, float k) {
    float x = floor(btf_add(btf_mul(btf_mul(d.x, k), 8192.0), 0.5));
    float y = floor(btf_add(btf_mul(btf_mul(d.y, k), 8192.0), 0.5));
    return ivec2(min(max(vec2(x, y), -8192.0), 8192.0)) + 8192;
}

/* A unit vector above the horizon in the plane of the triangulation. */
ivec2 btf_project(vec3 d) {
    return btf_plane(d, btf_reciprocal(btf_add(d.z, 1.0)));
}

int btf_cross(ivec2 p, ivec2 q) {
    return p.x * q.y - p.y * q.x;
}

int btf_dot(ivec2 p, ivec2 q) {
    return p.x * q.x + p.y * q.y;
}

/* Texel i of a direction table. */
uvec4 btf_table(highp usampler2D table, uint i) {
    return texelFetch(table, ivec2(int(i & 255u), int(i >> 8u)), 0);
}

/* part / whole in 4096ths; both lose the same low bits, so that the product fits 31 bits. */
uint btf_fraction(int part, int whole, int drop) {
    return btf_divide(uint(part >> drop) << 12u, uint(whole >> drop));
}

/* Records are tried in the order of the cell; the first that accepts gives the answer. Its third texel, the
 * indices of a and b, is fetched for that one alone. */
btf_neighbours btf_lookup(highp usampler2D table, uint grid, ivec2 q) {
    btf_neighbours r = btf_neighbours(uvec3(0u), uvec3(4096u, 0u, 0u));
    uvec2 at = (uvec2(min(q, 16383)) * grid) >> 14u;
    uvec4 cell = btf_table(table, at.y * grid + at.x);
    uint record = grid * grid + 3u * cell.x;
    for (uint i = 0u; i < cell.y; ++i, record += 3u) {
        uvec4 ab = btf_table(table, record);
        uvec4 more = btf_table(table, record + 1u);
        ivec2 a = ivec2(ab.xy), b = ivec2(ab.zw), c = ivec2(more.xy);
        bool edge = (more.w & 1u) != 0u;
        int drop = int(more.w >> 1u);
        if (!edge) {
            int e0 = btf_cross(b - q, c - q), e1 = btf_cross(c - q, a - q), e2 = btf_cross(a - q, b - q);
            if (min(e0, min(e1, e2)) >= 0) {
                int area = btf_cross(b - a, c - a);
                uint w0 = btf_fraction(e0, area, drop), w1 = btf_fraction(e1, area, drop);
                r = btf_neighbours(uvec3(btf_table(table, record + 2u).xy, more.z),
                                   uvec3(w0, w1, 4096u - w0 - w1));
                break;
            }
        } else {
            int t = btf_dot(q - a, b - a), n = btf_dot(b - a, b - a);
            if (t >= 0 && t <= n && btf_cross(b - a, q - a) <= 0) {
                uint w1 = btf_fraction(t, n, drop);
                r = btf_neighbours(btf_table(table, record + 2u).xyx, uvec3(4096u - w1, w1, 0u));
                break;
            }
            if (t >= n && btf_dot(q - b, c - b) <= 0) {
                r = btf_neighbours(btf_table(table, record + 2u).yyy, uvec3(4096u, 0u, 0u));
                break;
            }
        }
    }
    return r;
}

#if BTF_RELIEF || BTF_GLOSS
/* Element a, 0 to 2, of a list of three: some drivers read or write the wrong element by an index that varies. */
#define BTF_ELEMENT(list, a) ((a) == 0 ? list[0] : ((a) == 1 ? list[1] : list[2]))

/* A sampled view, and in w 1 where relief acts on it, else 0. */
vec4 btf_view_vector(uint view) {
    return texelFetch(btf_view_vectors, ivec2(int(view), 0), 0);
}
#endif

/* The neighbour of the largest weight, the first of equals. */
btf_neighbours btf_nearest(btf_neighbours n) {
    uint index = n.index.x, weight = n.weight.x;
    if (n.weight.y > weight) {
        index = n.index.y;
        weight = n.weight.y;
    }
    if (n.weight.z > weight)
        index = n.index.z;
    return btf_neighbours(uvec3(index), uvec3(4096u, 0u, 0u));
}

/* Whether d is finite, within -2..2, and above the horizon; tested on the bits, so that no NaN slips through. */
bool btf_is_above(vec3 d) {
    uvec3 magnitude = floatBitsToUint(d) & BTF_BITS_MAGNITUDE;
    uint most = max(magnitude.x, max(magnitude.y, magnitude.z));
    return most <= BTF_BITS_2 && floatBitsToInt(d.z) >= int(BTF_BITS_2_TO_MINUS_24);
}
