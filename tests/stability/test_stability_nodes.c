/* Fitted nodes on hard lists of directions: their weights stay small and reproduce constants, or there is no fit.
 *
 * SPDX-License-Identifier: MIT
 */
#include "cases.h"

#include "encoder/nodes/fit.h"
#include "encoder/nodes/rows.h"

#include <math.h>
#include <stdio.h>

enum { MOST = 256 };

static const enc_context context = {.threads = 2};

/* The weights of all strengths of a fit together. */
typedef struct outcome {
    int fits;         /* strengths with weights */
    double sum, gain; /* worst deviation of a node's weights from the sum 1, and sum of their magnitudes */
    bool finite;
} outcome;

static void look_at(const float *w, int n, outcome *out) {
    for (int i = 0; i < n; i++) {
        double sum = 0, gain = 0;
        for (int k = 0; k < n; k++) {
            const double x = (double)w[i * n + k];
            out->finite = out->finite && isfinite(x);
            sum += x;
            gain += fabs(x);
        }
        out->sum = fmax(out->sum, fabs(sum - 1));
        out->gain = fmax(out->gain, gain);
    }
}

/* Fits the list; returns -1 on an error other than a refusal. */
static int try_list(const enc_direction *list, int n, outcome *out) {
    static float w[MOST * MOST];
    enc_node_fit *fit = NULL;
    const btf_result made = enc_node_fit_create(&context, list, n, ENC_FIT_POINTS, &fit);
    *out = (outcome){.finite = true};
    if (made != BTF_OK) {
        return made == BTF_ERROR_UNSUPPORTED ? 0 : -1;
    }
    for (int s = 1; s < ENC_STRENGTHS; s++) {
        const btf_result result = enc_node_fit_weights(fit, enc_strength_kappa[s], w);
        if (result == BTF_OK) {
            look_at(w, n, out);
            out->fits++;
        } else if (result != BTF_ERROR_UNSUPPORTED) {
            out->fits = -1;
            break;
        }
    }
    enc_node_fit_destroy(&fit);
    return out->fits;
}

/* may_fit: a fit is allowed; must_fit: it has to be found. */
static void check(const char *name, const enc_direction *list, int n, bool may_fit, bool must_fit) {
    outcome o;
    const int fits = try_list(list, n, &o);
    const bool good = fits >= 0 && o.finite && o.sum < 1e-5 && o.gain <= ENC_FIT_MOST_GAIN;
    const bool expected = fits >= 0 && (may_fit || fits == 0) && (!must_fit || fits == ENC_STRENGTHS - 1);
    const char *const outcomes[] = {
        "no fit, the blend stays barycentric",
        "a fit or none, weights of a node sum to 1 within 1e-5, magnitudes to 4 at most",
        "a fit of every strength, weights of a node sum to 1 within 1e-5, magnitudes to 4 at most"};
    if (fits == 0) {
        cases_add(name, outcomes[may_fit + must_fit], expected, "no fit");
    } else {
        cases_add(name, outcomes[may_fit + must_fit], good && expected,
                  "%d of %d strengths, sums within %.0e, magnitudes to %.2f", fits, ENC_STRENGTHS - 1,
                  fmax(o.sum, 1e-8), o.gain);
    }
}

static int spiral(enc_direction *out, int n, double most) {
    for (int i = 0; i < n; i++) {
        out[i] = enc_direction_from_angles(most * sqrt((i + 0.5) / n), i * 137.50776405);
    }
    return n;
}

static int rings(enc_direction *out, const double *theta, int count, int each) {
    int n = 0;
    out[n++] = enc_direction_from_angles(0, 0);
    for (int r = 0; r < count; r++) {
        for (int i = 0; i < each; i++) {
            out[n++] = enc_direction_from_angles(theta[r], 360.0 * (i + 0.5 * (r % 2)) / each);
        }
    }
    return n;
}

int main(void) {
    enc_direction list[MOST];
    cases_title("Values at the nodes fitted for directions between them: lists on which a spline is "
                "ill-conditioned or absent.");
    check("one direction", list, rings(list, NULL, 0, 0), false, false);
    list[1] = enc_direction_from_angles(40, 10);
    check("two directions", list, 2, false, false);
    for (int i = 0; i < 9; i++) {
        list[i] = enc_direction_from_angles(fabs(i * 15.0 - 60), i < 4 ? 180 : 0);
    }
    check("nine directions in one line", list, 9, false, false);
    for (int i = 0; i < 9; i++) {
        list[i] = enc_direction_from_angles(fabs(i * 15.0 - 60), (i < 4 ? 180 : 0) + 1e-4 * (i % 2));
    }
    check("nine directions within a ten-thousandth of a degree of a line", list, 9, true, false);
    list[0] = enc_direction_from_angles(0, 0);
    list[1] = enc_direction_from_angles(30, 0);
    list[2] = enc_direction_from_angles(30, 90);
    check("three directions", list, 3, true, true);
    check("a ring without a pole", list + 1, rings(list, (const double[]){45}, 1, 12) - 1, true, false);
    check("256 on a spiral to 75 degrees", list, spiral(list, 256, 75), true, true);
    check("256 on a spiral to 89.9 degrees", list, spiral(list, 256, 89.9), true, true);
    check("256 within one degree of the normal", list, spiral(list, 256, 1), true, false);
    const int n = spiral(list, 64, 75);
    list[n] = enc_direction_from_angles(list[7].theta + 0.02, list[7].phi);
    check("64 and one a fiftieth of a degree beside another", list, n + 1, true, false);
    list[n] = enc_direction_from_angles(89.99, 0);
    check("64 to 75 degrees and one at 89.99", list, n + 1, true, false);
    check("rings at 80, 85 and 89.9 degrees", list, rings(list, (const double[]){80, 85, 89.9}, 3, 24),
          true, false);
    check("rings of 2 at 10 to 80 degrees", list, rings(list, (const double[]){10, 30, 50, 80}, 4, 2), true,
          false);
    return cases_result();
}
