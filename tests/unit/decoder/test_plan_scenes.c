/* The errors that plans predict for scenes against measured ones: within 25 % of the squared error, for six scenes and
 * both methods. With `--long` also on the measured sets of ../shared, if present. Prints the table.
 *
 * SPDX-License-Identifier: MIT
 */
#include "decoder/toolkit/cli.h"
#include "encoder/job/settings.h"
#include "encoder/input/reader.h"
#include "tests/bench/plan/plan_scenes.h"
#include "tests/sample/sample.h"
#include "tests/support/test.h"

static const enc_context context = {.threads = 2};
static const float tolerance = 0.5f;

/* 25 % of the squared error. A scene of one direction may be better or worse than its band: 2 dB, and 2 dB more where
 * both directions are single. */
static void expect_near(const btf_scene *scene, double predicted_db, double mse) {
    const double most = scene->view.fixed && scene->light.fixed   ? 1.6 * 1.6
                        : scene->view.fixed || scene->light.fixed ? 1.6
                                                                  : 1.25;
    const double ratio = pow(10, -predicted_db / 10) / mse;
    if (!(ratio > 1 / most && ratio < most)) {
        fail_msg("predicted %.2f dB, measured %.2f dB", predicted_db, plan_psnr(mse));
    }
}

/* Every scene of the material; at least three save 30 % of bytes. */
static void check_scenes(const char *name, const enc_data *data, const btf_material *material) {
    int saving = 0;
    print_message("%s: scene, plan, dB linear/sRGB predicted and measured, measured in full, bytes, time\n",
                  name);
    for (int i = 0; i < PLAN_SCENES; i++) {
        btf_plan plan;
        btf_material *small = NULL;
        btf_material_info info = {.struct_size = sizeof info};
        double planned[2], full[2];
        char words[48];
        assert_int_equal(btf_plan_effects(material, &plan_scenes[i].scene, tolerance, &plan), BTF_OK);
        assert_true(plan.measured);
        assert_int_equal(btf_material_restrict(material, &plan, NULL, &small), BTF_OK);
        assert_int_equal(plan_measure(&context, data, material, small, &plan, planned, full), BTF_OK);
        btf_material_get_info(small, &info);
        const double bytes = (double)info.gpu_bytes / (double)plan.full_gpu_bytes;
        const double time = (double)(plan.cost / plan.full_cost);
        print_message("  %-14s %-24s k %-3u level %u  %.2f/%.2f  %.2f/%.2f  %.2f/%.2f  %3.0f%% %3.0f%%\n",
                      plan_scenes[i].name, cli_effects_text(plan.effects, words), plan.components,
                      plan.level, (double)plan.psnr_linear, (double)plan.psnr_srgb, plan_psnr(planned[0]),
                      plan_psnr(planned[1]), plan_psnr(full[0]), plan_psnr(full[1]), 100 * bytes,
                      100 * time);
        expect_near(&plan.scene, (double)plan.psnr_linear, planned[0]);
        expect_near(&plan.scene, (double)plan.psnr_srgb, planned[1]);
        expect_near(&plan.scene, (double)plan.full_psnr_linear, full[0]);
        for (int d = 0; d < 2; d++) {
            assert_true(plan_psnr(full[d]) - plan_psnr(planned[d]) < (double)tolerance + 0.3);
        }
        saving += bytes < 0.7;
        btf_material_close(&small);
    }
    print_message("  %d of %d scenes save 30 %% of bytes\n", saving, PLAN_SCENES);
    assert_true(saving >= 3);
}

static void check_joint(const char *name, const enc_data *data, int levels) {
    enc_job job = {.joint = enc_joint_options_default()};
    enc_factors_stats stats;
    enc_solution found;
    btf_material *material = NULL;
    job.joint.preset = ENC_PRESET_FAST;
    const enc_factors_settings settings =
        enc_settings_of_factors(&job, data->width, data->height, data->n_views, data->n_lights);
    assert_int_equal(enc_factors_solve(&context, data, &settings, &found, &stats), BTF_OK);
    assert_int_equal(plan_pack(&context, data, &found, BTF_LAYOUT_TIGHT, levels, &material), BTF_OK);
    check_scenes(name, data, material);
    btf_material_close(&material);
    enc_solution_clear(&found);
}

static enc_data *make_sample(void) {
    const sample_options options = {.context = &context, .width = 16, .height = 16};
    enc_data *data = NULL;
    assert_int_equal(sample_render(&options, &data, NULL), BTF_OK);
    return data;
}

TEST(joint_sample) {
    enc_data *data = make_sample();
    check_joint("bricks, joint", data, 3);
    enc_data_destroy(&data);
}

TEST(paper_sample) {
    enc_data *data = make_sample();
    const enc_paper_options options = enc_paper_options_default();
    enc_solution found;
    enc_occlusion *occlusion = NULL;
    enc_paper_stats stats;
    btf_material *material = NULL;
    assert_int_equal(enc_paper(&context, data, &options, &found, &occlusion, &stats), BTF_OK);
    assert_int_equal(plan_pack(&context, data, &found, BTF_LAYOUT_PAPER, 1, &material), BTF_OK);
    check_scenes("bricks, paper", data, material);
    btf_material_close(&material);
    enc_solution_clear(&found);
    enc_occlusion_destroy(&occlusion);
    enc_data_destroy(&data);
}

TEST(shared_sets) {
    static const char *const names[] = {"BRICKS64", "UBO_IMPALLA64"};
    const char *shared = getenv("BTF_SHARED");
    for (int i = 0; i < 2; i++) {
        char path[4096];
        snprintf(path, sizeof path, "%s/data/%s.zip", shared ? shared : "", names[i]);
        FILE *there = fopen(path, "rb");
        if (!there) {
            print_message("skipped: no data/%s.zip in BTF_SHARED\n", names[i]);
            continue;
        }
        fclose(there);
        const enc_read_options read = {0};
        enc_data *data = NULL;
        assert_int_equal(enc_read(&context, path, &read, &data), BTF_OK);
        check_joint(names[i], data, 4);
        enc_data_destroy(&data);
    }
}

int main(int argc, char **argv) {
    cmocka_set_test_filter(argc > 1 && strcmp(argv[1], "--long") == 0 ? "shared_*" : "*_sample");
    return run_listed("tests", NULL, NULL);
}
