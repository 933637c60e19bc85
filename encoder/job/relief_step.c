/* Relief and gloss in a checkpoint. See relief_step.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "relief_step.h"

#include "encoder/base/ranks.h"

#include <float.h>
#include <openbtf/material.h>
#include <stdlib.h>
#include <string.h>

static const char step[] = "relief";

/* One walk over a choice, which puts its numbers into the blob or takes them out of it, so that both agree
 * about their order. Numbers that are taken must be such as an encode gives, since an undamaged file may
 * still hold others. */
typedef struct walk {
    enc_blob *blob;
    bool takes, good;
} walk;

static void pass_number(walk *w, double *io_x, double low, double high) {
    if (w->takes) {
        enc_blob_take(w->blob, io_x, sizeof *io_x);
        w->good = w->good && *io_x >= low && *io_x <= high;
    } else {
        enc_blob_put(w->blob, io_x, sizeof *io_x);
    }
}

static void pass_integer(walk *w, int *io_x, int low, int high) {
    if (w->takes) {
        enc_blob_take(w->blob, io_x, sizeof *io_x);
        w->good = w->good && *io_x >= low && *io_x <= high;
    } else {
        enc_blob_put(w->blob, io_x, sizeof *io_x);
    }
}

static void pass_flag(walk *w, bool *io_x) {
    int x = !w->takes && *io_x;
    pass_integer(w, &x, 0, 1);
    *io_x = x == 1;
}

static void pass_count(walk *w, uint32_t *io_x, uint32_t low, uint32_t high) {
    int x = w->takes ? 0 : (int)*io_x;
    pass_integer(w, &x, (int)low, (int)high);
    *io_x = (uint32_t)x;
}

static void pass_error(walk *w, enc_judged_error *io_error) {
    pass_number(w, &io_error->linear, 0, DBL_MAX);
    pass_number(w, &io_error->srgb, 0, DBL_MAX);
}

static void pass_gloss(walk *w, enc_gloss_choice *io_gloss) {
    pass_flag(w, &io_gloss->judged);
    for (int q = 0; q < ENC_GLOSS_SHARES; q++) {
        pass_error(w, &io_gloss->error[q]);
    }
    pass_number(w, &io_gloss->best, -DBL_MAX, DBL_MAX);
    pass_integer(w, &io_gloss->quarters, 0, 4);
}

static void pass_end(walk *w, enc_relief_end *io_end) {
    pass_integer(w, &io_end->end, 0, BTF_MAX_LEVELS);
    pass_integer(w, &io_end->judged, 0, BTF_MAX_LEVELS - 1);
    for (int k = 0; k < BTF_MAX_LEVELS; k++) {
        pass_error(w, &io_end->level[k].plain);
        pass_error(w, &io_end->level[k].moved);
        pass_number(w, &io_end->level[k].gain, -DBL_MAX, DBL_MAX);
        pass_flag(w, &io_end->level[k].on);
    }
}

static void pass_choice(walk *w, enc_relief_choice *io_choice, int n_views) {
    pass_flag(w, &io_choice->tried);
    pass_number(w, &io_choice->share, 0, DBL_MAX);
    for (int k = 0; k < ENC_RELIEF_CANDIDATES; k++) {
        enc_relief_candidate *c = &io_choice->candidate[k];
        pass_number(w, &c->scale, 0, 1);
        pass_flag(w, &c->constant);
        pass_flag(w, &c->judged);
        pass_flag(w, &c->drawn_in);
        pass_number(w, &c->gain, -DBL_MAX, DBL_MAX);
        pass_integer(w, &c->rings, 0, ENC_RELIEF_RINGS);
    }
    pass_integer(w, &io_choice->chosen, 0, ENC_RELIEF_CANDIDATES - 1);
    pass_integer(w, &io_choice->n_rings, 0, ENC_RELIEF_RINGS);
    for (int k = 0; k < ENC_RELIEF_RINGS; k++) {
        enc_relief_ring *r = &io_choice->ring[k];
        pass_number(w, &r->theta, 0, 90);
        pass_integer(w, &r->views, 0, n_views);
        pass_error(w, &r->plain);
        pass_error(w, &r->moved);
        pass_number(w, &r->gain, -DBL_MAX, DBL_MAX);
        pass_flag(w, &r->on);
    }
    pass_number(w, &io_choice->least, -DBL_MAX, DBL_MAX);
    pass_number(w, &io_choice->most, -DBL_MAX, DBL_MAX);
    pass_end(w, &io_choice->end);
    pass_gloss(w, &io_choice->gloss);
}

/* Whether a file may hold the heights (a map where their step is not 0) and the share of the half vector
 * (where there is gloss): marches along other heights would leave the tables of wrapped texels. */
static bool is_sound(const enc_relief_store *s, bool map) {
    const bool gloss = s->effects & BTF_EFFECT_GLOSS, relief = s->effects & BTF_EFFECT_RELIEF;
    return gloss == (s->gloss_share > 0) && s->gloss_share <= 2 &&
           (!relief || (map == (s->step > 0) && s->base + ((255 * s->step) >> 8) <= INT16_MAX));
}

/* Passes the store but for its arrays, and whether it has heights. */
static void pass_store(walk *w, enc_relief_store *io_store, const enc_data *data, bool *io_map) {
    pass_count(w, &io_store->effects, 0, BTF_EFFECT_RELIEF | BTF_EFFECT_GLOSS);
    w->good = w->good && (io_store->effects & ~(uint32_t)(BTF_EFFECT_RELIEF | BTF_EFFECT_GLOSS)) == 0;
    pass_count(w, &io_store->gloss_share, 0, 4);
    if (io_store->effects & BTF_EFFECT_RELIEF) {
        pass_integer(w, &io_store->width, data->width, data->width);
        pass_integer(w, &io_store->height, data->height, data->height);
        pass_integer(w, &io_store->base, INT16_MIN, INT16_MAX);
        pass_integer(w, &io_store->step, 0, INT16_MAX);
        pass_count(w, &io_store->steps, 1, BTF_MAX_RELIEF_STEPS);
        pass_count(w, &io_store->end, 1, BTF_MAX_LEVELS);
        pass_flag(w, io_map);
    }
    w->good = w->good && is_sound(io_store, *io_map);
}

/* Takes the arrays; false where no encode gives such ones, or memory is short. */
static bool take_arrays(enc_blob *blob, const enc_data *data, bool map, enc_relief_store *out) {
    const size_t texels = enc_data_texel_count(data), views = (size_t)data->n_views;
    out->views = malloc(views);
    out->heights = map ? malloc(texels) : NULL;
    if (!out->views || (map && !out->heights)) {
        return false;
    }
    enc_blob_take_bytes(blob, out->views, views, 0, 1);
    if (map) {
        enc_blob_take(blob, out->heights, texels);
    }
    return true;
}

btf_result enc_relief_step_take(const enc_context *context, const enc_data *data, bool *out_taken,
                                enc_relief_choice *out_choice, char reason[ENC_RELIEF_REASON],
                                enc_relief_store *out_store) {
    enc_blob blob;
    bool map = false;
    *out_taken = false;
    *out_choice = (enc_relief_choice){0};
    *out_store = (enc_relief_store){0};
    if (!enc_checkpoint_get(context, step, &blob)) {
        return BTF_OK;
    }
    walk w = {&blob, true, true};
    pass_choice(&w, out_choice, data->n_views);
    enc_blob_take(&blob, reason, ENC_RELIEF_REASON);
    reason[ENC_RELIEF_REASON - 1] = 0;
    out_choice->reason = *reason ? reason : NULL;
    pass_store(&w, out_store, data, &map);
    const bool relief = out_store->effects & BTF_EFFECT_RELIEF;
    w.good = w.good && !blob.failed && relief == (out_choice->chosen > 0);
    if (w.good && relief) {
        w.good = take_arrays(&blob, data, map, out_store);
    }
    w.good = enc_blob_taken(&blob) && w.good;
    *out_taken = enc_ranks_all(context, w.good);
    if (!*out_taken) {
        *out_choice = (enc_relief_choice){0};
        enc_relief_clear(out_store);
        return BTF_OK;
    }
    return enc_ranks_all(context, !relief || data->samples)
               ? BTF_OK
               : enc_fail(context, BTF_ERROR_USAGE,
                          "the checkpoint holds relief that was found with all samples in memory, which "
                          "--memory no longer allows: give the --memory of the first run, or remove the "
                          "checkpoint and begin anew");
}

btf_result enc_relief_step_keep(const enc_context *context, const enc_data *data,
                                const enc_relief_choice *choice, const enc_relief_store *store) {
    enc_blob blob = {0};
    char reason[ENC_RELIEF_REASON] = "";
    enc_relief_choice choice_now = *choice;
    enc_relief_store store_now = *store;
    bool map = store->heights;
    if (!context->checkpoint || !enc_ranks_leads(context)) {
        return BTF_OK;
    }
    walk w = {&blob, false, true};
    pass_choice(&w, &choice_now, data->n_views);
    strncpy(reason, choice->reason ? choice->reason : "", sizeof reason - 1);
    enc_blob_put(&blob, reason, sizeof reason);
    pass_store(&w, &store_now, data, &map);
    if (store->effects & BTF_EFFECT_RELIEF) {
        enc_blob_put(&blob, store->views, (size_t)data->n_views);
        if (map) {
            enc_blob_put(&blob, store->heights, enc_data_texel_count(data));
        }
    }
    return enc_checkpoint_put(context, step, &blob);
}
