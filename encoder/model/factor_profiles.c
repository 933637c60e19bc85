/* Light profiles of factors. See factor_profiles.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "factor_profiles.h"

#include "encoder/math/gemm.h"

#include <stdlib.h>

enum { CHANNELS = 3 };

struct enc_factor_profiles {
    const enc_solution *solution;
    enc_factor_unit *units;
    size_t n_units, lights, components;
    enc_gemm_tile tile;
    size_t count[CHANNELS];     /* components of Y, C1, C2 */
    size_t *member[CHANNELS];   /* [count]: which they are */
    float *w[CHANNELS];         /* packed columns: levels times scales */
    float *u, *packed, *result; /* [block][count], its panels, [channel][block][lights] */
    int16_t *levels;            /* [components] of a texel, then [components] of a light */
};

void enc_factor_profiles_destroy(enc_factor_profiles **profiles) {
    enc_factor_profiles *p = profiles ? *profiles : NULL;
    if (!p) {
        return;
    }
    for (int c = 0; c < CHANNELS; c++) {
        free(p->member[c]);
        free(p->w[c]);
    }
    free(p->units);
    free(p->u);
    free(p->packed);
    free(p->result);
    free(p->levels);
    free(p);
    *profiles = NULL;
}

static void list_members(enc_factor_profiles *p) {
    for (size_t i = 0; i < p->n_units; i++) {
        for (int k = 0; k < ENC_STORE_WORDS; k++) {
            for (int n = 0; n < p->units[i].word; n++) {
                const int channel = p->units[i].channel[k];
                p->member[channel][p->count[channel]++] =
                    p->units[i].first + (size_t)(k * p->units[i].word + n);
            }
        }
    }
}

/* Levels of w of the view times their scales, a row a light: rows[channel][light][count]. */
static void fill_rows(enc_factor_profiles *p, size_t view, float *const rows[CHANNELS]) {
    const enc_factor_store *f = &p->solution->factors;
    const size_t pairs = (size_t)p->solution->n_views * p->lights;
    for (size_t light = 0; light < p->lights; light++) {
        size_t at[CHANNELS] = {0};
        for (size_t i = 0; i < p->n_units; i++) {
            const enc_factor_unit *unit = &p->units[i];
            const float *factors = f->views + (view * ENC_STORE_TIERS + (size_t)unit->tier) * 4;
            enc_store_w_levels(
                unit, f->directions + (i * pairs + view * p->lights + light) * ENC_STORE_WORDS, p->levels);
            for (int n = 0; n < ENC_STORE_WORDS * unit->word; n++) {
                const int k = n / unit->word, channel = unit->channel[k];
                rows[channel][light * p->count[channel] + at[channel]++] =
                    (float)p->levels[n] * (f->scales[i * ENC_STORE_WORDS + (size_t)k] * factors[channel]);
            }
        }
    }
}

static bool pack_w(enc_factor_profiles *p, size_t view) {
    float *rows[CHANNELS] = {NULL};
    bool ok = true;
    for (int c = 0; c < CHANNELS; c++) {
        rows[c] = malloc((p->count[c] * p->lights + 1) * sizeof(float));
        p->w[c] = enc_gemm_alloc(enc_gemm_panels(p->lights, ENC_GEMM_N) * ENC_GEMM_N * p->count[c] + 1);
        ok = ok && rows[c] && p->w[c];
    }
    if (ok) {
        fill_rows(p, view, rows);
    }
    for (int c = 0; c < CHANNELS; c++) {
        if (ok) {
            enc_gemm_pack_rows(p->lights, p->count[c], rows[c], p->count[c], ENC_GEMM_N, p->w[c]);
        }
        free(rows[c]);
    }
    return ok;
}

enc_factor_profiles *enc_factor_profiles_create(const enc_solution *solution, size_t view, uint32_t units) {
    uint32_t classes[BTF_FACTOR_CLASSES][3];
    enc_factor_profiles *p = calloc(1, sizeof *p);
    if (!p) {
        return NULL;
    }
    enc_store_truncate(solution->factors.classes, units, classes);
    p->solution = solution;
    p->lights = (size_t)solution->n_lights;
    const uint32_t(*kept)[3] = (const uint32_t(*)[3])classes;
    p->n_units = enc_store_units(kept);
    p->tile = enc_gemm_select();
    p->units = calloc(p->n_units, sizeof *p->units);
    bool ok = p->units;
    if (ok) {
        p->components = enc_store_list(kept, p->units);
        p->levels = malloc(p->components * sizeof *p->levels);
        p->u = malloc(ENC_FACTOR_BLOCK * p->components * sizeof *p->u);
        p->packed = enc_gemm_alloc(ENC_FACTOR_BLOCK * p->components);
        p->result = malloc(CHANNELS * ENC_FACTOR_BLOCK * p->lights * sizeof *p->result);
        ok = p->levels && p->u && p->packed && p->result;
    }
    for (int c = 0; c < CHANNELS && ok; c++) {
        ok = (p->member[c] = malloc(p->components * sizeof *p->member[c]));
    }
    if (ok) {
        list_members(p);
        ok = pack_w(p, view);
    }
    if (!ok) {
        enc_factor_profiles_destroy(&p);
    }
    return p;
}

/* Copies the levels of u of one channel to `row`, as floats. */
static void gather_channel(const enc_factor_profiles *p, const int16_t *levels, int channel, float *row) {
    for (size_t n = 0; n < p->count[channel]; n++) {
        row[n] = (float)levels[p->member[channel][n]];
    }
}

/* Turns Y, C1 and C2 of profile i into R, G, B. */
static void to_rgb(const enc_factor_profiles *p, size_t i, float *out) {
    const size_t lights = p->lights, pitch = ENC_FACTOR_BLOCK * lights;
    const float *y = p->result + i * lights, *c1 = y + pitch, *c2 = c1 + pitch;
    for (size_t l = 0; l < lights; l++) {
        out[l] = (y[l] + c1[l]) + c2[l];
        out[lights + l] = y[l] - (c2[l] + c2[l]);
        out[2 * lights + l] = (y[l] - c1[l]) + c2[l];
    }
}

void enc_factor_profiles_get(enc_factor_profiles *p, const size_t *sources, size_t count, float *out) {
    const enc_factor_store *f = &p->solution->factors;
    const size_t texels = enc_solution_texels(p->solution);
    float *rows[CHANNELS] = {p->u, p->u + ENC_FACTOR_BLOCK * p->count[0],
                             p->u + ENC_FACTOR_BLOCK * (p->count[0] + p->count[1])};
    for (size_t i = 0; i < count; i++) {
        enc_store_texel_levels(p->units, p->n_units, f->texels, texels, sources[i], p->levels);
        for (int c = 0; c < CHANNELS; c++) {
            gather_channel(p, p->levels, c, rows[c] + i * p->count[c]);
        }
    }
    for (int c = 0; c < CHANNELS; c++) {
        enc_gemm_pack_rows(count, p->count[c], rows[c], p->count[c], ENC_GEMM_M, p->packed);
        enc_gemm_multiply(p->tile, count, p->lights, p->count[c], p->packed, p->w[c],
                          p->result + (size_t)c * ENC_FACTOR_BLOCK * p->lights, p->lights, 0);
    }
    for (size_t i = 0; i < count; i++) {
        to_rgb(p, i, out + i * CHANNELS * p->lights);
    }
}
