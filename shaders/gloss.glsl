/* OpenBTF shaders: gloss, for each neighbouring view the lights around a direction that keeps part of the half vector, so
 * that highlights, which follow the half vector (Rusinkiewicz 1998), stay where they are (FORMAT.md section 9).
 *
 * SPDX-License-Identifier: MIT
 */
#if BTF_GLOSS

float btf_inner(vec3 a, vec3 b) {
    return btf_add(btf_add(btf_mul(a.x, b.x), btf_mul(a.y, b.y)), btf_mul(a.z, b.z));
}

/* Where the neighbours of light l are looked up for a sampled view where v is the viewer's direction: l, moved by a share
 * of the difference between the reflections of both in the half vector. */
ivec2 btf_gloss(vec3 l, vec3 v, vec3 view) {
    vec3 d = btf_add(view, -v);
    vec3 c = l;
    float k = btf_add(l.z, 1.0);
    if (max(abs(d.x), max(abs(d.y), abs(d.z))) >= uintBitsToFloat(BTF_BITS_2_TO_MINUS_24)) {
        vec3 h = btf_add(l, v);
        float r = btf_reciprocal(min(max(btf_inner(h, h), 0.5), 4.0));
        float hd = btf_inner(h, d);
        vec3 g = btf_add(btf_mul(h, btf_mul(btf_add(hd, hd), r)), -d);
        c = btf_add(l, btf_mul(g, BTF_GLOSS == 2 ? 0.5 : 0.25));
        c.z = max(c.z, 0.0);
        k = min(max(btf_add(btf_pow(btf_inner(c, c), 0.5), c.z), 0.5), 4.0);
    }
    return btf_plane(c, btf_reciprocal(k));
}

#endif
