/* Every class of float bit pattern in a file is either refused, with a message that names its place, or decodes to
 * finite radiance. No argument gives anything but finite radiance, and addresses do not overflow in the largest
 * textures.
 *
 * SPDX-License-Identifier: MIT
 */
#include "bits.h"
#include "cases.h"

#include "tests/conformance/cases.h"
#include "tests/support/exr_edit.h"
#include <openbtf/reference.h>
#include "decoder/toolkit/reference_view.h"
#include "tests/support/messages.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

static bool is_legal(uint32_t bits) {
    const uint32_t magnitude = bits & 0x7FFFFFFFu;
    return magnitude == 0 || (magnitude >= 0x33800000u && magnitude <= 0x4B800000u);
}

/* ---- what a file may hold ---- */

/* A material of this kind, saved, to be edited. */
static edit_file *saved_file(const synthetic_spec *spec) {
    btf_material *material = NULL;
    void *data;
    size_t size;
    if (synthetic_create(spec, NULL, &material) != BTF_OK ||
        btf_material_save_memory(material, NULL, &data, &size) != BTF_OK) {
        exit(1);
    }
    btf_material_close(&material);
    edit_file *file = edit_load(data, size);
    btf_free(data);
    return file;
}

/* Puts each class into each float channel of the part `sbrdf` of a file, at a texel of its own. */
static void file_parameters(void) {
    for (size_t k = 0; k < bit_class_count; k++) {
        bool ok = true;
        int places = 0;
        char example[200] = "opens, radiance finite";
        for (int spec = 0; spec < BITS_FACTORS; spec += 4) { /* one colour, RGB lobes; floats */
            const synthetic_spec s = bits_spec(spec);
            edit_file *file = saved_file(&s);
            btf_material *material = NULL;
            void *data;
            size_t size;
            edit_part *part = edit_find_part(file, "sbrdf");
            for (int c = 0; c < part->channel_count; c++) {
                const int x = (c + (int)k) % part->width, y = c % part->height;
                uint32_t *texel = (uint32_t *)part->channels[c].data + y * part->width + x;
                const uint32_t before = *texel;
                *texel = bit_classes[k].bits;
                edit_save(file, &data, &size);
                *texel = before;
                last_message[0] = 0;
                const btf_result result = btf_material_open_memory(data, size, &log_keep, &material);
                free(data);
                places++;
                if (bit_classes[k].legal) {
                    ok = ok && result == BTF_OK && bits_decode(material, k + 1, 40);
                } else {
                    char place[100];
                    snprintf(place, sizeof place, "sbrdf: channel %s at (%d, %d) holds",
                             part->channels[c].name, x, y);
                    ok = ok && result == BTF_ERROR_BAD_FILE && strstr(last_message, place) != NULL;
                    snprintf(example, sizeof example, "refused: %s", last_message);
                }
                btf_material_close(&material);
            }
            edit_free(file);
        }
        cases_add(told("parameter of a file: %s", bit_classes[k].name),
                  bit_classes[k].legal ? "opens; radiance finite"
                                       : "refused, part, channel and texel named",
                  ok, "%d places, e.g. %s", places, example);
    }
}

/* Each class in each float attribute of the header. */
static void file_scales(void) {
    enum { POSITIVE = -1, FROM_ONE = -2 };
    static const struct {
        const char *name;
        int spec, number; /* POSITIVE, FROM_ONE: the attribute is one float, of that range */
    } list[] = {{"openbtf.radianceScale", 1, POSITIVE},
                {"openbtf.shadowScale", 1, POSITIVE},
                {"openbtf.gainScale", 1, POSITIVE},
                {"openbtf.centreScale", 1, POSITIVE},
                {"openbtf.residualScales", 1, 2},
                {"openbtf.factorScales", BITS_FACTORS + 1, 6},
                {"openbtf.factorViews", BITS_FACTORS + 1, 40},
                {"openbtf.horizonScale", BITS_FACTORS + 1, FROM_ONE}};
    btf_material *material = NULL;
    void *data;
    size_t size;
    for (size_t n = 0; n < sizeof list / sizeof *list; n++) {
        bool ok = true;
        const synthetic_spec s = bits_spec(list[n].spec);
        edit_file *file = saved_file(&s);
        edit_attribute *a = edit_find_attribute(file, list[n].name);
        const bool many = list[n].number >= 0; /* one number of several, which may be 0 or negative */
        float *value = many ? a->values + list[n].number : &a->f;
        int refused = 0;
        for (size_t k = 0; k < bit_class_count; k++) {
            *value = float_of_bits(bit_classes[k].bits);
            edit_save(file, &data, &size);
            last_message[0] = 0;
            const btf_result result = btf_material_open_memory(data, size, &log_keep, &material);
            free(data);
            const bool legal = bit_classes[k].legal &&
                               (many || *value > (list[n].number == FROM_ONE ? 0x1.fffffep-1f : 0));
            ok = ok && (result == BTF_OK) == legal;
            if (result == BTF_OK) {
                ok = ok && bits_decode(material, k + 1, 100);
            } else {
                refused++;
                ok = ok && result == BTF_ERROR_BAD_FILE &&
                     strstr(last_message, strchr(list[n].name, '.') + 1) != NULL;
            }
            btf_material_close(&material);
        }
        edit_free(file);
        cases_add(told("every class of bits in %s", list[n].name),
                  many ? "refused by name, or 0 or of magnitude 2^-24 to 2^24"
                  : list[n].number == FROM_ONE
                      ? "refused by name, or 1 to 2^24"
                      : "refused by name, or positive and of magnitude 2^-24 to 2^24",
                  ok, "%d of %zu refused", refused, bit_class_count);
    }
}

/* Every exponent, both signs, three mantissas; and every half there is (one of 13 in light runs). */
static void all_patterns(void) {
    const bool light = getenv("BTF_TEST_LIGHT") != NULL;
    for (int half = 0; half < 2; half++) {
        const synthetic_spec s = bits_spec(half ? 2 : 0);
        bits_desc d;
        bits_begin(&s, &d);
        bool ok = true;
        int legal = 0, seen = 0;
        for (uint32_t i = 0; i < (half ? 65536u : 1536u); i += half && light ? 13 : 1) {
            static const uint32_t mantissas[3] = {0, 1, 0x7FFFFF};
            const uint32_t bits = half ? i : (i & 1) << 31 | (i / 2 % 256) << 23 | mantissas[i / 512];
            const uint32_t place = i * 7 % (4 * 15);
            bool want;
            if (half) {
                uint16_t *at = (uint16_t *)d.texture[BTF_TEXTURE_SBRDF] + place, before = *at;
                *at = (uint16_t)bits;
                want = (bits & 0x7FFF) == 0 || ((bits & 0x7C00) != 0 && (bits & 0x7C00) != 0x7C00);
                btf_material *material = NULL;
                ok = ok && (btf_material_create(&d.desc, NULL, &material) == BTF_OK) == want;
                ok = ok && (!want || i % 16 != 0 || bits_decode(material, i, 2));
                btf_material_close(&material);
                *at = before;
            } else {
                float *at = (float *)d.texture[BTF_TEXTURE_SBRDF] + place, before = *at;
                memcpy(at, &bits, sizeof bits);
                want = is_legal(bits);
                btf_material *material = NULL;
                ok = ok && (btf_material_create(&d.desc, NULL, &material) == BTF_OK) == want;
                ok = ok && (!want || bits_decode(material, i, 4));
                btf_material_close(&material);
                *at = before;
            }
            legal += want;
            seen++;
        }
        bits_end(&d);
        cases_add(half ? "all 65536 half floats"
                       : "every exponent, both signs, mantissas of 0, 1 and all ones",
                  half ? "zeros and normal numbers alone are taken"
                       : "0 and 2^-24 to 2^24 alone are taken; radiance finite",
                  ok, "%d of %d taken", legal, seen);
    }
}

static void extreme_materials(void) {
    bool ok = true;
    for (int i = 0; i < 4 * BITS_SPECS; i++) {
        const synthetic_spec s = bits_spec(i % BITS_SPECS);
        random_state r = {(uint64_t)i + 7};
        bits_desc d;
        btf_material *material = NULL;
        bits_begin(&s, &d);
        bits_fill(&r, &d);
        ok = ok && btf_material_create(&d.desc, NULL, &material) == BTF_OK &&
             bits_decode(material, (uint64_t)i, 1500);
        btf_material_close(&material);
        bits_end(&d);
    }
    cases_add("48 materials of nothing but limits, 72000 random and extreme arguments",
              "radiance finite and not negative, twice the same bits", ok,
              "all effects, both layouts, both domains, both stores, both blends");
}

/* ---- arguments ---- */

static void coordinates(void) {
    static const struct {
        const char *name;
        float value;
        float same_as; /* a coordinate that it has to equal */
    } list[] = {
        {"NaN", NAN, 0},
        {"infinity", INFINITY, 0},
        {"-infinity", -INFINITY, 0},
        {"1e9", 1e9f, 0},
        {"-1e9", -1e9f, 0},
        {"4096.5", 4096.5f, 0},
        {"1e-40", 1e-40f, 0},
        {"-0", -0.0f, 0},
        {"1", 1, 0},
        {"-1", -1, 0},
        {"4096", 4096, 0},
        {"-4096", -4096, 0},
        {"-0.25", -0.25f, 0.75f},
        {"3.5", 3.5f, 0.5f},
        {"-4095.75", -4095.75f, 0.25f},
        {"4095.5", 4095.5f, 0.5f},
    };
    const synthetic_spec s = bits_spec(1);
    btf_material *material = NULL;
    btf_ref_material view;
    if (synthetic_create(&s, NULL, &material) != BTF_OK || reference_view(material, 0, &view) != 0) {
        exit(1);
    }
    const float light[3] = {0.3f, 0.2f, 0.93f}, eye[3] = {-0.4f, 0.1f, 0.91f};
    for (size_t i = 0; i < sizeof list / sizeof *list; i++) {
        bool ok = true;
        float rgb[2][3];
        for (int filter = 0; filter < 3; filter++) {
            const btf_ref_options options = {UINT32_MAX, UINT32_MAX, BTF_REF_LINEAR, filter};
            for (int axis = 0; axis < 2; axis++) {
                btf_ref_evaluate(&view, &options, axis ? 0.4f : list[i].value, axis ? list[i].value : 0.4f,
                                 light, eye, rgb[0]);
                btf_ref_evaluate(&view, &options, axis ? 0.4f : list[i].same_as,
                                 axis ? list[i].same_as : 0.4f, light, eye, rgb[1]);
                ok = ok && memcmp(rgb[0], rgb[1], sizeof rgb[0]) == 0 && isfinite(rgb[0][0]);
            }
        }
        char input[60], expected[60];
        snprintf(input, sizeof input, "u or v = %s", list[i].name);
        snprintf(expected, sizeof expected, "the same bits as at %g", (double)list[i].same_as);
        cases_add(input, expected, ok, "both axes, all filters, e.g. %g", (double)rgb[0][0]);
    }
    btf_material_close(&material);

    bool ok = true;
    static const uint32_t sizes[] = {1, 2, 7, 1000, 16383, 16384};
    for (uint32_t k = 0; k < 6; k++) {
        for (uint64_t bits = 0; bits <= UINT32_MAX;
             bits += 65521) { /* prime: every exponent, many mantissas */
            uint32_t c0, c1, f, t = btf_ref_coordinate(float_of_bits((uint32_t)bits), sizes[k]);
            btf_ref_bilinear(t, sizes[k], &c0, &c1, &f);
            ok = ok && t >> 18 < sizes[k] && c0 < sizes[k] && c1 < sizes[k] && f < 256;
        }
    }
    cases_add("65552 bit patterns as coordinates of 1 to 16384 texels", "texels inside, weights below 256",
              ok, "6 sizes");
}

static void directions(void) {
    const synthetic_spec s = bits_spec(0);
    btf_material *material = NULL;
    btf_ref_material view;
    if (synthetic_create(&s, NULL, &material) != BTF_OK || reference_view(material, 0, &view) != 0) {
        exit(1);
    }
    static const uint32_t parts[] = {0,          0x80000000, 1,          0x3F800000,
                                     0xBF800000, 0x33800000, 0x337FFFFF, 0x40000000,
                                     0x40000001, 0x7F800000, 0xFF800000, 0x7FC00000};
    const btf_ref_options options = {UINT32_MAX, UINT32_MAX, BTF_REF_LINEAR, BTF_REF_BILINEAR};
    bool ok = true, dark = true;
    for (size_t i = 0; i < 12 * 12 * 12; i++) {
        const float d[3] = {float_of_bits(parts[i % 12]), float_of_bits(parts[i / 12 % 12]),
                            float_of_bits(parts[i / 144])};
        const float pole[3] = {0, 0, 1};
        for (int which = 0; which < 2; which++) {
            float rgb[3];
            btf_ref_evaluate(&view, &options, 0.3f, 0.6f, which ? pole : d, which ? d : pole, rgb);
            for (int c = 0; c < 3; c++) {
                ok = ok && rgb[c] >= 0 && rgb[c] <= 0x1.fffffep127f;
            }
            const bool usable =
                fabsf(d[0]) <= 2 && fabsf(d[1]) <= 2 && fabsf(d[2]) <= 2 && d[2] >= 0x1p-24f;
            dark = dark && (usable || (rgb[0] == 0 && rgb[1] == 0 && rgb[2] == 0));
        }
    }
    cases_add("light or view of every three of 0, -0, 1, -1, 2^-24, 2, denormal, infinities, NaN",
              "finite; 0 below the horizon and for what is no direction", ok && dark, "1728 vectors each");
    btf_material_close(&material);
}

static void weights(void) {
    static const struct {
        const char *name;
        synthetic_directions kind;
        uint32_t count;
    } lists[] = {{"one direction", SYNTHETIC_RANDOM, 1},       {"two directions", SYNTHETIC_RANDOM, 2},
                 {"9 collinear ones", SYNTHETIC_COLLINEAR, 9}, {"81 in rings", SYNTHETIC_RINGS, 81},
                 {"256 in rings", SYNTHETIC_RINGS, 256},       {"256 at random", SYNTHETIC_RANDOM, 256}};
    for (size_t k = 0; k < sizeof lists / sizeof *lists; k++) {
        synthetic_spec s = bits_spec(1);
        s.n_views = s.n_lights = lists[k].count;
        s.directions = lists[k].kind;
        s.width = s.height = 1;
        btf_material *material = NULL;
        btf_ref_material view;
        if (synthetic_create(&s, NULL, &material) != BTF_OK || reference_view(material, 0, &view) != 0) {
            exit(1);
        }
        bool ok = true;
        int n = 0;
        for (int32_t y = 0; y <= 16384; y += 61) {
            for (int32_t x = 0; x <= 16384; x += 53, n++) {
                const int32_t q[2] = {x, y};
                const btf_ref_neighbours w = btf_ref_lookup(view.view_table, view.view_grid, q);
                const btf_ref_neighbours one = btf_ref_nearest(w);
                ok = ok && w.weight[0] + w.weight[1] + w.weight[2] == 4096 && w.weight[0] <= 4096 &&
                     w.weight[1] <= 4096 && w.weight[2] <= 4096 && one.weight[0] == 4096;
                for (int i = 0; i < 3; i++) {
                    ok = ok && w.index[i] < lists[k].count;
                }
            }
        }
        cases_add(told("weights of %s", lists[k].name),
                  "sum to 4096 of 4096 exactly, all neighbours exist", ok, "%d look-ups", n);
        btf_material_close(&material);
    }
}

/* ---- the largest textures ---- */

/* Zeros that take no memory until they are written to; NULL when the machine does not give so many addresses. */
static void *lend(size_t size) {
    void *p = mmap(NULL, size, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    return p == MAP_FAILED ? NULL : p;
}

/* The direction tables of a small material around textures of 16384 x 16384. */
static void largest(void) {
    enum { SIDE = 16384, VIEWS = 5, LIGHTS = 256, LOBES = 3, COMPONENTS = 8 };
    const char *const expected = "the last texel of the last layer is the one that decodes";
    synthetic_spec s = bits_spec(1);
    s.n_views = VIEWS;
    s.n_lights = LIGHTS;
    s.width = s.height = 1;
    btf_material *material = NULL;
    btf_ref_material m;
    if (synthetic_create(&s, NULL, &material) != BTF_OK || reference_view(material, 0, &m) != 0) {
        exit(1);
    }
    const size_t texels = (size_t)SIDE * SIDE, last = texels - 1;
    const size_t sbrdf_size = (1 + LOBES) * texels * 16, shadow_size = LIGHTS * texels,
                 shift_size = VIEWS * texels * 2;
    float *sbrdf = lend(sbrdf_size);
    uint8_t *shadow = lend(shadow_size), *shift = lend(shift_size), *gain = lend(VIEWS * texels);
    int8_t *residual = lend(COMPONENTS / 4 * texels * 4);
    const btf_directions lights = btf_material_lights(material), views = btf_material_views(material);
    const float *l = lights.xyz + 3 * (LIGHTS - 1), *v = views.xyz + 3 * (VIEWS - 1);
    const char *const tight = "layout tight, 16384 x 16384 texels, 256 lights: 64 GiB of shadow";
    if (sbrdf && shadow && shift && gain && residual) {
        /* texel (SIDE - 1, SIDE - 1) sees itself in the last view, under the last light */
        for (uint32_t j = 0; j <= LOBES; j++) {
            float *p = sbrdf + 4 * (j * texels + last);
            p[0] = p[1] = p[2] = j == 0 ? 1 : 0;
            p[3] = j == 0 ? 0.5f : 1;
        }
        sbrdf[4 * (LOBES * texels + last) + 2] = 4; /* the last lobe: 4 lz vz */
        shadow[(LIGHTS - 1) * texels + last] = 255;
        gain[(VIEWS - 1) * texels + last] = 64;
        residual[4 * (texels + last) + 3] = 100; /* the last component */
        int8_t *const residual_directions = calloc(3 * COMPONENTS / 4 * LIGHTS * VIEWS, 4);
        for (size_t c = 0; c < 3; c++) {
            residual_directions[4 * ((3 + c) * LIGHTS * VIEWS + LIGHTS * VIEWS - 1) + 3] = 50;
        }
        const float scales[COMPONENTS] = {0, 0, 0, 0, 0, 0, 0, 0x1p-14f};
        btf_ref_material big = m;
        big.width = big.height = SIDE;
        big.layout_tight = 1;
        big.domain_sqrt = 0;
        big.colour = BTF_REF_MONO;
        big.half_float = 0;
        big.lobes = LOBES;
        big.effects = BTF_REF_SHADOW | BTF_REF_SHIFT | BTF_REF_GAIN | BTF_REF_RESIDUAL;
        big.components = COMPONENTS;
        big.radiance_scale = 1;
        big.shadow_scale = 1 / 255.0f;
        big.gain_scale = 0x1p-7f;
        big.sbrdf = sbrdf;
        big.shadow = shadow;
        big.shift = shift;
        big.gain = gain;
        big.residual_texels = residual;
        big.residual_directions = residual_directions;
        big.residual_scales = scales;
        const btf_ref_options options = {UINT32_MAX, UINT32_MAX, BTF_REF_NEAREST, BTF_REF_TEXEL};
        const double want =
            0.5 * (double)l[2] * ((0.5 + 4 * (double)l[2] * (double)v[2]) + 100 * 50 * 0x1p-14);
        float rgb[2][3];
        btf_ref_evaluate_texel(&big, &options, SIDE - 1, SIDE - 1, l, v, rgb[0]);
        btf_ref_evaluate(&big, &options, 0x1.fffep-1f, 0, l, v,
                         rgb[1]); /* the same by coordinates: bottom right */
        const bool ok = fabs((double)rgb[0][0] - want) < 1e-5 && memcmp(rgb[0], rgb[1], sizeof rgb[0]) == 0;
        cases_add(tight, expected, ok, "%.7g, worked out %.7g", (double)rgb[0][0], want);
        free(residual_directions);
    } else {
        cases_skip(tight, expected, "no address space");
    }
    if (sbrdf) {
        munmap(sbrdf, sbrdf_size);
    }
    if (shadow) {
        munmap(shadow, shadow_size);
    }
    if (shift) {
        munmap(shift, shift_size);
    }
    if (gain) {
        munmap(gain, VIEWS * texels);
    }
    if (residual) {
        munmap(residual, COMPONENTS / 4 * texels * 4);
    }

    /* layout paper: an atlas of 16384 x 16384 full of tiles and centres */
    btf_material_info info = {.struct_size = sizeof info,
                              .width = 1024,
                              .height = 1024,
                              .n_views = VIEWS,
                              .n_lights = 255,
                              .layout = BTF_LAYOUT_PAPER,
                              .effects = BTF_EFFECT_SHADOW | BTF_EFFECT_SHIFT | BTF_EFFECT_HIDDEN,
                              .colour = BTF_COLOUR_MONO,
                              .lobes = 3};
    const btf_texture maps = btf_material_texture_shape(&(btf_material_info){.struct_size = sizeof info,
                                                                             .width = 16384,
                                                                             .height = 16384,
                                                                             .n_views = 1,
                                                                             .n_lights = 1,
                                                                             .layout = BTF_LAYOUT_TIGHT,
                                                                             .effects = BTF_EFFECT_SHADOW,
                                                                             .colour = BTF_COLOUR_MONO,
                                                                             .lobes = 4},
                                                        BTF_TEXTURE_SBRDF);
    cases_add("size of sbrdf, 16384 x 16384 texels, 4 lobes", "20 GiB, not modulo 2^32",
              maps.size == (size_t)5 << 32, "%zu bytes", maps.size);
    uint32_t room = 0;
    info.n_lights = 250;
    const btf_result planned = btf_material_atlas(&info, &info.atlas_width, &info.atlas_height, &room);
    uint8_t *atlas = lend((size_t)4 * SIDE * SIDE);
    const char *const paper = "layout paper, 1024 x 1024 texels, 250 tiles: the atlas is 16384 x 16384";
    if (planned != BTF_OK || info.atlas_width != SIDE || info.atlas_height != SIDE) {
        cases_add(paper, expected, false, "planned %u x %u", info.atlas_width, info.atlas_height);
    } else if (atlas == NULL) {
        cases_skip(paper, expected, "no address space");
    } else {
        btf_ref_material big = {.width = 1024,
                                .height = 1024,
                                .n_views = VIEWS,
                                .n_lights = 250,
                                .effects = info.effects,
                                .lobes = 3,
                                .atlas_width = SIDE,
                                .atlas_height = SIDE,
                                .centres = room,
                                .maps = atlas,
                                .centre_scale = 1,
                                .radiance_scale = 1};
        uint32_t x, y, px, py;
        bool ok = true;
        btf_ref_centre(&big, room - 1, 249, &x, &y);
        btf_material_atlas_centre(&info, room - 1, &px, &py);
        ok = ok && x == px && y == py + 249 && x < SIDE && y < SIDE;
        atlas[4 * ((size_t)y * SIDE + x)] = 9;
        /* texel (3, 2) of the last view is hidden behind the last centre */
        btf_ref_tile(&big, VIEWS - 1, 3, 2, &x, &y);
        uint8_t *point = atlas + 4 * ((size_t)y * SIDE + x);
        point[1] = 0;
        point[2] = (uint8_t)((room - 1) & 255);
        point[3] = (uint8_t)((room - 1) >> 8);
        const btf_ref_options options = {UINT32_MAX, UINT32_MAX, BTF_REF_LINEAR, BTF_REF_TEXEL};
        const btf_ref_neighbours light = {{249, 0, 0}, {4096, 0, 0}},
                                 view = {{VIEWS - 1, 0, 0}, {4096, 0, 0}};
        float rgb[3];
        btf_ref_evaluate_neighbours(&big, &options, 3, 2, &light, &view, (const float[]){0, 0, 1},
                                    (const float[]){0, 0, 1}, rgb);
        btf_ref_tile(&big, 249, 1023, 1023, &px, &py);
        ok = ok && rgb[0] == 81 && rgb[1] == 0 && px < SIDE && py < SIDE;
        cases_add(paper, expected, ok, "centre %u of %u shows %g", room - 1, room, (double)rgb[0]);
    }
    if (atlas) {
        munmap(atlas, (size_t)4 * SIDE * SIDE);
    }
    btf_material_close(&material);
}

int main(void) {
    cases_title("Every class of bits in a file, and every argument, given to decoder and reference.");
    file_parameters();
    file_scales();
    all_patterns();
    extreme_materials();
    coordinates();
    directions();
    weights();
    largest();
    return cases_result();
}
