/* The choice of relief and gloss. See relief.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "relief.h"

#include "descend.h"
#include "encoder/base/ranks.h"
#include "encoder/base/stage.h"
#include "encoder/data/level_filter.h"
#include "sweep.h"

#include <math.h>
#include <openbtf/material.h>
#include <stdlib.h>
#include <string.h>

enum {
    ESTIMATE_TEXELS = 128 * 128, /* beyond these, heights are found on smaller images */
    SWEEPS = 4,
    CODES = 255,
    LEAST_STEPS = 8,
};

/* RELIEF.md has what was measured with these. */
static const double least_theta = 10, most_theta = 65; /* of views that heights are found from */
static const double texels_a_step = 1.6;               /* that each step of a march passes over, seen from the
                                                          steepest ring */
static const double constant_margin = 0.1; /* dB that a map must gain over the best single height */

static const double scales[] = {0, 0.25, 0.5, 0.75, 1, 0.5, 0.75, 1};
enum { FIRST_CONSTANT = 5, DRAWN_IN = 8 };

/* How many times images are halved for the estimate: as long as they are large and their sides even. */
static int shift_of(int width, int height) {
    int shift = 0;
    while ((width >> shift) * (height >> shift) > ESTIMATE_TEXELS && (width >> shift) % 2 == 0 &&
           (height >> shift) % 2 == 0) {
        shift++;
    }
    return shift;
}

static int reach_of(int width, int height) {
    const int side = width < height ? width : height, reach = side / 8;
    return reach < 2 ? 2 : reach > 24 ? 24 : reach;
}

uint64_t enc_relief_memory(int width, int height, int n_views, int n_lights) {
    const int shift = shift_of(width, height), wide = width >> shift, high = height >> shift;
    const uint64_t texels = (uint64_t)wide * (uint64_t)high,
                   heights = 8 * (uint64_t)reach_of(wide, high) + 1;
    const uint64_t lights = 3 * (uint64_t)n_lights;
    const uint64_t drawn = lights * (20000 + (uint64_t)n_views) * 4 + lights * lights * 8;
    const uint64_t images = 2 * enc_relief_images_bytes(wide, high, n_views);
    const uint64_t sweep = texels * heights * 8, descent = texels * 4 * ((uint64_t)n_views + 8);
    const uint64_t estimate = images + drawn + (sweep > descent ? sweep : descent);
    const uint64_t of_level = enc_relief_end_memory(width, height, n_views, n_lights);
    const uint64_t of_images = enc_judged_bytes(width, height, n_views);
    const uint64_t judged = of_images > of_level ? of_images : of_level;
    return (estimate > judged ? estimate : judged) + 16 * (uint64_t)width * (uint64_t)height;
}

enc_relief_work enc_relief_work_of(int width, int height) {
    const int shift = shift_of(width, height), wide = width >> shift, high = height >> shift;
    return (enc_relief_work){.texels = (double)wide * high,
                             .heights = 8.0 * reach_of(wide, high) + 1,
                             .sweeps = SWEEPS,
                             .judged = fmin((double)width * height, 4096)};
}

/* The surface that is judged, and the heights found that candidates are made of. */
typedef struct relief_job {
    const enc_context *context;
    const enc_data *data;
    enc_seen *seen; /* all views that can be left out */
    float *height;  /* [texel], in texels */
    float median, low, high; /* of the heights; range of the candidate drawn in */
    int ring_of[ENC_MAX_DIRECTIONS]; /* of a view */
    enc_judged judged;
    enc_judged_error *error[ENC_RELIEF_CANDIDATES]; /* [view left out] */
} relief_job;

/* Copies heights of the smaller images to the texels that each covers. */
static void enlarge(const enc_warp *found, int shift, const enc_data *data, float *out) {
    for (int row = 0; row < data->height; row++) {
        for (int column = 0; column < data->width; column++) {
            const size_t from = (size_t)(row >> shift) * (size_t)found->width + (size_t)(column >> shift);
            out[(size_t)row * (size_t)data->width + (size_t)column] =
                ldexpf((float)found->heights[from], shift - 8);
        }
    }
}

static btf_result descend(const relief_job *j, const enc_relief_images images[ENC_RELIEF_KINDS],
                          enc_warp *w, float *first, double *out_share) {
    const size_t texels = (size_t)w->width * (size_t)w->height;
    enc_seen *some = malloc(sizeof *some);
    btf_result result =
        some ? enc_seen_make(j->context, j->data->views, j->data->n_views, least_theta, most_theta, some)
             : BTF_ERROR_MEMORY;
    for (size_t t = 0; t < texels; t++) {
        w->heights[t] = (int32_t)lrintf(first[t] * ENC_WARP_ONE);
    }
    if (result == BTF_OK) {
        result = enc_relief_descend(j->context, &images[ENC_RELIEF_ROOTS], some, SWEEPS, w, out_share);
    }
    free(some);
    return result;
}

static btf_result find_heights(const relief_job *j, double *out_share) {
    const enc_data *data = j->data;
    const int shift = shift_of(data->width, data->height);
    enc_relief_images images[ENC_RELIEF_KINDS] = {{0}};
    enc_warp w = {0};
    btf_result result = enc_relief_images_create(j->context, data, shift, images);
    const size_t texels = (size_t)images->width * (size_t)images->height;
    float *first = malloc((texels > 0 ? texels : 1) * sizeof *first);
    if (result == BTF_OK) {
        result = enc_warp_create(images->width, images->height, 0, 0, &w);
        w.heights = result == BTF_OK ? malloc(texels * sizeof *w.heights) : NULL;
        result = first && w.heights ? BTF_OK : BTF_ERROR_MEMORY;
    }
    if (result == BTF_OK) {
        result = enc_relief_sweep(j->context, &images[ENC_RELIEF_STANDARD], data->views, data->top_view,
                                  reach_of(images->width, images->height), first);
        enc_relief_images_clear(&images[ENC_RELIEF_STANDARD]);
    }
    if (result == BTF_OK) {
        result = descend(j, images, &w, first, out_share);
    }
    if (result == BTF_OK) {
        enlarge(&w, shift, data, j->height);
    }
    enc_relief_images_clear(&images[ENC_RELIEF_ROOTS]);
    enc_relief_images_clear(&images[ENC_RELIEF_STANDARD]);
    enc_warp_clear(&w);
    free(first);
    return result;
}

static int rising(const void *a, const void *b) {
    const float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

static btf_result order_heights(relief_job *j) {
    const size_t texels = enc_data_texel_count(j->data);
    float *sorted = malloc(texels * sizeof *sorted);
    if (!sorted) {
        return BTF_ERROR_MEMORY;
    }
    memcpy(sorted, j->height, texels * sizeof *sorted);
    qsort(sorted, texels, sizeof *sorted, rising);
    const size_t few = (size_t)(ENC_RELIEF_DRAWN_IN * (double)texels);
    j->median = sorted[texels / 2];
    j->low = sorted[few];
    j->high = sorted[texels - 1 - few];
    free(sorted);
    return BTF_OK;
}

static int32_t bounded(double texels) {
    const double z = floor(texels * ENC_WARP_ONE + 0.5);
    return (int32_t)(z < -32767 ? -32767 : z > 32767 ? 32767 : z);
}

/* The steps of a march: as many as the steepest view with relief asks for. */
static uint32_t steps_for(const relief_job *j, int32_t range, const uint8_t *views) {
    double steepest = 0;
    for (int v = 0; v < j->data->n_views; v++) {
        int32_t slope[2];
        enc_warp_slope(j->data->views[v].xyz, slope);
        if (!views || views[v]) {
            steepest = fmax(steepest, hypot(slope[0], slope[1]) / ENC_WARP_WEIGHT);
        }
    }
    const int steps = (int)ceil(range * steepest / ENC_WARP_ONE / texels_a_step);
    return steps < LEAST_STEPS            ? LEAST_STEPS
           : steps > BTF_MAX_RELIEF_STEPS ? BTF_MAX_RELIEF_STEPS
                                          : (uint32_t)steps;
}

/* The height of a texel in the map of a candidate. */
static int32_t height_of(const relief_job *j, const enc_relief_candidate *c, size_t texel) {
    const float z = j->height[texel], drawn = fminf(fmaxf(z, j->low), j->high);
    return bounded(c->scale * (double)(c->drawn_in ? drawn : z));
}

/* Makes the surface of a candidate as files hold it. */
static btf_result make_store(const relief_job *j, const enc_relief_candidate *c, const uint8_t *views,
                             enc_relief_store *out) {
    const size_t texels = enc_data_texel_count(j->data);
    enc_relief_candidate whole = *c;
    int32_t low = INT32_MAX, high = INT32_MIN, least = INT32_MAX, most = INT32_MIN;
    whole.drawn_in = false;
    *out = (enc_relief_store){.width = j->data->width,
                              .height = j->data->height,
                              .base = bounded(c->scale * (double)j->median),
                              .steps = 1};
    for (size_t t = 0; t < texels && !c->constant; t++) {
        const int32_t z = height_of(j, c, t), given = height_of(j, &whole, t);
        low = z < low ? z : low;
        high = z > high ? z : high;
        least = given < least ? given : least;
        most = given > most ? given : most;
    }
    if (c->constant || low == high) {
        return BTF_OK;
    }
    out->heights = malloc(texels);
    if (!out->heights) {
        return BTF_ERROR_MEMORY;
    }
    out->base = low;
    out->step = ((high - low) * 256 + CODES - 1) / CODES;
    out->step = out->base + ((CODES * out->step) >> 8) > 32767 ? out->step - 1 : out->step;
    out->steps = steps_for(j, most - least, views); /* heights drawn in get finer steps, not fewer */
    for (size_t t = 0; t < texels; t++) {
        const int32_t code = ((height_of(j, c, t) - low) * 256 + out->step / 2) / out->step;
        out->heights[t] = (uint8_t)(code < CODES ? code : CODES);
    }
    return BTF_OK;
}

/* Sorts views into rings, of which a new one begins where theta rises by more than half a degree; into
 * bands of the hemisphere where rings are too many. Returns their number. */
static int find_rings(relief_job *j) {
    const enc_direction *views = j->data->views;
    int rings = 0;
    for (int v = 0; v < j->data->n_views; v++) {
        rings += v == 0 || views[v].theta - views[v - 1].theta > 0.5;
        j->ring_of[v] = rings - 1;
    }
    for (int v = 0; v < j->data->n_views && rings > ENC_RELIEF_RINGS; v++) {
        const int band = (int)(views[v].theta * ENC_RELIEF_RINGS / 90);
        j->ring_of[v] = band < ENC_RELIEF_RINGS ? band : ENC_RELIEF_RINGS - 1;
    }
    return rings > ENC_RELIEF_RINGS ? ENC_RELIEF_RINGS : rings;
}

/* A ring that gains while its neighbours do not gains by chance, and the picture would jump at both its
 * edges. The last one stays only beside one that stays: nothing lies beyond it, which makes it gain most of
 * all when it is left out. */
static void drop_lone_rings(int n_rings, enc_relief_ring rings[ENC_RELIEF_RINGS]) {
    bool alone[ENC_RELIEF_RINGS];
    for (int k = 0; k < n_rings; k++) {
        const bool inner = k > 0 && rings[k - 1].on, outer = k + 1 < n_rings && rings[k + 1].on;
        alone[k] = n_rings > 2 && !inner && !outer;
    }
    for (int k = 0; k < n_rings; k++) {
        rings[k].on = rings[k].on && !alone[k];
    }
    if (n_rings > 2) {
        rings[n_rings - 1].on = rings[n_rings - 1].on && rings[n_rings - 2].on;
    }
}

/* Finds the gain of a candidate, ring by ring and over all. */
static void weigh(const relief_job *j, int number, int n_rings, enc_relief_ring rings[ENC_RELIEF_RINGS],
                  enc_relief_candidate *c) {
    enc_judged_error plain = {0, 0}, mixed = {0, 0};
    memset(rings, 0, ENC_RELIEF_RINGS * sizeof *rings);
    for (int v = 0; v < j->data->n_views; v++) {
        rings[j->ring_of[v]].theta = j->data->views[v].theta;
    }
    for (int i = 0; i < j->seen->count; i++) {
        enc_relief_ring *r = &rings[j->ring_of[j->seen->of[i].view]];
        r->views++;
        r->plain.linear += j->error[0][i].linear;
        r->plain.srgb += j->error[0][i].srgb;
        r->moved.linear += j->error[number][i].linear;
        r->moved.srgb += j->error[number][i].srgb;
    }
    c->rings = 0;
    for (int k = 0; k < n_rings; k++) {
        enc_relief_ring *r = &rings[k];
        r->gain = r->views > 0 ? enc_judged_gain(r->plain, r->moved) : 0;
        r->on = number > 0 && r->gain > ENC_RELIEF_MARGIN;
    }
    drop_lone_rings(n_rings, rings);
    for (int k = 0; k < n_rings; k++) {
        enc_relief_ring *r = &rings[k];
        c->rings += r->on;
        plain.linear += r->plain.linear;
        plain.srgb += r->plain.srgb;
        mixed.linear += r->on ? r->moved.linear : r->plain.linear;
        mixed.srgb += r->on ? r->moved.srgb : r->plain.srgb;
        if (r->views > 0) {
            r->plain = (enc_judged_error){r->plain.linear / r->views, r->plain.srgb / r->views};
            r->moved = (enc_judged_error){r->moved.linear / r->views, r->moved.srgb / r->views};
        }
    }
    c->gain = enc_judged_gain(plain, mixed);
    c->judged = true;
}

static btf_result judge_candidate(relief_job *j, int number, enc_relief_choice *choice) {
    enc_relief_candidate *c = &choice->candidate[number];
    enc_relief_store store = {0};
    enc_warp w = {0};
    btf_result result = enc_cancelled(j->context) ? BTF_ERROR_INTERRUPTED : make_store(j, c, NULL, &store);
    j->error[number] = malloc((size_t)(j->seen->count + 1) * sizeof *j->error[number]);
    if (result == BTF_OK && !j->error[number]) {
        result = BTF_ERROR_MEMORY;
    }
    if (result == BTF_OK) {
        result = enc_relief_level(&store, j->data->width, j->data->height, 0, NULL, &w);
    }
    if (result == BTF_OK) {
        enc_judge_surface(j->context, &j->judged, j->seen, &w, j->error[number]);
        weigh(j, number, choice->n_rings, choice->ring, c);
    }
    enc_warp_clear(&w);
    enc_relief_clear(&store);
    return result;
}

/* Finds the map and the single height that gain most; 0: none gains. */
static void find_best(const enc_relief_choice *choice, int best[2]) {
    best[0] = best[1] = 0;
    for (int k = 1; k < ENC_RELIEF_CANDIDATES; k++) {
        const enc_relief_candidate *c = &choice->candidate[k];
        int *of = &best[c->constant];
        if (c->judged && c->rings > 0 && c->gain > (*of ? choice->candidate[*of].gain : 0)) {
            *of = k;
        }
    }
}

/* The candidate that gains most; a single height where a map gains little more. */
static int best_of(const enc_relief_choice *choice, bool only_constants) {
    int best[2];
    find_best(choice, best);
    const double map = best[0] && !only_constants ? choice->candidate[best[0]].gain : 0;
    const double constant = best[1] ? choice->candidate[best[1]].gain : 0;
    return map > constant + constant_margin ? best[0] : best[1];
}

static btf_result decide(relief_job *j, enc_relief_choice *choice, enc_relief_store *out) {
    btf_result result = BTF_OK;
    for (int k = 0; k < DRAWN_IN && result == BTF_OK; k++) {
        choice->candidate[k] =
            (enc_relief_candidate){.scale = scales[k], .constant = k == 0 || k >= FIRST_CONSTANT};
        if (k < FIRST_CONSTANT || fabsf(j->median) >= 0.1f) {
            result = judge_candidate(j, k, choice);
        }
        choice->candidate[k].constant = k >= FIRST_CONSTANT;
        enc_stage_step(j->context, enc_data_texel_count(j->data));
    }
    int best[2];
    find_best(choice, best);
    /* The few highest and lowest texels are often noise, and make the march's steps coarser for all
     * others. */
    if (result == BTF_OK && best[0] > 0) {
        choice->candidate[DRAWN_IN] =
            (enc_relief_candidate){.scale = choice->candidate[best[0]].scale, .drawn_in = true};
        result = judge_candidate(j, DRAWN_IN, choice);
    }
    enc_stage_step(j->context, enc_data_texel_count(j->data));
    if (result != BTF_OK) {
        return result;
    }
    choice->chosen = best_of(choice, !(choice->share < ENC_RELIEF_SHARE));
    int shown = choice->chosen;
    for (int k = 1; k < ENC_RELIEF_CANDIDATES && choice->chosen == 0; k++) {
        shown = shown == 0 || choice->candidate[k].gain > choice->candidate[shown].gain ? k : shown;
    }
    weigh(j, shown, choice->n_rings, choice->ring, &choice->candidate[shown]);
    choice->reason = choice->chosen > 0                    ? NULL
                     : choice->share >= ENC_RELIEF_SHARE ? "the heights found leave too much of a plane's squared error"
                                                         : "it gains too little on every ring of views";
    if (choice->chosen == 0) {
        return BTF_OK;
    }
    uint8_t *views = malloc((size_t)j->data->n_views);
    for (int v = 0; v < j->data->n_views && views; v++) {
        views[v] = choice->ring[j->ring_of[v]].on;
    }
    result = views ? make_store(j, &choice->candidate[choice->chosen], views, out) : BTF_ERROR_MEMORY;
    out->views = views;
    out->effects = BTF_EFFECT_RELIEF;
    choice->least = (double)out->base / ENC_WARP_ONE;
    choice->most = (double)(out->base + ((CODES * out->step) >> 8)) / ENC_WARP_ONE;
    return result;
}

static btf_result choose_relief(relief_job *j, int levels, enc_relief_choice *choice,
                                enc_relief_store *out) {
    const size_t texels = enc_data_texel_count(j->data);
    j->height = malloc(texels * sizeof *j->height);
    btf_result result = j->height ? find_heights(j, &choice->share) : BTF_ERROR_MEMORY;
    if (result == BTF_OK) {
        result = order_heights(j);
    }
    if (result == BTF_OK) {
        result = enc_judged_create(j->context, j->data, 0, &j->judged);
    }
    if (result == BTF_OK) {
        choice->tried = true;
        choice->n_rings = find_rings(j);
        result = decide(j, choice, out);
    }
    enc_judged_clear(&j->judged);
    if (result == BTF_OK && choice->chosen > 0) {
        result = enc_relief_find_end(j->context, j->data, j->seen, levels, out, &choice->end);
        out->end = (uint32_t)choice->end.end;
    }
    for (int k = 0; k < ENC_RELIEF_CANDIDATES; k++) {
        free(j->error[k]);
    }
    free(j->height);
    return result;
}

/* Returns why relief is not tried; NULL: it is. */
static const char *obstacle(const relief_job *j, const enc_relief_options *options) {
    const enc_data *d = j->data;
    const uint64_t held = 4 * (uint64_t)enc_data_texel_count(d) * enc_data_texel_stride(d);
    return !options->relief                ? "not asked for"
           : j->seen->count == 0           ? "no view lies among others that could predict it"
           : d->width < 8 || d->height < 8 ? "images have fewer than 8 texels a side"
           : !d->samples                   ? "the samples do not fit the memory allowed"
           : j->context->memory > 0 &&
                   held + enc_relief_memory(d->width, d->height, d->n_views, d->n_lights) >
                       j->context->memory
               ? "its tables do not fit the memory allowed beside the samples"
               : NULL;
}

static btf_result choose_gloss(const relief_job *j, const enc_relief_options *options,
                               enc_relief_choice *choice, enc_relief_store *out) {
    enc_warp w = {0};
    btf_result result = BTF_OK;
    choice->gloss.quarters = options->gloss;
    if (options->gloss < 0) {
        result = enc_relief_level(out, j->data->width, j->data->height, 0, NULL, &w);
        if (result == BTF_OK) {
            result = enc_gloss_choose(j->context, j->data, j->seen, &w, out->views, &choice->gloss);
        }
        enc_warp_clear(&w);
    }
    out->gloss_share = (uint32_t)choice->gloss.quarters;
    out->effects |= out->gloss_share > 0 ? BTF_EFFECT_GLOSS : 0;
    return result;
}

btf_result enc_relief_choose(const enc_context *context, const enc_data *data,
                             const enc_relief_options *options, enc_relief_choice *out_choice,
                             enc_relief_store *out_store) {
    const size_t texels = enc_data_texel_count(data);
    const int levels = options->levels > 0 ? options->levels : 1;
    relief_job j = {.context = context, .data = data, .seen = malloc(sizeof *j.seen)};
    *out_choice = (enc_relief_choice){.share = 1};
    *out_store = (enc_relief_store){0};
    enc_stage_begin(context, "relief",
                    (2 + ENC_RELIEF_CANDIDATES) * texels +
                        SWEEPS * (texels >> 2 * shift_of(data->width, data->height)) +
                        enc_level_further_texels(data->width, data->height, levels + 1) -
                        enc_level_further_texels(data->width, data->height, 2));
    btf_result result =
        j.seen ? enc_seen_make(context, data->views, data->n_views, 0, 90, j.seen) : BTF_ERROR_MEMORY;
    if (result == BTF_OK) {
        out_choice->reason = obstacle(&j, options);
        result = out_choice->reason ? BTF_OK : choose_relief(&j, levels, out_choice, out_store);
    }
    if (result == BTF_OK) {
        result = choose_gloss(&j, options, out_choice, out_store);
    }
    result = enc_ranks_agree(context, result);
    enc_stage_end(context);
    free(j.seen);
    if (result != BTF_OK) {
        enc_relief_clear(out_store);
    }
    return result == BTF_ERROR_MEMORY ? enc_fail(context, result, "relief: out of memory") : result;
}
