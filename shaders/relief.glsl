/* OpenBTF shaders: relief, the heights along which each neighbouring view is shifted before views are blended (FORMAT.md
 * sections 3 and 9). Positions are in 1/256 of a texel, v upwards; heights in 1/256 of a texel of the level that they were
 * made for, which is the first but in a restriction. The march is the linear search of relief mapping (Policarpo, Oliveira
 * and Comba 2005).
 *
 * SPDX-License-Identifier: MIT
 */
#if BTF_RELIEF

#define BTF_RELIEF_TOP (BTF_RELIEF_BASE + ((255 * BTF_RELIEF_STEP) >> 8))
#define BTF_RELIEF_DOWN ((BTF_RELIEF_TOP - BTF_RELIEF_BASE + BTF_RELIEF_STEPS - 1) / BTF_RELIEF_STEPS)

/* Texels across for a texel of height along a line towards d, * 4096. */
ivec2 btf_slope(vec3 d) {
    float z = max(d.z, 0.25);
    float k = btf_reciprocal(btf_add(z, z));
    k = btf_add(k, k);
    vec2 s = vec2(floor(btf_add(btf_mul(btf_mul(d.x, k), 4096.0), 0.5)),
                  floor(btf_add(btf_mul(btf_mul(d.y, k), 4096.0), 0.5)));
    return ivec2(min(max(s, -32767.0), 32767.0));
}

/* How far a point at height z lies from its foot along a line of slope s. */
ivec2 btf_move(int z, ivec2 s, int level) {
    return (z * s) >> (12 + BTF_RELIEF_LEVEL + level);
}

/* A coordinate beyond the image by 2^19 at most, wrapped. Of a size that is a power of two all levels are. */
int btf_around(int x, uint size, bool binary) {
    uint period = size << 8u;
    if (binary)
        return int(uint(x) & (period - 1u));
    return int(uint(x + int(((1u << 19u) / period + 1u) * period)) % period);
}

/* A position that may lie beyond the image, wrapped. */
ivec2 btf_inside(ivec2 x, int level) {
    uvec2 size = btf_size(level);
    return ivec2(btf_around(x.x, size.x, (BTF_WIDTH & (BTF_WIDTH - 1u)) == 0u),
                 btf_around(x.y, size.y, (BTF_HEIGHT & (BTF_HEIGHT - 1u)) == 0u));
}

#if BTF_RELIEF == 2

/* The height where a line of slope s meets the surface that comes down to the plane of the data at x; any height of at
 * most `enough` where that is lower. It tests at its end, where a rasteriser on a CPU would run a body once more,
 * masked. */
int btf_march(ivec2 x, ivec2 s, int enough, int level) {
    int rows = int(btf_size(level).y), z = BTF_RELIEF_TOP, t;
    do {
        ivec2 at = btf_inside(x + btf_move(z, s, level), level) >> 8;
        uint code = texelFetch(btf_heights, ivec2(at.x, rows - 1 - at.y), level).x;
        t = BTF_RELIEF_BASE + ((int(code) * BTF_RELIEF_STEP) >> 8);
        if (t >= z)
            break;
        z -= BTF_RELIEF_DOWN;
    } while (z + BTF_RELIEF_DOWN > enough);
    if (z == BTF_RELIEF_TOP)
        return z;
    return t < z + BTF_RELIEF_DOWN ? t : z + (BTF_RELIEF_DOWN >> 1);
}

/* The weight of a view, less where it shows something that rises above the point at height z: all of it up to a texel,
 * at least 0.3. */
uint btf_occlude(uint weight, ivec2 x, ivec2 s, int z, int e, int level) {
    int above = btf_march(x, s, z + (256 << (BTF_RELIEF_LEVEL + level)), level) - z;
    return weight * uint(min(max(6144 - 8 * (((above * e) >> 12) >> (BTF_RELIEF_LEVEL + level)), 1229), 4096));
}

#endif

/* Where the first n views show the point that is seen at x from v, unwrapped; lowers the weights of views that show it
 * hidden. At a level where relief has ended each shows it at x. */
void btf_relief(out ivec2 shown[3], inout btf_neighbours views, int n, vec4 vector[3], ivec2 x, vec3 v, int level) {
#ifdef BTF_RELIEF_END
    shown[0] = shown[1] = shown[2] = x;
    if (level >= BTF_RELIEF_END)
        return;
#endif
    int e = 0;
    for (int a = 0; a < n; ++a)
        e += int(views.weight[a]) * int(BTF_ELEMENT(vector, a).w);
    ivec2 s = (btf_slope(v) * e) >> 12;
#if BTF_RELIEF == 2
    int z = btf_march(x, s, BTF_RELIEF_BASE, level); /* it comes down to that at most */
#else
    int z = BTF_RELIEF_BASE;
#endif
    ivec2 point = x + btf_move(z, s, level);
    uvec3 weight = uvec3(0u);
    for (int a = 0; a < n; ++a) {
        ivec2 s_a = (btf_slope(BTF_ELEMENT(vector, a).xyz) * e) >> 12;
        ivec2 at = btf_inside(point - btf_move(z, s_a, level), level);
        if (a == 0)
            shown[0] = shown[1] = shown[2] = at;
        else if (a == 1)
            shown[1] = at;
        else
            shown[2] = at;
#if BTF_RELIEF == 2
        if (n > 1 && views.weight[a] > 0u)
            weight[a] = btf_occlude(views.weight[a], at, s_a, z, e, level);
#endif
    }
#if BTF_RELIEF == 2
    if (n > 1) {
        uint sum = weight.x + weight.y + weight.z;
        uint w0 = btf_divide((weight.x >> 6u) << 12u, sum >> 6u);
        uint w1 = weight.z > 0u ? btf_divide((weight.y >> 6u) << 12u, sum >> 6u) : 4096u - w0;
        views.weight = uvec3(w0, w1, 4096u - w0 - w1);
    }
#endif
}

#endif
