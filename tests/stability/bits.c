/* Materials whose parameters are chosen bit patterns, see bits.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "bits.h"

#include "decoder/toolkit/reference_view.h"
#include "tests/conformance/cases.h"
#include <openbtf/reference.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const bit_class bit_classes[] = {
    {"0", 0x00000000, 1},
    {"-0", 0x80000000, 1},
    {"the least denormal", 0x00000001, 0},
    {"the least negative denormal", 0x80000001, 0},
    {"the largest denormal", 0x007FFFFF, 0},
    {"2^-126, the least normal", 0x00800000, 0},
    {"2^-25", 0x33000000, 0},
    {"one step below 2^-24", 0x337FFFFF, 0},
    {"2^-24", 0x33800000, 1},
    {"-2^-24", 0xB3800000, 1},
    {"one step above 2^-24", 0x33800001, 1},
    {"one step below 1", 0x3F7FFFFF, 1},
    {"1", 0x3F800000, 1},
    {"-1", 0xBF800000, 1},
    {"a full mantissa", 0x40FFFFFF, 1},
    {"n = 200", 0x43480000, 1},
    {"n = 1000000", 0x49742400, 1},
    {"one step below 2^24", 0x4B7FFFFF, 1},
    {"2^24", 0x4B800000, 1},
    {"-2^24", 0xCB800000, 1},
    {"one step above 2^24", 0x4B800001, 0},
    {"-2^24 and one step", 0xCB800001, 0},
    {"2^25", 0x4C000000, 0},
    {"the largest float", 0x7F7FFFFF, 0},
    {"infinity", 0x7F800000, 0},
    {"-infinity", 0xFF800000, 0},
    {"a quiet NaN", 0x7FC00000, 0},
    {"a signalling NaN", 0x7F800001, 0},
    {"a negative NaN of all ones", 0xFFFFFFFF, 0},
};
const size_t bit_class_count = sizeof bit_classes / sizeof *bit_classes;

synthetic_spec bits_spec(int index) {
    synthetic_spec spec = {
        .seed = 100 + (uint64_t)index,
        .width = 5,
        .height = 3,
        .n_views = 9,
        .n_lights = 7,
        .layout = index & 1 ? BTF_LAYOUT_TIGHT : BTF_LAYOUT_PAPER,
        .domain = index & 2 ? BTF_DOMAIN_SQRT : BTF_DOMAIN_LINEAR,
        .colour = index & 4 ? BTF_COLOUR_RGB : BTF_COLOUR_MONO,
        .half_float = index == 2 || index == 7,
        .lobes = 1 + (uint32_t)index % 4,
        .effects = index == 3 ? BTF_EFFECT_SHADOW | BTF_EFFECT_GAIN : BTF_EFFECT_VERSION_1,
        .components = index == 3 ? 0 : 6,
        .centres = 11,
        .directions = index == 5 ? SYNTHETIC_RANDOM : SYNTHETIC_RINGS,
        .values = SYNTHETIC_EXTREME,
    };
    static const uint32_t classes[BTF_FACTOR_CLASSES][3] = {
        {2, 3, 1}, {1, 1, 1}, {3, 2, 1}, {1, 0, 1}, {2, 1, 2}};
    if (index >= BITS_FACTORS) {
        memcpy(spec.classes, classes, sizeof classes);
        spec.components = 9;
        spec.codes = SYNTHETIC_BOUNDS;
        spec.blend = index & 2 ? BTF_BLEND_ROOTS : BTF_BLEND_RADIANCE;
        spec.horizon_scale = index & 1 ? 0x1p24f : 5;
    }
    return spec;
}

void bits_begin(const synthetic_spec *spec, bits_desc *out) {
    btf_material *material = NULL;
    *out = (bits_desc){.desc = {.struct_size = sizeof out->desc}};
    out->desc.info.struct_size = sizeof out->desc.info;
    if (synthetic_create(spec, NULL, &material) != BTF_OK ||
        btf_material_get_info(material, &out->desc.info) != BTF_OK) {
        fprintf(stderr, "bits: no material\n");
        exit(1);
    }
    out->desc.info.method = out->desc.info.options = out->desc.info.source = NULL;
    const btf_directions lists[2] = {btf_material_views(material), btf_material_lights(material)};
    for (int i = 0; i < 2; i++) {
        float *xyz = malloc(3 * lists[i].count * sizeof *xyz);
        if (xyz == NULL) {
            exit(1);
        }
        memcpy(xyz, lists[i].xyz, 3 * lists[i].count * sizeof *xyz);
        *(i == 0 ? &out->desc.views : &out->desc.lights) = xyz;
    }
    for (int id = 0; id < BTF_TEXTURE_COUNT; id++) {
        const btf_texture t = btf_material_texture(material, (btf_texture_id)id);
        const bool table = id == BTF_TEXTURE_VIEW_TABLE || id == BTF_TEXTURE_LIGHT_TABLE;
        if (t.format != BTF_FORMAT_NONE && !table) {
            out->desc.texture[id] = out->texture[id] = malloc(t.size);
            if (out->texture[id] == NULL) {
                exit(1);
            }
            memcpy(out->texture[id], t.data, t.size);
        }
    }
    btf_material_close(&material);
}

void bits_end(bits_desc *d) {
    free((void *)d->desc.views);
    free((void *)d->desc.lights);
    for (int id = 0; id < BTF_TEXTURE_COUNT; id++) {
        free(d->texture[id]);
    }
}

static float legal(random_state *r, int positive) {
    for (;;) {
        const bit_class *c = bit_classes + random_below(r, (uint32_t)bit_class_count);
        if (c->legal && (!positive || float_of_bits(c->bits) > 0)) {
            return float_of_bits(c->bits);
        }
    }
}

/* A unit of Y alone has one scale. */
static void fill_factors(random_state *r, const btf_material_info *info, float *scales, float *views) {
    for (int c = 0; scales && c < BTF_FACTOR_CLASSES; c++) {
        for (uint32_t unit = 0; unit < info->factor_classes[c][0]; unit++, scales += 4) {
            const bool mixed = c == 0 || 4 * unit < info->factor_classes[c][1] + info->factor_classes[c][2];
            for (int word = 0; word < 4; word++) {
                scales[word] = word == 0 || mixed ? legal(r, 0) : scales[0];
            }
        }
    }
    for (uint32_t i = 0; views && i < 12 * info->n_views; i++) {
        views[i] = i % 4 == 3 ? 0 : legal(r, 0);
    }
}

void bits_fill(random_state *r, bits_desc *d) {
    static const uint16_t halves[] = {0x0000, 0x8000, 0x0400, 0x8400, 0x0401, 0x3C00,
                                      0xBC00, 0x3BFF, 0x7BFE, 0x7BFF, 0xFBFF, 0x5A40};
    btf_material_info *info = &d->desc.info;
    const btf_texture t = btf_material_texture_shape(info, BTF_TEXTURE_SBRDF);
    const size_t n = t.format == BTF_FORMAT_NONE ? 0 : 4 * (size_t)t.width * t.height * t.layers;
    const uint32_t colour_layers = info->colour == BTF_COLOUR_MONO ? 1 : (3 + 3 * info->lobes + 3) / 4;
    for (size_t i = 0; i < n; i++) {
        const uint32_t layer = (uint32_t)(i / (4 * (size_t)t.width * t.height));
        if (info->colour == BTF_COLOUR_RGB && layer < colour_layers &&
            4 * layer + i % 4 >= 3 + 3 * info->lobes) {
            continue; /* a number without a meaning has to stay 0 */
        }
        if (info->half_float) {
            ((uint16_t *)d->texture[BTF_TEXTURE_SBRDF])[i] =
                halves[random_below(r, sizeof halves / sizeof *halves)];
        } else {
            ((float *)d->texture[BTF_TEXTURE_SBRDF])[i] = legal(r, 0);
        }
    }
    float *scales = d->texture[BTF_TEXTURE_RESIDUAL_SCALES];
    for (uint32_t i = 0; scales && i < info->components; i++) {
        scales[i] = legal(r, 0);
    }
    fill_factors(r, info, d->texture[BTF_TEXTURE_FACTOR_SCALES], d->texture[BTF_TEXTURE_FACTOR_VIEWS]);
    info->radiance_scale = legal(r, 1);
    info->shadow_scale = legal(r, 1);
    info->gain_scale = legal(r, 1);
    info->centre_scale = legal(r, 1);
}

bool bits_decode(const btf_material *material, uint64_t seed, int count) {
    btf_ref_material view;
    if (reference_view(material, 0, &view) != 0) {
        return false;
    }
    random_state r = {seed};
    for (int i = 0; i < count; i++) {
        uint32_t words[CASE_WORDS];
        float f[CASE_WORDS], rgb[2][3];
        case_make(&r, material, words);
        memcpy(f, words, sizeof f);
        const btf_ref_options options = {random_below(&r, 4) ? UINT32_MAX : random_below(&r, 128),
                                         UINT32_MAX, i & 1, (i >> 1) % 3};
        for (int run = 0; run < 2; run++) {
            btf_ref_evaluate(&view, &options, f[0], f[1], f + 2, f + 5, rgb[run]);
        }
        for (int c = 0; c < 3; c++) {
            if (!(rgb[0][c] >= 0 && rgb[0][c] <= 0x1.fffffep127f)) {
                return false;
            }
        }
        if (memcmp(rgb[0], rgb[1], sizeof rgb[0]) != 0) {
            return false;
        }
    }
    return true;
}
