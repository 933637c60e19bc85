/* Tests of the reference decoder: seeded numbers, direction tables made from given triangles, and made-up
 * materials of every kind that FORMAT.md allows. Needs no library, so that it also runs where there is
 * none.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TEST_REFERENCE_MATERIAL_H
#define OPENBTF_TEST_REFERENCE_MATERIAL_H

#include <openbtf/reference.h>

#include <stddef.h>

enum {
    MADE_WIDTH = 7,
    MADE_HEIGHT = 5,
    MADE_TEXELS = MADE_WIDTH * MADE_HEIGHT,
    MADE_VIEWS = 9,
    MADE_LIGHTS = 5,
    MADE_CENTRES = 121, /**< as many as the atlas of the paper's layout has room for */
    MADE_ATLAS = 32,    /**< its width and height */
    MADE_COMPONENTS = 9,
    MADE_COMPONENT_LAYERS = 3,
    MADE_SBRDF_LAYERS = 8,
    MADE_GRID = 4,
    MADE_TABLE = 4 * 2048, /**< numbers in a direction table */
    MADE_UNITS = 12,
    MADE_UNIT_LAYERS = 24,
};

/** A float of the given bits, and back. */
static inline float float_of(uint32_t bits) {
    union {
        uint32_t bits;
        float value;
    } pun = {.bits = bits};
    return pun.value;
}

static inline uint32_t bits_of(float value) {
    union {
        float value;
        uint32_t bits;
    } pun = {.value = value};
    return pun.bits;
}

/** Marsaglia's xorshift of 32 bits; the state is never 0. */
static inline uint32_t random_bits(uint32_t *state) {
    *state ^= *state << 13;
    *state ^= *state >> 17;
    *state ^= *state << 5;
    return *state;
}

static inline uint32_t random_below(uint32_t *state, uint32_t limit) {
    return (random_bits(state) >> 8) % limit;
}

/** A multiple of span * 2^-24 in [low, low + span), when low is 0 or -span / 2. */
static inline float random_float(uint32_t *state, float low, float span) {
    float unit = (float)(random_bits(state) >> 8) * 0x1p-24f;
    float offset = unit * span;
    return low + offset;
}

/** A parameter that a file may hold: 0, or of magnitude 2^-24 to 2^24, of either sign. */
static inline float random_parameter(uint32_t *state) {
    uint32_t choice = random_below(state, 16);
    uint32_t sign = random_bits(state) & 0x80000000u;
    if (choice == 0) {
        return 0.0f;
    }
    if (choice == 1) {
        return float_of(sign | 0x33800000u); /* 2^-24 */
    }
    if (choice == 2) {
        return float_of(sign | 0x4B800000u); /* 2^24 */
    }
    return float_of(sign | (0x33800000u + random_below(state, 0x18000000u >> 8) * 256u));
}

/** A direction of length about 1 with z > 0, by stereographic projection of a point of the unit disc. */
static inline void random_direction(uint32_t *state, float out_direction[3]) {
    float a, b, r;
    do {
        a = random_float(state, -1.0f, 2.0f);
        b = random_float(state, -1.0f, 2.0f);
        float aa = a * a, bb = b * b;
        r = aa + bb;
    } while (r >= 1.0f);
    out_direction[0] = 2.0f * a / (1.0f + r);
    out_direction[1] = 2.0f * b / (1.0f + r);
    out_direction[2] = (1.0f - r) / (1.0f + r);
}

/** Directions as FORMAT.md, section 6, stores them. */
typedef struct direction_set {
    uint32_t n_vertices, n_triangles, n_hull;
    int32_t vertices[16][2];
    uint32_t triangles[16][3];
    uint32_t hull[16];
} direction_set;

/** 9 directions: the pole and an octagon. */
static const direction_set made_views = {
    .n_vertices = 9,
    .n_triangles = 8,
    .n_hull = 8,
    .vertices = {{8192, 8192},
                 {14192, 8192},
                 {12435, 12435},
                 {8192, 14192},
                 {3949, 12435},
                 {2192, 8192},
                 {3949, 3949},
                 {8192, 2192},
                 {12435, 3949}},
    .triangles = {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 5}, {0, 5, 6}, {0, 6, 7}, {0, 7, 8}, {0, 8, 1}},
    .hull = {1, 2, 3, 4, 5, 6, 7, 8},
};

/** 5 directions without symmetry; one lies on the rim of the disc. */
static const direction_set made_lights = {
    .n_vertices = 5,
    .n_triangles = 4,
    .n_hull = 4,
    .vertices = {{9001, 7503}, {16384, 8192}, {8000, 15001}, {1203, 9405}, {7777, 100}},
    .triangles = {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 1}},
    .hull = {1, 2, 3, 4},
};

static inline void put_record(uint16_t *texel, const int32_t (*vertices)[2], const uint32_t corner[3],
                              uint32_t edge) {
    const int32_t *a = vertices[corner[0]], *b = vertices[corner[1]], *c = vertices[corner[2]];
    int32_t bx = b[0] - a[0], by = b[1] - a[1], cx = c[0] - a[0], cy = c[1] - a[1];
    int32_t size = edge ? bx * bx + by * by : bx * cy - by * cx;
    uint32_t shift = 0;
    while (size >> shift >= 1 << 19) {
        ++shift;
    }
    for (int i = 0; i < 2; ++i) {
        texel[i] = (uint16_t)a[i];
        texel[2 + i] = (uint16_t)b[i];
        texel[4 + i] = (uint16_t)c[i];
    }
    texel[6] = (uint16_t)corner[2];
    texel[7] = (uint16_t)(edge + 2 * shift);
    texel[8] = (uint16_t)corner[0];
    texel[9] = (uint16_t)corner[1];
    texel[10] = texel[11] = 0;
}

/** The GPU table of a set of directions; every cell lists every record.
 *  @return the numbers written, 4 a texel. */
static inline size_t make_table(const direction_set *set, uint32_t grid, uint16_t *out_table) {
    uint32_t records = set->n_triangles + set->n_hull;
    for (uint32_t cell = 0; cell < grid * grid; ++cell) {
        uint16_t *texel = out_table + 4 * cell;
        texel[0] = (uint16_t)(cell * records);
        texel[1] = (uint16_t)records;
        texel[2] = texel[3] = 0;
        uint16_t *record = out_table + 4 * (grid * grid + 3 * cell * records);
        for (uint32_t i = 0; i < set->n_triangles; ++i, record += 12) {
            put_record(record, set->vertices, set->triangles[i], 0);
        }
        for (uint32_t i = 0; i < set->n_hull; ++i, record += 12) {
            uint32_t corner[3] = {set->hull[i], set->hull[(i + 1) % set->n_hull],
                                  set->hull[(i + 2) % set->n_hull]};
            put_record(record, set->vertices, corner, 1);
        }
    }
    return 4 * (size_t)(grid * grid + 3 * grid * grid * records);
}

/** The arrays that a made-up material points to. */
typedef struct made_storage {
    float sbrdf[MADE_SBRDF_LAYERS * MADE_TEXELS * 4];
    uint16_t sbrdf_half[MADE_SBRDF_LAYERS * MADE_TEXELS * 4];
    uint8_t maps[MADE_ATLAS * MADE_ATLAS * 4];
    uint8_t shadow[MADE_LIGHTS * MADE_TEXELS];
    uint8_t shift[MADE_VIEWS * MADE_TEXELS * 2];
    uint8_t gain[MADE_VIEWS * MADE_TEXELS];
    uint8_t centre[MADE_CENTRES * MADE_LIGHTS * 4];
    int8_t residual_texels[MADE_COMPONENT_LAYERS * MADE_TEXELS * 4];
    int8_t residual_directions[MADE_COMPONENT_LAYERS * 3 * MADE_VIEWS * MADE_LIGHTS * 4];
    float residual_scales[MADE_COMPONENT_LAYERS * 4];
    uint16_t view_table[MADE_TABLE];
    uint16_t light_table[MADE_TABLE];
} made_storage;

static inline float random_scale(uint32_t *state, float usual, int extreme) {
    float wild = float_of(0x33800000u + random_below(state, 0x18000000u >> 8) * 256u);
    return extreme ? wild : usual;
}

static inline void random_bytes(uint32_t *state, uint8_t *out_bytes, size_t count) {
    for (size_t i = 0; i < count; ++i) {
        uint32_t choice = random_below(state, 8);
        uint8_t byte = (uint8_t)(random_bits(state) >> 8);
        out_bytes[i] = choice == 0 ? 0 : choice == 1 ? 255 : byte;
    }
}

/** A half of magnitude 2^-14 to 32 and of either sign; with `extreme` of magnitude up to 65504, or 0. */
static inline uint16_t random_half(uint32_t *state, int extreme) {
    uint32_t bits = random_bits(state) >> 8 & 0xFFFFu;
    uint32_t magnitude = 0x400u + (bits & 0x7FFFu) % (extreme ? 0x7800u : 0x4C00u);
    if (extreme && (bits & 0xF0u) == 0) {
        return 0;
    }
    return (uint16_t)((bits & 0x8000u) | magnitude);
}

/** Fills a material with seeded contents: `kind` selects layout, domain, colour and float type (0 to 23),
 * `effects` those of the file. Gain codes 0 occur with hidden only; centre indices stay below K. `extreme`:
 * parameters and scales over all their range, else ordinary ones. */
static inline void make_material(uint32_t seed, uint32_t kind, uint32_t effects, int extreme,
                                 made_storage *s, btf_ref_material *out_material) {
    uint32_t state = seed * 2654435761u + 1u;
    state = state != 0 ? state : 1;
    /* clang-format off */
    btf_ref_material m = {
        .width = MADE_WIDTH, .height = MADE_HEIGHT, .n_views = MADE_VIEWS, .n_lights = MADE_LIGHTS,
        .layout_tight = kind & 1, .domain_sqrt = kind >> 1 & 1, .half_float = kind >> 2 & 1,
        .colour = (int)(kind >> 3) % 3, .effects = effects, .centres = MADE_CENTRES,
        .atlas_width = MADE_ATLAS, .atlas_height = MADE_ATLAS, .maps = s->maps, .shadow = s->shadow,
        .shift = s->shift, .gain = s->gain, .centre = s->centre, .residual_texels = s->residual_texels,
        .residual_directions = s->residual_directions, .residual_scales = s->residual_scales,
        .view_table = s->view_table, .light_table = s->light_table, .view_grid = MADE_GRID, .light_grid = 1,
    };
    /* clang-format on */
    m.lobes = 1 + random_below(&state, 4);
    m.components = 1 + random_below(&state, MADE_COMPONENTS);
    m.radiance_scale = random_scale(&state, 1.5f, extreme);
    m.shadow_scale = random_scale(&state, 0x1.010102p-8f, extreme);
    m.gain_scale = random_scale(&state, 0x1p-7f, extreme);
    m.centre_scale = random_scale(&state, 0x1.1p-8f, extreme);
    if (m.colour == BTF_REF_NONE) {
        m.lobes = 0;
        m.effects |= BTF_REF_RESIDUAL;
    }
    m.sbrdf = m.half_float ? (const void *)s->sbrdf_half : (const void *)s->sbrdf;

    for (size_t i = 0; i < sizeof s->sbrdf / sizeof *s->sbrdf; ++i) {
        /* usual: sums of lobes about 1 and exponents up to 30, a few negative */
        float usual = i % 4 == 3 ? random_float(&state, -2.0f, 32.0f) : random_float(&state, -0.25f, 1.25f);
        if (usual > -0x1p-24f && usual < 0x1p-24f) {
            usual = 0.0f;
        }
        s->sbrdf[i] = extreme ? random_parameter(&state) : usual;
        s->sbrdf_half[i] = random_half(&state, extreme);
    }
    random_bytes(&state, s->maps, sizeof s->maps);
    random_bytes(&state, s->shadow, sizeof s->shadow);
    random_bytes(&state, s->shift, sizeof s->shift);
    random_bytes(&state, s->gain, sizeof s->gain);
    random_bytes(&state, s->centre, sizeof s->centre);
    for (size_t i = 0; i < sizeof s->residual_texels; ++i) {
        s->residual_texels[i] = (int8_t)((int)random_below(&state, 255) - 127);
    }
    for (size_t i = 0; i < sizeof s->residual_directions; ++i) {
        s->residual_directions[i] = (int8_t)((int)random_below(&state, 255) - 127);
    }
    for (size_t i = 0; i < sizeof s->residual_scales / sizeof *s->residual_scales; ++i) {
        s->residual_scales[i] =
            extreme ? random_parameter(&state) : random_float(&state, 0x1p-20f, 0x1p-16f);
    }

    for (uint32_t view = 0; view < MADE_VIEWS; ++view) {
        for (uint32_t texel = 0; texel < MADE_TEXELS; ++texel) {
            uint32_t x, y;
            btf_ref_tile(&m, view, texel % MADE_WIDTH, texel / MADE_WIDTH, &x, &y);
            uint8_t *atlas = s->maps + 4 * (y * MADE_ATLAS + x);
            uint8_t *gain = s->gain + view * MADE_TEXELS + texel;
            uint8_t *shift = s->shift + 2 * (view * MADE_TEXELS + texel);
            if (!(m.effects & BTF_REF_HIDDEN)) {
                *gain = (uint8_t)(*gain | (*gain == 0));
                atlas[1] = (uint8_t)(atlas[1] | (atlas[1] == 0));
            }
            if (*gain == 0) {
                shift[0] = (uint8_t)random_below(&state, MADE_CENTRES);
                shift[1] = 0;
            }
            if (atlas[1] == 0) {
                atlas[2] = (uint8_t)random_below(&state, MADE_CENTRES);
                atlas[3] = 0;
            }
        }
    }
    make_table(&made_views, MADE_GRID, s->view_table);
    make_table(&made_lights, 1, s->light_table);
    *out_material = m;
}

/** Packs the points of a made-up material: any two bytes of its shifts are one. `extreme` as in make_material(). */
static inline void make_points(uint32_t seed, int extreme, made_storage *s, btf_ref_material *m) {
    uint32_t state = seed * 3266489917u + 1u;
    state = state != 0 ? state : 1;
    m->layout_tight = 1;
    m->effects = (m->effects | BTF_REF_SHIFT | BTF_REF_GAIN) & ~(uint32_t)BTF_REF_HIDDEN;
    m->points_packed = 1;
    m->points = s->shift;
    m->shift = m->gain = 0;
    m->gain_base = extreme ? random_parameter(&state) : random_float(&state, 0.25f, 0.5f);
    m->gain_step = extreme ? random_parameter(&state) : random_float(&state, 0.03125f, 0.125f);
}

/** The same in lists of `entries`, whose indices are any bytes that name one. */
static inline void make_lists(uint32_t seed, uint32_t entries, uint8_t (*indices)[MADE_VIEWS * MADE_TEXELS],
                              made_storage *s, btf_ref_material *m) {
    uint32_t state = seed * 668265263u + 1u;
    state = state != 0 ? state : 1;
    for (size_t i = 0; i < sizeof *indices; ++i) {
        (*indices)[i] = (uint8_t)(random_below(&state, entries) + 16 * random_below(&state, entries));
    }
    m->points = 0;
    m->point_lists = s->shift; /* as many entries as there are views at most */
    m->point_indices = *indices;
}

/** The arrays of version 2 that a made-up material points to. */
typedef struct made_factors {
    uint32_t texels[MADE_UNIT_LAYERS * MADE_TEXELS * 4];
    uint32_t directions[MADE_UNITS * MADE_VIEWS * MADE_LIGHTS * 4];
    float scales[MADE_UNITS * 4];
    float views[MADE_VIEWS * 3 * 4];
} made_factors;

/** A word of codes: all at their largest or smallest, or at random; no byte is -128. */
static inline uint32_t random_codes(uint32_t *state) {
    uint32_t choice = random_below(state, 6);
    if (choice < 2) {
        return choice == 0 ? 0x7F7F7F7Fu : 0x81818181u;
    }
    if (choice < 4) {
        return choice == 2 ? 0xFFFFFFFFu : 0x01010101u;
    }
    return random_bits(state) | 0x01010101u;
}

/** Gives a made-up material factors in place of components: random classes and words of colour, all of its
 * other effects kept. `extreme` as in make_material(). */
static inline void make_factors(uint32_t seed, int extreme, made_factors *f, btf_ref_material *m) {
    uint32_t state = seed * 2246822519u + 1u;
    state = state != 0 ? state : 1;
    m->store = BTF_REF_FACTORS;
    m->blend = m->domain_sqrt && random_below(&state, 2) ? BTF_REF_BLEND_ROOTS : BTF_REF_BLEND_RADIANCE;
    m->horizon_scale = random_below(&state, 2) ? random_scale(&state, 3.75f, extreme) : 1.0f;
    m->horizon_scale = m->horizon_scale < 1 ? 1 : m->horizon_scale;
    m->effects |= BTF_REF_RESIDUAL;
    m->components = 0;
    for (int c = 0; c < BTF_REF_FACTOR_CLASSES; ++c) {
        uint32_t *counts = m->factor_classes[c];
        counts[0] = random_below(&state, 3);
        counts[1] = random_below(&state, 4 * counts[0] + 1);
        counts[2] = random_below(&state, 4 * counts[0] - counts[1] + 1);
        m->components += counts[0];
    }
    m->factor_texels = f->texels;
    m->factor_directions = f->directions;
    m->factor_scales = f->scales;
    m->factor_views = f->views;
    for (size_t i = 0; i < sizeof f->texels / sizeof *f->texels; ++i) {
        f->texels[i] = random_codes(&state);
    }
    for (size_t i = 0; i < sizeof f->directions / sizeof *f->directions; ++i) {
        f->directions[i] = random_codes(&state);
    }
    for (size_t i = 0; i < sizeof f->scales / sizeof *f->scales; ++i) {
        f->scales[i] = extreme ? random_parameter(&state) : random_float(&state, 0x1p-14f, 0x1p-10f);
    }
    for (size_t i = 0; i < sizeof f->views / sizeof *f->views; ++i) {
        f->views[i] = i % 4 == 3 ? 0.0f
                      : extreme  ? random_parameter(&state)
                                 : random_float(&state, 0.0f, 1.0f);
    }
}

/** The arrays of relief and gloss that a made-up material points to, and tables of its own. */
typedef struct made_relief {
    uint8_t heights[MADE_TEXELS];
    float view_vectors[MADE_VIEWS * 4];
    uint16_t view_table[MADE_TABLE];
} made_relief;

/** The direction whose stereographic projection is a vertex of a table. */
static inline void direction_of_vertex(const int32_t vertex[2], float out_direction[3]) {
    float a = (float)(vertex[0] - 8192) * 0x1p-13f, b = (float)(vertex[1] - 8192) * 0x1p-13f;
    float aa = a * a, bb = b * b;
    float r = aa + bb;
    out_direction[0] = 2.0f * a / (1.0f + r);
    out_direction[1] = 2.0f * b / (1.0f + r);
    out_direction[2] = (1.0f - r) / (1.0f + r);
}

/** Gives a made-up material relief and gloss: random heights, some views that relief leaves alone, one of three levels
 * of detail. Its views are exactly where their vectors project. `extreme`: heights over all their range, else of up to
 * eight texels. */
static inline void make_relief(uint32_t seed, int extreme, made_relief *r, btf_ref_material *m) {
    uint32_t state = seed * 374761393u + 1u;
    state = state != 0 ? state : 1;
    m->layout_tight = 1;
    m->effects |= BTF_REF_RELIEF | BTF_REF_GLOSS;
    m->heights = r->heights;
    m->view_vectors = r->view_vectors;
    m->view_table = r->view_table;
    m->relief_steps = 1 + random_below(&state, 64);
    m->gloss_share = 1 + random_below(&state, 2);
    m->level = random_below(&state, 3);
    m->relief_base =
        extreme ? (int32_t)random_below(&state, 65536) - 32768 : (int32_t)random_below(&state, 2048) - 1024;
    int32_t room = (32767 - m->relief_base) * 256 / 255; /* the greatest height is at most 32767 */
    m->relief_step =
        (int32_t)random_below(&state, extreme ? (uint32_t)(room < 32767 ? room : 32767) + 1 : 2048);
    if (random_below(&state, 8) == 0) {
        m->relief_step = 0;
    }
    if (m->relief_step == 0) {
        m->relief_steps = 1;
    }
    random_bytes(&state, r->heights, sizeof r->heights);

    direction_set views = made_views;
    for (uint32_t view = 0; view < MADE_VIEWS; ++view) {
        float *vector = r->view_vectors + 4 * view;
        direction_of_vertex(made_views.vertices[view], vector);
        vector[3] = random_below(&state, 4) == 0 ? 0.0f : 1.0f;
        btf_ref_project(vector, views.vertices[view]);
    }
    make_table(&views, MADE_GRID, r->view_table);
}

/** A made-up material of any kind with relief and gloss, and what it points to. */
typedef struct made_all {
    btf_ref_material m;
    made_storage storage;
    made_factors factors;
    made_relief relief;
} made_all;

static inline void make_all(uint32_t seed, int extreme, made_all *out) {
    make_material(seed, seed | 1, seed % 3 ? 31 : seed / 3 % 32, extreme, &out->storage, &out->m);
    if (seed % 2) {
        make_factors(seed, extreme, &out->factors, &out->m);
    }
    if (seed % 7 == 3) {
        make_points(seed, extreme, &out->storage, &out->m);
    }
    make_relief(seed, extreme, &out->relief, &out->m);
}

#endif
