/* Hard data for shifts, flow, the search for the sources of hidden points, and their clusters: results stay in range,
 * and are no worse than without shifts and with one cluster.
 *
 * SPDX-License-Identifier: MIT
 */
#include "cases.h"
#include "hard_data.h"

#include "encoder/paper/cluster.h"
#include "encoder/paper/flow.h"
#include "encoder/math/kmeans.h"
#include "encoder/paper/refine.h"
#include "tests/support/messages.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const enc_context one_thread = {.threads = 1}, two_threads = {.threads = 2};

/* ---- shifts ---- */

static void wrapped_shifts(void) {
    bool ok = true;
    int least = 0, most = 0;
    for (int size = 1; size <= 256; size++) {
        for (int delta = -600; delta <= 600; delta++) {
            const int w = enc_occlusion_wrap(delta, size);
            ok = ok && w >= -128 && w <= 127 && (w - delta) % size == 0 && 2 * abs(w) <= size;
            least = w < least ? w : least;
            most = w > most ? w : most;
        }
    }
    ok = ok && enc_occlusion_wrap(128, 256) == -128 && enc_occlusion_wrap(-128, 256) == -128;
    cases_add("shifts of -600 to 600 wrapped over 1 to 256 texels",
              "-128 to 127, at most half the tile, congruent", ok, "%d to %d", least, most);

    static const int sizes[][2] = {{1, 1}, {1, 7}, {7, 1}, {3, 5}, {128, 2}, {129, 3}, {256, 2}, {300, 2}};
    ok = true;
    for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++) {
        const int w = sizes[s][0], h = sizes[s][1];
        for (int t = 0; t < w * h; t++) {
            for (int dx = -128; dx <= 127; dx += dx < -126 || dx > 125 ? 1 : 17) {
                for (int dy = -128; dy <= 127; dy += dy < -126 || dy > 125 ? 1 : 31) {
                    const int c = (t % w + dx + 1000 * w) % w, r = (t / w + dy + 1000 * h) % h;
                    ok = ok && enc_occlusion_source(w, h, (size_t)t, dx, dy) == (size_t)(r * w + c);
                }
            }
        }
    }
    cases_add("sources at shifts of -128 and 127 in textures of 1x1 to 300x2", "wrapped over the tile", ok,
              "%d sizes", (int)(sizeof sizes / sizeof *sizes));
}

/* ---- flow ---- */

/* A smooth periodic texture of two waves a side, moved by (dx, dy) texels. */
static float wave(int w, int h, double column, double row) {
    const double turn = 2 * acos(-1.0), x = column / w, y = row / h;
    return (float)(1 + 0.4 * sin(turn * (x + y)) + 0.3 * sin(turn * (2 * x - y) + 1) +
                   0.2 * cos(turn * (x - 2 * y)));
}

typedef struct pair_result {
    bool finite;
    double error, zero; /* mean distance to the true shift, of the flow and of no shift */
    size_t hidden;
} pair_result;

static pair_result flow_of_pair(int w, int h, const float *target, const float *top, double dx, double dy) {
    const size_t n = (size_t)(w * h);
    float *flow = malloc(2 * n * sizeof *flow);
    uint8_t *hidden = malloc(n);
    pair_result out = {.finite =
                           flow != NULL && hidden != NULL &&
                           enc_flow_pair(&one_thread, w, h, target, top, NULL, flow, hidden) == BTF_OK};
    for (size_t t = 0; out.finite && t < n; t++) {
        out.finite = isfinite(flow[2 * t]) && isfinite(flow[2 * t + 1]);
        double ex = (double)flow[2 * t] - dx, ey = (double)flow[2 * t + 1] - dy;
        ex -= w * floor(ex / w + 0.5);
        ey -= h * floor(ey / h + 0.5);
        out.error += hypot(ex, ey) / (double)n;
        out.zero += hypot(dx, dy) / (double)n;
        out.hidden += hidden[t];
    }
    free(flow);
    free(hidden);
    return out;
}

static void flow_pairs(void) {
    static const struct {
        const char *input;
        int w, h;
        double dx, dy; /* top(x + d) = target(x) */
        float target_gain, top_gain;
        int kind; /* 0 constant, 1 waves, 2 noise, 3 one bright texel */
        const char *expected;
    } all[] = {
        {"constant images, 12x12", 12, 12, 0, 0, 1, 1, 0, "no shift, nothing hidden"},
        {"constant images, one 1000 times brighter", 12, 12, 0, 0, 1000, 1, 0, "no shift, nothing hidden"},
        {"constant images of 1e30 and 1e-5", 12, 12, 0, 0, 1e30f, 1e-5f, 0, "no shift, nothing hidden"},
        {"denormal images", 12, 12, 0, 0, 1e-40f, 1e-41f, 1, "no shift, nothing hidden"},
        {"a black image", 12, 12, 0, 0, 0, 1, 1, "no shift, nothing hidden"},
        {"equal waves", 16, 12, 0, 0, 1, 1, 1, "no shift, nothing hidden"},
        {"equal waves, one 100 times brighter", 16, 12, 0, 0, 100, 1, 1, "no shift, nothing hidden"},
        {"one texel", 1, 1, 0, 0, 1, 1, 1, "no shift, nothing hidden"},
        {"one column of 16 texels", 1, 16, 0, 0, 1, 1, 2, "no shift, nothing hidden"},
        {"one row of 16 texels", 16, 1, 0, 0, 1, 1, 2, "no shift, nothing hidden"},
        {"waves moved by 2 texels, 24x8", 24, 8, 2, 0, 1, 1, 1, "nearer to the truth than no shift"},
        {"waves moved by (-2, 1) texels, 9x31", 9, 31, -2, 1, 1, 1, 1, "nearer to the truth than no shift"},
        {"waves moved across the wrap, one 20 times brighter", 24, 24, 3, -2, 20, 1, 1,
         "nearer to the truth than no shift"},
        {"independent noise", 12, 12, 0, 0, 1, 1, 4, "finite"},
        {"one bright texel in black", 12, 12, 0, 0, 1, 1, 3, "no shift, nothing hidden"},
    };
    for (size_t i = 0; i < sizeof all / sizeof *all; i++) {
        const int w = all[i].w, h = all[i].h;
        float target[24 * 31], top[24 * 31];
        for (int t = 0; t < w * h; t++) {
            const double c = t % w, r = t / w;
            float a = 1, b = 1;
            if (all[i].kind == 1) {
                a = wave(w, h, c + all[i].dx, r + all[i].dy);
                b = wave(w, h, c, r);
            } else if (all[i].kind == 3) {
                a = b = t == w + 2 ? 1 : 0;
            } else if (all[i].kind > 1) {
                a = hard_random((uint32_t)t, 1, 2);
                b = all[i].kind == 4 ? hard_random((uint32_t)t, 5, 6) : a;
            }
            target[t] = a * all[i].target_gain;
            top[t] = b * all[i].top_gain;
        }
        const pair_result p = flow_of_pair(w, h, target, top, all[i].dx, all[i].dy);
        bool ok = p.finite;
        if (strcmp(all[i].expected, "no shift, nothing hidden") == 0) {
            ok = ok && p.error < 0.25 && p.hidden == 0;
        } else if (strcmp(all[i].expected, "finite") != 0) {
            ok = ok && p.error < 0.5 * p.zero;
        }
        cases_add(told("flow of a pair: %s", all[i].input), all[i].expected, ok,
                  "%.2f texels off, %zu hidden", p.error, p.hidden);
    }
}

/* user: a texture that looks the same from every view. */
static void flat_waves(const void *user, int texel, const enc_direction *v, const enc_direction *l,
                       int sample, float rgb[3]) {
    const int *size = user;
    (void)sample;
    /* brightness jumps from view to view by up to 1000 */
    const float jump =
        size[2] ? powf(10, 3 * hard_random((uint32_t)(v->phi * 8), (uint32_t)v->theta, 3)) : 1;
    const float value = wave(size[0], size[1], texel % size[0], (double)(texel / size[0]));
    for (int c = 0; c < 3; c++) {
        rgb[c] = (size[3] ? 0.5f : value) * jump * l->xyz[2] * (1 - 0.2f * (float)c);
    }
}

static enc_occlusion *voted(const enc_data *data, bool plain, bool *ok) {
    const enc_flow_options options = {.plain = plain};
    enc_occlusion *o[2] = {0};
    *ok = enc_flow_vote(&one_thread, data, &options, &o[0]) == BTF_OK &&
          enc_flow_vote(&two_threads, data, &options, &o[1]) == BTF_OK;
    if (*ok) {
        const size_t n = (size_t)data->n_views * enc_data_texel_count(data);
        *ok = memcmp(o[0]->shift, o[1]->shift, 2 * n) == 0 && memcmp(o[0]->hidden, o[1]->hidden, n) == 0 &&
              memcmp(o[0]->ratio, o[1]->ratio, n * sizeof(float)) == 0;
        for (size_t i = 0; i < n; i++) {
            *ok = *ok && o[0]->ratio[i] >= 0 && o[0]->ratio[i] <= 1;
        }
    }
    enc_occlusion_destroy(&o[1]);
    return o[0];
}

static void flow_votes(void) {
    static const struct {
        const char *input;
        int size[4]; /* width, height, brightness jumps, constant */
    } all[] = {
        {"constant images", {8, 8, 0, 1}},
        {"constant images, brightness jumps of up to 1000", {8, 8, 1, 1}},
        {"a plane with a texture", {12, 8, 0, 0}},
        {"a plane with a texture, brightness jumps of up to 1000", {12, 8, 1, 0}},
        {"one texel", {1, 1, 1, 0}},
        {"1x9 texels", {1, 9, 1, 0}},
        {"9x1 texels", {9, 1, 1, 0}},
    };
    const hard_directions d = hard_thirteen();
    for (size_t i = 0; i < sizeof all / sizeof *all; i++) {
        enc_data *data = hard_create(all[i].size[0], all[i].size[1], &d, &d, flat_waves, all[i].size);
        size_t moved = 0, hidden = 0;
        bool ok = true;
        for (int plain = 0; plain < 2; plain++) {
            bool mine;
            enc_occlusion *o = voted(data, plain, &mine);
            ok = ok && mine;
            for (size_t k = 0; o != NULL && k < 13 * o->n_texels; k++) {
                moved += o->shift[2 * k] != 0 || o->shift[2 * k + 1] != 0;
                hidden += o->hidden[k];
            }
            enc_occlusion_destroy(&o);
        }
        cases_add(told("flow of 13 views: %s", all[i].input),
                  "no shift, nothing hidden; the same with 1 and 2 threads",
                  ok && moved == 0 && hidden == 0, "%zu moved, %zu hidden", moved, hidden);
        enc_data_destroy(&data);
    }
}

static void flow_noise(void) {
    const hard_directions d = hard_thirteen();
    const float one = 1;
    const struct {
        const char *input;
        hard_value_fn value;
    } all[] = {{"noise", hard_noise}, {"values from 1e-8 to 1e6", hard_spread}, {"black", hard_black}};
    for (size_t i = 0; i < 3; i++) {
        enc_data *data = hard_create(8, 6, &d, &d, all[i].value, &one);
        bool ok;
        enc_occlusion *o = voted(data, false, &ok);
        cases_add(told("flow of 13 views: %s", all[i].input),
                  "ratios of votes within 0 and 1, the same with 1 and 2 threads", ok, "%zu of %d hidden",
                  o == NULL ? 0 : enc_occlusion_hidden_count(o, -1), 13 * 48);
        enc_occlusion_destroy(&o);
        enc_data_destroy(&data);
    }
}

/* ---- the search for hidden points ---- */

/* `hidden` of texel t in view v. */
typedef bool (*hide_fn)(int view, size_t texel);
static bool hide_none(int view, size_t texel) {
    return (void)view, (void)texel, false;
}
static bool hide_all(int view, size_t texel) {
    return (void)view, (void)texel, true;
}
static bool hide_some(int view, size_t texel) {
    return (view + (int)texel) % 3 == 0;
}
static bool hide_one_view(int view, size_t texel) {
    return (void)texel, view == 5;
}

static enc_occlusion *occlusion_of(const enc_data *data, hide_fn hide) {
    enc_occlusion *o = NULL;
    if (enc_occlusion_create(data->n_views, enc_data_texel_count(data), &o) != BTF_OK) {
        exit(1);
    }
    for (int v = 0; v < data->n_views; v++) {
        for (size_t t = 0; t < o->n_texels; t++) {
            o->hidden[(size_t)v * o->n_texels + t] = hide(v, t);
        }
    }
    return o;
}

/* STVS of a diffuse texel of albedo `albedo`. */
static double refine_distance(const enc_data *data, const float *albedo, size_t texel, size_t source,
                              int view) {
    double sum = 0;
    for (int l = 0; l < data->n_lights; l++) {
        double squares = 0;
        for (int c = 0; c < 3; c++) {
            const double model = (double)albedo[source] * (double)data->lights[l].xyz[2];
            const double r = (double)*hard_sample(data, texel, view, c, l) - model;
            squares += r * r;
        }
        sum += sqrt(squares);
    }
    return sum;
}

static void refine(void) {
    const hard_directions d = hard_thirteen();
    const float one = 1;
    enum { W = 7, H = 4 };
    const struct {
        const char *input;
        hide_fn hide;
        hard_value_fn value;
    } all[] = {
        {"no point hidden", hide_none, hard_noise},
        {"nothing but hidden points", hide_all, hard_noise},
        {"one view all hidden", hide_one_view, hard_noise},
        {"a third hidden, noise", hide_some, hard_noise},
        {"a third hidden, black", hide_some, hard_black},
        {"a third hidden, values from 1e-8 to 1e6", hide_some, hard_spread},
    };
    for (size_t i = 0; i < sizeof all / sizeof *all; i++) {
        enc_data *data = hard_create(W, H, &d, &d, all[i].value, &one);
        enc_sbrdf *sbrdf = NULL;
        if (enc_sbrdf_create(W * H, 1, false, &sbrdf) != BTF_OK) {
            exit(1);
        }
        float albedo[W * H];
        for (size_t t = 0; t < W * H; t++) {
            albedo[t] = all[i].value == hard_black ? 0 : 0.1f + 0.05f * (float)t;
            float *p = sbrdf->values + t * 8;
            p[0] = p[1] = p[2] = albedo[t] > 0 ? 1 : 0;
            p[3] = albedo[t];
        }
        uint8_t shadow[13 * W * H];
        memset(shadow, 255, sizeof shadow);
        bool ok = true;
        size_t freed = 0, worse = 0;
        enc_occlusion *o[2];
        for (int run = 0; run < 2; run++) {
            o[run] = occlusion_of(data, all[i].hide);
            float thresholds[13];
            ok = ok && enc_refine(run ? &two_threads : &one_thread, data, sbrdf, shadow, 1 / 255.0f, NULL,
                                  o[run], thresholds) == BTF_OK;
            for (int v = 0; v < 13; v++) {
                ok = ok && isfinite(thresholds[v]) && thresholds[v] >= 0;
                for (size_t t = 0; t < W * H && run == 0; t++) {
                    const size_t at = (size_t)v * W * H + t;
                    if (all[i].hide(v, t)) {
                        freed += o[0]->hidden[at] == 0;
                        const size_t source =
                            enc_occlusion_source(W, H, t, o[0]->shift[2 * at], o[0]->shift[2 * at + 1]);
                        worse += refine_distance(data, albedo, t, source, v) >
                                 refine_distance(data, albedo, t, t, v) * (1 + 1e-5);
                    } else {
                        ok = ok && o[0]->hidden[at] == 0;
                    }
                }
            }
        }
        ok = ok && memcmp(o[0]->hidden, o[1]->hidden, 13 * W * H) == 0 &&
             memcmp(o[0]->shift, o[1]->shift, 2 * 13 * W * H) == 0 && worse == 0;
        if (all[i].hide == hide_all || all[i].hide == hide_one_view) {
            ok = ok && freed == 0; /* without a visible point there is no threshold */
        }
        cases_add(told("search for hidden points: %s", all[i].input),
                  all[i].hide == hide_all || all[i].hide == hide_one_view
                      ? "without a visible point all stay hidden; no shift worse than none"
                      : "finite thresholds, no shift worse than none",
                  ok, "%zu found", freed);
        enc_occlusion_destroy(&o[0]);
        enc_occlusion_destroy(&o[1]);
        enc_sbrdf_destroy(&sbrdf);
        enc_data_destroy(&data);
    }
}

/* ---- clusters ---- */

/* Three different profiles, over and over. */
static void three_profiles(const void *user, int texel, const enc_direction *v, const enc_direction *l,
                           int sample, float rgb[3]) {
    (void)user, (void)v, (void)sample;
    for (int c = 0; c < 3; c++) {
        rgb[c] = (0.2f + 0.3f * (float)(texel % 3)) * l->xyz[2];
    }
}

/* A value as a stored centre gives it back: its square root is a code (encoder/paper/cluster.h). */
static double coded(double value, double scale, bool linear) {
    const double root = fmin(floor((linear ? sqrt(value) : value) / scale + 0.5), 255) * scale;
    return linear ? root * root : root;
}

/* Squared errors over hidden points by the stored centres, by one centre for each view, coded alike, and by
 * black. In radiance (`linear`) or its square root, whichever the clusters are made in. */
static void cluster_errors(const enc_data *data, const enc_occlusion *o, const enc_centres *k, bool linear,
                           double *out_stored, double *out_one, double *out_black) {
    const double scale = (double)k->scale;
    *out_stored = *out_one = *out_black = 0;
    for (int v = 0; v < data->n_views; v++) {
        for (int channel = 0; channel < 3 * data->n_lights; channel++) {
            const int l = channel / 3, c = channel % 3;
            double sum = 0, n = 0;
            for (int pass = 0; pass < 2; pass++) {
                const double one = n > 0 ? coded(sum / n, scale, linear) : 0;
                for (size_t t = 0; t < o->n_texels; t++) {
                    const size_t at = (size_t)v * o->n_texels + t;
                    if (!o->hidden[at]) {
                        continue;
                    }
                    const double radiance = (double)*hard_sample(data, t, v, c, l);
                    const double y = linear ? radiance : sqrt(radiance);
                    const double root =
                        scale *
                        k->codes[((size_t)o->centre[at] * (size_t)k->n_lights + (size_t)l) * 3 + (size_t)c];
                    const double r = (linear ? root * root : root) - y;
                    if (pass == 0) {
                        sum += y;
                        n++;
                    } else {
                        *out_stored += r * r;
                        *out_one += (one - y) * (one - y);
                        *out_black += y * y;
                    }
                }
            }
        }
    }
}

static void clusters(void) {
    const hard_directions d = hard_thirteen();
    enum { W = 6, H = 5 };
    const float one = 1, dim = 1e-12f, denormal = 1e-40f, bright = 1e30f;
    const struct {
        const char *input;
        hide_fn hide;
        hard_value_fn value;
        const float *scale;
        int k, expected_k;
        bool exact; /* as many centres as different points: the only error is that of the codes */
    } all[] = {
        {"no hidden point, no centre asked for", hide_none, hard_noise, &one, 0, 0, false},
        {"no hidden point, 5 centres", hide_none, hard_noise, &one, 5, 0, false},
        {"nothing but hidden points, 26 centres", hide_all, hard_noise, &one, 26, 26, false},
        {"one view all hidden, 4 centres", hide_one_view, hard_noise, &one, 4, 4, false},
        {"13 views with hidden points, 1 centre", hide_some, hard_noise, &one, 1, 1, false},
        {"k far above the points", hide_some, hard_noise, &one, 65536, 130, true},
        {"390 points, 3 different ones a view, k = 300", hide_all, three_profiles, &one, 300, 39, true},
        {"black points only", hide_some, hard_black, &one, 20, 13, true},
        {"points of 1e-12", hide_some, hard_noise, &dim, 26, 26, false},
        {"denormal points", hide_some, hard_noise, &denormal, 26, 26, false},
        {"points of up to 1e30", hide_some, hard_noise, &bright, 26, 26, false},
        {"values from 1e-8 to 1e6", hide_some, hard_spread, &one, 26, 26, false},
    };
    for (size_t i = 0; i < sizeof all / sizeof *all; i++) {
        enc_data *data = hard_create(W, H, &d, &d, all[i].value, all[i].scale);
        bool ok = true;
        double stored = 0, single = 0, energy = 0;
        int k = -1;
        const bool fewer = all[i].k < 13;   /* than views */
        for (int way = 0; way < 4; way++) { /* linear, data points */
            const enc_cluster_options options = {.linear = way & 1, .data_points = way & 2};
            enc_occlusion *o[2] = {occlusion_of(data, all[i].hide), occlusion_of(data, all[i].hide)};
            enc_centres *c[2] = {0};
            ok = ok && enc_cluster(&one_thread, data, &options, all[i].k, o[0], &c[0]) == BTF_OK &&
                 enc_cluster(&two_threads, data, &options, all[i].k, o[1], &c[1]) == BTF_OK;
            if (ok) {
                k = c[0]->k;
                ok = k == c[1]->k && k == all[i].expected_k && c[0]->scale >= 0x1p-24f &&
                     c[0]->scale <= 0x1p24f && memcmp(&c[0]->scale, &c[1]->scale, sizeof(float)) == 0 &&
                     memcmp(c[0]->codes, c[1]->codes, (size_t)k * 13 * 3) == 0 &&
                     memcmp(o[0]->centre, o[1]->centre, 13 * W * H * sizeof(uint16_t)) == 0;
            }
            for (size_t p = 0; ok && p < 13 * W * H; p++) {
                ok = o[0]->hidden[p] ? o[0]->centre[p] < k : o[0]->centre[p] == 0;
            }
            double errors[3];
            if (ok && k > 0) {
                cluster_errors(data, o[0], c[0], options.linear, &errors[0], &errors[1], &errors[2]);
                /* a data point nearest to the mean of its cluster is off by at most twice the squares */
                ok = errors[0] <=
                     (fewer ? errors[2] : (options.data_points ? 2 : 1) * errors[1]) * (1 + 1e-9);
                if (all[i].exact) { /* half a code of each root */
                    const double points = (double)enc_occlusion_hidden_count(o[0], -1) * 39;
                    const double half = (double)c[0]->scale / 2, most = options.linear ? 2 : 1;
                    ok = ok && errors[0] <= points * half * half * most * most * (1 + 1e-6);
                }
                if (way == 0) {
                    stored = errors[0], single = errors[1], energy = errors[2];
                }
            }
            for (int r = 0; r < 2; r++) {
                enc_occlusion_destroy(&o[r]);
                enc_centres_destroy(&c[r]);
            }
        }
        cases_add(told("clusters: %s", all[i].input),
                  all[i].exact ? "as many centres as different points, exact but for codes"
                  : fewer      ? "the centres asked for, a storable scale, no worse than black"
                               : "the centres asked for, a storable scale, no worse than one centre a view",
                  ok, "k %d, rms %.2g, of one centre %.2g", k, energy > 0 ? sqrt(stored / energy) : 0,
                  energy > 0 ? sqrt(single / energy) : 0);
        enc_data_destroy(&data);
    }
}

enum { POINTS = 24, STRIDE = 16 };

/* One run of k-means over n points. False for an index out of range or a centre that is no number. */
static bool settle(int n, const float *points, size_t k, uint64_t seed, size_t *out_distinct,
                   int *out_empty, double *out_error) {
    float centres[POINTS * STRIDE];
    uint32_t index[POINTS] = {0};
    size_t count[POINTS] = {0};
    for (size_t i = 0; i < POINTS * STRIDE; i++) {
        centres[i] = NAN;
    }
    *out_empty = 0;
    *out_error = 0;
    if (enc_kmeans_distinct((size_t)n, STRIDE, points, out_distinct) != BTF_OK ||
        enc_kmeans((size_t)n, STRIDE, points, k, 100, seed, false, centres, index) != BTF_OK) {
        return false;
    }
    for (int i = 0; i < n; i++) {
        if (index[i] >= k) {
            return false;
        }
        count[index[i]]++;
        for (int c = 0; c < STRIDE; c++) {
            const double r = (double)(points[i * STRIDE + c] - centres[index[i] * STRIDE + (size_t)c]);
            *out_error += r * r;
        }
    }
    bool finite = true;
    for (size_t j = 0; j < k; j++) {
        *out_empty += count[j] == 0 && *out_distinct >= k;
        for (int c = 0; c < STRIDE; c++) {
            finite = finite && isfinite(centres[j * STRIDE + (size_t)c]);
        }
    }
    return finite;
}

/* k-means itself: duplicates, fewer points than centres, and clusters that lose their members on the way. */
static void empty_clusters(void) {
    enum { TRIALS = 3000 };
    int emptied = 0, unsettled = 0, empty;
    bool ok = true;
    size_t distinct;
    double error;
    for (uint32_t trial = 0; trial < TRIALS; trial++) {
        float points[POINTS * STRIDE] = {0};
        const size_t k = 2 + trial % 6;
        for (int i = 0; i < 14; i++) {
            for (int c = 0; c < 2; c++) { /* a plane of small integers: many ties and duplicates */
                points[i * STRIDE + c] =
                    floorf(hard_random(trial, (uint32_t)i, (uint32_t)c) * (trial % 2 ? 9 : 2)) *
                    (c == 0 && trial % 3 == 0 ? 100 : 1);
            }
        }
        ok = settle(14, points, k, trial + 1, &distinct, &empty, &error) && ok;
        emptied += empty;
        unsettled += distinct <= k && error > 0;
    }
    cases_add("k-means of 14 small integer points, 3000 sets, k up to 7",
              "finite centres, no cluster left empty", ok && emptied == 0, "%d empty", emptied);
    cases_add("k-means with k at least the different points", "every point is its centre",
              ok && unsettled == 0, "%d sets with an error", unsettled);

    /* sets found by search, in which Lloyd's rounds alone empty a cluster */
    static const uint32_t sets[] = {19168, 20999, 25355, 26658, 31991, 33462};
    emptied = 0;
    ok = true;
    for (size_t s = 0; s < sizeof sets / sizeof *sets; s++) {
        float points[POINTS * STRIDE] = {0};
        for (int i = 0; i < POINTS; i++) {
            for (int c = 0; c < 2; c++) {
                points[i * STRIDE + c] = hard_random(sets[s], (uint32_t)i, (uint32_t)c);
            }
        }
        ok = settle(POINTS, points, 7, sets[s] + 1, &distinct, &empty, &error) && ok;
        emptied += empty;
    }
    cases_add("k-means of 24 points, 6 sets that empty a cluster of 7 on the way", "no cluster left empty",
              ok && emptied == 0, "%d empty", emptied);
}

static void shares(void) {
    const size_t hidden[5] = {0, 1, 1000000, 3, 7}, distinct[5] = {0, 1, 999999, 2, 1};
    bool ok = true;
    for (size_t k = 1; k < 70000; k = k * 2 + 1) {
        size_t share[5], sum = 0;
        enc_cluster_shares(5, hidden, distinct, k, share);
        for (int v = 0; v < 5; v++) {
            ok = ok && share[v] <= distinct[v] && (k < 4 || hidden[v] == 0 || share[v] >= 1);
            sum += share[v];
        }
        ok = ok && sum == k;
    }
    cases_add("shares of views with 0, 1, 3, 7 and 1000000 hidden points",
              "sum k, at least 1, at most the different ones", ok, "k from 1 to 65535");
}

int main(void) {
    cases_title("Shifts, flow, the search for hidden points, clusters.");
    wrapped_shifts();
    flow_pairs();
    flow_votes();
    flow_noise();
    refine();
    clusters();
    empty_clusters();
    shares();
    return cases_result();
}
