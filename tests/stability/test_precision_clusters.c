/* The clusters of hidden points against the same k-means in double, in plain loops.
 *
 * SPDX-License-Identifier: MIT
 */
#include "cases.h"
#include "precision.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { VIEWS = 13, LIGHTS = 13, ROW = 3 * LIGHTS, SIDE = 10, TEXELS = SIDE * SIDE, MOST_CENTRES = 256 };

static const enc_context context = {.threads = 1};

typedef struct point {
    double x[ROW];
} point;

/* The hidden points of a view. */
typedef struct view_points {
    size_t n;
    size_t texel[TEXELS];
    point row[TEXELS];
} view_points;

static void points_of_view(const enc_data *data, const enc_occlusion *o, int view, bool linear,
                           view_points *out) {
    out->n = 0;
    for (size_t t = 0; t < TEXELS; t++) {
        if (o->hidden[(size_t)view * TEXELS + t]) {
            for (int i = 0; i < ROW; i++) {
                const double y = fmax((double)*hard_sample(data, t, view, i / LIGHTS, i % LIGHTS), 0);
                out->row[out->n].x[i] = linear ? y : sqrt(y);
            }
            out->texel[out->n++] = t;
        }
    }
}

static double square(const point *a, const point *b) {
    double sum = 0;
    for (int i = 0; i < ROW; i++) {
        sum += (a->x[i] - b->x[i]) * (a->x[i] - b->x[i]);
    }
    return sum;
}

static size_t distinct(const view_points *p) {
    size_t count = 0;
    for (size_t i = 0; i < p->n; i++) {
        bool first = true;
        for (size_t j = 0; j < i; j++) {
            first = first && square(p->row + i, p->row + j) > 0;
        }
        count += first;
    }
    return count;
}

/* splitmix64, in [0, 1): the draws of the float stage. */
static double draw(uint64_t *state) {
    uint64_t z = *state += UINT64_C(0x9E3779B97F4A7C15);
    z = (z ^ (z >> 30)) * UINT64_C(0xBF58476D1CE4E5B9);
    z = (z ^ (z >> 27)) * UINT64_C(0x94D049BB133111EB);
    z ^= z >> 31;
    return (double)(z >> 11) * 0x1p-53;
}

/* The nearest centre, the lowest among equals. */
static size_t nearest(const point *p, size_t k, const point *centres, double *out_square) {
    size_t best = 0;
    for (size_t j = 1; j < k; j++) {
        best = square(p, centres + j) < square(p, centres + best) ? j : best;
    }
    *out_square = square(p, centres + best);
    return best;
}

/* Start values by k-means++ (D. Arthur and S. Vassilvitskii, 2007), in double. */
static void start(const view_points *p, size_t k, uint64_t seed, point *centres) {
    uint64_t state = seed;
    double weight[TEXELS];
    size_t chosen = (size_t)(draw(&state) * (double)p->n);
    for (size_t j = 0; j < k; j++) {
        double total = 0;
        centres[j] = p->row[chosen];
        for (size_t i = 0; i < p->n; i++) {
            nearest(p->row + i, j + 1, centres, weight + i);
            total += weight[i];
        }
        double left = draw(&state) * total;
        chosen = (j + 1) % p->n;
        for (size_t i = 0; i < p->n && left >= 0; i++) {
            if (weight[i] > 0) {
                chosen = i;
                left -= weight[i];
            }
        }
    }
}

/* Lloyd's rounds (S. Lloyd, 1982); an empty cluster moves to the farthest point. */
static void k_means(const view_points *p, size_t k, uint64_t seed, point *centres) {
    size_t index[TEXELS], members[MOST_CENTRES];
    double squares[TEXELS];
    start(p, k, seed, centres);
    for (size_t i = 0; i < p->n; i++) {
        index[i] = nearest(p->row + i, k, centres, squares + i);
    }
    size_t changed = 1;
    for (int round = 0; round < 30 && changed > 0; round++) {
        changed = 0;
        memset(members, 0, sizeof members);
        for (size_t i = 0; i < p->n; i++) {
            members[index[i]]++;
        }
        for (size_t j = 0; j < k; j++) {
            size_t farthest = p->n;
            for (size_t i = 0; i < p->n && members[j] == 0; i++) {
                if (squares[i] > 0 && members[index[i]] > 1 &&
                    (farthest == p->n || squares[i] > squares[farthest])) {
                    farthest = i;
                }
            }
            if (farthest < p->n) {
                members[index[farthest]]--;
                members[j] = 1;
                index[farthest] = j;
                squares[farthest] = 0;
                changed++;
            }
        }
        for (size_t j = 0; j < k; j++) {
            point sum = {{0}};
            for (size_t i = 0; i < p->n; i++) {
                for (int d = 0; d < ROW && index[i] == j; d++) {
                    sum.x[d] += p->row[i].x[d] / (double)members[j];
                }
            }
            centres[j] = members[j] > 0 ? sum : centres[j];
        }
        for (size_t i = 0; i < p->n; i++) {
            const size_t before = index[i];
            index[i] = nearest(p->row + i, k, centres, squares + i);
            changed += index[i] != before;
        }
    }
}

/* enc_cluster in double: at least one centre for every view with hidden points. */
static enc_centres cluster(const enc_data *data, size_t k_total, bool linear, enc_occlusion *o) {
    static point centres[MOST_CENTRES];
    static view_points p;
    size_t hidden[VIEWS], different[VIEWS], share[VIEWS], k = 0;
    for (int v = 0; v < VIEWS; v++) {
        points_of_view(data, o, v, linear, &p);
        hidden[v] = p.n;
        different[v] = distinct(&p);
    }
    enc_cluster_shares(VIEWS, hidden, different, k_total, share);
    for (int v = 0; v < VIEWS; v++) {
        points_of_view(data, o, v, linear, &p);
        if (share[v] > 0) {
            k_means(&p, share[v], 1 + (uint64_t)v, centres + k);
        }
        k += share[v];
    }
    double most = 0;
    for (size_t i = 0; i < k * ROW; i++) {
        most = fmax(most, centres[i / ROW].x[i % ROW]);
    }
    most = linear ? sqrt(most) : most;
    enc_centres out = {(int)k, LIGHTS, (float)(most / 255), malloc(k * ROW)};
    if (out.codes == NULL) {
        exit(1);
    }
    for (size_t i = 0; i < k * ROW; i++) {
        double *value = &centres[i / ROW].x[i % ROW];
        const double code = fmin(rint((linear ? sqrt(*value) : *value) / (double)out.scale), 255);
        out.codes[(i / ROW * LIGHTS + i % LIGHTS) * 3 + i % ROW / LIGHTS] = (uint8_t)code;
        *value = code * (double)out.scale;
        *value *= linear ? *value : 1;
    }
    size_t first = 0;
    for (int v = 0; v < VIEWS; v++) {
        points_of_view(data, o, v, linear, &p);
        for (size_t i = 0; i < p.n; i++) {
            double unused;
            o->centre[(size_t)v * TEXELS + p.texel[i]] =
                (uint16_t)(first + nearest(p.row + i, share[v], centres + first, &unused));
        }
        first += share[v];
    }
    return out;
}

void precision_clusters(void) {
    static const struct {
        const char *input;
        size_t k;
        bool linear;
    } list[] = {{"24 clusters by k-means in double", 24, false},
                {"100 clusters by k-means in double", 100, false},
                {"48 clusters by k-means in double, of radiance instead of its root", 48, true}};
    precision_scene s = precision_scene_make(SIDE);
    for (size_t i = 0; i < sizeof list / sizeof *list; i++) {
        enc_occlusion *single = precision_occlusion(s.data), *twice = precision_occlusion(s.data);
        const enc_cluster_options options = {.linear = list[i].linear};
        enc_centres *a = NULL;
        if (enc_cluster(&context, s.data, &options, (int)list[i].k, single, &a) != BTF_OK) {
            exit(1);
        }
        enc_centres b = cluster(s.data, list[i].k, list[i].linear, twice);
        size_t codes = 0, points = 0;
        for (size_t j = 0; j < (size_t)a->k * ROW && a->k == b.k; j++) {
            codes += a->codes[j] != b.codes[j];
        }
        for (size_t j = 0; j < VIEWS * TEXELS; j++) {
            points += single->centre[j] != twice->centre[j];
        }
        const double psnr = precision_psnr_of_parts(s.data, s.sbrdf, s.shadow, single, a);
        const double exact = precision_psnr_of_parts(s.data, s.sbrdf, s.shadow, twice, &b);
        cases_add(list[i].input, "less than 0.05 dB either way",
                  a->k == (int)list[i].k && a->k == b.k && fabs(exact - psnr) < precision_most_loss,
                  "%.4f dB, double %.4f dB; %zu codes and %zu points' centres differ", psnr, exact, codes,
                  points);
        free(b.codes);
        enc_centres_destroy(&a);
        enc_occlusion_destroy(&single);
        enc_occlusion_destroy(&twice);
    }
    precision_scene_clear(&s);
}
