/* OpenBTF reference decoder: whether this build computes what FORMAT.md, section 8, demands.
 *
 * Every file is probed for contraction, reassociation and rounding with its own compiler flags; then the
 * arithmetic, the look-up and the whole evaluation of small made-up materials are run on seeded arguments,
 * and a hash of all bits is compared with the one that sound builds agree on. Takes about a millisecond.
 *
 * SPDX-License-Identifier: MIT
 */
#include "btf_reference_private.h"

#define ARITHMETIC_HASH 0xD17D2CC8u
#define EVALUATION_HASH 0x3EE5763Bu
#define FACTORS_HASH 0x3C92541Bu
#define RELIEF_HASH 0xC406F172u

enum {
    SIZE = 2,
    VIEWS = 3,
    LIGHTS = 2,
    LOBES = 2,
    COMPONENTS = 5,
    CENTRES = 10,
    ATLAS_WIDTH = 8,
    ATLAS_HEIGHT = 4,
    SBRDF_LAYERS = 5, /* RGB: 9 numbers in 3 layers, 2 lobes */
    RESIDUAL_LAYERS = 2,
    UNITS = 8,
    UNIT_LAYERS = 12,
};

/** Three views, a triangle; one cell, which lists the triangle and the three hull edges. */
static const uint16_t view_table[4 * 13] = {
    0,     4,     0,     0,                                      /* cell */
    4000,  5000,  13000, 6000,  8000,  13000, 2, 16, 0, 1, 0, 0, /* triangle, shift 8 */
    4000,  5000,  13000, 6000,  8000,  13000, 2, 17, 0, 1, 0, 0, /* edges, shift 8 */
    13000, 6000,  8000,  13000, 4000,  5000,  0, 17, 1, 2, 0, 0,
    8000,  13000, 4000,  5000,  13000, 6000,  1, 17, 2, 0, 0, 0,
};

/** Two lights: an edge there and back. */
static const uint16_t light_table[4 * 7] = {
    0,     2,    0,     0,                                    /* cell */
    6000,  8192, 10000, 9000, 6000,  8192, 0, 11, 0, 1, 0, 0, /* edges, shift 5 */
    10000, 9000, 6000,  8192, 10000, 9000, 1, 11, 1, 0, 0, 0,
};

/** Contents of the made-up material. */
typedef struct contents {
    float sbrdf[SBRDF_LAYERS * SIZE * SIZE * 4];
    float scales[RESIDUAL_LAYERS * 4];
    uint8_t maps[ATLAS_HEIGHT * ATLAS_WIDTH * 4];
    int8_t texels[RESIDUAL_LAYERS * SIZE * SIZE * 4];
    int8_t directions[3 * RESIDUAL_LAYERS * VIEWS * LIGHTS * 4];
} contents;

/** Marsaglia's xorshift of 32 bits. */
static uint32_t next_random(uint32_t *state) {
    *state ^= *state << 13;
    *state ^= *state >> 17;
    *state ^= *state << 5;
    return *state;
}

/** A float of 24 random bits in [low, low + span), as far as the rounding of this build allows. */
static float random_float(uint32_t *state, float low, float span) {
    float unit = (float)(next_random(state) >> 8) * 0x1p-24f;
    float offset = unit * span;
    return low + offset;
}

/** FNV-1a, a word at a time. */
static void add_to_hash(uint32_t *hash, uint32_t word) {
    *hash = (*hash ^ word) * 16777619u;
    *hash ^= *hash >> 15;
}

static void add_float(uint32_t *hash, float x) {
    add_to_hash(hash, btf_ref_bits(x));
}

static uint32_t hash_arithmetic(void) {
    uint32_t hash = 2166136261u, state = 1;
    for (int i = 0; i < 500; ++i) {
        float positive = btf_ref_float(0x33800000u + next_random(&state) % 0x1B000000u); /* 2^-24 to 2^30 */
        add_float(&hash, btf_ref_log2(positive));
        add_float(&hash, btf_ref_exp2(random_float(&state, -60.0f, 100.0f)));
        float base = random_float(&state, 0.0f, 1.5f), exponent = random_float(&state, 0.0f, 64.0f);
        add_float(&hash, btf_ref_pow(base, exponent));
        add_float(&hash, btf_ref_reciprocal(random_float(&state, 0.5f, 3.5f)));
        add_float(&hash, btf_ref_half((uint16_t)(next_random(&state) & 0x7BFFu)));
    }
    return hash;
}

static void fill(contents *c) {
    uint32_t state = 2;
    for (unsigned i = 0; i < sizeof c->sbrdf / sizeof *c->sbrdf; ++i) {
        c->sbrdf[i] = random_float(&state, 0.1f, 1.2f);
    }
    for (unsigned i = 0; i < sizeof c->scales / sizeof *c->scales; ++i) {
        c->scales[i] = random_float(&state, 0x1p-18f, 0x1p-16f);
    }
    for (unsigned i = 0; i < sizeof c->texels; ++i) {
        c->texels[i] = (int8_t)((int)(next_random(&state) >> 8) % 255 - 127);
    }
    for (unsigned i = 0; i < sizeof c->directions; ++i) {
        c->directions[i] = (int8_t)((int)(next_random(&state) >> 8) % 255 - 127);
    }
    for (unsigned i = 0; i < sizeof c->maps; ++i) {
        c->maps[i] = (uint8_t)(next_random(&state) >> 8 | 1); /* no gain code 0 */
    }
    /* a texel of view 1 and one of view 2 are hidden, behind centres that the atlas has: 9 and 1 */
    uint8_t *hidden = c->maps + 4 * (0 * ATLAS_WIDTH + SIZE);
    hidden[1] = 0, hidden[2] = 9, hidden[3] = 0;
    hidden = c->maps + 4 * (1 * ATLAS_WIDTH + 2 * SIZE + 1);
    hidden[1] = 0, hidden[2] = 1, hidden[3] = 0;
}

/** Contents of the made-up material of version 2. */
typedef struct factors {
    uint32_t texels[UNIT_LAYERS * SIZE * SIZE * 4];
    uint32_t directions[UNITS * VIEWS * LIGHTS * 4];
    float scales[UNITS * 4];
    float views[VIEWS * 3 * 4];
} factors;

/** Of each class units, words of C1 and of C2: all five, whole and mixed ones. */
static const uint32_t factor_classes[5][3] = {{1, 1, 2}, {2, 2, 3}, {2, 1, 0}, {2, 0, 3}, {1, 0, 0}};

static uint32_t hash_evaluations(btf_ref_material *material, uint32_t state, int count) {
    btf_ref_options options = {.effects = UINT32_MAX, .components = UINT32_MAX};
    uint32_t hash = 2166136261u;
    for (int i = 0; i < count; ++i) {
        bool version_2 = material->store == BTF_REF_FACTORS;
        material->colour = i % 2 != 0 ? BTF_REF_RGB : BTF_REF_MONO;
        material->domain_sqrt = i / 2 % 2;
        material->blend = version_2 && i / 2 % 4 == 3 ? BTF_REF_BLEND_ROOTS : BTF_REF_BLEND_RADIANCE;
        options.components = version_2 && i % 7 == 0 ? (uint32_t)i % UNITS : UINT32_MAX;
        options.interpolation = i % 3 != 0 ? BTF_REF_LINEAR : BTF_REF_NEAREST;
        options.filter = i % 5 != 0 ? BTF_REF_BILINEAR : BTF_REF_TEXEL;
        if ((material->effects & BTF_REF_RELIEF) && i % 5 > 2) {
            options.filter = BTF_REF_STEEP;
        }
        float light[3], view[3], radiance[3];
        for (int k = 0; k < 3; ++k) { /* the decoder does not mind directions that are not of unit length */
            light[k] = random_float(&state, k == 2 ? 0.01f : -0.8f, k == 2 ? 1.0f : 1.6f);
            view[k] = random_float(&state, k == 2 ? 0.01f : -0.8f, k == 2 ? 1.0f : 1.6f);
        }
        float u = random_float(&state, -2.0f, 4.0f), v = random_float(&state, -2.0f, 4.0f);
        btf_ref_evaluate(material, &options, u, v, light, view, radiance);
        for (int k = 0; k < 3; ++k) {
            add_float(&hash, radiance[k]);
        }
    }
    return hash;
}

static void fill_factors(factors *f) {
    uint32_t state = 5;
    for (unsigned i = 0; i < sizeof f->texels / sizeof *f->texels; ++i) {
        f->texels[i] = next_random(&state) | 0x01010101u; /* no byte is -128 */
    }
    for (unsigned i = 0; i < sizeof f->directions / sizeof *f->directions; ++i) {
        f->directions[i] = next_random(&state) | 0x01010101u;
    }
    /* one scale in four words, as whole units have it; smaller in wider classes */
    for (unsigned unit = 0; unit < UNITS; ++unit) {
        float scale = random_float(&state, 0x1p-8f, 0x1p-8f);
        for (unsigned word = 0; word < 4; ++word) {
            bool mixed = unit < 3 || unit == 3 || unit == 5;
            f->scales[4 * unit + word] = mixed ? scale * (float)(1 + word) : scale;
        }
    }
    for (unsigned i = 0; i < sizeof f->views / sizeof *f->views; ++i) {
        static const float tiers[3] = {0x1p-10f, 0x1p-5f, 1.0f};
        float factor = random_float(&state, 0x1p-4f, 0x1p-4f);
        f->views[i] = i % 4 == 3 ? 0.0f : factor * tiers[i / 4 % 3];
    }
}

static btf_ref_material make_material(const contents *c) {
    return (btf_ref_material){
        .width = SIZE,
        .height = SIZE,
        .n_views = VIEWS,
        .n_lights = LIGHTS,
        .lobes = LOBES,
        .effects = BTF_REF_SHADOW | BTF_REF_SHIFT | BTF_REF_HIDDEN | BTF_REF_GAIN | BTF_REF_RESIDUAL,
        .centres = CENTRES,
        .components = COMPONENTS,
        .atlas_width = ATLAS_WIDTH,
        .atlas_height = ATLAS_HEIGHT,
        .radiance_scale = 1.25f,
        .shadow_scale = 0x1.010102p-8f, /* 1/255 */
        .gain_scale = 0x1p-7f,
        .centre_scale = 0x1.1p-8f,
        .sbrdf = c->sbrdf,
        .maps = c->maps,
        .residual_texels = c->texels,
        .residual_directions = c->directions,
        .residual_scales = c->scales,
        .view_table = view_table,
        .light_table = light_table,
        .view_grid = 1,
        .light_grid = 1,
    };
}

static uint32_t hash_evaluation(void) {
    contents c;
    fill(&c);
    btf_ref_material material = make_material(&c);
    return hash_evaluations(&material, 3, 240);
}

/** The same material with factors in place of components. */
static btf_ref_material make_factor_material(const contents *c, const factors *f) {
    btf_ref_material material = make_material(c);
    material.store = BTF_REF_FACTORS;
    material.components = UNITS;
    material.horizon_scale = 2.5f;
    for (int i = 0; i < 5; ++i) {
        for (int k = 0; k < 3; ++k) {
            material.factor_classes[i][k] = factor_classes[i][k];
        }
    }
    material.factor_texels = f->texels;
    material.factor_directions = f->directions;
    material.factor_scales = f->scales;
    material.factor_views = f->views;
    return material;
}

static uint32_t hash_factors(void) {
    contents c;
    factors f;
    fill(&c);
    fill_factors(&f);
    btf_ref_material material = make_factor_material(&c, &f);
    return hash_evaluations(&material, 6, 240);
}

/** Factors alone in layout tight, with relief and gloss. */
static uint32_t hash_relief(void) {
    static const uint8_t heights[SIZE * SIZE] = {0, 200, 120, 255};
    static const float view_vectors[VIEWS * 4] = {-0.65f, -0.5f, 0.5723635f, 1.0f,  0.8f,       -0.36f,
                                                  0.48f,  1.0f,  -0.03f,     0.88f, 0.4740253f, 0.0f};
    contents c;
    factors f;
    fill(&c);
    fill_factors(&f);
    btf_ref_material material = make_factor_material(&c, &f);
    material.layout_tight = 1;
    material.effects = BTF_REF_RESIDUAL | BTF_REF_RELIEF | BTF_REF_GLOSS;
    material.heights = heights;
    material.view_vectors = view_vectors;
    material.relief_base = -150;
    material.relief_step = 700;
    material.relief_steps = 9;
    material.gloss_share = 2;
    material.level = 1;
    return hash_evaluations(&material, 8, 240);
}

int btf_ref_self_test(void) {
    return btf_ref_probe() && btf_ref_probe_arithmetic() && btf_ref_probe_addressing() &&
           btf_ref_probe_directions() && btf_ref_probe_evaluate() && btf_ref_probe_factors() &&
           btf_ref_probe_source() && btf_ref_probe_relief() && btf_ref_probe_gloss() &&
           btf_ref_probe_stochastic() && btf_ref_probe_sampling() && hash_arithmetic() == ARITHMETIC_HASH &&
           hash_evaluation() == EVALUATION_HASH && hash_factors() == FACTORS_HASH &&
           hash_relief() == RELIEF_HASH;
}
