/* The estimate of errors between the samples: against the same predictions made one by one, and against properties that
 * it must have.
 *
 * SPDX-License-Identifier: MIT
 */
#include "decoder/toolkit/reference_view.h"
#include "encoder/between/blend.h"
#include "encoder/data/level_filter.h"
#include "encoder/nodes/left_out.h"
#include "encoder/report/leave_one_out.h"
#include "encoder/report/left_out_lights.h"
#include "tests/sample/directions.h"
#include "tests/sample/sample.h"
#include "tests/support/random_material.h"
#include "tests/support/test.h"

#include <openbtf/plan.h>

static const enc_context context = {.threads = 2};

static enc_direction *directions(const char *list, int *count) {
    enc_direction *made = NULL;
    assert_int_equal(directions_parse(NULL, list, &made, count), BTF_OK);
    return made;
}

static enc_left_out left_out(const char *list) {
    int count;
    enc_direction *made = directions(list, &count);
    enc_left_out out;
    assert_int_equal(enc_left_out_make(&context, made, count, &out), BTF_OK);
    free(made);
    return out;
}

TEST(test_which_can_be_left_out) {
    assert_int_equal(left_out("ubo").count, 81); /* a ring bridges the gap at its rim */
    assert_int_equal(left_out("tiny").count, 1); /* the pole; nothing is near the four around it */
    assert_int_equal(left_out("tiny").index[0], 0);
    assert_int_equal(left_out("0:1").count, 0);
    const enc_left_out out = left_out("ubo");
    for (int i = 0; i < out.count; i++) {
        uint32_t sum = 0;
        for (int k = 0; k < 3; k++) {
            sum += out.near[i].weight[k];
            assert_true(out.near[i].weight[k] == 0 || out.near[i].index[k] != (uint32_t)out.index[i]);
        }
        assert_int_equal(sum, 4096);
    }
}

static enc_data *render(relief_kind kind, const char *views, const char *lights, int size) {
    enc_data *data;
    assert_int_equal(sample_render_small(&context, kind, views, lights, size, &data), BTF_OK);
    return data;
}

/* The data without some views and lights. */
static enc_data *without(const enc_data *data, int view, int light) {
    enc_direction views[256], lights[256];
    int v = 0, l = 0;
    for (int i = 0; i < data->n_views; i++) {
        if (i != view) {
            views[v++] = data->views[i];
        }
    }
    for (int i = 0; i < data->n_lights; i++) {
        if (i != light) {
            lights[l++] = data->lights[i];
        }
    }
    enc_data *out = NULL;
    assert_int_equal(enc_data_create(&context, data->width, data->height, v, views, l, lights, &out),
                     BTF_OK);
    float *to = out->samples;
    for (size_t t = 0; t < enc_data_texel_count(data); t++) {
        for (int i = 0; i < data->n_views; i++) {
            for (int c = 0; c < 3; c++) {
                for (int k = 0; k < data->n_lights; k++) {
                    if (i != view && k != light) {
                        *to++ = data->samples[t * enc_data_texel_stride(data) +
                                              (size_t)((i * 3 + c) * data->n_lights + k)];
                    }
                }
            }
        }
    }
    return out;
}

/* Mean squared error, linear, of the samples (view, light), predicted from the data without what is left
 * out. */
static double error_without(const enc_data *data, int view, int light, int left) {
    enc_data *rest = without(data, left & ENC_LEFT_VIEW ? view : -1, left & ENC_LEFT_LIGHT ? light : -1);
    const size_t texels = enc_data_texel_count(data);
    float *image = malloc(3 * texels * sizeof *image);
    enc_blend *blend = NULL;
    const enc_pair pair = {.view = data->views[view], .light = data->lights[light]};
    assert_int_equal(enc_blend_create(&context, rest, ENC_INTERPOLATE_LINEAR, &blend), BTF_OK);
    assert_int_equal(enc_blend_images(&context, blend, &pair, 1, image), BTF_OK);
    double sum = 0;
    for (size_t t = 0; t < texels; t++) {
        for (int c = 0; c < 3; c++) {
            const float truth = data->samples[t * enc_data_texel_stride(data) +
                                              (size_t)((view * 3 + c) * data->n_lights + light)];
            const double step = fmin(truth, 1) - fmin(image[3 * t + (size_t)c], 1);
            sum += step * step;
        }
    }
    enc_blend_destroy(&blend);
    enc_data_destroy(&rest);
    free(image);
    return sum / (3 * (double)texels);
}

/* Makes all predictions, each from a data set of its own. The estimate draws 65,536 of their texels and pairs. */
TEST(test_against_the_long_way) {
    enc_data *data = render(RELIEF_BUMPS, "0:1,50:8", "0:1,55:7", 16);
    enc_leave_one_out measured;
    assert_int_equal(enc_leave_one_out_measure(&context, data, NULL, 1, &measured), BTF_OK);
    assert_true(measured.views == 9 && measured.lights == 8);
    for (int left = ENC_LEFT_VIEW; left <= ENC_LEFT_BOTH; left++) {
        double sum = 0;
        for (int v = 0; v < data->n_views; v++) {
            for (int l = 0; l < data->n_lights; l++) {
                sum += error_without(data, v, l, left) / (data->n_views * data->n_lights);
            }
        }
        const enc_error_sum *found = &measured.error[left].data;
        assert_true(measured.error[left].material.count == 0);
        if (fabs(enc_psnr_linear(found) + 10 * log10(sum)) > 0.1) {
            fail_msg("left out %d: %f dB, the long way %f dB", left, enc_psnr_linear(found),
                     -10 * log10(sum));
        }
    }
    enc_data_destroy(&data);
}

/* A material that decodes to the data has the data's own errors. */
TEST(test_an_exact_material) {
    random_state r = {5};
    btf_material_desc desc = random_material_desc(6, 5, 19, 19, BTF_LAYOUT_TIGHT, BTF_EFFECT_RESIDUAL);
    desc.info.colour = BTF_COLOUR_NONE;
    desc.info.lobes = 0;
    desc.info.domain = BTF_DOMAIN_LINEAR;
    desc.info.components = 4;
    random_material_fill(&r, &desc);
    btf_material *material = NULL;
    assert_int_equal(btf_material_create(&desc, NULL, &material), BTF_OK);
    enc_direction v[19], l[19];
    for (int i = 0; i < 19; i++) {
        const float *p = desc.views + 3 * i, *q = desc.lights + 3 * i;
        v[i] = enc_direction_from_angles(acos(p[2]) * 180 / M_PI, atan2(p[1], p[0]) * 180 / M_PI);
        l[i] = enc_direction_from_angles(acos(q[2]) * 180 / M_PI, atan2(q[1], q[0]) * 180 / M_PI);
    }
    enc_data *data = NULL;
    assert_int_equal(enc_data_create(&context, 6, 5, 19, v, 19, l, &data), BTF_OK);
    btf_ref_material reference;
    reference_view(material, 0, &reference);
    const btf_ref_options options = {
        .effects = BTF_EFFECT_ALL, .components = UINT32_MAX, .interpolation = BTF_REF_NEAREST};
    for (uint32_t t = 0; t < 30; t++) {
        for (int i = 0; i < 19; i++) {
            for (int k = 0; k < 19; k++) {
                float rgb[3];
                btf_ref_evaluate_texel(&reference, &options, t % 6, t / 6, desc.lights + 3 * k,
                                       desc.views + 3 * i, rgb);
                for (int c = 0; c < 3; c++) {
                    data->samples[t * enc_data_texel_stride(data) + (size_t)((i * 3 + c) * 19 + k)] =
                        rgb[c];
                }
            }
        }
    }
    enc_leave_one_out measured;
    assert_int_equal(enc_leave_one_out_measure(&context, data, material, 1, &measured), BTF_OK);
    const enc_left_out_errors *view = &measured.error[ENC_LEFT_VIEW],
                              *both = &measured.error[ENC_LEFT_BOTH];
    /* The same views are blended, in radiance: rounding alone differs, and where the sum is below 0, which
     * the decoder takes for 0 view by view as the data do. */
    assert_true(view->data.linear > 0 && fabs(view->material.linear / view->data.linear - 1) < 1e-4);
    assert_true(view->material.count == view->data.count && both->data.linear > 0);
    float numbers[ENC_BETWEEN_NUMBERS];
    const int v_bands = measured.view_bands.count, l_bands = measured.light_bands.count;
    assert_int_equal(enc_leave_one_out_numbers(&measured, 0, numbers),
                     4 + v_bands + l_bands + 3 * (5 + 2 * v_bands * l_bands));
    const float *row = numbers + 4 + v_bands + l_bands;
    assert_true(row[0] == ENC_LEFT_VIEW && row[1] == fminf((float)view->material.linear, 1) &&
                row[4] == fminf((float)view->data.srgb, 1));
    assert_true(row[5 + 2 * v_bands * l_bands] == ENC_LEFT_LIGHT);
    enc_data_destroy(&data);
    btf_material_close(&material);
    random_material_free(&desc);
}

/* Data with the views and lights of a material, and arbitrary samples. */
static enc_data *data_of(const btf_material_desc *desc) {
    const int n_views = (int)desc->info.n_views, n_lights = (int)desc->info.n_lights;
    enc_direction views[256], lights[256];
    enc_data *data = NULL;
    for (int i = 0; i < n_views; i++) {
        const float *p = desc->views + 3 * i;
        views[i] = enc_direction_from_angles(acos(p[2]) * 180 / M_PI, atan2(p[1], p[0]) * 180 / M_PI);
    }
    for (int i = 0; i < n_lights; i++) {
        const float *p = desc->lights + 3 * i;
        lights[i] = enc_direction_from_angles(acos(p[2]) * 180 / M_PI, atan2(p[1], p[0]) * 180 / M_PI);
    }
    assert_int_equal(enc_data_create(&context, (int)desc->info.width, (int)desc->info.height, n_views,
                                     views, n_lights, lights, &data),
                     BTF_OK);
    for (size_t i = 0; i < enc_data_texel_count(data) * enc_data_texel_stride(data); i++) {
        data->samples[i] = (float)(i * 37 % 101) / 101;
    }
    return data;
}

/* For a material with gloss, the row without gloss is the one of the same material made without gloss. */
TEST(test_without_gloss) {
    random_state r = {6};
    btf_material_desc desc =
        random_material_desc(6, 5, 19, 19, BTF_LAYOUT_TIGHT, BTF_EFFECT_RESIDUAL | BTF_EFFECT_GLOSS);
    btf_material *material = NULL;
    enc_leave_one_out with, without;
    float numbers[ENC_BETWEEN_NUMBERS];
    desc.info.colour = BTF_COLOUR_NONE;
    desc.info.lobes = 0;
    desc.info.components = 4;
    random_material_fill(&r, &desc);
    enc_data *data = data_of(&desc);
    assert_int_equal(btf_material_create(&desc, NULL, &material), BTF_OK);
    assert_int_equal(enc_leave_one_out_measure(&context, data, material, 1, &with), BTF_OK);
    btf_material_close(&material);
    desc.info.effects = BTF_EFFECT_RESIDUAL;
    desc.info.gloss_share = 0;
    assert_int_equal(btf_material_create(&desc, NULL, &material), BTF_OK);
    assert_int_equal(enc_leave_one_out_measure(&context, data, material, 1, &without), BTF_OK);
    for (int left = ENC_LEFT_VIEW; left <= ENC_LEFT_BOTH; left++) {
        const enc_left_out_errors *a = &with.error[left], *b = &without.error[left];
        assert_true(b->no_gloss.count == 0 && b->material.count > 0 && a->no_relief.count == 0);
        if (left & ENC_LEFT_VIEW) {
            assert_true(a->no_gloss.linear == b->material.linear && a->no_gloss.srgb == b->material.srgb);
            assert_true(a->material.linear != a->no_gloss.linear);
        } else {
            assert_true(a->no_gloss.count == 0 && a->material.linear == b->material.linear);
        }
    }
    const size_t cells = (size_t)(with.view_bands.count * with.light_bands.count);
    const size_t head = 4 + (size_t)(with.view_bands.count + with.light_bands.count), row = 5 + 2 * cells;
    static const float rows[5] = {1, 2, 3, 9, 11};
    assert_int_equal(enc_leave_one_out_numbers(&with, 0, numbers), head + 5 * row);
    for (size_t i = 0; i < 5; i++) {
        assert_true(numbers[head + i * row] == rows[i]);
    }
    assert_true(numbers[head + 4 * row + 1] == fminf((float)with.error[ENC_LEFT_BOTH].no_gloss.linear, 1));
    enc_data_destroy(&data);
    btf_material_close(&material);
    random_material_free(&desc);
}

/* A coarser level gets the errors of level 0 of a material that begins at that level, against filtered data; level 0
 * gets those that it would have alone. */
TEST(test_levels) {
    random_state r = {8};
    btf_material_desc desc =
        random_material_desc(8, 6, 19, 19, BTF_LAYOUT_TIGHT, BTF_EFFECT_RESIDUAL | BTF_EFFECT_GLOSS);
    const btf_scene far = {.struct_size = sizeof far, .pixels = 0.5f};
    btf_material *material = NULL, *coarse = NULL;
    enc_data *data, *filtered = NULL;
    enc_leave_one_out levels[2], expected;
    float numbers[ENC_BETWEEN_NUMBERS], others[ENC_BETWEEN_NUMBERS];
    btf_plan plan;
    desc.info.colour = BTF_COLOUR_NONE;
    desc.info.lobes = 0;
    desc.info.components = 4;
    desc.info.levels = 2;
    random_material_fill(&r, &desc);
    data = data_of(&desc);
    assert_int_equal(btf_material_create(&desc, NULL, &material), BTF_OK);
    assert_int_equal(enc_leave_one_out_measure(&context, data, material, 2, levels), BTF_OK);
    assert_int_equal(enc_leave_one_out_measure(&context, data, material, 1, &expected), BTF_OK);
    assert_memory_equal(&levels[0], &expected, sizeof expected);
    assert_int_equal(btf_plan_effects(material, &far, 0, &plan), BTF_OK);
    assert_int_equal(plan.level, 1);
    assert_int_equal(btf_material_restrict(material, &plan, NULL, &coarse), BTF_OK);
    assert_int_equal(enc_level_filter(&context, data, 4, 3, &filtered), BTF_OK);
    assert_int_equal(enc_leave_one_out_measure(&context, filtered, coarse, 1, &expected), BTF_OK);
    assert_memory_equal(&levels[1], &expected, sizeof expected);
    assert_true(levels[1].error[ENC_LEFT_BOTH].no_gloss.linear != levels[0].error[ENC_LEFT_BOTH].no_gloss.linear);
    const size_t count = enc_leave_one_out_numbers(&levels[1], 1, numbers),
                 head = enc_leave_one_out_numbers(&expected, 0, others) - count;
    assert_int_equal(head, 4 + (size_t)(expected.view_bands.count + expected.light_bands.count));
    for (size_t row = 0; row < count; row += count / 5) {
        assert_true(numbers[row] == others[head + row] + 16);
        numbers[row] -= 16;
    }
    assert_memory_equal(numbers, others + head, count * sizeof *numbers);
    enc_data_destroy(&data);
    enc_data_destroy(&filtered);
    btf_material_close(&material);
    btf_material_close(&coarse);
    random_material_free(&desc);
}

/* With gloss, the light that is left out is predicted from the others, and from those around it where the half vector
 * does not move. */
TEST(test_lights_of_gloss) {
    enc_data *data = render(RELIEF_FLAT, "small", "small", 8);
    const enc_left_out left = left_out("small");
    enc_left_out_lights *gloss = NULL;
    int moved = 0;
    assert_true(left.count > 0);
    assert_int_equal(enc_left_out_lights_create(&context, data, 2, &gloss), BTF_OK);
    for (int i = 0; i < left.count; i++) {
        for (int v = 0; v < data->n_views; v++) {
            const uint32_t view = (uint32_t)v;
            const btf_ref_neighbours views = {{view, (view + 1) % (uint32_t)data->n_views, 0},
                                              {2048, 1024, 1024}};
            btf_ref_neighbours lights[2][3];
            for (int out = 0; out < 2; out++) {
                enc_left_out_lights_find(gloss, v, &views, left.index[i], out, lights[out]);
            }
            for (int k = 0; k < 3; k++) {
                assert_int_equal(lights[1][0].weight[k], left.near[i].weight[k]);
                assert_true(left.near[i].weight[k] == 0 || lights[1][0].index[k] == left.near[i].index[k]);
            }
            assert_true(lights[0][0].weight[0] == 4096 && lights[0][0].index[0] == (uint32_t)left.index[i]);
            for (int a = 0; a < 3; a++) {
                uint32_t sum = 0;
                for (int k = 0; k < 3; k++) {
                    sum += lights[1][a].weight[k];
                    assert_true(lights[1][a].weight[k] == 0 ||
                                lights[1][a].index[k] != (uint32_t)left.index[i]);
                }
                assert_int_equal(sum, 4096);
            }
            moved += lights[0][1].weight[0] < 4096;
        }
    }
    assert_true(moved > left.count * data->n_views / 2);
    enc_left_out_lights_destroy(&gloss);
    enc_data_destroy(&data);
}

TEST(test_threads_and_memory) {
    enc_data *data = render(RELIEF_BRICKS, "small", "small", 8);
    const enc_context alone = {.threads = 1};
    enc_leave_one_out two, one;
    assert_int_equal(enc_leave_one_out_measure(&context, data, NULL, 1, &two), BTF_OK);
    assert_int_equal(enc_leave_one_out_measure(&alone, data, NULL, 1, &one), BTF_OK);
    assert_memory_equal(&one, &two, sizeof one);
    enc_data_destroy(&data);
}

/* Bands are of rings, and all together their mean, weighted by the pairs that they have. */
TEST(test_bands) {
    enc_data *data = render(RELIEF_BUMPS, "0:1,30:6,60:12", "0:1,45:5", 8);
    enc_leave_one_out measured;
    static const int views[3] = {1, 6, 12}, lights[2] = {1, 5};
    assert_int_equal(enc_leave_one_out_measure(&context, data, NULL, 1, &measured), BTF_OK);
    assert_true(measured.view_bands.count == 3 && measured.light_bands.count == 2);
    for (int left = ENC_LEFT_VIEW; left <= ENC_LEFT_BOTH; left++) {
        double sum = 0, weight = 0;
        for (int cell = 0; cell < 6; cell++) {
            const enc_error_sum *e = &measured.band_error[left][cell].data;
            const bool rim =
                cell % 2 == 1; /* five lights at 45 are too far apart to stand for one another */
            if (left & ENC_LEFT_LIGHT && rim) {
                assert_true(e->count == 0);
                continue;
            }
            assert_true(e->count == 1 && e->linear > 0 && e->srgb > 0);
            sum += views[cell / 2] * lights[cell % 2] * e->linear;
            weight += views[cell / 2] * lights[cell % 2];
        }
        assert_true(fabs(measured.error[left].data.linear - sum / weight) < 1e-9);
    }
    float numbers[ENC_BETWEEN_NUMBERS];
    assert_int_equal(enc_leave_one_out_numbers(&measured, 0, numbers), 2 + 4 + 3); /* no material: no row */
    enc_data_destroy(&data);
}

/* With a single light only views are left out. */
TEST(test_one_light) {
    enc_data *data = render(RELIEF_FLAT, "small", "0:1", 8);
    enc_leave_one_out measured;
    assert_int_equal(enc_leave_one_out_measure(&context, data, NULL, 1, &measured), BTF_OK);
    assert_true(measured.views > 0 && measured.lights == 0);
    assert_true(measured.error[ENC_LEFT_VIEW].data.count > 0 &&
                measured.error[ENC_LEFT_LIGHT].data.count == 0 &&
                measured.error[ENC_LEFT_BOTH].data.count == 0);
    enc_data_destroy(&data);
}

RUN_TESTS(NULL, NULL)
