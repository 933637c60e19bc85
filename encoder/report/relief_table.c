/* Relief and gloss as tables. See relief_table.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "relief_table.h"

#include "metrics.h"

static double linear(enc_judged_error e) {
    const enc_error_sum sum = {e.linear, e.srgb, 1};
    return enc_psnr_linear(&sum);
}

static double srgb(enc_judged_error e) {
    const enc_error_sum sum = {e.linear, e.srgb, 1};
    return enc_psnr_srgb(&sum);
}

static const char *kind_of(const enc_relief_candidate *c) {
    return c->constant ? "constant" : c->drawn_in ? "drawn-in" : "map";
}

const char *enc_relief_text(const enc_relief_choice *choice, char text[ENC_RELIEF_TEXT]) {
    if (choice->chosen > 0) {
        const enc_relief_candidate *c = &choice->candidate[choice->chosen];
        char end[24] = "";
        if (choice->end.judged > 0) {
            snprintf(end, sizeof end, " relief-end=%d", choice->end.end);
        }
        snprintf(text, ENC_RELIEF_TEXT, "relief-chosen=%s:%g,%.3f,%.3f%s gloss-chosen=%d", kind_of(c),
                 c->scale, choice->least, choice->most, end, choice->gloss.quarters);
    } else {
        snprintf(text, ENC_RELIEF_TEXT, "relief-chosen=none gloss-chosen=%d", choice->gloss.quarters);
    }
    return text;
}

static void print_end(const enc_relief_end *end, FILE *out) {
    fprintf(out,
            "Relief at levels of detail: PSNR of views left out, in dB, linear / sRGB, without -> with "
            "relief (it ends\n"
            "before the first level that gains less than %g dB, or loses in one of the two)\n",
            ENC_RELIEF_LEVEL_MARGIN);
    for (int i = 0; i < end->judged; i++) {
        const enc_relief_judged_level *l = &end->level[i];
        fprintf(out, "%c level %-16d %8.2f / %.2f -> %.2f / %.2f\n", l->on ? '*' : ' ', i + 1,
                linear(l->plain), srgb(l->plain), linear(l->moved), srgb(l->moved));
    }
}

static void print_gloss(const enc_gloss_choice *gloss, FILE *out) {
    fprintf(out,
            "Gloss: PSNR of samples whose view and light are left out, in dB, linear / sRGB, by the share "
            "of the half\n"
            "vector that is kept (the best is %.2f; the largest share is taken up to which each step gains enough)\n",
            gloss->best);
    for (int q = 0; q < ENC_GLOSS_SHARES; q++) {
        fprintf(out, "%c %-22.2f %8.2f / %.2f\n", q == gloss->quarters ? '*' : ' ', q / 4.0,
                linear(gloss->error[q]), srgb(gloss->error[q]));
    }
}

void enc_relief_print(const enc_relief_choice *choice, FILE *out) {
    if (choice->tried) {
        fprintf(out,
                "Relief: PSNR of views left out, in dB, linear / sRGB, without -> with relief, by ring; a "
                "ring must gain %g dB\n"
                "(the heights found leave %.3f of a plane's squared error; a map is taken where they leave "
                "less than %g)\n",
                ENC_RELIEF_MARGIN, choice->share, ENC_RELIEF_SHARE);
        for (int k = 0; k < ENC_RELIEF_CANDIDATES; k++) {
            const enc_relief_candidate *c = &choice->candidate[k];
            char name[32] = "none";
            if (k > 0) {
                snprintf(name, sizeof name, "%s x %g", kind_of(c), c->scale);
            }
            if (c->judged) {
                fprintf(out, "%c %-22s gains %.2f dB on %d rings\n", k == choice->chosen ? '*' : ' ', name,
                        c->gain, c->rings);
            }
        }
        for (int k = 0; k < choice->n_rings; k++) {
            const enc_relief_ring *r = &choice->ring[k];
            if (r->views > 0) {
                fprintf(out, "%c %-22.1f %8.2f / %.2f -> %.2f / %.2f\n", r->on ? '*' : ' ', r->theta,
                        linear(r->plain), srgb(r->plain), linear(r->moved), srgb(r->moved));
            }
        }
    }
    if (choice->end.judged > 0) {
        print_end(&choice->end, out);
    }
    if (choice->reason) {
        fprintf(out, choice->tried ? "Relief: none, %s\n" : "Relief: not tried: %s\n", choice->reason);
    }
    if (choice->gloss.judged) {
        print_gloss(&choice->gloss, out);
    }
}

static void candidates_json(json *j, const enc_relief_choice *choice) {
    json_array(j, "candidates");
    for (int k = 0; k < ENC_RELIEF_CANDIDATES; k++) {
        const enc_relief_candidate *c = &choice->candidate[k];
        if (c->judged) {
            json_object(j, NULL);
            json_integer(j, "candidate", k);
            json_string(j, "kind", k == 0 ? "none" : kind_of(c));
            json_number(j, "scale", c->scale);
            json_number(j, "gain", c->gain);
            json_integer(j, "rings", c->rings);
            json_end(j);
        }
    }
    json_end(j);
}

static void rings_json(json *j, const enc_relief_choice *choice) {
    json_array(j, "rings");
    for (int k = 0; k < choice->n_rings; k++) {
        const enc_relief_ring *r = &choice->ring[k];
        json_object(j, NULL);
        json_number(j, "theta", r->theta);
        json_integer(j, "views_left_out", r->views);
        json_integer(j, "relief", r->on);
        json_number(j, "plain_linear", linear(r->plain));
        json_number(j, "plain_srgb", srgb(r->plain));
        json_number(j, "moved_linear", linear(r->moved));
        json_number(j, "moved_srgb", srgb(r->moved));
        json_end(j);
    }
    json_end(j);
}

static void end_json(json *j, const enc_relief_end *end) {
    json_integer(j, "end", end->end);
    json_array(j, "levels");
    for (int i = 0; i < end->judged; i++) {
        const enc_relief_judged_level *l = &end->level[i];
        json_object(j, NULL);
        json_integer(j, "level", i + 1);
        json_integer(j, "relief", l->on);
        json_number(j, "plain_linear", linear(l->plain));
        json_number(j, "plain_srgb", srgb(l->plain));
        json_number(j, "moved_linear", linear(l->moved));
        json_number(j, "moved_srgb", srgb(l->moved));
        json_end(j);
    }
    json_end(j);
}

static void gloss_json(json *j, const enc_gloss_choice *gloss) {
    json_integer(j, "gloss", gloss->quarters);
    if (gloss->judged) {
        json_number(j, "gloss_best", gloss->best);
        json_array(j, "gloss_shares");
        for (int q = 0; q < ENC_GLOSS_SHARES; q++) {
            json_object(j, NULL);
            json_number(j, "share", q / 4.0);
            json_number(j, "left_out_linear", linear(gloss->error[q]));
            json_number(j, "left_out_srgb", srgb(gloss->error[q]));
            json_end(j);
        }
        json_end(j);
    }
}

void enc_relief_json(json *j, const char *key, const enc_relief_choice *choice) {
    if (!choice) {
        json_null(j, key);
        return;
    }
    json_object(j, key);
    json_integer(j, "chosen", choice->chosen);
    json_bool(j, "tried", choice->tried);
    if (choice->reason) {
        json_string(j, "reason", choice->reason);
    }
    json_number(j, "least_height", choice->least);
    json_number(j, "greatest_height", choice->most);
    if (choice->tried) {
        json_number(j, "share_of_plane", choice->share);
        candidates_json(j, choice);
        rings_json(j, choice);
    }
    if (choice->end.judged > 0) {
        end_json(j, &choice->end);
    }
    gloss_json(j, &choice->gloss);
    json_end(j);
}
