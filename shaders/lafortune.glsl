/* OpenBTF shaders: the Lafortune model of a texel (Lafortune et al. 1997; paper 2.1; FORMAT.md 4 and 9).
 *
 * SPDX-License-Identifier: MIT
 */
#if BTF_COLOUR != 2

vec4 btf_parameters(uvec2 x, int layer, int level) {
    return texelFetch(btf_sbrdf, ivec3(x, layer), level);
}

/* max(0, Cx lx vx + Cy ly vy + Cz lz vz)^n; p holds the products of l and v. */
float btf_lobe(vec4 c, vec3 p) {
    float b = btf_add(btf_add(btf_mul(c.x, p.x), btf_mul(c.y, p.y)), btf_mul(c.z, p.z));
    return btf_pow(b, c.w);
}

/* The model without its cosine. */
vec3 btf_lafortune(uvec2 x, vec3 p, int level) {
#if BTF_COLOUR == 0
    vec4 base = btf_parameters(x, 0, level);
    float s = base.w;
    for (int j = 0; j < BTF_LOBES; ++j)
        s = btf_add(s, btf_lobe(btf_parameters(x, 1 + j, level), p));
    return btf_mul(base.xyz, s);
#else
    const int colour_layers = (3 + 3 * BTF_LOBES + 3) / 4;
    vec4 c[colour_layers];
    for (int i = 0; i < colour_layers; ++i)
        c[i] = btf_parameters(x, i, level);
#define BTF_CHANNEL(i) c[(i) / 4][(i) % 4]
#define BTF_WEIGHT(j) vec3(BTF_CHANNEL(3 + 3 * j), BTF_CHANNEL(4 + 3 * j), BTF_CHANNEL(5 + 3 * j))
#define BTF_LOBE(j) btf_lobe(btf_parameters(x, colour_layers + j, level), p)
#define BTF_ADD_LOBE(j) f = btf_add(f, btf_mul(BTF_WEIGHT(j), BTF_LOBE(j)))
    vec3 f = c[0].xyz;
#if BTF_LOBES > 0
    BTF_ADD_LOBE(0);
#endif
#if BTF_LOBES > 1
    BTF_ADD_LOBE(1);
#endif
#if BTF_LOBES > 2
    BTF_ADD_LOBE(2);
#endif
#if BTF_LOBES > 3
    BTF_ADD_LOBE(3);
#endif
    return f;
#endif
}

#endif
