/* Sources, gains, and the texels that refer to each source. See match.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "match.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define FIRST_GAIN 0.25f /* the least gain that the first search may take */
#define FIRST_STEP 0.015625f

btf_result enc_match_create(const enc_context *context, int width, int height, size_t views, bool gains,
                            enc_match *out) {
    const size_t texels = (size_t)width * (size_t)height, points = texels * views;
    *out = (enc_match){.width = width, .height = height, .texels = texels, .views = views};
    out->gains = gains ? (enc_match_gains){ENC_MATCH_TRIED, FIRST_GAIN, FIRST_STEP}
                       : (enc_match_gains){1, 1.0f, 0.0f};
    out->source = malloc(points * sizeof *out->source);
    out->gain = malloc(points);
    out->first = malloc((points + 1) * sizeof *out->first);
    out->user = malloc(points * sizeof *out->user);
    out->weight = malloc(points * sizeof *out->weight);
    if (!out->source || !out->gain || !out->first || !out->user || !out->weight) {
        enc_match_clear(out);
        return enc_fail(context, BTF_ERROR_MEMORY, "match: out of memory for %zu points", points);
    }
    const uint8_t one = gains ? (uint8_t)((1.0f - FIRST_GAIN) / FIRST_STEP) : 0;
    memset(out->gain, one, points);
    for (size_t i = 0; i < points; i++) {
        out->source[i] = (uint32_t)(i % texels);
    }
    enc_match_count_users(context, out);
    return BTF_OK;
}

void enc_match_clear(enc_match *match) {
    free(match->source);
    free(match->gain);
    free(match->first);
    free(match->user);
    free(match->weight);
    *match = (enc_match){0};
}

void enc_match_count_users(const enc_context *context, enc_match *match) {
    const size_t views = match->views, texels = match->texels, points = views * texels;
    memset(match->first, 0, (points + 1) * sizeof *match->first);
    for (size_t v = 0; v < views; v++) {
        for (size_t x = 0; x < texels; x++) {
            match->first[match->source[v * texels + x] * views + v + 1]++;
        }
    }
    for (size_t i = 0; i < points; i++) {
        match->first[i + 1] += match->first[i];
    }
    memset(match->weight, 0, points * sizeof *match->weight);
#pragma omp parallel for schedule(static) num_threads(context->threads)
    for (size_t v = 0; v < views; v++) {
        /* this moves first[i] to the end of its users; it moves back below */
        for (size_t x = 0; x < texels; x++) {
            const size_t i = match->source[v * texels + x] * views + v;
            const float gain = enc_match_gain(match, v, x);
            match->user[match->first[i]++] = (uint32_t)x;
            match->weight[i] += gain * gain;
        }
    }
    memmove(match->first + 1, match->first, points * sizeof *match->first);
    match->first[0] = 0;
}

/* The gain that `share` of all points are below. */
static float percentile(const enc_match *match, const size_t histogram[ENC_MATCH_TRIED], double share) {
    const double wanted = share * (double)(match->texels * match->views);
    size_t sum = 0;
    int at = 0;
    while (at < match->gains.count - 1 && (double)(sum += histogram[at]) < wanted) {
        at++;
    }
    return match->gains.base + match->gains.step * (float)at;
}

/* A scale of gains from about `least` to `most`. Where 1 lies between them, one of the gains is exactly 1,
 * the only one that levels of detail need. Values are short in binary, so that no bit is lost in a file or
 * on the way to a GPU. */
static enc_match_gains gains_between(float least, float most) {
    const float grid = 0x1p-9f;
    const float step = fmaxf(rintf((most - least) / (ENC_MATCH_GAINS - 1) / grid), 1) * grid;
    const float below = fminf(floorf((1 - least) / step), ENC_MATCH_GAINS - 1); /* codes below that of 1 */
    return (enc_match_gains){ENC_MATCH_GAINS, 1 - below * step, step};
}

void enc_match_fit_gains(const enc_context *context, enc_match *match) {
    size_t histogram[ENC_MATCH_TRIED] = {0};
    const size_t points = match->texels * match->views;
    for (size_t i = 0; i < points; i++) {
        histogram[match->gain[i]]++;
    }
    const enc_match_gains from = match->gains;
    match->gains = gains_between(fminf(percentile(match, histogram, 0.01), 1.0f),
                                 fmaxf(percentile(match, histogram, 0.99), 1.0f));
    for (size_t i = 0; i < points; i++) {
        const float gain = from.base + from.step * (float)match->gain[i];
        const float index = rintf((gain - match->gains.base) / match->gains.step);
        match->gain[i] = (uint8_t)fminf(fmaxf(index, 0), ENC_MATCH_GAINS - 1);
    }
    enc_match_count_users(context, match);
}

/* Bytes of a texel with a list of so many pairs; 0: with a pair for each view. */
static uint64_t texel_bytes(size_t entries, size_t views) {
    return entries > 0 ? 2 * entries + (views + 1) / 2 : 2 * views;
}

size_t enc_match_entries(size_t views) {
    return texel_bytes(ENC_MATCH_ENTRIES, views) < texel_bytes(0, views) ? ENC_MATCH_ENTRIES : 0;
}

uint64_t enc_match_bytes(size_t texels, size_t views) {
    return texel_bytes(enc_match_entries(views), views) * texels;
}

/* The step from one place to another on a circle of `size`, the shorter way round. */
static int turn(int from, int to, int size) {
    const int by = (to - from + size) % size;
    return 2 * by >= size ? by - size : by;
}

void enc_match_store(const enc_match *match, int8_t *out_shift, uint8_t *out_gain) {
    for (size_t i = 0; i < match->texels * match->views; i++) {
        const int x = (int)(i % match->texels), source = (int)match->source[i], width = match->width;
        out_shift[2 * i] = (int8_t)turn(x % width, source % width, width);
        out_shift[2 * i + 1] = (int8_t)turn(x / width, source / width, match->height);
        out_gain[i] = match->gain[i];
    }
}
