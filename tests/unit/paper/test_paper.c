/* `--method paper` on samples whose truth is known: shadow masks, shifts, the flat control, the rising
 * ladder. The figures are printed, so that a report can quote them.
 *
 * SPDX-License-Identifier: MIT
 */
#include "encoder/paper/paper.h"
#include "encoder/report/metrics.h"
#include "encoder/model/decode_samples.h"
#include "tests/sample/sample.h"
#include "tests/support/test.h"

static const enc_context context = {.threads = 2};
static bool is_long; /* every light votes, and the flat material has more texels */

static double psnr_of(const enc_data *data, const enc_solution *solution, uint32_t effects, bool srgb) {
    enc_sample_decoder *decoder = NULL;
    enc_metrics metrics;
    assert_int_equal(enc_sample_decoder_create(&context, data, solution, &decoder), BTF_OK);
    const enc_decoded_samples played = {.decoder = decoder, .effects = effects};
    assert_int_equal(enc_metrics_compare(&context, data, enc_data_images(data), enc_decoded_images(&played),
                                         false, &metrics),
                     BTF_OK);
    enc_sample_decoder_destroy(&decoder);
    return srgb ? enc_psnr_srgb(&metrics.total) : enc_psnr_linear(&metrics.total);
}

/* F1 of the mask "code below 255" against the truth, over all lights. */
static double shadow_f1(const uint8_t *codes, const uint8_t *truth, size_t count) {
    size_t both = 0, found = 0, real = 0;
    for (size_t i = 0; i < count; i++) {
        const bool is = codes[i] < 255;
        found += is;
        real += truth[i];
        both += is && truth[i];
    }
    return 2.0 * (double)both / (double)(found + real);
}

/* The same for the test with the sign that the paper prints: Error < t_e and BTF < t_btf. */
static double printed_sign_f1(const enc_data *data, const enc_solution *s, const uint8_t *truth) {
    const enc_decoded_samples played = {.decoder = NULL, .effects = 0};
    const size_t texels = enc_data_texel_count(data), count = texels * (size_t)data->n_lights;
    enc_sample_decoder *decoder = NULL;
    float *model = malloc(count * 3 * sizeof *model), *original = malloc(count * 3 * sizeof *original);
    uint8_t *codes = malloc(count);
    assert_true(model && original && codes);
    assert_int_equal(enc_sample_decoder_create(&context, data, s, &decoder), BTF_OK);
    enc_decoded_samples shown = played;
    shown.decoder = decoder;
    const enc_image_source source = enc_decoded_images(&shown);
    assert_int_equal(source.view(source.user, data->top_view, model), BTF_OK);
    assert_int_equal(enc_data_view(&context, data, data->top_view, original), BTF_OK);
    for (size_t i = 0; i < count; i++) {
        const float m = enc_luminance(model[3 * i], model[3 * i + 1], model[3 * i + 2]);
        const float b = enc_luminance(original[3 * i], original[3 * i + 1], original[3 * i + 2]);
        codes[i] = m - b < 0.3f * b && b < 0.3f ? 0 : 255;
    }
    const double f1 = shadow_f1(codes, truth, count);
    free(codes);
    free(original);
    free(model);
    enc_sample_decoder_destroy(&decoder);
    return f1;
}

TEST(test_bricks) {
    const int side = 40;
    const sample_options options = {.context = &context, .width = side, .height = side};
    enc_data *data = NULL;
    sample_truth *truth = NULL;
    enc_solution solution;
    enc_occlusion *occlusion = NULL;
    enc_paper_stats stats;
    enc_paper_options paper = enc_paper_options_default();
    if (!is_long) {
        paper.flow.lights = 27; /* fewer lights, to save time; the vote that is measured below has all */
    }
    assert_int_equal(sample_render(&options, &data, &truth), BTF_OK);
    assert_int_equal(enc_paper(&context, data, &paper, &solution, &occlusion, &stats), BTF_OK);

    const size_t count = (size_t)data->n_lights * enc_data_texel_count(data);
    const double f1 = shadow_f1(solution.shadow, truth->top_shadow, count);
    const double printed = printed_sign_f1(data, &solution, truth->top_shadow);
    print_message("shadow masks of the top view: F1 %.3f; with the printed sign %.3f\n", f1, printed);
    assert_true(f1 >= 0.8 && printed < 0.5);

    /* vote again, because refinement overwrote the voted shifts of hidden points */
    enc_occlusion *voted = NULL;
    enc_flow_ring rings[16];
    assert_int_equal(enc_flow_vote(&context, data, &(enc_flow_options){0}, &voted), BTF_OK);
    const int n = enc_flow_error(data, voted, truth->shift, truth->hidden, 2, rings, 16);
    for (int r = 1; r < n; r++) {
        print_message(
            "view theta %2.0f: end-point error over %zu points moved more than 2 texels %.2f (zero motion "
            "%.2f), over all %.2f (%.2f)\n",
            rings[r].theta, rings[r].moved, rings[r].moved_error, rings[r].moved_zero, rings[r].error,
            rings[r].zero);
        if (rings[r].theta == 30) {
            assert_true(rings[r].moved > 1000 && rings[r].moved_error <= 2.0);
        }
    }
    assert_true(stats.hidden_after < stats.hidden_before);
    const double stvs = psnr_of(data, &solution, BTF_EFFECT_SHADOW, false);
    const double full = psnr_of(data, &solution, BTF_EFFECT_ALL, false);
    print_message("STVS %.2f dB, full %.2f dB (linear); hidden points %zu, refined %zu\n", stvs, full,
                  stats.hidden_before, stats.hidden_after);
    assert_true(full > stvs);

    enc_occlusion_destroy(&voted);
    enc_occlusion_destroy(&occlusion);
    enc_solution_clear(&solution);
    sample_truth_destroy(&truth);
    enc_data_destroy(&data);
}

TEST(test_flat) {
    const int flat_side = is_long ? 32 : 16;
    const sample_options options = {
        .context = &context, .relief = RELIEF_FLAT, .width = flat_side, .height = flat_side};
    enc_data *data = NULL;
    enc_solution solution;
    enc_paper_stats stats;
    enc_paper_options paper = enc_paper_options_default();
    paper.effects = 0;
    assert_int_equal(sample_render(&options, &data, NULL), BTF_OK);
    assert_int_equal(enc_paper(&context, data, &paper, &solution, NULL, &stats), BTF_OK);
    const double linear = psnr_of(data, &solution, 0, false), srgb = psnr_of(data, &solution, 0, true);
    print_message("flat control: SBRDF %.1f/%.1f dB\n", linear, srgb);
    assert_true(linear >= 35 && srgb >= 35);
    enc_solution_clear(&solution);
    enc_data_destroy(&data);
}

int main(int argc, char **argv) {
    is_long = argc > 1 && strcmp(argv[1], "--long") == 0;
    return run_listed("tests", NULL, NULL);
}
