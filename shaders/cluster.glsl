/* OpenBTF shaders: hidden points, which take the profile of a cluster centre (paper 2.3.3; FORMAT.md
 * section 3).
 *
 * SPDX-License-Identifier: MIT
 */
#if BTF_HIDDEN

/* Index of the centre of a hidden point. */
uint btf_centre_index(uvec3 codes) {
    return codes.y + 256u * codes.z;
}

/* Radiance, before radianceScale, of a centre under the first n neighbouring lights (1 or 3); its root where
 * views are blended as roots. */
vec3 btf_centre_radiance(uint centre, btf_neighbours lights, int n) {
    uvec3 t = uvec3(0u);
    for (int b = 0; b < n; ++b) {
        ivec2 at = ivec2(btf_centre(centre, lights.index[b]));
#if BTF_LAYOUT_TIGHT
        t += lights.weight[b] * texelFetch(btf_centres, at, 0).xyz;
#else
        t += lights.weight[b] * texelFetch(btf_maps, at, 0).xyz;
#endif
    }
    vec3 y = btf_mul(vec3(t), BTF_CENTRE_SCALE);
#if BTF_BLEND_ROOTS
    return y;
#else
    return btf_mul(y, y);
#endif
}

#endif
