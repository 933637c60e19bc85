/* Plans: the cheapest way within the tolerance; restricted materials decode in range, bit for bit, what the
 * whole one does; fixed directions have the neighbours that the reference finds.
 *
 * SPDX-License-Identifier: MIT
 */
#include <openbtf/reference.h>
#include "decoder/toolkit/reference_view.h"
#include "tests/support/factor_material.h"
#include "tests/support/plan_decode.h"
#include "tests/support/test.h"
#include <openbtf/plan.h>

static btf_material *make(btf_material_desc *desc, random_state *r) {
    btf_material *material = NULL;
    factor_material_fill(r, desc);
    assert_int_equal(btf_material_create(desc, NULL, &material), BTF_OK);
    random_material_free(desc);
    return material;
}

static btf_range random_range(random_state *r) {
    btf_range range = {0};
    switch (random_below(r, 5)) {
    case 0:
        break;
    case 1: {
        range.fixed = 1;
        plan_angles(random_below(r, 3) ? 89 * random_unit(r) : 15.0 * random_below(r, 6),
                    random_below(r, 3) ? 360 * random_unit(r) : 15.0 * random_below(r, 24),
                    range.direction);
        break;
    }
    default:
        range.theta[0] = random_below(r, 2) ? 0 : (float)(80 * random_unit(r));
        range.theta[1] = range.theta[0] + (float)((90 - range.theta[0]) * random_unit(r));
        if (random_below(r, 2)) {
            range.phi[0] = (float)(720 * random_unit(r) - 360);
            range.phi[1] = (float)(720 * random_unit(r) - 360);
        }
    }
    return range;
}

/* Decodes both in the ranges, which must give the same bits; returns how many values were not zero. */
static int decodes_alike(random_state *r, const btf_material *whole, const btf_material *small,
                         const btf_plan *plan, int count) {
    int lit = 0;
    assert_int_equal(plan_differences(r, whole, small, plan, count, &lit), 0);
    return lit;
}

/* Every direction, every effect: a GPU that cannot hold the atlas. */
TEST(tight_decodes_like_paper) {
    random_state r = {11};
    int lit = 0;
    for (uint32_t effects = 0; effects < 32; effects++) {
        const uint32_t n_views = 1 + random_below(&r, 40), n_lights = 1 + random_below(&r, 40);
        btf_material_desc desc = random_material_desc(9, 6, n_views, n_lights, BTF_LAYOUT_PAPER, effects);
        desc.info.domain = (btf_domain)random_below(&r, 2);
        factor_material_choose(&r, &desc);
        btf_material *paper = make(&desc, &r), *tight = NULL;
        assert_int_equal(btf_material_to_tight(paper, NULL, &tight), BTF_OK);
        btf_material_info a = {.struct_size = sizeof a}, b = a;
        btf_material_get_info(paper, &a);
        btf_material_get_info(tight, &b);
        assert_int_equal(b.layout, BTF_LAYOUT_TIGHT);
        assert_int_equal(a.effects, b.effects);
        assert_int_equal(a.n_views, b.n_views);
        assert_int_equal(a.n_lights, b.n_lights);
        const btf_plan everything = {.struct_size = sizeof everything};
        lit += decodes_alike(&r, paper, tight, &everything, 60);
        btf_material_close(&tight);
        btf_material_close(&paper);
    }
    assert_true(lit > 32 * 30);
}

TEST(restrictions_decode_alike) {
    enum { MATERIALS = 60, PLANS = 12, SAMPLES = 60 };
    random_state r = {7};
    int lit = 0, fewer = 0;
    for (int m = 0; m < MATERIALS; m++) {
        const uint32_t effects = random_below(&r, 32);
        const btf_layout layout = m % 2 ? BTF_LAYOUT_PAPER : BTF_LAYOUT_TIGHT;
        static const uint32_t counts[] = {1, 2, 5, 37, 81, 81};
        btf_material_desc desc = random_material_desc(9, 6, counts[random_below(&r, 6)],
                                                      counts[random_below(&r, 6)], layout, effects);
        desc.info.domain = random_below(&r, 2) ? BTF_DOMAIN_SQRT : BTF_DOMAIN_LINEAR;
        desc.info.levels = layout == BTF_LAYOUT_TIGHT ? 1 + random_below(&r, 3) : 1;
        desc.info.gain_scale = random_below(&r, 3) ? BTF_GAIN_SCALE : 0x1.8p-6f;
        desc.info.colour = (btf_colour)random_below(&r, 2);
        if ((effects & BTF_EFFECT_RESIDUAL) && random_below(&r, 3) == 0) {
            desc.info.colour = BTF_COLOUR_NONE;
            desc.info.lobes = 0;
        }
        factor_material_choose(&r, &desc);
        if (random_below(&r, 3) == 0) {
            random_directions(&r, desc.info.n_views, 85, (float *)(uintptr_t)desc.views);
            random_directions(&r, desc.info.n_lights, 70, (float *)(uintptr_t)desc.lights);
        }
        btf_material *whole = make(&desc, &r);
        btf_material_info info = {.struct_size = sizeof info}, less = {.struct_size = sizeof less};
        btf_material_get_info(whole, &info);
        for (int p = 0; p < PLANS; p++) {
            btf_scene scene = {
                .struct_size = sizeof scene, .view = random_range(&r), .light = random_range(&r)};
            scene.pixels = random_below(&r, 2) ? 1 : 0.3f;
            btf_plan plan;
            assert_int_equal(btf_plan_effects(whole, &scene, 0.5f, &plan), BTF_OK);
            /* any subset of effects, also one that no plan would choose */
            plan.effects = info.effects & random_below(&r, 32);
            plan.components =
                plan.effects & BTF_EFFECT_RESIDUAL ? 1 + random_below(&r, info.components) : 0;
            plan.shader.leave_out = info.effects & ~plan.effects;
            plan.shader.components = plan.components;
            plan.shader.interpolation = (btf_interpolation)random_below(&r, 2);
            plan.shader.filter = (btf_filter)random_below(&r, 2);
            btf_material *small = NULL;
            assert_int_equal(btf_material_restrict(whole, &plan, NULL, &small), BTF_OK);
            btf_material_get_info(small, &less);
            assert_true(less.n_views == plan.views && less.n_lights == plan.lights);
            assert_int_equal(less.levels, info.levels - plan.level);
            fewer += less.n_views < info.n_views || less.n_lights < info.n_lights;
            lit += decodes_alike(&r, whole, small, &plan, SAMPLES);
            btf_material_close(&small);
        }
        btf_material_close(&whole);
    }
    print_message("%d of %d samples lit, %d restrictions of directions\n", lit, MATERIALS * PLANS * SAMPLES,
                  fewer);
    assert_true(lit > MATERIALS * PLANS * SAMPLES / 4 && fewer > MATERIALS * PLANS / 4);
}

/* Few directions are enough for few directions, and each texture shrinks with them. */
TEST(restrictions_are_small) {
    random_state r = {3};
    btf_material_desc desc = random_material_desc(16, 16, 81, 81, BTF_LAYOUT_PAPER,
                                                  BTF_EFFECT_SHADOW | BTF_EFFECT_SHIFT | BTF_EFFECT_HIDDEN);
    float *xyz = (float *)(uintptr_t)desc.views;
    random_ubo2003((float(*)[3])xyz);
    memcpy((float *)(uintptr_t)desc.lights, xyz, 81 * 3 * sizeof *xyz);
    btf_material *whole = make(&desc, &r), *small = NULL;
    const btf_scene top = {
        .struct_size = sizeof top, .view.theta = {0, 10}, .light = {.fixed = 1, .direction = {0, 0, 1}}};
    btf_plan plan;
    btf_material_info info = {.struct_size = sizeof info};
    assert_int_equal(btf_plan_effects(whole, &top, 0.5f, &plan), BTF_OK);
    assert_int_equal(plan.measured, 0); /* no table: everything is decoded */
    assert_int_equal(plan.effects, BTF_EFFECT_SHADOW | BTF_EFFECT_SHIFT | BTF_EFFECT_HIDDEN);
    assert_int_equal(plan.views, 7); /* the pole and the ring around it */
    assert_int_equal(plan.lights, 1);
    assert_int_equal(plan.textures & (1u << BTF_TEXTURE_LIGHT_TABLE), 0);
    assert_int_equal(btf_material_restrict(whole, &plan, NULL, &small), BTF_OK);
    btf_material_get_info(small, &info);
    assert_int_equal(info.layout, BTF_LAYOUT_TIGHT);
    assert_int_equal(info.n_views, 7);
    assert_int_equal(info.n_lights, 1);
    assert_int_equal(info.gpu_bytes, 256 * (4 * 16 + 1 + 7 * 3) + info.centres * 4);
    assert_true(info.gpu_bytes <= plan.gpu_bytes && plan.gpu_bytes < plan.full_gpu_bytes / 2);
    void *data;
    size_t size;
    btf_material *back = NULL;
    assert_int_equal(btf_material_save_memory(small, NULL, &data, &size), BTF_OK); /* it can be saved */
    assert_int_equal(btf_material_open_memory(data, size, NULL, &back), BTF_OK);
    decodes_alike(&r, whole, back, &plan, 500);
    btf_free(data);
    btf_material_close(&back);
    btf_material_close(&small);
    btf_material_close(&whole);
}

/* The number after a macro's name. */
static unsigned number_after(const char *text, const char *name, int skip) {
    const char *at = strstr(text, name);
    assert_non_null(at);
    at += strlen(name);
    for (int i = 0; i <= skip; i++) {
        at += strcspn(at, " (,");
        at += strspn(at, " (,");
        if (strncmp(at, "uvec3(", 6) == 0) {
            at += 6;
        }
    }
    return (unsigned)strtoul(at, NULL, 10);
}

TEST(fixed_neighbours_are_the_reference_s) {
    random_state r = {11};
    btf_material_desc desc = random_material_desc(4, 4, 81, 30, BTF_LAYOUT_TIGHT, 0);
    btf_material *material = make(&desc, &r);
    btf_ref_material m;
    reference_view(material, 0, &m);
    for (int i = 0; i < 300; i++) {
        btf_shader_options o = {.struct_size = sizeof o, .fixed = BTF_FIXED_LIGHT};
        plan_angles(89.9 * random_unit(&r), 360 * random_unit(&r), o.fixed_light);
        o.interpolation = (btf_interpolation)(i & 1);
        char *text = NULL;
        int32_t q[2];
        assert_int_equal(btf_shader_source(material, &o, NULL, &text), BTF_OK);
        btf_ref_project(o.fixed_light, q);
        btf_ref_neighbours n = btf_ref_lookup(m.light_table, m.light_grid, q);
        n = i & 1 ? btf_ref_nearest(n) : n;
        unsigned count = 0;
        for (int k = 0; k < 3; k++) {
            if (n.weight[k] > 0) {
                assert_int_equal(number_after(text, "BTF_FIXED_LIGHT_INDEX", (int)count), n.index[k]);
                assert_int_equal(number_after(text, "BTF_FIXED_LIGHT_WEIGHT", (int)count), n.weight[k]);
                count++;
            }
        }
        assert_int_equal(number_after(text, "BTF_FIXED_LIGHT", 0), count);
        btf_free(text);
    }
    const btf_shader_options below = {
        .struct_size = sizeof below, .fixed = BTF_FIXED_VIEW, .fixed_view = {1, 0, 0}};
    char *text = NULL;
    assert_int_equal(btf_shader_source(material, &below, NULL, &text), BTF_ERROR_USAGE);
    assert_null(text);
    btf_material_close(&material);
}

enum { EFFECTS = BTF_EFFECT_SHIFT | BTF_EFFECT_GAIN | BTF_EFFECT_RESIDUAL };

/* Two bands of views, 0..30 and 30..75; one of lights. Rows: effects, components, nearest, level, bytes,
 * then linear and sRGB errors of each band. */
/* clang-format off */
static const float known_table[] = {
    2, 1, 0, 30, 75, 0, 75,
    EFFECTS, 8, 3, 0, 0, 0.01f, 0.01f, 0.01f, 0.01f,                                   /* views at samples */
    EFFECTS, 8, 0, 0, 0, 0.001f, 0.002f, 0.002f, 0.004f,                               /* everything */
    EFFECTS, 4, 0, 0, 0, 0.0011f, 0.0021f, 0.004f, 0.008f,                             /* fine from the top */
    BTF_EFFECT_GAIN | BTF_EFFECT_RESIDUAL, 8, 0, 0, 0, 0.00105f, 0.00205f, 0.1f, 0.1f, /* likewise */
    BTF_EFFECT_GAIN | BTF_EFFECT_RESIDUAL, 4, 0, 0, 0, 0.00115f, 0.0022f, 0.1f, 0.1f,  /* cheapest */
    BTF_EFFECT_GAIN | BTF_EFFECT_RESIDUAL, 4, 1, 0, 0, 0.00108f, 0.0042f, 0.1f, 0.1f,  /* wrong in sRGB */
    BTF_EFFECT_RESIDUAL, 4, 0, 0, 0, 0.0016f, 0.0025f, 0.3f, 0.3f,                     /* 2 dB below */
    EFFECTS, 8, 0, 1, 0, 0.0005f, 0.0005f, 0.0005f, 0.0005f,                           /* level 1 */
    BTF_EFFECT_RESIDUAL, 4, 1, 1, 0, 0.0005f, 0.0005f, 0.0005f, 0.0005f,
};
/* clang-format on */

/* Bands of views 0..30 and 30..75, one of lights. Rows: the effects left out, four means, then each band. */
/* clang-format off */
static const float between_table[] = {
    2, 1, 0, 30, 75, 0, 75,
    1, 0.1f, 0.1f, 0.1f, 0.1f, 0.004f, 0.005f, 0.006f, 0.007f,
    2, 0.1f, 0.1f, 0.1f, 0.1f, 0.002f, 0.003f, 0.008f, 0.009f,
    3, 0.1f, 0.1f, 0.1f, 0.1f, 0.01f, 0.02f, -1, -1,
};
/* clang-format on */

static bool is_near(float psnr, double mse) {
    return fabs((double)psnr + 10 * log10(mse)) < 1e-3;
}

/* Laid out as known_table: the differences to decoding everything. */
/* clang-format off */
static const float difference_table[] = {
    2, 1, 0, 30, 75, 0, 75,
    EFFECTS, 8, 0, 0, 0, 0, 0, 0, 0,
    EFFECTS, 4, 0, 0, 0, 0.0002f, 0.0002f, 0.004f, 0.008f,
    BTF_EFFECT_GAIN | BTF_EFFECT_RESIDUAL, 4, 0, 0, 0, 0.003f, 0.001f, 0.1f, 0.1f,
    BTF_EFFECT_GAIN | BTF_EFFECT_RESIDUAL, 4, 1, 0, 0, 0.004f, 0.004f, 0.1f, 0.1f,
    BTF_EFFECT_RESIDUAL, 4, 0, 0, 0, 0.02f, 0.02f, 0.1f, 0.1f,
};

/* Differences in one band of view and one of light: shorter rows than known_table's. */
static const float other_bands[] = {
    1, 1, 0, 75, 0, 75,
    BTF_EFFECT_GAIN | BTF_EFFECT_RESIDUAL, 4, 0, 0, 0, 0.003f, 0.001f,
};

/* More of known_table: errors where view and light are samples. */
static const float sample_rows[] = {
    EFFECTS, 8, 2, 0, 0, 0.0005f, 0.001f, 0.0005f, 0.001f,
    BTF_EFFECT_GAIN | BTF_EFFECT_RESIDUAL, 4, 2, 0, 0, 0.0015f, 0.002f, 0.1f, 0.1f,
};
/* clang-format on */

/* The parts that a known material has beside its table. */
enum { PLAIN = 0, WITH_BETWEEN = 1, WITH_DIFFERENCES = 2, WITH_SAMPLES = 4, WITH_OTHER_BANDS = 8 };

/* The material of the known table and of others as well. */
static btf_material *make_known(int parts) {
    random_state r = {5};
    btf_material_desc desc = random_material_desc(16, 16, 81, 81, BTF_LAYOUT_TIGHT, EFFECTS);
    desc.info.colour = BTF_COLOUR_NONE;
    desc.info.lobes = 0;
    desc.info.components = 8;
    desc.info.levels = 2;
    enum {
        KNOWN = sizeof known_table / sizeof *known_table,
        MORE = sizeof sample_rows / sizeof *sample_rows
    };
    float table[KNOWN + MORE];
    memcpy(table, known_table, sizeof known_table);
    memcpy(table + KNOWN, sample_rows, sizeof sample_rows);
    desc.effect_errors = table;
    desc.effect_error_count = parts & WITH_SAMPLES ? KNOWN + MORE : KNOWN;
    desc.between_errors = parts & WITH_BETWEEN ? between_table : NULL;
    desc.between_error_count = parts & WITH_BETWEEN ? sizeof between_table / sizeof *between_table : 0;
    desc.effect_differences = parts & WITH_DIFFERENCES ? difference_table : NULL;
    desc.effect_difference_count =
        parts & WITH_DIFFERENCES ? sizeof difference_table / sizeof *difference_table : 0;
    if (parts & WITH_OTHER_BANDS) {
        desc.effect_differences = other_bands;
        desc.effect_difference_count = sizeof other_bands / sizeof *other_bands;
    }
    return make(&desc, &r);
}

TEST(plans_tell_of_what_lies_between) {
    btf_material *plain = make_known(PLAIN), *material = make_known(WITH_BETWEEN);
    btf_scene scene = {.struct_size = sizeof scene, .view.theta = {0, 30}};
    btf_plan plan;
    assert_int_equal(btf_plan_effects(plain, &scene, 0.7f, &plan), BTF_OK); /* a file without the table */
    assert_true(plan.measured && plan.between_psnr_linear == 0 && plan.full_between_psnr_srgb == 0);
    assert_int_equal(plan.effects, BTF_EFFECT_GAIN | BTF_EFFECT_RESIDUAL);
    assert_int_equal(btf_plan_effects(material, &scene, 0.7f, &plan),
                     BTF_OK); /* 0.0006 beside half of 0.01 */
    assert_int_equal(plan.effects, BTF_EFFECT_RESIDUAL);
    assert_int_equal(btf_plan_effects(material, &scene, 0.48f, &plan), BTF_OK);
    assert_int_equal(plan.effects, BTF_EFFECT_GAIN | BTF_EFFECT_RESIDUAL);
    assert_int_equal(btf_plan_effects(material, &scene, 0.3f, &plan), BTF_OK); /* gains, four components */
    assert_true(is_near(plan.full_between_psnr_linear, 0.01) && is_near(plan.full_between_psnr_srgb, 0.02));
    assert_true(is_near(plan.between_psnr_linear, 0.01 + 0.00015) &&
                is_near(plan.between_psnr_srgb, 0.02 + 0.0002));
    scene.view.theta[1] = 60; /* bands without a number do not count */
    assert_int_equal(btf_plan_effects(material, &scene, 0, &plan), BTF_OK);
    assert_true(is_near(plan.full_between_psnr_linear, 0.01));
    scene.view =
        (btf_range){.fixed = 1, .direction = {0, 0, 1}}; /* a sample: the lights alone lie between */
    assert_int_equal(btf_plan_effects(material, &scene, 0, &plan), BTF_OK);
    assert_true(is_near(plan.full_between_psnr_linear, 0.002) && plan.level == 0);
    scene.light = scene.view; /* both are samples */
    assert_int_equal(btf_plan_effects(material, &scene, 0, &plan), BTF_OK);
    assert_true(plan.between_psnr_linear == 0);
    scene = (btf_scene){.struct_size = sizeof scene, .pixels = 0.5f};
    assert_int_equal(btf_plan_effects(material, &scene, 0.5f, &plan), BTF_OK); /* level 1 is not measured */
    assert_true(plan.level == 1 && plan.between_psnr_linear == 0);
    btf_material_close(&plain);
    btf_material_close(&material);
}

/* Between the samples the predicted error of a plan is that of decoding everything plus the plan's squared difference
 * to it. Without a table of differences it is the mean of the errors' growth at the samples and against interpolated
 * data. Where the file knows no errors between the samples, neither counts. */
TEST(plans_add_differences) {
    enum { CHEAPEST = BTF_EFFECT_GAIN | BTF_EFFECT_RESIDUAL };
    btf_material *told = make_known(WITH_BETWEEN | WITH_DIFFERENCES | WITH_SAMPLES),
                 *old = make_known(WITH_BETWEEN | WITH_SAMPLES), *silent = make_known(WITH_DIFFERENCES);
    const btf_scene scene = {.struct_size = sizeof scene, .view.theta = {0, 30}};
    btf_plan plan;
    assert_int_equal(btf_plan_effects(told, &scene, 0.3f, &plan),
                     BTF_OK); /* the cheapest: 0.003 beside 0.005 */
    assert_false(plan.effects == CHEAPEST && plan.components == 4);
    assert_int_equal(btf_plan_effects(told, &scene, 2.1f, &plan), BTF_OK); /* 2.04 dB */
    assert_true(plan.effects == CHEAPEST && plan.components == 4);
    assert_true(is_near(plan.between_psnr_linear, 0.01 + 0.003) &&
                is_near(plan.between_psnr_srgb, 0.02 + 0.001));
    assert_true(is_near(plan.psnr_linear, 0.00115)); /* against the data as before */
    assert_int_equal(btf_plan_effects(told, &scene, 2.0f, &plan), BTF_OK);
    assert_false(plan.effects == CHEAPEST && plan.components == 4);
    assert_int_equal(btf_plan_effects(old, &scene, 0.48f, &plan), BTF_OK); /* 0.001 and 0.00015: 0.47 dB */
    assert_true(plan.effects == CHEAPEST && plan.components == 4);
    assert_true(is_near(plan.between_psnr_linear, 0.01 + 0.000575) &&
                is_near(plan.between_psnr_srgb, 0.02 + 0.0006));
    assert_int_equal(btf_plan_effects(old, &scene, 0.46f, &plan), BTF_OK);
    assert_false(plan.effects == CHEAPEST && plan.components == 4);
    assert_int_equal(btf_plan_effects(silent, &scene, 0.7f, &plan), BTF_OK);
    assert_true(plan.effects == CHEAPEST && plan.components == 4 && plan.between_psnr_linear == 0);
    btf_material_close(&told);
    btf_material_close(&old);
    btf_material_close(&silent);
}

/* A table of differences is ignored where its bands are not those of the errors: its rows would be read beyond their
 * ends. */
TEST(differences_of_other_bands_count_for_nothing) {
    btf_material *other = make_known(WITH_BETWEEN | WITH_SAMPLES | WITH_OTHER_BANDS),
                 *without = make_known(WITH_BETWEEN | WITH_SAMPLES);
    const btf_scene scene = {.struct_size = sizeof scene, .view.theta = {0, 30}};
    assert_int_equal(btf_material_effect_differences(other).row_count, 1);
    for (float tolerance = 0.3f; tolerance < 2.5f; tolerance += 0.1f) {
        btf_plan plan, expected;
        assert_int_equal(btf_plan_effects(other, &scene, tolerance, &plan), BTF_OK);
        assert_int_equal(btf_plan_effects(without, &scene, tolerance, &expected), BTF_OK);
        assert_int_equal(plan.effects, expected.effects);
        assert_int_equal(plan.components, expected.components);
        assert_true(plan.between_psnr_linear == expected.between_psnr_linear);
    }
    btf_material_close(&other);
    btf_material_close(&without);
}

TEST(plans_follow_the_table) {
    btf_material *material = make_known(PLAIN);
    btf_scene scene = {.struct_size = sizeof scene};
    btf_plan plan;

    assert_int_equal(btf_plan_effects(material, &scene, 0.5f, &plan), BTF_OK); /* everywhere: everything */
    assert_true(plan.measured && plan.effects == EFFECTS && plan.components == 8);
    assert_true(plan.psnr_linear == plan.full_psnr_linear);
    const double top = 1 - cos(M_PI / 6), rest = cos(M_PI / 6) - cos(75 * M_PI / 180);
    const double mean = (0.001 * top + 0.002 * rest) / (top + rest);
    assert_true(fabs(plan.psnr_linear + 10 * log10(mean)) < 1e-3);

    scene.view.theta[1] = 30; /* from the top: no shifts, half of the components */
    assert_int_equal(btf_plan_effects(material, &scene, 0.7f, &plan), BTF_OK);
    assert_int_equal(plan.effects, BTF_EFFECT_GAIN | BTF_EFFECT_RESIDUAL);
    assert_int_equal(plan.components, 4);
    assert_int_equal(plan.shader.leave_out, BTF_EFFECT_SHIFT);
    assert_int_equal(plan.shader.interpolation, BTF_INTERPOLATION_LINEAR);
    assert_int_equal(plan.textures & (1u << BTF_TEXTURE_SHIFT), 0);
    assert_true(fabs(plan.psnr_linear + 10 * log10(0.00115)) < 1e-3);
    assert_true(fabs(plan.psnr_srgb + 10 * log10(0.0022)) < 1e-3);
    assert_true(plan.cost < plan.full_cost && plan.gpu_bytes < plan.full_gpu_bytes);
    assert_int_equal(btf_plan_effects(material, &scene, 0.3f, &plan),
                     BTF_OK); /* less loss: more components */
    assert_true(plan.effects == (BTF_EFFECT_GAIN | BTF_EFFECT_RESIDUAL) && plan.components == 8);
    assert_int_equal(btf_plan_effects(material, &scene, 3, &plan), BTF_OK);
    assert_int_equal(plan.effects, BTF_EFFECT_RESIDUAL);
    assert_int_equal(btf_plan_effects(material, &scene, 0, &plan), BTF_OK);
    assert_int_equal(plan.effects, EFFECTS);

    btf_scene still = scene; /* the samples' errors count where the view is one */
    still.view = (btf_range){.fixed = 1, .direction = {0, 0, 1}};
    assert_int_equal(btf_plan_effects(material, &still, 0, &plan), BTF_OK);
    assert_true(fabs(plan.full_psnr_linear + 10 * log10(0.01)) < 1e-3);

    scene.pixels = 0.5f; /* far away: a coarser level */
    assert_int_equal(btf_plan_effects(material, &scene, 0.5f, &plan), BTF_OK);
    assert_int_equal(plan.level, 1);
    assert_true(plan.effects == BTF_EFFECT_RESIDUAL &&
                plan.shader.interpolation == BTF_INTERPOLATION_NEAREST);
    scene.interpolate = 1;
    assert_int_equal(btf_plan_effects(material, &scene, 0.5f, &plan), BTF_OK);
    assert_true(plan.effects == EFFECTS && plan.shader.interpolation == BTF_INTERPOLATION_LINEAR);
    scene.pixels = 0.6f;
    scene.lights = 3;
    assert_int_equal(btf_plan_effects(material, &scene, 0.5f, &plan), BTF_OK);
    assert_int_equal(plan.level, 0);
    assert_true(plan.full_cost ==
                3 * btf_plan_cost(material,
                                  &(btf_shader_options){.struct_size = sizeof(btf_shader_options)}, NULL));
    scene.pixels = 2;
    assert_int_equal(btf_plan_effects(material, &scene, 0.5f, &plan), BTF_OK);
    assert_int_equal(plan.shader.filter, BTF_FILTER_BILINEAR);
    btf_material_close(&material);
}

/* The cost model that plan.h promises: decoding less never costs more, and a view fixed at a sample makes the full
 * decode cheaper too where its groups of components are a loop. */
TEST(costs_follow_the_model) {
    random_state r = {5};
    const uint32_t all =
        BTF_EFFECT_SHADOW | BTF_EFFECT_SHIFT | BTF_EFFECT_HIDDEN | BTF_EFFECT_GAIN | BTF_EFFECT_RESIDUAL;
    btf_material_desc desc = random_material_desc(4, 4, 81, 81, BTF_LAYOUT_TIGHT, all);
    random_ubo2003((float(*)[3])(uintptr_t)desc.views);
    desc.info.components = 56;
    btf_material *material = make(&desc, &r);
    for (uint32_t more = 0; more < 32; more++) {
        for (uint32_t less = 0; less < 32; less++) {
            for (int way = 0; way < 8 && (more & less) == less; way++) {
                const btf_shader_options a = {.struct_size = sizeof a,
                                              .leave_out = all & ~more,
                                              .interpolation = (btf_interpolation)(way & 1),
                                              .filter = (btf_filter)(way >> 1 & 1),
                                              .fixed = way & 4 ? BTF_FIXED_VIEW | BTF_FIXED_LIGHT : 0,
                                              .fixed_view = {0, 0, 1},
                                              .fixed_light = {0.6f, 0, 0.8f}};
                btf_shader_options b = a;
                b.leave_out = all & ~less;
                b.components = 40;
                assert_true(btf_plan_cost(material, &b, NULL) <= btf_plan_cost(material, &a, NULL));
            }
        }
    }
    const btf_scene still = {.struct_size = sizeof still, .view = {.fixed = 1, .direction = {0, 0, 1}}};
    btf_shader_options o = {.struct_size = sizeof o, .leave_out = all & ~(uint32_t)BTF_EFFECT_RESIDUAL};
    btf_shader_options folded = o;
    folded.fixed = BTF_FIXED_VIEW;
    folded.fixed_view[2] = 1;
    const float anywhere = btf_plan_cost(material, &o, NULL), there = btf_plan_cost(material, &o, &still);
    assert_true(there < 0.5f * anywhere && there > 0.35f * anywhere); /* measured: 0.40 */
    const float saved = btf_plan_cost(material, &folded, &still) / there;
    assert_true(saved > 0.65f && saved < 0.9f); /* 0.82 */
    o.components = folded.components = 16;      /* too few groups for a loop: none is passed over */
    assert_true(btf_plan_cost(material, &o, &still) == btf_plan_cost(material, &o, NULL));
    assert_true(btf_plan_cost(material, &folded, &still) <
                0.4f * btf_plan_cost(material, &o, &still)); /* 0.30 */
    btf_material_close(&material);
}

static float cost_of_residual(const btf_material *material, btf_shader_options o) {
    const float with = btf_plan_cost(material, &o, NULL);
    o.leave_out |= BTF_EFFECT_RESIDUAL;
    return with - btf_plan_cost(material, &o, NULL);
}

/* The same for factors: decoding less never costs more, the cost is in proportion to the units, and u is fetched once
 * where no view shifts its source. */
TEST(costs_of_factors_follow_the_model) {
    random_state r = {6};
    static const uint32_t classes[BTF_FACTOR_CLASSES][3] = {{2, 4, 2}, {1, 1, 1}, {5, 2, 3}, {1}, {4}};
    const uint32_t all = BTF_EFFECT_SHADOW | BTF_EFFECT_SHIFT | BTF_EFFECT_HIDDEN | BTF_EFFECT_RESIDUAL;
    btf_material_desc desc = factor_material_desc(4, 4, 81, 81, BTF_LAYOUT_TIGHT, all, classes);
    btf_material *material = make(&desc, &r);
    for (int way = 0; way < 16; way++) {
        btf_shader_options o = {.struct_size = sizeof o,
                                .leave_out = way & 8 ? BTF_EFFECT_SHIFT : 0,
                                .interpolation = (btf_interpolation)(way & 1),
                                .filter = (btf_filter)(way >> 1 & 1),
                                .fixed = way & 4 ? BTF_FIXED_VIEW | BTF_FIXED_LIGHT : 0,
                                .fixed_view = {0, 0, 1},
                                .fixed_light = {0.6f, 0, 0.8f}};
        btf_shader_options none = o;
        none.leave_out |= BTF_EFFECT_RESIDUAL;
        float last = btf_plan_cost(material, &none, NULL);
        for (o.components = 1; o.components <= 13; o.components++) {
            const float cost = btf_plan_cost(material, &o, NULL);
            assert_true(cost > last);
            last = cost;
        }
        o.components = 0; /* all */
        assert_true(btf_plan_cost(material, &o, NULL) == last);
    }
    /* Measured on llvmpipe with a file of default options, whole decodes: nearest directions take 0.30 of the time of
     * interpolated ones, four texels 1.97. */
    const btf_shader_options o = {.struct_size = sizeof o, .leave_out = BTF_EFFECT_SHIFT};
    btf_shader_options nearest = o, bilinear = o, shifted = o;
    nearest.interpolation = BTF_INTERPOLATION_NEAREST;
    bilinear.filter = BTF_FILTER_BILINEAR;
    shifted.leave_out = 0;
    const float full = cost_of_residual(material, o);
    const float of_nearest = cost_of_residual(material, nearest) / full,
                of_four = cost_of_residual(material, bilinear) / full;
    assert_true(of_nearest > 0.15f && of_nearest < 0.35f && of_four > 1.6f && of_four < 2.4f);
    /* Two more fetches of 15 texels of u and of 13 of the scales. */
    const btf_decode_counts alike = btf_plan_counts(material, &o, NULL),
                            apart = btf_plan_counts(material, &shifted, NULL);
    assert_true(apart.fetches - alike.fetches == 2 * (15 + 13));
    assert_true(alike.masked < apart.masked && apart.masked <= apart.integers + apart.floats);
    assert_true(cost_of_residual(material, shifted) > full);
    btf_material_close(&material);
}

TEST(wrong_scenes_are_refused) {
    random_state r = {5};
    btf_material_desc desc = random_material_desc(4, 4, 7, 7, BTF_LAYOUT_TIGHT, 0);
    btf_material *material = make(&desc, &r), *small = (btf_material *)&desc;
    const btf_scene good = {.struct_size = sizeof good};
    btf_scene wrong[11];
    for (int i = 0; i < 11; i++) {
        wrong[i] = good;
    }
    wrong[0].view.theta[1] = 91;
    wrong[1].light.theta[0] = 3; /* above theta[1] */
    wrong[2].view.phi[0] = NAN;
    wrong[3].pixels = -1;
    wrong[4].light.fixed = 1; /* no unit vector */
    wrong[5].view = (btf_range){.fixed = 1, .direction = {1, 0, 0}};
    wrong[6].pixels = INFINITY;
    wrong[7].view.phi[1] = 400;
    wrong[8].folded_pixels = -1;
    wrong[9].folded_pixels = NAN;
    wrong[10].folded_pixels = INFINITY;
    btf_plan plan;
    for (int i = 0; i < 11; i++) {
        assert_int_equal(btf_plan_effects(material, &wrong[i], 0.5f, &plan), BTF_ERROR_USAGE);
    }
    assert_int_equal(btf_plan_effects(material, &good, -1, &plan), BTF_ERROR_USAGE);
    assert_int_equal(btf_plan_effects(material, &good, NAN, &plan), BTF_ERROR_USAGE);
    assert_int_equal(btf_plan_effects(material, NULL, 0, &plan), BTF_OK);
    plan.level = 1;
    assert_int_equal(btf_material_restrict(material, &plan, NULL, &small), BTF_ERROR_USAGE);
    assert_null(small);
    btf_material_close(&material);
}

RUN_TESTS(NULL, NULL)
