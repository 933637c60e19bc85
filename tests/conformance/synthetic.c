/* Random legal materials.
 *
 * SPDX-License-Identifier: MIT
 */
#include "synthetic.h"
#include "random.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

/* Up to `count` directions in rings; the last ring takes what is left. */
static void make_rings(uint32_t count, float (*xyz)[3]) {
    uint32_t made = 0;
    for (int ring = 0; made < count; ++ring) {
        uint32_t azimuths = ring == 0 ? 1 : (uint32_t)(6 * ring);
        if (azimuths > count - made) {
            azimuths = count - made;
        }
        double theta = fmin(12.5 * ring, 89.0 - 40.0 / (ring + 1)) * M_PI / 180;
        for (uint32_t i = 0; i < azimuths; ++i) {
            double phi = 2 * M_PI * i / azimuths;
            xyz[made][0] = (float)(sin(theta) * cos(phi));
            xyz[made][1] = (float)(sin(theta) * sin(phi));
            xyz[made++][2] = (float)cos(theta);
        }
    }
}

typedef struct polar {
    double theta, phi;
} polar;

static int compare_polar(const void *a, const void *b) {
    const polar *p = a, *q = b;
    if (p->theta != q->theta) {
        return p->theta < q->theta ? -1 : 1;
    }
    return p->phi < q->phi ? -1 : p->phi > q->phi;
}

static void make_directions(random_state *r, synthetic_directions kind, uint32_t count, float (*xyz)[3]) {
    polar list[BTF_MAX_DIRECTIONS];
    if (kind == SYNTHETIC_RINGS) {
        make_rings(count, xyz);
        return;
    }
    for (uint32_t i = 0; i < count; ++i) {
        if (kind == SYNTHETIC_COLLINEAR) {
            list[i] = (polar){count == 1 ? 20.0 : 80.0 * i / count, 30.0};
        } else {
            list[i] = (polar){random_between(r, 0, 89), random_between(r, 0, 360)};
        }
    }
    qsort(list, count, sizeof *list, compare_polar);
    for (uint32_t i = 0; i < count; ++i) {
        double theta = list[i].theta * M_PI / 180, phi = list[i].phi * M_PI / 180;
        xyz[i][0] = (float)(sin(theta) * cos(phi));
        xyz[i][1] = (float)(sin(theta) * sin(phi));
        xyz[i][2] = (float)cos(theta);
    }
}

/* 0, or of magnitude 2^-24 .. 2^24 with any sign and mantissa. */
static float extreme_float(random_state *r, int positive) {
    if (!positive && random_below(r, 8) == 0) {
        return 0.0f;
    }
    uint32_t exponent = 127 - 24 + random_below(r, 48);
    uint32_t mantissa = random_below(r, 4) ? random_below(r, 1u << 23) : 0;
    return float_of_bits((positive ? 0u : random_below(r, 2) << 31) | exponent << 23 | mantissa);
}

static float plausible_float(random_state *r, double from, double to) {
    float x = (float)random_between(r, from, to);
    return fabsf(x) < 0x1p-24f ? 0.0f : x;
}

/* The nearest normal half of a parameter, as bits: magnitudes beyond 65504 become that, those below 2^-14
 * zero. */
static uint16_t half_of_float(float x) {
    double magnitude = fmin(fabs((double)x), 65504.0);
    if (magnitude < 0x1p-14) {
        return 0;
    }
    int exponent;
    frexp(magnitude, &exponent);
    uint32_t steps = (uint32_t)nearbyint(ldexp(magnitude, 11 - exponent)); /* of 2^(exponent - 11) */
    if (steps == 2048) {
        steps = 1024;
        ++exponent;
    }
    return (uint16_t)((x < 0 ? 0x8000 : 0) | (((exponent + 14) << 10) + (int)(steps - 1024)));
}

/* What a component of a layer of `sbrdf` holds: nothing, part of a lobe's vector, its exponent, or a colour. */
static char parameter_kind(const synthetic_spec *s, uint32_t layer, uint32_t component) {
    uint32_t colour_layers = s->colour == BTF_COLOUR_MONO ? 1 : (3 + 3 * s->lobes + 3) / 4;
    if (layer >= colour_layers) {
        return component == 3 ? 'n' : 'C';
    }
    if (s->colour == BTF_COLOUR_RGB && 4 * layer + component >= 3 + 3 * s->lobes) {
        return 0;
    }
    return 'c';
}

static void fill_sbrdf(random_state *r, const synthetic_spec *s, const btf_texture *t, void *data) {
    size_t i = 0;
    for (uint32_t layer = 0; layer < t->layers; ++layer) {
        for (size_t texel = 0; texel < (size_t)t->width * t->height; ++texel) {
            for (uint32_t c = 0; c < 4; ++c, ++i) {
                char kind = parameter_kind(s, layer, c);
                float x = 0;
                if (kind && s->values == SYNTHETIC_EXTREME) {
                    x = extreme_float(r, 0);
                } else if (kind == 'c') {
                    x = plausible_float(r, 0, 1);
                } else if (kind == 'C') {
                    x = plausible_float(r, -1.5, 1.5);
                } else if (kind == 'n') {
                    x = (float)exp2(random_between(r, -1, 7));
                }
                if (s->half_float) {
                    ((uint16_t *)data)[i] = half_of_float(x);
                } else {
                    ((float *)data)[i] = x;
                }
            }
        }
    }
}

/* Gain code and shift bytes of one texel and view. */
static void make_point(random_state *r, const synthetic_spec *s, uint32_t centres, uint8_t out[3]) {
    out[0] = s->effects & (BTF_EFFECT_GAIN | BTF_EFFECT_HIDDEN) ? BTF_GAIN_ONE : 0;
    out[1] = out[2] = 0;
    if ((s->effects & BTF_EFFECT_HIDDEN) && (s->all_hidden || random_below(r, 3) == 0)) {
        uint32_t centre = random_below(r, centres);
        out[0] = 0;
        out[1] = (uint8_t)centre;
        out[2] = (uint8_t)(centre >> 8);
        return;
    }
    if (s->effects & BTF_EFFECT_GAIN) {
        out[0] = (uint8_t)(1 + random_below(r, 255));
    }
    if (s->effects & BTF_EFFECT_SHIFT) {
        out[1] = (uint8_t)random_bits(r);
        out[2] = (uint8_t)random_bits(r);
    }
}

static void fill_maps(random_state *r, const synthetic_spec *s, const btf_material_info *info,
                      uint8_t *data) {
    if (!data) { /* the material has no effect that this texture serves */
        return;
    }
    uint32_t tiles = info->n_views > info->n_lights ? info->n_views : info->n_lights;
    uint32_t columns = info->atlas_width / info->width;
    for (uint32_t tile = 0; tile < tiles; ++tile) {
        for (uint32_t y = 0; y < info->height; ++y) {
            for (uint32_t x = 0; x < info->width; ++x) {
                size_t column = (size_t)(tile % columns) * info->width + x;
                size_t row = (size_t)(tile / columns) * info->height + y;
                uint8_t *texel = data + 4 * (row * info->atlas_width + column);
                if (tile < info->n_lights && (s->effects & BTF_EFFECT_SHADOW)) {
                    texel[0] = (uint8_t)random_bits(r);
                }
                if (tile < info->n_views) {
                    make_point(r, s, info->centres, texel + 1);
                }
            }
        }
    }
    for (uint32_t i = 0; i < info->centres; ++i) {
        uint32_t x, y;
        btf_material_atlas_centre(info, i, &x, &y);
        for (uint32_t light = 0; light < info->n_lights; ++light) {
            for (int c = 0; c < 3; ++c) {
                data[4 * ((size_t)(y + light) * info->atlas_width + x) + (size_t)c] =
                    (uint8_t)random_bits(r);
            }
        }
    }
}

static void fill_tight(random_state *r, const synthetic_spec *s, const btf_material_info *info,
                       void *const texture[BTF_TEXTURE_COUNT]) {
    size_t points = (size_t)info->width * info->height * info->n_views;
    uint8_t *shift = texture[BTF_TEXTURE_SHIFT], *gain = texture[BTF_TEXTURE_GAIN];
    uint8_t *shadow = texture[BTF_TEXTURE_SHADOW], *centres = texture[BTF_TEXTURE_CENTRES];
    uint8_t *packed = texture[BTF_TEXTURE_POINTS];
    for (size_t i = 0; packed && i < 2 * points; ++i) { /* each may be anything */
        packed[i] = (uint8_t)random_bits(r);
    }
    uint8_t *lists = texture[BTF_TEXTURE_POINT_LISTS], *indices = texture[BTF_TEXTURE_POINT_INDICES];
    const size_t texels = (size_t)info->width * info->height;
    for (size_t i = 0; lists && i < 2 * texels * info->point_entries; ++i) {
        lists[i] = (uint8_t)random_bits(r);
    }
    for (size_t i = 0; lists && i < points; ++i) {
        indices[i / texels / 2 * texels + i % texels] |=
            (uint8_t)(random_below(r, info->point_entries) * (i / texels % 2 ? 16u : 1u));
    }
    for (size_t i = 0; i < points; ++i) {
        uint8_t point[3];
        make_point(r, s, info->centres, point);
        if (gain) {
            gain[i] = point[0];
        }
        if (shift) {
            shift[2 * i] = point[1];
            shift[2 * i + 1] = point[2];
        }
    }
    if (shadow) {
        for (size_t i = 0; i < (size_t)info->width * info->height * info->n_lights; ++i) {
            shadow[i] = (uint8_t)random_bits(r);
        }
    }
    if (!centres) {
        return;
    }
    btf_texture t = btf_material_texture_shape(info, BTF_TEXTURE_CENTRES);
    for (uint32_t i = 0; i < info->centres; ++i) {
        for (uint32_t light = 0; light < info->n_lights; ++light) {
            for (int c = 0; c < 3; ++c) {
                size_t x = (size_t)(i / t.height) * info->n_lights + light;
                centres[4 * ((size_t)(i % t.height) * t.width + x) + (size_t)c] = (uint8_t)random_bits(r);
            }
        }
    }
}

/* The scales too, and `residual_directions`, where the level has them. */
static void fill_residual(random_state *r, const synthetic_spec *s, const btf_material_info *info,
                          void *const texture[BTF_TEXTURE_COUNT]) {
    for (int directions = 0; directions < 2; ++directions) {
        btf_texture_id id = directions ? BTF_TEXTURE_RESIDUAL_DIRECTIONS : BTF_TEXTURE_RESIDUAL_TEXELS;
        btf_texture t = btf_material_texture_shape(info, id);
        int8_t *data = texture[id];
        if (!data) {
            return;
        }
        for (uint32_t layer = 0; layer < t.layers; ++layer) {
            for (size_t i = 0; i < 4 * (size_t)t.width * t.height; ++i, ++data) {
                uint32_t component = layer / (directions ? 3 : 1) * 4 + i % 4;
                *data = component < info->components ? (int8_t)((int)random_below(r, 255) - 127) : 0;
            }
        }
    }
    float *scales = texture[BTF_TEXTURE_RESIDUAL_SCALES];
    for (uint32_t i = 0; i < info->components; ++i) {
        scales[i] = s->values == SYNTHETIC_EXTREME
                        ? extreme_float(r, 0)
                        : (float)random_between(r, 0.2, 1) * 0x1p-15f / (float)(1 + (i < 64 ? i : 64));
    }
}

/* A word of codes: of class 0 (no byte of which may be -128) or another. */
static uint32_t make_codes(random_state *r, const synthetic_spec *s, bool bytes) {
    const uint32_t kind = s->codes == SYNTHETIC_BOUNDS ? random_below(r, 5) : 4;
    if (kind < 4) {
        return kind < 2 ? (bytes ? 0x7F7F7F7Fu : 0xFFFFFFFFu) : bytes ? 0x81818181u : 0;
    }
    uint32_t word = random_bits(r);
    for (uint32_t i = 0; bytes && i < 32; i += 8) {
        word ^= (word >> i & 255) == 128 ? 1u << i : 0;
    }
    return word;
}

/* Two texels' words in three are alike in a texture's layer, so that units reach their bounds, not words
 * alone. */
static void fill_codes(random_state *r, const synthetic_spec *s, const btf_texture *t, uint32_t *data) {
    for (uint32_t layer = 0; layer < t->layers; ++layer) {
        for (size_t i = 0; i < (size_t)t->width * t->height; ++i, data += 4) {
            const bool alike = s->codes == SYNTHETIC_BOUNDS && random_below(r, 3) > 0;
            for (int word = 0; word < 4; ++word) {
                data[word] = word > 0 && alike ? data[0] : make_codes(r, s, layer < s->classes[0][0]);
            }
        }
    }
}

/* The scales of units, at which each adds about as much as any other. */
static void fill_factor_scales(random_state *r, const synthetic_spec *s, uint32_t units, float *data) {
    /* The root of the sum of squares of products of random levels, of a word. */
    static const double size[BTF_FACTOR_CLASSES] = {10700, 3840, 240, 83, 20};
    for (int c = 0; c < BTF_FACTOR_CLASSES; ++c) {
        for (uint32_t unit = 0; unit < s->classes[c][0]; ++unit, data += 4) {
            const bool mixed = c == 0 || 4 * unit < s->classes[c][1] + s->classes[c][2];
            for (int word = 0; word < 4; ++word) {
                if (word > 0 && !mixed) {
                    data[word] = data[0];
                } else if (s->values == SYNTHETIC_EXTREME) {
                    data[word] = extreme_float(r, 0);
                } else {
                    data[word] = (float)(random_between(r, 0.3, 1) * (random_below(r, 4) ? 1 : -1) /
                                         size[c] / sqrt(units));
                }
            }
        }
    }
}

/* Fills the factors of texels, and those that all levels share, where the level has them. */
static void fill_factors(random_state *r, const synthetic_spec *s, const btf_material_info *info,
                         void *const texture[BTF_TEXTURE_COUNT]) {
    btf_texture t = btf_material_texture_shape(info, BTF_TEXTURE_FACTOR_TEXELS);
    fill_codes(r, s, &t, texture[BTF_TEXTURE_FACTOR_TEXELS]);
    float *views = texture[BTF_TEXTURE_FACTOR_VIEWS];
    if (!views) {
        return;
    }
    t = btf_material_texture_shape(info, BTF_TEXTURE_FACTOR_DIRECTIONS);
    fill_codes(r, s, &t, texture[BTF_TEXTURE_FACTOR_DIRECTIONS]);
    fill_factor_scales(r, s, info->components, texture[BTF_TEXTURE_FACTOR_SCALES]);
    for (size_t i = 0; i < (size_t)12 * info->n_views; ++i) {
        views[i] = i % 4 == 3                       ? 0
                   : s->values == SYNTHETIC_EXTREME ? extreme_float(r, 0)
                                                    : (float)random_between(r, 0.2, i % 4 == 0 ? 1 : 0.5);
    }
}

static void fill_heights(random_state *r, const synthetic_spec *s, size_t texels, uint8_t *data) {
    for (size_t i = 0; i < texels; ++i) {
        data[i] = s->relief == SYNTHETIC_EVEN ? 100
                  : s->relief == SYNTHETIC_HIGH && random_below(r, 2) == 0
                      ? (uint8_t)(255 * random_below(r, 2))
                      : (uint8_t)random_bits(r);
    }
}

static float make_scale(random_state *r, const synthetic_spec *s, float plausible) {
    return s->values == SYNTHETIC_EXTREME ? extreme_float(r, 1) : plausible;
}

/* Fills the info by the spec. The size of the atlas and the number of centres follow from it. */
static btf_result make_info(random_state *r, const synthetic_spec *s, btf_material_info *info) {
    /* clang-format off */
    *info = (btf_material_info){
        .struct_size = sizeof *info, .width = s->width, .height = s->height, .n_views = s->n_views,
        .n_lights = s->n_lights, .layout = s->layout, .domain = s->domain, .colour = s->colour,
        .half_float = s->half_float, .lobes = s->lobes, .effects = s->effects, .components = s->components,
        .radiance_scale = make_scale(r, s, 1.25f), .shadow_scale = make_scale(r, s, 2.0f / 255),
        .gain_scale = make_scale(r, s, BTF_GAIN_SCALE), .centre_scale = make_scale(r, s, 1.0f / 255),
        .method = "synthetic",
    };
    /* clang-format on */
    for (int c = 0; c < BTF_FACTOR_CLASSES; ++c) {
        info->store = s->classes[c][0] ? BTF_STORE_FACTORS : info->store;
        memcpy(info->factor_classes[c], s->classes[c], sizeof info->factor_classes[c]);
    }
    info->blend = s->blend;
    if (s->packed) {
        info->point_store = s->entries ? BTF_POINTS_LISTS : BTF_POINTS_PACKED;
        info->point_entries = s->entries;
        info->gain_base = s->values == SYNTHETIC_EXTREME ? extreme_float(r, 0) : 0.3f;
        info->gain_step = s->values == SYNTHETIC_EXTREME ? extreme_float(r, 0) : 0.11f;
    }
    info->horizon_scale = info->store == BTF_STORE_FACTORS ? s->horizon_scale : 0;
    if (s->effects & BTF_EFFECT_RELIEF) {
        static const int32_t heights[SYNTHETIC_RELIEFS][3] = {
            {-700, 0, 1}, {-900, 1100, 8}, {-32768, 32767, 1}, {128, 32767, 64}, {300, 900, 3}};
        info->relief_base = heights[s->relief][0];
        info->relief_step = heights[s->relief][1];
        info->relief_steps = (uint32_t)heights[s->relief][2];
    }
    info->gloss_share = s->effects & BTF_EFFECT_GLOSS ? s->gloss_share : 0;
    uint32_t room = BTF_MAX_CENTRES;
    if (s->layout == BTF_LAYOUT_PAPER) {
        btf_result result = btf_material_atlas(info, &info->atlas_width, &info->atlas_height, &room);
        if (result != BTF_OK) {
            return result;
        }
    }
    if (s->effects & BTF_EFFECT_HIDDEN) {
        info->centres = s->centres < room ? s->centres : room;
    }
    info->levels = 1;
    while (s->layout == BTF_LAYOUT_TIGHT && info->levels < s->levels &&
           (s->width >> info->levels || s->height >> info->levels)) {
        info->levels++;
    }
    if (s->effects & BTF_EFFECT_RELIEF) {
        info->relief_end = s->relief_end < info->levels ? s->relief_end : info->levels;
    }
    return BTF_OK;
}

/* Makes and fills the textures of a level. */
static btf_result make_level(random_state *r, const synthetic_spec *spec, const btf_material_info *info,
                             uint32_t level, void *texture[BTF_TEXTURE_COUNT]) {
    for (int id = 0; id < BTF_TEXTURE_COUNT; ++id) {
        btf_texture t = btf_material_level_shape(info, level, (btf_texture_id)id);
        if (t.format == BTF_FORMAT_NONE) {
            continue;
        }
        texture[id] = calloc(1, t.size);
        if (!texture[id]) {
            return BTF_ERROR_MEMORY;
        }
    }
    btf_material_info of_level = *info;
    of_level.width = btf_level_size(info->width, level);
    of_level.height = btf_level_size(info->height, level);
    if (spec->colour != BTF_COLOUR_NONE) {
        btf_texture t = btf_material_texture_shape(&of_level, BTF_TEXTURE_SBRDF);
        fill_sbrdf(r, spec, &t, texture[BTF_TEXTURE_SBRDF]);
    }
    if (spec->layout == BTF_LAYOUT_PAPER) {
        fill_maps(r, spec, &of_level, texture[BTF_TEXTURE_MAPS]);
    } else {
        fill_tight(r, spec, &of_level, texture);
    }
    if (texture[BTF_TEXTURE_HEIGHTS]) {
        fill_heights(r, spec, (size_t)of_level.width * of_level.height, texture[BTF_TEXTURE_HEIGHTS]);
    }
    if (spec->effects & BTF_EFFECT_RESIDUAL) {
        (info->store == BTF_STORE_FACTORS ? fill_factors : fill_residual)(r, spec, &of_level, texture);
    }
    return BTF_OK;
}

/* A preview for image viewers, which no decoder may read, in every second material of version 2; NULL in others. */
static uint16_t *make_preview(random_state *r, const synthetic_spec *spec, const btf_material_info *info) {
    const bool version_2 = info->store == BTF_STORE_FACTORS || info->blend == BTF_BLEND_ROOTS ||
                           spec->packed || info->effects & (BTF_EFFECT_RELIEF | BTF_EFFECT_GLOSS);
    const size_t texels = (size_t)info->width * info->height;
    uint16_t *halves = version_2 && (spec->seed & 1) ? malloc(texels * 4 * sizeof *halves) : NULL;
    for (size_t i = 0; halves && i < 4 * texels; ++i) {
        halves[i] = i % 4 == 3 ? 0 : half_of_float(plausible_float(r, 0, 1));
    }
    return halves;
}

btf_result synthetic_create(const synthetic_spec *spec, const btf_log *log, btf_material **out_material) {
    *out_material = NULL;
    random_state r = {spec->seed};
    btf_material_desc desc = {.struct_size = sizeof desc};
    float views[BTF_MAX_DIRECTIONS][3], lights[BTF_MAX_DIRECTIONS][3];
    void *texture[BTF_MAX_LEVELS][BTF_TEXTURE_COUNT] = {{0}};
    btf_result result = make_info(&r, spec, &desc.info);
    make_directions(&r, spec->directions, spec->n_views, views);
    make_directions(&r, spec->directions, spec->n_lights, lights);
    desc.views = views[0];
    desc.lights = lights[0];
    for (uint32_t level = 0; level < desc.info.levels && result == BTF_OK; ++level) {
        result = make_level(&r, spec, &desc.info, level, texture[level]);
        for (int id = 0; id < BTF_TEXTURE_COUNT; ++id) {
            *(level ? &desc.level_texture[level][id] : &desc.texture[id]) = texture[level][id];
        }
    }
    uint8_t acts[BTF_MAX_DIRECTIONS];
    for (uint32_t v = 0; v < spec->n_views && spec->relief_mixed; ++v) {
        acts[v] = (uint8_t)random_below(&r, 2);
    }
    desc.relief_views = spec->effects & BTF_EFFECT_RELIEF && spec->relief_mixed ? acts : NULL;
    desc.effect_errors = spec->effect_errors;
    desc.effect_error_count = spec->effect_error_count;
    desc.between_errors = spec->between_errors;
    desc.between_error_count = spec->between_error_count;
    uint16_t *preview = make_preview(&r, spec, &desc.info);
    desc.preview = preview;
    if (result == BTF_OK) {
        result = btf_material_create(&desc, log, out_material);
    }
    free(preview);
    for (int level = 0; level < BTF_MAX_LEVELS; ++level) {
        for (int id = 0; id < BTF_TEXTURE_COUNT; ++id) {
            free(texture[level][id]);
        }
    }
    return result;
}
