/* The integer steps and the arithmetic of the decoder, each on its own, against the reference.
 *
 * SPDX-License-Identifier: MIT
 */
#include "cases.h"
#include "check_internal.h"
#include "decoder/toolkit/reference_view.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* One program answers for every step: b.w says which. Numbers as in the table below. */
static const char body[] =
    "uvec4 check(uvec4 a, uvec4 b) {\n"
    "    if (b.w == 0u)\n"
    "        return uvec4(btf_coordinate(uintBitsToFloat(a.x), a.y), 0u, 0u, 0u);\n"
    "    if (b.w == 1u)\n"
    "        return uvec4(btf_bilinear(a.x, a.y), 0u);\n"
    "    if (b.w == 2u)\n"
    "        return uvec4(btf_wrap(a.x, int(a.y), a.z), 0u, 0u, 0u);\n"
    "    if (b.w == 3u)\n"
    "        return uvec4(btf_project(uintBitsToFloat(a.xyz)), 0u, 0u);\n"
    "    if (b.w == 4u || b.w == 5u) {\n"
    "        btf_neighbours n, m;\n"
    "        if (b.w == 4u)\n"
    "            n = btf_lookup(btf_view_table, BTF_VIEW_GRID, ivec2(a.xy));\n"
    "        else\n"
    "            n = btf_lookup(btf_light_table, BTF_LIGHT_GRID, ivec2(a.xy));\n"
    "        m = btf_nearest(n);\n"
    "        return uvec4(n.index.x | n.index.y << 16u, n.index.z | m.index.x << 16u,\n"
    "                     n.weight.x | n.weight.y << 16u, n.weight.z | m.weight.x << 16u);\n"
    "    }\n"
    "#if !BTF_LAYOUT_TIGHT\n"
    "    if (b.w == 6u)\n"
    "        return uvec4(btf_tile(a.x, a.yz), 0u, 0u);\n"
    "#endif\n"
    "#if BTF_HIDDEN\n"
    "    if (b.w == 7u)\n"
    "        return uvec4(btf_centre(a.x, a.y), 0u, 0u);\n"
    "    if (b.w == 8u)\n"
    "        return uvec4(btf_centre_index(a.xyz), 0u, 0u, 0u);\n"
    "#endif\n"
    "    if (b.w == 9u)\n"
    "        return uvec4(btf_source(uvec2(b.xy), a.xyz, int(a.w)), 0u, 0u);\n"
    "    if (b.w == 10u)\n"
    "        return uvec4(btf_view_codes(a.xy, a.z, int(a.w)), 0u);\n"
    "#if BTF_SHADOW\n"
    "    if (b.w == 11u)\n"
    "        return uvec4(btf_shadow_code(a.xy, a.z, int(a.w)), 0u, 0u, 0u);\n"
    "#endif\n"
    "    if (b.w == 12u)\n"
    "        return uvec4(floatBitsToUint(btf_log2(uintBitsToFloat(a.x))),\n"
    "                     floatBitsToUint(btf_exp2(uintBitsToFloat(a.y))),\n"
    "                     floatBitsToUint(btf_pow(uintBitsToFloat(a.z), uintBitsToFloat(a.w))),\n"
    "                     floatBitsToUint(btf_reciprocal(uintBitsToFloat(b.x))));\n"
    "    return uvec4(0xFFFFFFFFu);\n"
    "}\n";

/* The state from which a step draws its elements. */
typedef struct context_of_step {
    const btf_material *material;
    btf_material_info info; /* width and height are the level's */
    const btf_ref_material *reference;
    uint32_t level;    /* of detail, for the steps that look at texels */
    uint32_t textures; /* those the decoder reads */
    uint32_t effects;  /* those it decodes */
    random_state random;
} steps;

/* Element i of a step: inputs (7 words; the eighth is the step's number) and the words expected. */
typedef void (*make_element)(steps *s, uint64_t i, uint32_t *in, uint32_t *out);

static void make_coordinate(steps *s, uint64_t i, uint32_t *in, uint32_t *out) {
    uint32_t size = i & 1   ? s->info.height
                    : i & 2 ? s->info.width
                            : 1 + random_below(&s->random, BTF_MAX_SIZE);
    float c = case_coordinate(&s->random, size);
    in[0] = bits_of_float(c);
    in[1] = size;
    out[0] = btf_ref_coordinate(c, size);
}

static void make_bilinear(steps *s, uint64_t i, uint32_t *in, uint32_t *out) {
    uint32_t size = i & 1   ? s->info.height
                    : i & 2 ? s->info.width
                            : 1 + random_below(&s->random, BTF_MAX_SIZE);
    uint32_t p = random_below(&s->random, 1u << 18);
    if (random_below(&s->random, 8) == 0) {
        p = random_below(&s->random, 2) ? 0x3FFFF - random_below(&s->random, 4)
                                        : random_below(&s->random, 4);
    }
    in[0] = p * size;
    in[1] = size;
    btf_ref_bilinear(in[0], size, &out[0], &out[1], &out[2]);
}

/* All 256 shifts at every column, then every row. */
static uint64_t count_wrap(const steps *s) {
    return 256 * ((uint64_t)s->info.width + s->info.height);
}

static void make_wrap(steps *s, uint64_t i, uint32_t *in, uint32_t *out) {
    uint32_t position = (uint32_t)(i / 256), size = s->info.width;
    int32_t shift = (int32_t)(i % 256) - 128;
    if (position >= size) {
        position -= size;
        size = s->info.height;
    }
    in[0] = position;
    in[1] = (uint32_t)shift;
    in[2] = size;
    out[0] = btf_ref_wrap(position, shift, size);
}

static void make_project(steps *s, uint64_t i, uint32_t *in, uint32_t *out) {
    btf_directions list = i & 1 ? btf_material_views(s->material) : btf_material_lights(s->material);
    float d[3];
    do {
        case_direction(&s->random, &list, d);
    } while (!(fabsf(d[0]) <= 2 && fabsf(d[1]) <= 2 && d[2] >= 0x1p-24f && d[2] <= 2));
    int32_t q[2];
    btf_ref_project(d, q);
    for (int c = 0; c < 3; ++c) {
        in[c] = bits_of_float(d[c]);
    }
    out[0] = (uint32_t)q[0];
    out[1] = (uint32_t)q[1];
}

static void make_lookup(steps *s, int of_lights, uint32_t *in, uint32_t *out) {
    btf_directions list = of_lights ? btf_material_lights(s->material) : btf_material_views(s->material);
    int32_t q[2];
    if (random_below(&s->random, 3) == 0) { /* anywhere */
        q[0] = (int32_t)random_below(&s->random, 16385);
        q[1] = (int32_t)random_below(&s->random, 16385);
    } else { /* at and between samples: edges, corners and their neighbourhood */
        uint32_t a = random_below(&s->random, list.count), b = random_below(&s->random, list.count);
        double t = random_below(&s->random, 3) ? random_between(&s->random, 0, 1) : 0;
        for (int c = 0; c < 2; ++c) {
            double x =
                (1 - t) * list.vertices[2 * a + (uint32_t)c] + t * list.vertices[2 * b + (uint32_t)c];
            q[c] = (int32_t)nearbyint(x) + (int32_t)random_below(&s->random, 3) - 1;
            q[c] = q[c] < 0 ? 0 : q[c] > 16384 ? 16384 : q[c];
        }
    }
    in[0] = (uint32_t)q[0];
    in[1] = (uint32_t)q[1];
    btf_ref_neighbours n = of_lights
                               ? btf_ref_lookup(s->reference->light_table, s->reference->light_grid, q)
                               : btf_ref_lookup(s->reference->view_table, s->reference->view_grid, q);
    btf_ref_neighbours m = btf_ref_nearest(n);
    out[0] = n.index[0] | n.index[1] << 16;
    out[1] = n.index[2] | m.index[0] << 16;
    out[2] = n.weight[0] | n.weight[1] << 16;
    out[3] = n.weight[2] | m.weight[0] << 16;
}

static void make_view_lookup(steps *s, uint64_t i, uint32_t *in, uint32_t *out) {
    (void)i;
    make_lookup(s, 0, in, out);
}

static void make_light_lookup(steps *s, uint64_t i, uint32_t *in, uint32_t *out) {
    (void)i;
    make_lookup(s, 1, in, out);
}

/* Every texel of every tile. */
static uint64_t count_tile(const steps *s) {
    if (s->info.layout != BTF_LAYOUT_PAPER) {
        return 0;
    }
    return (uint64_t)s->info.width * s->info.height *
           (s->info.n_views > s->info.n_lights ? s->info.n_views : s->info.n_lights);
}

static void make_tile(steps *s, uint64_t i, uint32_t *in, uint32_t *out) {
    uint64_t texels = (uint64_t)s->info.width * s->info.height;
    in[0] = (uint32_t)(i / texels);
    in[1] = (uint32_t)(i % texels % s->info.width);
    in[2] = (uint32_t)(i % texels / s->info.width);
    btf_ref_tile(s->reference, in[0], in[1], in[2], &out[0], &out[1]);
}

/* Every centre under every light. */
static uint64_t count_centre(const steps *s) {
    return s->effects & BTF_EFFECT_HIDDEN ? (uint64_t)s->info.centres * s->info.n_lights : 0;
}

static void make_centre(steps *s, uint64_t i, uint32_t *in, uint32_t *out) {
    in[0] = (uint32_t)(i / s->info.n_lights);
    in[1] = (uint32_t)(i % s->info.n_lights);
    btf_ref_centre(s->reference, in[0], in[1], &out[0], &out[1]);
}

/* All 65536 pairs of bytes, as an index. */
static uint64_t count_index(const steps *s) {
    return s->effects & BTF_EFFECT_HIDDEN ? 65536 : 0;
}

static void make_index(steps *s, uint64_t i, uint32_t *in, uint32_t *out) {
    (void)s;
    in[1] = (uint32_t)i & 255;
    in[2] = (uint32_t)i >> 8;
    out[0] = (uint32_t)i;
}

/* All 65536 pairs of bytes, as a shift; of packed points all 4096 pairs of codes, each often. */
static uint64_t count_shift(const steps *s) {
    (void)s;
    return 65536;
}

static void make_shift(steps *s, uint64_t i, uint32_t *in, uint32_t *out) {
    uint32_t column = random_below(&s->random, s->info.width),
             row = random_below(&s->random, s->info.height);
    int32_t dx = (int32_t)(i & 255), dy = (int32_t)(i >> 8);
    if (s->reference->points_packed) {
        dx &= 63;
        dy &= 63;
    }
    in[0] = random_below(&s->random, 16) ? 1 + random_below(&s->random, 255) : 0;
    in[1] = (uint32_t)dx;
    in[2] = (uint32_t)dy;
    in[3] = s->level;
    in[4] = column;
    in[5] = row;
    if (s->reference->points_packed) {
        dx -= 32;
        dy -= 32;
    } else {
        dx -= dx > 127 ? 256 : 0;
        dy -= dy > 127 ? 256 : 0;
    }
    int shifted =
        (s->effects & BTF_EFFECT_SHIFT) && !(in[0] == 0 && (s->reference->effects & BTF_REF_HIDDEN));
    out[0] = shifted ? btf_ref_wrap(column, dx, s->info.width) : column;
    out[1] = shifted ? btf_ref_wrap(row, dy, s->info.height) : row;
}

/* The codes of every texel in every view, as the textures hold them. */
static uint64_t count_codes(const steps *s) {
    return (uint64_t)s->info.width * s->info.height * s->info.n_views;
}

static void make_codes(steps *s, uint64_t i, uint32_t *in, uint32_t *out) {
    const btf_ref_material *m = s->reference;
    uint64_t texels = (uint64_t)s->info.width * s->info.height, texel = i % texels;
    in[0] = (uint32_t)(texel % s->info.width);
    in[1] = (uint32_t)(texel / s->info.width);
    in[2] = (uint32_t)(i / texels);
    in[3] = s->level;
    out[0] = 128;
    if (s->textures >> BTF_TEXTURE_MAPS & 1) {
        uint32_t x, y;
        btf_ref_tile(m, in[2], in[0], in[1], &x, &y);
        /* a variant that decodes the shadow alone reads nothing else of the texel */
        if (s->effects & (BTF_EFFECT_SHIFT | BTF_EFFECT_HIDDEN | BTF_EFFECT_GAIN)) {
            for (size_t c = 0; c < 3; ++c) {
                out[c] = m->maps[4 * ((size_t)y * m->atlas_width + x) + 1 + c];
            }
        }
        return;
    }
    if (s->textures >> BTF_TEXTURE_POINTS & 1) {
        const uint32_t point = m->points[2 * i] + 256u * m->points[2 * i + 1];
        out[0] = point / 4096;
        out[1] = point % 64;
        out[2] = point / 64 % 64;
    }
    if (s->textures >> BTF_TEXTURE_POINT_LISTS & 1) {
        const uint64_t two = m->point_indices[(in[2] / 2) * texels + texel];
        const uint8_t *entry = m->point_lists + 2 * ((in[2] & 1 ? two / 16 : two % 16) * texels + texel);
        out[0] = entry[1] / 16;
        out[1] = entry[0] % 64;
        out[2] = entry[0] / 64 + entry[1] % 16 * 4u;
    }
    if (s->textures >> BTF_TEXTURE_GAIN & 1) {
        out[0] = m->gain[i];
    }
    if (s->textures >> BTF_TEXTURE_SHIFT & 1) {
        out[1] = m->shift[2 * i];
        out[2] = m->shift[2 * i + 1];
    }
}

/* The shadow code of every texel under every light. */
static uint64_t count_shadow(const steps *s) {
    int shadow = (s->effects & BTF_EFFECT_SHADOW) && s->info.colour != BTF_COLOUR_NONE;
    return shadow ? (uint64_t)s->info.width * s->info.height * s->info.n_lights : 0;
}

static void make_shadow(steps *s, uint64_t i, uint32_t *in, uint32_t *out) {
    const btf_ref_material *m = s->reference;
    uint64_t texels = (uint64_t)s->info.width * s->info.height, texel = i % texels;
    in[0] = (uint32_t)(texel % s->info.width);
    in[1] = (uint32_t)(texel / s->info.width);
    in[2] = (uint32_t)(i / texels);
    in[3] = s->level;
    if (m->layout_tight) {
        out[0] = m->shadow[i];
    } else {
        uint32_t x, y;
        btf_ref_tile(m, in[2], in[0], in[1], &x, &y);
        out[0] = m->maps[4 * ((size_t)y * m->atlas_width + x)];
    }
}

static void make_arithmetic(steps *s, uint64_t i, uint32_t *in, uint32_t *out) {
    random_state *r = &s->random;
    (void)i;
    float x = float_of_bits(0x33800000u + random_below(r, 0x19000000u)); /* 2^-24 .. 2^26 */
    float e = (float)random_between(r, -60, 40);
    float base = random_below(r, 8) ? (float)random_between(r, 0, 2) : x,
          n = (float)exp2(random_between(r, -4, 8));
    if (random_below(r, 8) == 0) {
        base = -base;
    }
    if (random_below(r, 8) == 0) {
        n = float_of_bits((127 - 24 + random_below(r, 48)) << 23 | random_below(r, 2) << 31);
    }
    if (random_below(r, 64) == 0) {
        n = 0;
    }
    float d = (float)random_between(r, 0.5, 4);
    in[0] = bits_of_float(x);
    in[1] = bits_of_float(e);
    in[2] = bits_of_float(base);
    in[3] = bits_of_float(n);
    in[4] = bits_of_float(d);
    out[0] = bits_of_float(btf_ref_log2(x));
    out[1] = bits_of_float(btf_ref_exp2(e));
    out[2] = bits_of_float(btf_ref_pow(base, n));
    out[3] = bits_of_float(btf_ref_reciprocal(d));
}

/* In the order of the numbers in `body`. Without a count, elements are random and as many as allowed. */
static const struct {
    uint64_t (*count)(const steps *s);
    make_element make;
} table[] = {
    {NULL, make_coordinate},   {NULL, make_bilinear},       {count_wrap, make_wrap},
    {NULL, make_project},      {NULL, make_view_lookup},    {NULL, make_light_lookup},
    {count_tile, make_tile},   {count_centre, make_centre}, {count_index, make_index},
    {count_shift, make_shift}, {count_codes, make_codes},   {count_shadow, make_shadow},
    {NULL, make_arithmetic},
};
enum { STEP_COUNT = sizeof table / sizeof *table, MOST_RANDOM = 200000 };

const char *const check_step_names[] = {"coordinate", "bilinear", "wrap",       "project", "views",
                                        "lights",     "tile",     "centre",     "index",   "source",
                                        "codes",      "shadow",   "arithmetic", NULL};

static btf_result run_step(check_session *session, steps *s, uint32_t step, uint64_t most,
                           check_outcome *outcome) {
    uint64_t all = table[step].count ? table[step].count(s) : MOST_RANDOM;
    uint64_t count = all < most ? all : most;
    const uint64_t batch = (uint64_t)GPU_SIDE * GPU_SIDE;
    for (uint64_t first = 0; first < count; first += batch) {
        size_t n = (size_t)(count - first < batch ? count - first : batch);
        memset(session->inputs, 0, n * GPU_INPUTS * sizeof *session->inputs);
        memset(session->expected, 0, n * GPU_OUTPUTS * sizeof *session->expected);
        for (size_t i = 0; i < n; ++i) {
            /* a step with more elements than fit gets a random selection */
            uint64_t element = count < all && table[step].count ? random_bits(&s->random) % all : first + i;
            uint32_t *in = session->inputs + GPU_INPUTS * i;
            table[step].make(s, element, in, session->expected + GPU_OUTPUTS * i);
            in[7] = step;
        }
        btf_result result = check_batch(session, check_step_names[step], first, n, GPU_OUTPUTS, outcome);
        if (result != BTF_OK) {
            return result;
        }
    }
    return BTF_OK;
}

/* The look-up steps run on the material's tables with wide indices: index i becomes i * 257 modulo 2^16, so that both
 * bytes of an index matter even in a material of few directions. Replaces the table on the GPU; NULL where memory is
 * out. */
static uint16_t *widen_table(const check_session *session, btf_texture_id id) {
    const btf_material *material = session->subject->material;
    const btf_texture t = btf_material_texture(material, id);
    const btf_directions d =
        id == BTF_TEXTURE_VIEW_TABLE ? btf_material_views(material) : btf_material_lights(material);
    const size_t cells = (size_t)d.grid * d.grid;
    const gl_api *gl = gpu_api(session->subject->gpu);
    uint16_t *wide = malloc(t.size);
    if (!wide) {
        return NULL;
    }
    memcpy(wide, t.data, t.size);
    for (size_t r = 0; r < d.cells_length - cells; ++r) {
        uint16_t *record = wide + 4 * (cells + 3 * r);
        static const int places[] = {6, 8, 9}; /* ic, ia, ib */
        for (int i = 0; i < 3; ++i) {
            record[places[i]] = (uint16_t)(257u * record[places[i]]);
        }
    }
    gl->ActiveTexture(GL_TEXTURE0);
    gl->BindTexture(GL_TEXTURE_2D, btf_gl_texture(session->gl, id));
    gl->TexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, (GLsizei)t.width, (GLsizei)t.height, GL_RGBA_INTEGER,
                      GL_UNSIGNED_SHORT, wide);
    return wide;
}

btf_result check_steps(const check_subject *subject, uint64_t seed, uint64_t most, const char *only,
                       check_outcome *outcome) {
    check_session session;
    btf_result result = check_begin(subject, body, &session);
    if (result != BTF_OK) {
        return result;
    }
    steps s = {.material = subject->material, .reference = &session.reference, .random = {seed}};
    s.info.struct_size = sizeof s.info;
    btf_material_get_info(subject->material, &s.info);
    s.level = (uint32_t)(seed % s.info.levels);
    reference_view(subject->material, s.level, &session.reference);
    s.info.width = session.reference.width;
    s.info.height = session.reference.height;
    s.textures = btf_shader_textures(&s.info, subject->shader);
    s.effects = s.info.effects & ~subject->shader->leave_out;
    uint16_t *views = widen_table(&session, BTF_TEXTURE_VIEW_TABLE),
             *lights = widen_table(&session, BTF_TEXTURE_LIGHT_TABLE);
    session.reference.view_table = views;
    session.reference.light_table = lights;
    if (!views || !lights) {
        result = BTF_ERROR_MEMORY;
    }
    for (uint32_t step = 0; step < STEP_COUNT && result == BTF_OK; ++step) {
        if (!only || strcmp(only, check_step_names[step]) == 0) {
            result = run_step(&session, &s, step, most, outcome);
        }
    }
    check_end(&session);
    free(views);
    free(lights);
    return result;
}
