/* Gains and costs of fits, with a coder after them. See expect.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "expect.h"

#include <math.h>

/* A blend's squared error between the samples as a share of that with samples left out: of the part that a
 * fit follows, of the rest. These constants were set with BRICKS64, IMPALLA and btf-sample: see FIT.md. */
static const double smooth_share = 1 / 30.0, rough_share = 0.5;

/* The cosine of a fit's move with the blend's error, between the samples against left-out ones: smooth,
 * rough. */
static const double smooth_aim = 1, rough_aim = 2 / 3.0;

/* Share of the coder's squared error at the samples that a blend of three views and three lights keeps. */
static const double blended_share = 0.25;

/* dB between the samples, where a renderer looks, that a dB at them is worth. */
static const double price = 0.125;

/* A fit may add this part of the coder's squared error at the samples: 1.1 dB. An error of one level of 255 goes
 * unseen and adds to the coder's. */
static const double most_added = 0.3, unseen = 1.0 / (255 * 255);

static double product(const enc_fit_moved *m) {
    return 0.5 * (m->error - m->fitted + m->move);
}

/* The part of the error that a fit follows: the squared cosine of its move with it. */
static double followed(const enc_fit_moved *m) {
    const double p = product(m);
    return m->move > 0 && m->error > 0 && p > 0 ? fmin(1, p * p / (m->move * m->error)) : 0;
}

/* The squared error of the blend between the samples, given that with samples left out; the strongest fit
 * follows the share `smooth` of it. */
static double error_between(double left_out, double smooth) {
    return left_out * (smooth * smooth_share + (1 - smooth) * rough_share);
}

/* The squared error that a move saves between the samples: twice its product with the error less its
 * square. */
static double gain(const enc_fit_moved *m, double smooth) {
    const double share = smooth * smooth_share + (1 - smooth) * rough_share;
    const double aim = smooth * smooth_aim + (1 - smooth) * rough_aim;
    return m->move > 0 ? 2 * product(m) * aim * sqrt(share * m->moves / m->move) - m->moves : 0;
}

static enc_fit_error gains(const enc_fit_moved *linear, const enc_fit_moved *srgb, enc_fit_error smooth) {
    return (enc_fit_error){gain(linear, smooth.linear), gain(srgb, smooth.srgb)};
}

void enc_fit_expect(const enc_fit_moved linear[ENC_FIT_CANDIDATES],
                    const enc_fit_moved srgb[ENC_FIT_CANDIDATES], enc_fit_choice *choice) {
    enc_fit_error smooth = {0, 0}, error = {0, 0}, plain;
    for (int k = 1; k < ENC_FIT_CANDIDATES; k++) {
        if (choice->candidate[k].judged) {
            smooth = (enc_fit_error){followed(&linear[k]), followed(&srgb[k])};
            error = (enc_fit_error){linear[k].error, srgb[k].error};
        }
    }
    plain =
        (enc_fit_error){error_between(error.linear, smooth.linear), error_between(error.srgb, smooth.srgb)};
    choice->candidate[0].left_out = error;
    choice->candidate[0].between = plain;
    for (int k = 1; k < ENC_FIT_CANDIDATES; k++) {
        enc_fit_candidate *c = &choice->candidate[k];
        c->left_out = (enc_fit_error){linear[k].fitted, srgb[k].fitted};
        c->gain = gains(&linear[k], &srgb[k], smooth);
        c->between =
            (enc_fit_error){fmax(plain.linear - c->gain.linear, 0), fmax(plain.srgb - c->gain.srgb, 0)};
    }
}

enc_fit_error enc_fit_coded_at(const enc_fit_candidate *candidate, enc_fit_error coder) {
    return (enc_fit_error){candidate->at.linear + coder.linear, candidate->at.srgb + coder.srgb};
}

enc_fit_error enc_fit_coded_between(const enc_fit_candidate *candidate, enc_fit_error coder) {
    return (enc_fit_error){candidate->between.linear + blended_share * coder.linear,
                           candidate->between.srgb + blended_share * coder.srgb};
}

/* A fit may remove detail that the coder would lose, so that the difference of the errors is too small:
 * then the coder is taken to be as much better or worse than foreseen as the whole is. */
static double coder_of(double at, double foreseen, double measured) {
    return fmax(measured - at, foreseen + at > 0 ? foreseen * measured / (foreseen + at) : measured);
}

enc_fit_error enc_fit_coder_measured(const enc_fit_choice *choice, enc_fit_error measured) {
    const enc_fit_error at = choice->candidate[choice->chosen].at;
    return (enc_fit_error){coder_of(at.linear, choice->coder.linear, measured.linear),
                           coder_of(at.srgb, choice->coder.srgb, measured.srgb)};
}

static double db(double from, double to) {
    return 10 * log10((from + unseen) / (to + unseen));
}

bool enc_fit_allowed(const enc_fit_choice *choice, const enc_fit_candidate *c) {
    return c->at.srgb <= most_added * (choice->coder.srgb + unseen);
}

double enc_fit_value(const enc_fit_choice *choice, const enc_fit_candidate *c) {
    const enc_fit_error before = enc_fit_coded_between(&choice->candidate[0], choice->coder),
                        after = enc_fit_coded_between(c, choice->coder);
    const double gained = 0.5 * (db(before.linear, after.linear) + db(before.srgb, after.srgb));
    return gained - price * db(enc_fit_coded_at(c, choice->coder).srgb, choice->coder.srgb);
}
