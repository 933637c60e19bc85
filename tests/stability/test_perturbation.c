/* Noise of half an 8-bit step in the input changes the result by no more than the noise itself.
 *
 * SPDX-License-Identifier: MIT
 */
#include "cases.h"
#include "encode.h"
#include "tests/support/messages.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static const double sigma = 1.0 / 512;

/* Gaussian noise of standard deviation sigma, kept above 0. */
static enc_data *noisy(const enc_data *data, uint32_t seed) {
    const enc_context context = {.threads = 1};
    enc_data *out = NULL;
    if (enc_data_create(&context, data->width, data->height, data->n_views, data->views, data->n_lights,
                        data->lights, &out) != BTF_OK) {
        exit(1);
    }
    for (size_t i = 0; i < enc_data_texel_count(data) * enc_data_texel_stride(data); i++) {
        const double a = (double)hard_random((uint32_t)i, seed, 1),
                     b = (double)hard_random((uint32_t)i, seed, 2);
        const double normal = sqrt(-2 * log(1 - a)) * cos(6.283185307179586 * b);
        out->samples[i] = (float)fmax((double)data->samples[i] + sigma * normal, 0);
    }
    return out;
}

/* A surface without relief or shadow. */
static void plain(const void *user, int texel, const enc_direction *v, const enc_direction *l, int sample,
                  float rgb[3]) {
    (void)user;
    (void)sample;
    for (int c = 0; c < 3; c++) {
        const float albedo = 0.1f + 0.4f * hard_random((uint32_t)texel, (uint32_t)c, 3);
        const float base = -l->xyz[0] * v->xyz[0] - l->xyz[1] * v->xyz[1] + l->xyz[2] * v->xyz[2];
        rgb[c] = l->xyz[2] * (albedo + 0.3f * powf(fmaxf(base, 0), 10));
    }
}

static void check(const char *name, const enc_data *data) {
    for (int method = 0; method < ENCODE_METHODS; method++) {
        const double clean = encode_played_psnr(data, data, (encode_method)method, 1, 1);
        const double rms = clean >= 200 ? 0 : pow(10, -clean / 20);
        double worst = 0, before = 0;
        bool ok = true;
        for (uint32_t seed = 1; seed <= 2; seed++) {
            enc_data *other = noisy(data, seed);
            const double psnr = encode_played_psnr(other, data, (encode_method)method, 1, 1);
            const double rms_now = pow(10, -psnr / 20);
            ok = ok && rms_now <= rms + sigma;
            if (rms_now > before) {
                before = rms_now;
                worst = psnr;
            }
            enc_data_destroy(&other);
        }
        cases_add(told("%s, by method %s", name, encode_names[method]),
                  "error at most that without noise plus 1/512", ok,
                  "%.2f dB without noise, %.2f dB with it, %.2f dB allowed", clean, worst,
                  -20 * log10(rms + sigma));
    }
}

int main(void) {
    cases_title(
        "Gaussian noise of 1/512 in the input: PSNR against the clean original, the worse of two seeds.");
    const hard_directions d = hard_thirteen();
    enc_data *data = hard_relief(10, &d, &d, 1);
    check("a relief of bricks", data);
    enc_data_destroy(&data);
    data = hard_create(6, 6, &d, &d, plain, NULL);
    check("a glossy plane", data);
    enc_data_destroy(&data);
    data = hard_create(4, 4, &d, &d, hard_black, NULL);
    check("black", data);
    enc_data_destroy(&data);
    return cases_result();
}
