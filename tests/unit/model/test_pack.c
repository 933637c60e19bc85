/* Unpacking undoes packing; the atlas is the paper's; the encoder's own decoding agrees with the reference.
 *
 * SPDX-License-Identifier: MIT
 */
#include "decoder/toolkit/reference_view.h"
#include "encoder/model/decode_samples.h"
#include "encoder/model/pack.h"
#include "encoder/data/images.h"
#include "encoder/model/unpack.h"
#include "tests/support/messages.h"
#include "tests/support/test.h"

static const enc_context context = {.threads = 2};

static uint32_t random_state;
static uint32_t random_bits(void) {
    random_state = random_state * 1664525u + 1013904223u;
    return random_state >> 8;
}
static float random_float(float low, float high) {
    return low + (high - low) * (float)random_bits() * 0x1p-24f;
}
static void *random_bytes(size_t size, int low, int high) {
    uint8_t *bytes = malloc(size + 1);
    assert_non_null(bytes);
    for (size_t i = 0; i < size; i++) {
        bytes[i] = (uint8_t)(low + (int)(random_bits() % (uint32_t)(high - low + 1)));
    }
    return bytes;
}

static enc_data *make_data(int width, int height, int views, int lights) {
    enc_direction v[16], l[16];
    v[0] = l[0] = enc_direction_from_angles(0, 0);
    for (int i = 1; i < 16; i++) {
        v[i] = enc_direction_from_angles(i < 8 ? 30 : 60, (i % 8) * 45);
        l[i] = enc_direction_from_angles(i < 6 ? 25 : 70, (i % 10) * 36);
    }
    enc_data *data = NULL;
    assert_int_equal(enc_data_create(&context, width, height, views, v, lights, l, &data), BTF_OK);
    return data;
}

static enc_solution random_solution(const enc_data *data, uint32_t effects, btf_domain domain, int lobes,
                                    bool rgb) {
    const size_t texels = enc_data_texel_count(data), points = texels * (size_t)data->n_views;
    enc_solution s = {.width = data->width,
                      .height = data->height,
                      .n_views = data->n_views,
                      .n_lights = data->n_lights,
                      .domain = domain,
                      .effects = effects,
                      .radiance_scale = 1.5f,
                      .shadow_scale = 2.0f / 255,
                      .gain_scale = BTF_GAIN_SCALE};
    if (lobes > 0) {
        assert_int_equal(enc_sbrdf_create(texels, lobes, rgb, &s.sbrdf), BTF_OK);
        const size_t stride = enc_sbrdf_stride(lobes, rgb);
        for (size_t i = 0; i < texels * stride; i++) {
            const size_t at = i % stride;
            s.sbrdf->values[i] = at >= stride - 4 * (size_t)lobes && (stride - at) % 4 == 1
                                     ? random_float(0.5f, 30)
                                     : random_float(0.1f, 0.9f);
        }
    }
    if (effects & BTF_EFFECT_SHADOW) {
        s.shadow = random_bytes(texels * (size_t)data->n_lights, 0, 255);
    }
    s.shift = random_bytes(points * 2, 0, 255);
    s.gain = effects & BTF_EFFECT_GAIN ? random_bytes(points, 1, 255)
                                       : random_bytes(points, BTF_GAIN_ONE, BTF_GAIN_ONE);
    s.centre = calloc(points, sizeof *s.centre);
    if (!(effects & BTF_EFFECT_SHIFT)) {
        memset(s.shift, 0, points * 2);
    }
    if (effects & BTF_EFFECT_HIDDEN) {
        s.n_centres = 7;
        s.centre_scale = 1.2f / 255;
        s.centre_codes = random_bytes(7 * (size_t)data->n_lights * 3, 0, 255);
        for (size_t i = 0; i < points; i += 3) {
            s.gain[i] = 0;
            s.centre[i] = (uint16_t)(random_bits() % 7);
            s.shift[2 * i] = s.shift[2 * i + 1] = 0;
        }
    }
    if (effects & BTF_EFFECT_RESIDUAL) {
        s.n_components = 6;
        s.residual_texels = random_bytes(texels * 6, 0, 254);
        s.residual_directions = random_bytes((size_t)data->n_views * (size_t)data->n_lights * 18, 0, 254);
        s.residual_scales = malloc(6 * sizeof(float));
        assert_non_null(s.residual_scales);
        for (size_t i = 0; i < texels * 6; i++) {
            s.residual_texels[i] = (int8_t)((uint8_t)s.residual_texels[i] - 127);
        }
        for (size_t i = 0; i < (size_t)data->n_views * (size_t)data->n_lights * 18; i++) {
            s.residual_directions[i] = (int8_t)((uint8_t)s.residual_directions[i] - 127);
        }
        for (int i = 0; i < 6; i++) {
            s.residual_scales[i] = random_float(1e-6f, 2e-5f);
        }
    }
    return s;
}

/* The same with shift and gain in two bytes a point. */
static void pack_points(enc_solution *s) {
    const size_t points = enc_solution_texels(s) * (size_t)s->n_views;
    s->packed = true;
    s->gain_base = 0.3f;
    s->gain_step = 0.11f;
    for (size_t i = 0; i < points; i++) {
        s->gain[i] = s->gain[i] & 15;
        s->shift[2 * i] = (int8_t)(s->shift[2 * i] / 4);
        s->shift[2 * i + 1] = (int8_t)(s->shift[2 * i + 1] / 4);
    }
}

/* The same with at most five pairs a texel. */
static void list_points(enc_solution *s, int entries) {
    const size_t texels = enc_solution_texels(s);
    pack_points(s);
    s->point_entries = entries;
    for (size_t i = (size_t)entries * texels; i < texels * (size_t)s->n_views; i++) {
        const size_t other = (size_t)(random_bits() % (uint64_t)entries) * texels + i % texels;
        s->gain[i] = s->gain[other];
        s->shift[2 * i] = s->shift[2 * other];
        s->shift[2 * i + 1] = s->shift[2 * other + 1];
    }
}

static void assert_equal_bytes(const void *a, const void *b, size_t size) {
    assert_true((a == NULL) == (b == NULL));
    if (a) {
        assert_memory_equal(a, b, size);
    }
}

static int packed_checks, list_checks;

static void check(int width, int height, int views, int lights, btf_layout layout, uint32_t effects,
                  btf_domain domain, int lobes, bool rgb) {
    enc_data *data = make_data(width, height, views, lights);
    const size_t texels = enc_data_texel_count(data), points = texels * (size_t)views, image = texels * 3;
    enc_solution s = random_solution(data, effects, domain, lobes, rgb), back;
    const uint32_t both = BTF_EFFECT_SHIFT | BTF_EFFECT_GAIN;
    if (layout == BTF_LAYOUT_TIGHT && (effects & (both | BTF_EFFECT_HIDDEN)) == both) {
        list_checks += views > 5; /* an odd number of views, too */
        views > 5 ? list_points(&s, 5) : pack_points(&s);
        packed_checks++;
    }
    const enc_pack_options options = {.layout = layout, .method = "test"};
    btf_material *material = NULL;
    assert_int_equal(enc_pack(&context, data, &s, &options, &material), BTF_OK);
    assert_int_equal(enc_unpack(&context, material, &back), BTF_OK);
    assert_int_equal(s.packed, back.packed);
    assert_int_equal(s.point_entries, back.point_entries);
    const size_t sizes[3] = {btf_material_texture(material, BTF_TEXTURE_POINTS).size,
                             btf_material_texture(material, BTF_TEXTURE_POINT_LISTS).size,
                             btf_material_texture(material, BTF_TEXTURE_POINT_INDICES).size};
    assert_int_equal(sizes[0], s.packed && s.point_entries == 0 ? 2 * points : 0);
    assert_int_equal(sizes[1], 2 * texels * (size_t)s.point_entries);
    assert_int_equal(sizes[2], s.point_entries ? texels * (((size_t)views + 1) / 2) : 0);
    if (s.sbrdf) {
        assert_equal_bytes(s.sbrdf->values, back.sbrdf->values,
                           texels * enc_sbrdf_stride(lobes, rgb) * sizeof(float));
    }
    assert_equal_bytes(s.shadow, back.shadow, texels * (size_t)lights);
    assert_equal_bytes(s.shift, back.shift, points * 2);
    assert_equal_bytes(s.gain, back.gain, points);
    assert_equal_bytes(s.centre, back.centre, points * sizeof *s.centre);
    assert_equal_bytes(s.centre_codes, back.centre_codes, (size_t)s.n_centres * (size_t)lights * 3);
    assert_equal_bytes(s.residual_texels, back.residual_texels, texels * s.n_components);
    assert_equal_bytes(s.residual_directions, back.residual_directions,
                       (size_t)views * (size_t)lights * 3 * s.n_components);

    enc_sample_decoder *decoder = NULL;
    enc_reference_images reference = {.shape = data, .options = {.components = UINT32_MAX}};
    reference_view(material, 0, &reference.material);
    assert_int_equal(enc_sample_decoder_create(&context, data, &back, &decoder), BTF_OK);
    float *fast = malloc(image * (size_t)lights * sizeof *fast),
          *exact = malloc(image * (size_t)lights * sizeof *exact);
    assert_true(fast && exact);
    for (uint32_t mask = 0; mask < 32; mask++) {
        const enc_decoded_samples decoded = {.decoder = decoder, .effects = mask};
        const enc_image_source source = enc_decoded_images(&decoded),
                               truth = enc_reference_image_source(&reference);
        reference.options.effects = mask;
        for (int v = 0; v < views; v++) {
            assert_int_equal(source.view(source.user, v, fast), BTF_OK);
            assert_int_equal(truth.view(truth.user, v, exact), BTF_OK);
            for (size_t i = 0; i < image * (size_t)lights; i++) {
                assert_true(fabsf(fast[i] - exact[i]) <= 2e-5f * (1 + fabsf(exact[i])));
            }
        }
    }
    free(exact);
    free(fast);
    enc_sample_decoder_destroy(&decoder);
    btf_material_close(&material);
    enc_solution_clear(&back);
    enc_solution_clear(&s);
    enc_data_destroy(&data);
}

TEST(test_round_trip) {
    random_state = 1;
    for (int layout = 0; layout < 2; layout++) {
        for (uint32_t effects = 0; effects < 32; effects += 3) {
            check(5, 3, 4, 7, (btf_layout)layout, effects,
                  effects & 1 ? BTF_DOMAIN_SQRT : BTF_DOMAIN_LINEAR, 1 + (int)(effects % 4), effects & 2);
        }
        check(4, 8, 9, 3, (btf_layout)layout, 31, BTF_DOMAIN_SQRT, 3, true);
    }
    check(4, 4, 3, 3, BTF_LAYOUT_TIGHT, BTF_EFFECT_RESIDUAL | BTF_EFFECT_SHIFT, BTF_DOMAIN_SQRT, 0, false);
    check(4, 4, 3, 3, BTF_LAYOUT_TIGHT, BTF_EFFECT_RESIDUAL | BTF_EFFECT_SHIFT | BTF_EFFECT_GAIN, BTF_DOMAIN_SQRT,
          0, false);
    check(4, 3, 9, 3, BTF_LAYOUT_TIGHT, BTF_EFFECT_RESIDUAL | BTF_EFFECT_SHIFT | BTF_EFFECT_GAIN, BTF_DOMAIN_SQRT,
          0, false);
    check(5, 4, 8, 3, BTF_LAYOUT_TIGHT, BTF_EFFECT_SHADOW | BTF_EFFECT_SHIFT | BTF_EFFECT_GAIN, BTF_DOMAIN_SQRT, 1,
          false);
    assert_true(packed_checks > 1);
    assert_int_equal(list_checks, 2);
}

/* Entries stand in the order of the first views that have them; lists that are too short are refused. */
TEST(test_lists) {
    enum { VIEWS = 5, TEXELS = 6 };
    static const uint8_t codes[VIEWS] = {3, 9, 3, 0, 9}, indices[3] = {0x10, 0x20, 0x01};
    enc_data *data = make_data(3, 2, VIEWS, 2);
    enc_solution s = random_solution(data, BTF_EFFECT_SHIFT | BTF_EFFECT_GAIN, BTF_DOMAIN_SQRT, 1, false), back;
    const enc_pack_options options = {.layout = BTF_LAYOUT_TIGHT, .method = "test"};
    const enc_context loud = {.threads = 1, .log = log_keep};
    btf_material *material = NULL;
    pack_points(&s);
    s.point_entries = 4;
    memset(s.shift, 0, (size_t)2 * VIEWS * TEXELS);
    for (size_t i = 0; i < (size_t)VIEWS * TEXELS; i++) {
        s.gain[i] = codes[i / TEXELS];
    }
    s.shift[2 * (3 * TEXELS + 4) + 1] = -32; /* view 3 of texel (1, 1) */
    assert_int_equal(enc_pack(&loud, data, &s, &options, &material), BTF_OK);
    const uint8_t *list = btf_material_texture(material, BTF_TEXTURE_POINT_LISTS).data,
                  *index = btf_material_texture(material, BTF_TEXTURE_POINT_INDICES).data;
    for (size_t t = 0; t < TEXELS; t++) {
        static const unsigned points[4] = {3 << 12 | 32 << 6 | 32, 9 << 12 | 32 << 6 | 32, 32 << 6 | 32, 0};
        for (size_t e = 0; e < 4; e++) {
            const uint8_t *entry = list + 2 * (e * TEXELS + t);
            assert_int_equal(entry[0] + 256 * entry[1], e == 2 && t == 4 ? 32 : points[e]);
        }
        for (size_t i = 0; i < 3; i++) {
            assert_int_equal(index[i * TEXELS + t], indices[i]);
        }
    }
    assert_int_equal(enc_unpack(&loud, material, &back), BTF_OK);
    assert_memory_equal(back.shift, s.shift, (size_t)2 * VIEWS * TEXELS);
    assert_memory_equal(back.gain, s.gain, (size_t)VIEWS * TEXELS);
    btf_material_close(&material);
    enc_solution_clear(&back);

    s.point_entries = 3;
    assert_int_equal(enc_pack(&loud, data, &s, &options, &material), BTF_OK);
    btf_material_close(&material);
    s.gain[4 * TEXELS + 5] = 15; /* texel (2, 1) has four now */
    assert_int_equal(enc_pack(&loud, data, &s, &options, &material), BTF_ERROR_USAGE);
    assert_null(material);
    assert_string_equal(last_message,
                        "packing: level 0, texel (2, 1): more than 3 different pairs of shift and gain");
    enc_solution_clear(&s);
    enc_data_destroy(&data);
}

TEST(test_paper_room) {
    uint32_t room = 0;
    assert_int_equal(enc_pack_centre_room(&context, 64, 64, 81, 81, &room), BTF_OK);
    assert_int_equal(room, 1984);
}

TEST(test_half) {
    assert_int_equal(enc_half_from_float(1.0f), 0x3c00);
    assert_int_equal(enc_half_from_float(-2.5f), 0xc100);
    assert_int_equal(enc_half_from_float(65504.0f), 0x7bff);
    assert_int_equal(enc_half_from_float(1e9f), 0x7bff);
    assert_int_equal(enc_half_from_float(0x1p-14f), 0x0400);
    assert_int_equal(enc_half_from_float(0x1p-15f), 0);
    assert_int_equal(enc_half_from_float(NAN), 0);
    assert_int_equal(enc_half_from_float(1 + 0x1p-11f), 0x3c00);            /* tie to even */
    assert_int_equal(enc_half_from_float(1 + 0x1p-10f + 0x1p-11f), 0x3c02); /* tie to even */
}

RUN_TESTS(NULL, NULL)
