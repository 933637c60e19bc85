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

void enc_fit_print(const enc_fit_choice *choice, FILE *out) {
    int judged = 0;
    for (int k = 1; k < ENC_FIT_CANDIDATES; k++) {
        judged += choice->candidate[k].judged;
    }
    if (judged == 0) {
        return;
    }
    fprintf(out,
            "Fit of values at views and lights, before compression (PSNR in dB, linear / sRGB; left out: view and\n"
            "light, predicted from the others; gain: squared error expected between the samples, times 1e6)\n");
    fprintf(out, "  %-22s %15s %15s %15s\n", "--fit, kappa", "at the samples", "left out", "gain");
    for (int k = 0; k < ENC_FIT_CANDIDATES; k++) {
        const enc_fit_candidate *c = &choice->candidate[k];
        char kappa[ENC_FIT_TEXT], name[ENC_FIT_TEXT + 16], at[32] = "exact";
        if (!c->judged) {
            continue;
        }
        if (k > 0) {
            snprintf(at, sizeof at, "%.2f / %.2f", psnr(c->at.linear), psnr(c->at.srgb));
        }
        snprintf(name, sizeof name, k == 0 ? "samples" : "between %s", kappa_text(c, kappa));
        fprintf(out, "%c %-22s %15s %8.2f / %.2f %8.1f / %.1f\n", k == choice->chosen ? '*' : ' ', name, at,
                psnr(c->left_out.linear), psnr(c->left_out.srgb), 1e6 * c->gain.linear, 1e6 * c->gain.srgb);
    }
}

void enc_fit_json(json *j, const char *key, const enc_fit_choice *choice) {
    if (!choice) {
        json_null(j, key);
        return;
    }
    json_object(j, key);
    json_integer(j, "chosen", choice->chosen);
    json_array(j, "candidates");
    for (int k = 0; k < ENC_FIT_CANDIDATES; k++) {
        const enc_fit_candidate *c = &choice->candidate[k];
        if (!c->judged) {
            continue;
        }
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
        json_end(j);
    }
    json_end(j);
    json_end(j);
}
