/* btf-view's keys and gestures, and the costs in its panel.
 *
 * SPDX-License-Identifier: MIT
 */
#include "decoder/toolkit/font.h"
#include "decoder/tools/view/costs.h"
#include "decoder/tools/view/state.h"
#include "tests/support/test.h"

static char text[160];

static view_state fresh(void) {
    view_state s = {0};
    view_state_reset(&s);
    s.has_sbrdf = true;
    return s;
}

/* Pressing a switch twice restores the state; every key of the help changes something. */
TEST(test_switches) {
    for (const char *key = "1234567NXLTAIH"; *key; key++) {
        view_state s = fresh(), before = s;
        assert_int_equal(view_state_key(&s, *key, text, sizeof text), VIEW_CHANGED);
        assert_true(strlen(text) > 0);
        assert_memory_not_equal(&s, &before, sizeof s);
        assert_int_equal(view_state_key(&s, *key, text, sizeof text), VIEW_CHANGED);
        assert_memory_equal(&s, &before, sizeof s);
    }
    view_state s = fresh();
    static const char *const filters[] = {"filter texel", "filter bilinear", "filter steep"};
    for (int i = 1; i <= 3; i++) {
        assert_int_equal(view_state_key(&s, 'B', text, sizeof text), VIEW_CHANGED);
        assert_int_equal(s.filter, i % 3);
        assert_string_equal(text, filters[i % 3]);
    }
    assert_int_equal(view_state_key(&s, 'Q', text, sizeof text), VIEW_QUIT);
    assert_int_equal(view_state_key(&s, VIEW_KEY_ESCAPE, text, sizeof text), VIEW_QUIT);
    assert_int_equal(view_state_key(&s, 'P', text, sizeof text), VIEW_SCREENSHOT);
    assert_int_equal(view_state_key(&s, 'C', text, sizeof text), VIEW_MEASURE);
    assert_int_equal(view_state_key(&s, 'Z', text, sizeof text), VIEW_NOTHING);
    view_state_key(&s, '3', text, sizeof text);
    assert_string_equal(text, "effects shadow,shift,gain,residual,relief,gloss");
    view_state_key(&s, '0', text, sizeof text);
    assert_int_equal(s.effects, BTF_EFFECT_ALL);
}

/* Only meshes, effects and levels that exist can be chosen. */
TEST(test_choices) {
    view_state s = fresh();
    for (int i = 0; i < 4; i++) {
        view_state_key(&s, 'M', text, sizeof text);
    }
    assert_int_equal(s.mesh, 0);
    s.has_own_mesh = true;
    for (int i = 0; i < 4; i++) {
        view_state_key(&s, 'M', text, sizeof text);
    }
    assert_int_equal(s.mesh, VIEW_OWN_MESH);
    view_state_key(&s, 'S', text, sizeof text);
    assert_int_equal(s.split, VIEW_SPLIT_SBRDF);
    view_state_key(&s, 'S', text, sizeof text);
    assert_int_equal(s.split, VIEW_SPLIT_OFF);
    s.has_sbrdf = false;
    view_state_key(&s, 'S', text, sizeof text);
    assert_int_equal(s.split, VIEW_SPLIT_OFF);
    assert_non_null(strstr(text, "no SBRDF"));
    s.has_original = true;
    view_state_key(&s, 'S', text, sizeof text);
    assert_int_equal(s.split, VIEW_SPLIT_ORIGINAL);
}

TEST(test_gestures) {
    view_state s = fresh();
    view_state_drag(&s, VIEW_DRAG_ORBIT, -0.25,
                    0); /* a quarter of half a turn to the left: the camera goes right */
    assert_true(fabs(s.theta - 45) < 1e-9 && fabs(s.phi) < 1e-9);
    for (int i = 0; i < 50; i++) {
        view_state_drag(&s, VIEW_DRAG_ORBIT, 0.01, 0.2);
    }
    assert_true(s.theta <= 90 && s.theta > 80); /* stops short of the pole, y up */
    assert_true(fabs(sin(s.theta * 0.017453292519943295) * sin(s.phi * 0.017453292519943295)) < 1);
    view_state_drag(&s, VIEW_DRAG_SPLIT, 3, 0);
    assert_true(s.split_at == 1);
    for (int i = 0; i < 100; i++) {
        view_state_scroll(&s, 1);
    }
    assert_true(s.zoom == 3);
    for (int i = 0; i < 100; i++) {
        view_state_key(&s, '+', text, sizeof text);
    }
    assert_true(s.exposure == 10);
    s.light_theta = 40;
    s.light_phi = 350;
    view_state_advance(&s, 0.25);
    assert_true(fabs(s.light_phi - 5) < 1e-9 && s.light_theta == 40);
    view_state_drag(&s, VIEW_DRAG_LIGHT, 0, 0);
    assert_true(fabs(s.light_theta - 40) < 1e-9 && fabs(s.light_phi - 5) < 1e-9);
}

/* A flat material of one texel, one view and one light, with two rows of errors. */
static btf_material *make_material(void) {
    static const float up[3] = {0, 0, 1}, sbrdf[8] = {1, 1, 1, 0.5f, 0, 0, 1, 2};
    static const unsigned char shadow[1] = {255};
    const btf_material_error errors[2] = {{BTF_EFFECT_SHADOW, 30, 28, 33}, {0, 20, 19, 32}};
    btf_material_desc desc = {
        .struct_size = sizeof desc, .views = up, .lights = up, .errors = errors, .error_count = 2};
    desc.info = (btf_material_info){.struct_size = sizeof desc.info,
                                    .width = 1,
                                    .height = 1,
                                    .n_views = 1,
                                    .n_lights = 1,
                                    .layout = BTF_LAYOUT_TIGHT,
                                    .lobes = 1,
                                    .effects = BTF_EFFECT_SHADOW,
                                    .radiance_scale = 1,
                                    .shadow_scale = 1.0f / 255,
                                    .gain_scale = BTF_GAIN_SCALE,
                                    .centre_scale = 1.0f / 255};
    desc.texture[BTF_TEXTURE_SBRDF] = sbrdf;
    desc.texture[BTF_TEXTURE_SHADOW] = shadow;
    btf_material *material = NULL;
    assert_int_equal(btf_material_create(&desc, NULL, &material), BTF_OK);
    return material;
}

TEST(test_costs) {
    btf_material *material = make_material();
    costs c;
    char panel[600];
    costs_clear(&c);
    costs_text(&c, material, BTF_EFFECT_ALL, panel, sizeof panel);
    assert_non_null(strstr(panel, "1 shadow   on          -  +10.0/+9.0 dB"));
    assert_non_null(strstr(panel, "5 residual not in the file"));
    assert_non_null(strstr(panel, "7 gloss    not in the file"));
    costs_record(&c, BTF_EFFECT_SHADOW, 12);
    costs_record(&c, 0, 9.5);
    costs_text(&c, material, 0, panel, sizeof panel);
    assert_non_null(strstr(panel, "1 shadow   off   +2.5 ms  +10.0/+9.0 dB"));
    assert_true(costs_error(material, BTF_EFFECT_ALL)->psnr_linear == 30);
    assert_true(costs_error(material, BTF_EFFECT_ALL & ~1u)->psnr_linear == 20);
    for (size_t size = 1; size < 200; size += 7) { /* text is cut at the buffer's end */
        costs_text(&c, material, 0, panel, size);
    }
    btf_material_close(&material);
}

/* Every character has its own shape, blank only the space. */
TEST(test_font) {
    for (char a = ' '; a <= '~'; a++) {
        int set = 0;
        for (int y = -1; y < FONT_HEIGHT; y++) {
            for (int x = -1; x < FONT_WIDTH; x++) {
                set += font_pixel(a, x, y);
            }
        }
        assert_int_equal(set == 0, a == ' ');
        for (char b = ' '; b < a; b++) {
            bool same = true;
            for (int y = 0; y < FONT_HEIGHT; y++) {
                for (int x = 0; x < FONT_WIDTH; x++) {
                    same = same && font_pixel(a, x, y) == font_pixel(b, x, y);
                }
            }
            if (same) {
                fail_msg("'%c' looks like '%c'", a, b);
            }
        }
    }
}

RUN_TESTS(NULL, NULL)
