/* OpenBTF reference decoder: which texel (FORMAT.md, sections 3, 5 and 9). Integers from the first step on.
 *
 * SPDX-License-Identifier: MIT
 */
#include "btf_reference_private.h"

/** Centres of layout tight stand in blocks of at most this many rows. */
#define CENTRE_ROWS 4096u

uint32_t btf_ref_coordinate(float c, uint32_t size) {
    uint32_t magnitude = btf_ref_bits(c) & 0x7FFFFFFFu;
    if (magnitude > 0x45800000u || magnitude < 0x00800000u) {
        return 0; /* beyond 4096, infinite, NaN; zero, denormal */
    }
    int32_t fixed = btf_ref_floor(c * 0x1p18f);
    return ((uint32_t)fixed & 0x3FFFFu) * size;
}

void btf_ref_bilinear(uint32_t t, uint32_t size, uint32_t *out_c0, uint32_t *out_c1,
                      uint32_t *out_weight1) {
    uint32_t start = t - (1u << 17); /* half a texel earlier, modulo 2^32 as all of this */
    if (t < 1u << 17) {
        start += size << 18;
    }
    *out_c0 = start >> 18;
    *out_c1 = *out_c0 + 1 == size ? 0 : *out_c0 + 1;
    *out_weight1 = (start >> 10) & 255u;
}

uint32_t btf_ref_steep(uint32_t weight) {
    uint32_t twice = 2 * weight;
    if (twice < 128) {
        return 0;
    }
    return twice - 128 > 256 ? 256 : twice - 128;
}

uint32_t btf_ref_wrap(uint32_t position, int32_t shift, uint32_t size) {
    int32_t wrapped = ((int32_t)position + shift) % (int32_t)size; /* has the sign of the sum */
    return (uint32_t)(wrapped < 0 ? wrapped + (int32_t)size : wrapped);
}

void btf_ref_tile(const btf_ref_material *material, uint32_t tile, uint32_t column, uint32_t row,
                  uint32_t *out_x, uint32_t *out_y) {
    uint32_t columns = material->atlas_width / material->width;
    *out_x = tile % columns * material->width + column;
    *out_y = tile / columns * material->height + row;
}

/** Section 5: centres fill bands of n_lights rows below the full rows of tiles; the first `narrow` bands
 * lose the columns of the last, partly filled row of tiles. */
static void centre_in_atlas(const btf_ref_material *material, uint32_t centre, uint32_t *out_x,
                            uint32_t *out_y) {
    uint32_t n_lights = material->n_lights;
    uint32_t tiles = material->n_views > n_lights ? material->n_views : n_lights;
    uint32_t columns = material->atlas_width / material->width;
    uint32_t part = tiles % columns;
    uint32_t y0 = tiles / columns * material->height;
    uint32_t bands = (material->atlas_height - y0) / n_lights;
    uint32_t narrow = 0;
    if (part > 0) {
        narrow = (material->height + n_lights - 1) / n_lights;
        narrow = narrow < bands ? narrow : bands;
    }
    uint32_t narrow_width = material->atlas_width - part * material->width;

    uint32_t band;
    if (centre < narrow * narrow_width) {
        band = centre / narrow_width;
        *out_x = part * material->width + centre % narrow_width;
    } else {
        uint32_t rest = centre - narrow * narrow_width;
        band = narrow + rest / material->atlas_width;
        *out_x = rest % material->atlas_width;
    }
    *out_y = y0 + band * n_lights;
}

void btf_ref_centre(const btf_ref_material *material, uint32_t centre, uint32_t light, uint32_t *out_x,
                    uint32_t *out_y) {
    if (!material->layout_tight) {
        centre_in_atlas(material, centre, out_x, out_y);
        *out_y += light;
        return;
    }
    uint32_t blocks = (material->centres + CENTRE_ROWS - 1) / CENTRE_ROWS;
    uint32_t rows = (material->centres + blocks - 1) / blocks;
    *out_x = centre / rows * material->n_lights + light;
    *out_y = centre % rows;
}

bool btf_ref_probe_addressing(void) {
    return btf_ref_probe();
}
