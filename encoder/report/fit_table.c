/* The fit of node values as a table. See fit_table.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "fit_table.h"

#include "metrics.h"

#include <math.h>

static double psnr(double mean) {
    const enc_error_sum sum = {mean, mean, 1};
    return enc_psnr_linear(&sum);
}

static const char *kappa_text(const enc_fit_candidate *c, char text[ENC_FIT_TEXT]) {
    char views[16] = "none", lights[16] = "none";
    if (isfinite(c->kappa_views)) {
        snprintf(views, sizeof views, "%g", c->kappa_views);
    }
    if (isfinite(c->kappa_lights)) {
        snprintf(lights, sizeof lights, "%g", c->kappa_lights);
    }
    snprintf(text, ENC_FIT_TEXT, "%s,%s", views, lights);
    return text;
}

const char *enc_fit_text(const enc_fit_choice *choice, char text[ENC_FIT_TEXT]) {
    if (choice->chosen > 0) {
        return kappa_text(&choice->candidate[choice->chosen], text);
    }
    snprintf(text, ENC_FIT_TEXT, "none");
    return text;
}

/* Finds the errors that are expected of candidate k once it is coded; for the chosen one, the error at the
 * samples was measured. */
static void coded(const enc_fit_choice *choice, int k, enc_fit_error measured, enc_fit_error *out_at,
                  enc_fit_error *out_between) {
    const enc_fit_error coder = enc_fit_coder_measured(choice, measured);
    *out_at = k == choice->chosen ? measured : enc_fit_coded_at(&choice->candidate[k], coder);
    *out_between = enc_fit_coded_between(&choice->candidate[k], coder);
}

static const char *pair_text(enc_fit_error error, char text[32]) {
    snprintf(text, 32, "%.2f / %.2f", psnr(error.linear), psnr(error.srgb));
    return text;
}

void enc_fit_print(const enc_fit_choice *choice, enc_fit_error measured, FILE *out) {
    int judged = 0;
    for (int k = 1; k < ENC_FIT_CANDIDATES; k++) {
        judged += choice->candidate[k].judged;
    }
    if (judged == 0) {
        return;
    }
    fprintf(out, "Values stored at views and lights: the samples, or values fitted for directions between "
                 "them (PSNR in dB,\n"
                 "linear / sRGB; * was taken: measured at the samples; all other figures are predicted)\n");
    fprintf(out, "  %-22s %15s %15s %15s\n", "--fit, kappa", "not coded", "at the samples", "between");
    for (int k = 0; k < ENC_FIT_CANDIDATES; k++) {
        const enc_fit_candidate *c = &choice->candidate[k];
        char kappa[ENC_FIT_TEXT], name[ENC_FIT_TEXT + 16], own[32] = "exact", texts[2][32];
        enc_fit_error at, between;
        if (!c->judged) {
            continue;
        }
        coded(choice, k, measured, &at, &between);
        if (k > 0) {
            pair_text(c->at, own);
        }
        snprintf(name, sizeof name, k == 0 ? "samples" : "between %s", kappa_text(c, kappa));
        fprintf(out, "%c %-22s %15s %15s %15s%s\n", k == choice->chosen ? '*' : ' ', name, own, pair_text(at, texts[0]),
                pair_text(between, texts[1]), k > 0 && !c->allowed ? "  (costs too much)" : "");
    }
}

void enc_fit_json(json *j, const char *key, const enc_fit_choice *choice, enc_fit_error measured) {
    if (!choice) {
        json_null(j, key);
        return;
    }
    json_object(j, key);
    json_integer(j, "chosen", choice->chosen);
    json_integer(j, "best", choice->best);
    json_number(j, "coder_linear", psnr(choice->coder.linear));
    json_number(j, "coder_srgb", psnr(choice->coder.srgb));
    json_array(j, "candidates");
    for (int k = 0; k < ENC_FIT_CANDIDATES; k++) {
        const enc_fit_candidate *c = &choice->candidate[k];
        enc_fit_error at, between;
        if (!c->judged) {
            continue;
        }
        coded(choice, k, measured, &at, &between);
        json_object(j, NULL);
        json_integer(j, "candidate", k);
        json_number(j, "kappa_views", isfinite(c->kappa_views) ? c->kappa_views : NAN);
        json_number(j, "kappa_lights", isfinite(c->kappa_lights) ? c->kappa_lights : NAN);
        json_number(j, "at_linear", k > 0 ? psnr(c->at.linear) : NAN);
        json_number(j, "at_srgb", k > 0 ? psnr(c->at.srgb) : NAN);
        json_number(j, "left_out_linear", psnr(c->left_out.linear));
        json_number(j, "left_out_srgb", psnr(c->left_out.srgb));
        json_number(j, "gain_linear", c->gain.linear);
        json_number(j, "gain_srgb", c->gain.srgb);
        json_number(j, "coded_at_linear", psnr(at.linear));
        json_number(j, "coded_at_srgb", psnr(at.srgb));
        json_number(j, "coded_between_linear", psnr(between.linear));
        json_number(j, "coded_between_srgb", psnr(between.srgb));
        json_bool(j, "allowed", k == 0 || c->allowed);
        json_number(j, "value", c->value);
        json_end(j);
    }
    json_end(j);
    json_end(j);
}
