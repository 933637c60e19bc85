/* Changes of the input that must change the result in a known way: order of lights and views, axes, brightness.
 *
 * SPDX-License-Identifier: MIT
 */
#include "cases.h"
#include "encode.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { SIDE = 12 };

static const double bound = 0.1; /* dB */

/* The effect of a change on azimuths (phi -> sign * phi + step) and to texels. */
typedef struct change {
    const char *name;
    int sign, step;               /* degrees */
    bool flip_columns, transpose; /* texel (c, r) of the result is that of (W-1-c, r), or of (r, W-1-c): a
                                     quarter turn, counter-clockwise as seen with row 0 at the top */
    bool flip_rows;
    const enc_data *data;
} change;

/* Index of the direction in `list` with this theta and this azimuth. */
static int find(const enc_direction *list, int n, double theta, double phi) {
    for (int i = 0; i < n; i++) {
        const double d = fabs(list[i].phi - phi);
        if (fabs(list[i].theta - theta) < 1e-6 && (theta == 0 || fmin(d, 360 - d) < 1e-6)) {
            return i;
        }
    }
    fprintf(stderr, "test_equivariance: no direction %g, %g\n", theta, phi);
    exit(1);
}

/* The index that direction i of the result had before. */
static int before(const change *k, const enc_direction *list, int n, int i) {
    const double phi = (list[i].phi - k->step) * k->sign;
    return find(list, n, list[i].theta, fmod(phi + 720, 360));
}

static void undo(const void *user, int *texel, int *view, int *light) {
    const change *k = user;
    int c = *texel % SIDE, r = *texel / SIDE;
    if (k->transpose) {
        const int column = SIDE - 1 - r;
        r = c;
        c = column;
    }
    c = k->flip_columns ? SIDE - 1 - c : c;
    r = k->flip_rows ? SIDE - 1 - r : r;
    *texel = r * SIDE + c;
    *view = before(k, k->data->views, k->data->n_views, *view);
    *light = before(k, k->data->lights, k->data->n_lights, *light);
}

/* Orders other than the paper's. */
typedef struct order {
    const int *views, *lights;
} order;

static void take_order(const void *user, int *texel, int *view, int *light) {
    const order *o = user;
    (void)texel;
    *view = o->views[*view];
    *light = o->lights[*light];
}

static void shuffle(int n, uint32_t seed, int *out) {
    for (int i = 0; i < n; i++) {
        out[i] = i;
    }
    for (int i = n - 1; i > 0; i--) {
        const int j = (int)(hard_random((uint32_t)i, seed, 0) * (float)(i + 1));
        const int swap = out[i];
        out[i] = out[j];
        out[j] = swap;
    }
}

static void report(const char *what, encode_method method, double was, double is) {
    char input[160], expected[60];
    snprintf(input, sizeof input, "%s, by method %s", what, encode_names[method]);
    snprintf(expected, sizeof expected, "the same PSNR within %g dB", bound);
    cases_add(input, expected, fabs(was - is) <= bound, "%.3f dB, then %.3f dB", was, is);
}

int main(void) {
    cases_title(
        "Changes of the input whose effect is known, by PSNR (peak 1, of n times the radiance peak n).");
    const hard_directions d = hard_rings(3, (const double[]){0, 30, 60}, (const int[]){1, 4, 8});
    enc_data *data = hard_relief(SIDE, &d, &d, 0.2f); /* below 1 even when 4 times as bright */
    const change changes[] = {
        {"x axis reversed", -1, 180, true, false, false, data},
        {"y axis reversed", -1, 0, false, false, true, data},
        {"turned by 90 degrees", 1, 90, false, true, false, data},
        {"turned by 180 degrees", 1, 180, true, false, true, data},
    };
    int views[HARD_MAX_DIRECTIONS], lights[HARD_MAX_DIRECTIONS], same[HARD_MAX_DIRECTIONS];
    shuffle(d.n, 1, views);
    shuffle(d.n, 2, lights);
    for (int i = 0; i < d.n; i++) {
        same[i] = i;
    }
    enc_direction shuffled_views[HARD_MAX_DIRECTIONS], shuffled_lights[HARD_MAX_DIRECTIONS];
    for (int i = 0; i < d.n; i++) {
        shuffled_views[i] = d.list[views[i]];
        shuffled_lights[i] = d.list[lights[i]];
    }
    enc_data *lights_moved = hard_moved(data, NULL, shuffled_lights, take_order, &(order){same, lights});
    enc_data *views_moved = hard_moved(data, shuffled_views, NULL, take_order, &(order){views, same});
    enc_data *brighter = hard_relief(SIDE, &d, &d, 0.8f), *dimmer = hard_relief(SIDE, &d, &d, 0.2f / 1024);
    for (int m = 0; m <= ENCODE_PAPER_SHADOW; m++) {
        const encode_method method = (encode_method)m;
        const double plain = encode_played_psnr(data, data, method, 1, 1);
        report("lights in another order", method, plain,
               encode_played_psnr(lights_moved, lights_moved, method, 1, 1));
        report("views in another order", method, plain,
               encode_played_psnr(views_moved, views_moved, method, 1, 1));
        for (size_t k = 0; k < sizeof changes / sizeof *changes; k++) {
            enc_data *moved = hard_moved(data, NULL, NULL, undo, &changes[k]);
            report(changes[k].name, method, plain, encode_played_psnr(moved, moved, method, 1, 1));
            enc_data_destroy(&moved);
        }
        report("radiance times 4, thresholds too", method, plain,
               encode_played_psnr(brighter, brighter, method, 4, 4));
        if (method == ENCODE_JOINT) {
            report("radiance divided by 1024", method, plain,
                   encode_played_psnr(dimmer, dimmer, method, 1, 0x1p-10f));
        }
    }
    enc_data_destroy(&data);
    enc_data_destroy(&lights_moved);
    enc_data_destroy(&views_moved);
    enc_data_destroy(&brighter);
    enc_data_destroy(&dimmer);
    return cases_result();
}
