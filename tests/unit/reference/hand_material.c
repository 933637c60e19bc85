/* See hand_material.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "hand_material.h"

#include <string.h>

const float hand_pole[3] = {0, 0, 1};

hand_fixture *hand_material(int layout_tight, uint32_t effects) {
    static hand_fixture f;
    make_material(1, (uint32_t)layout_tight, effects, 0, &f.s, &f.m);
    memset(f.s.sbrdf, 0, sizeof f.s.sbrdf);
    memset(f.s.maps, 0, sizeof f.s.maps);
    memset(f.s.shadow, 0, sizeof f.s.shadow);
    memset(f.s.shift, 0, sizeof f.s.shift);
    memset(f.s.gain, 0, sizeof f.s.gain);
    memset(f.s.centre, 0, sizeof f.s.centre);
    memset(f.s.residual_texels, 0, sizeof f.s.residual_texels);
    memset(f.s.residual_directions, 0, sizeof f.s.residual_directions);
    memset(f.s.residual_scales, 0, sizeof f.s.residual_scales);
    f.m.lobes = 1;
    f.m.components = 1;
    f.m.radiance_scale = f.m.shadow_scale = f.m.gain_scale = f.m.centre_scale = 1.0f;
    f.o = (btf_ref_options){.effects = UINT32_MAX, .components = UINT32_MAX};
    return &f;
}

float *hand_parameter(hand_fixture *f, uint32_t layer, uint32_t column, uint32_t row) {
    return f->s.sbrdf + 4 * ((layer * MADE_HEIGHT + row) * MADE_WIDTH + column);
}

void hand_set_shadow(hand_fixture *f, uint32_t column, uint32_t row, uint32_t light, uint8_t code) {
    uint32_t x, y;
    btf_ref_tile(&f->m, light, column, row, &x, &y);
    f->s.maps[4 * (y * MADE_ATLAS + x)] = code;
    f->s.shadow[(light * MADE_HEIGHT + row) * MADE_WIDTH + column] = code;
}

void hand_set_view(hand_fixture *f, uint32_t column, uint32_t row, uint32_t view, uint8_t gain, int b0,
                   int b1) {
    uint32_t x, y, texel = (view * MADE_HEIGHT + row) * MADE_WIDTH + column;
    btf_ref_tile(&f->m, view, column, row, &x, &y);
    uint8_t *map = f->s.maps + 4 * (y * MADE_ATLAS + x);
    map[1] = f->s.gain[texel] = gain;
    map[2] = f->s.shift[2 * texel] = (uint8_t)b0;
    map[3] = f->s.shift[2 * texel + 1] = (uint8_t)b1;
}

void hand_set_centre(hand_fixture *f, uint32_t centre, uint32_t light, uint8_t r, uint8_t g, uint8_t b) {
    uint32_t x, y;
    btf_ref_centre(&f->m, centre, light, &x, &y);
    uint8_t *texel =
        f->m.layout_tight ? f->s.centre + 4 * (y * MADE_LIGHTS + x) : f->s.maps + 4 * (y * MADE_ATLAS + x);
    texel[0] = r;
    texel[1] = g;
    texel[2] = b;
}

void hand_evaluate(const hand_fixture *f, uint32_t column, uint32_t row, uint32_t light_index,
                   uint32_t view_index, const float light[3], const float view[3], float out_rgb[3]) {
    btf_ref_neighbours lights = {{light_index, 0, 0}, {4096, 0, 0}},
                       views = {{view_index, 0, 0}, {4096, 0, 0}};
    btf_ref_evaluate_neighbours(&f->m, &f->o, column, row, &lights, &views, light, view, out_rgb);
}

float hand_albedo(uint32_t column, uint32_t row) {
    return 1.0f / (float)(1 + column + 8 * row);
}

void hand_set_lambertian(hand_fixture *f) {
    for (uint32_t row = 0; row < MADE_HEIGHT; ++row) {
        for (uint32_t column = 0; column < MADE_WIDTH; ++column) {
            float *p = hand_parameter(f, 0, column, row);
            p[0] = 1.0f, p[1] = 0.5f, p[2] = 0.25f, p[3] = hand_albedo(column, row);
        }
    }
}
