/* OpenBTF shaders: where tiles and centres lie (FORMAT.md sections 3 and 5).
 *
 * SPDX-License-Identifier: MIT
 */
#if BTF_LAYOUT_TIGHT

#if BTF_HIDDEN
/* Texel of `centres` that holds a centre under a light. */
uvec2 btf_centre(uint centre, uint light) {
    uint block = centre / BTF_CENTRE_ROWS;
    return uvec2(block * BTF_N_LIGHTS + light, centre - block * BTF_CENTRE_ROWS);
}
#endif

#else

/* Texel of the atlas that holds texel x of a tile. */
uvec2 btf_tile(uint tile, uvec2 x) {
    uint columns = BTF_ATLAS_WIDTH / BTF_WIDTH;
    uint row = tile / columns;
    return uvec2((tile - row * columns) * BTF_WIDTH, row * BTF_HEIGHT) + x;
}

/* Texel of the atlas that holds a centre under a light. */
uvec2 btf_centre(uint centre, uint light) {
    uint columns = BTF_ATLAS_WIDTH / BTF_WIDTH;
    uint left = (BTF_TILES % columns) * BTF_WIDTH;
    uint top = (BTF_TILES / columns) * BTF_HEIGHT;
    uint bands = (BTF_ATLAS_HEIGHT - top) / BTF_N_LIGHTS;
    uint narrow = left > 0u ? min(bands, (BTF_HEIGHT + BTF_N_LIGHTS - 1u) / BTF_N_LIGHTS) : 0u;
    uint narrow_width = BTF_ATLAS_WIDTH - left;
    uint band, column;
    if (centre < narrow * narrow_width) {
        band = centre / narrow_width;
        column = left + (centre - band * narrow_width);
    } else {
        uint rest = centre - narrow * narrow_width;
        uint full = rest / BTF_ATLAS_WIDTH;
        band = narrow + full;
        column = rest - full * BTF_ATLAS_WIDTH;
    }
    return uvec2(column, top + band * BTF_N_LIGHTS + light);
}

#endif
