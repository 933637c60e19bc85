/* The fit with the settings of the encoder against the same fit in double, from the same starts.
 *
 * SPDX-License-Identifier: MIT
 */
#include "cases.h"
#include "precision.h"
#include "precision_double.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { SIDE = 8, TEXELS = SIDE * SIDE, MOST = 3 + 7 * ENC_MAX_LOBES };

static const enc_context context = {.threads = 1};

/* PSNR (peak 1) of the model over all samples, square roots squared. */
static double psnr_of_model(const enc_data *data, int lobes, bool rgb, bool square_root, const double *p) {
    double squares = 0;
    for (size_t t = 0; t < TEXELS; t++, p += enc_sbrdf_stride(lobes, rgb)) {
        const double *shapes = p + (rgb ? 3 + 3 * lobes : 4);
        for (int v = 0; v < data->n_views; v++) {
            for (int i = 0; i < 3 * data->n_lights; i++) {
                const int c = i / data->n_lights, l = i % data->n_lights;
                double sum = p[rgb ? c : 3];
                for (int j = 0; j < lobes; j++) {
                    double base = 0;
                    for (int k = 0; k < 3; k++) {
                        base += shapes[4 * j + k] * (double)data->lights[l].xyz[k] *
                                (double)data->views[v].xyz[k];
                    }
                    const double power = base > 0x1p-24 ? pow(base, shapes[4 * j + 3]) : 0;
                    sum += rgb ? p[3 + 3 * j + c] * power : power;
                }
                const double z = (double)data->lights[l].xyz[2];
                const double y = (rgb ? 1 : p[c]) * sum * (square_root ? sqrt(z) : z);
                const double r = (square_root ? y * y : y) - (double)*hard_sample(data, t, v, c, l);
                squares += r * r;
            }
        }
    }
    return hard_psnr(squares, (double)(TEXELS * enc_data_texel_stride(data)), 1);
}

/* PSNR with the shadow map that the float stage makes of the model. */
static double psnr_played(const enc_data *data, enc_sbrdf *sbrdf) {
    static uint8_t codes[HARD_MAX_DIRECTIONS * TEXELS];
    const enc_shadow_options shadow = enc_shadow_options_default();
    if (enc_top_view_shadow(&context, data, sbrdf, &shadow, codes) != BTF_OK) {
        exit(1);
    }
    return precision_psnr_of_parts(data, sbrdf, codes, NULL, NULL);
}

static void compare(const char *of, const enc_data *data, int lobes, bool rgb, bool square_root) {
    static double single[TEXELS * MOST], twice[TEXELS * MOST];
    const size_t count = TEXELS * enc_sbrdf_stride(lobes, rgb);
    enc_fit_options options = enc_fit_options_default();
    enc_fit_stats stats = {0};
    enc_sbrdf *sbrdf = NULL;
    options.lobes = lobes;
    options.rgb = rgb;
    options.square_root = square_root;
    if (enc_fit(&context, data, &options, &sbrdf, &stats) != BTF_OK ||
        !precision_fit_in_double(data, lobes, rgb, square_root, twice)) {
        exit(1);
    }
    double played[2] = {0};
    played[0] = square_root ? 0 : psnr_played(data, sbrdf);
    for (size_t i = 0; i < count; i++) {
        single[i] = (double)sbrdf->values[i];
        sbrdf->values[i] = (float)twice[i];
    }
    played[1] = square_root ? 0 : psnr_played(data, sbrdf);
    const double psnr = psnr_of_model(data, lobes, rgb, square_root, single);
    const double exact = psnr_of_model(data, lobes, rgb, square_root, twice);
    char input[140], also[80] = "";
    snprintf(input, sizeof input, "fit of %d %slobes%s with the encoder's settings, in double: %s", lobes,
             rgb ? "RGB " : "", square_root ? " of square roots" : "", of);
    if (!square_root) {
        snprintf(also, sizeof also, "; with shadows %.4f dB, double %.4f dB", played[0], played[1]);
    }
    cases_add(input, "less than 0.05 dB either way, also with shadows",
              stats.rejected > 0 && fabs(exact - psnr) < precision_most_loss &&
                  fabs(played[1] - played[0]) < precision_most_loss,
              "%.4f dB, double %.4f dB%s; %llu of %llu samples rejected", psnr, exact, also,
              (unsigned long long)stats.rejected, (unsigned long long)stats.samples);
    enc_sbrdf_destroy(&sbrdf);
}

void precision_fit(void) {
    const hard_directions d = hard_thirteen();
    enc_data *data = hard_create(SIDE, SIDE, &d, &d, precision_measured, NULL);
    compare("noise and a dark side", data, 3, false, false);
    compare("noise and a dark side", data, 2, true, false);
    compare("noise and a dark side", data, 2, true, true);
    enc_data_destroy(&data);
    data = hard_relief(SIDE, &d, &d, 1);
    compare("a relief", data, 3, false, false);
    compare("a relief", data, 2, true, false);
    enc_data_destroy(&data);
}
