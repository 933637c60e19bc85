/* Fuzz target: bytes as the result of a step in a checkpoint, undamaged and of the right data. The first byte says
 * which step. An accepted result must be usable: the target reads all of it, and the factor encoder goes on from its
 * steps.
 *
 * SPDX-License-Identifier: MIT
 */
#include "fuzz.h"

#include "encoder/data/checkpoint.h"
#include "encoder/job/relief_step.h"
#include "encoder/nodes/apply.h"
#include "encoder/paper/steps.h"
#include "encoder/report/relief_table.h"
#include "step_data.h"

#include <math.h>
#include <openbtf/material.h>
#include <string.h>

static enc_context context = {.threads = 1};
static enc_data *data;

static void make_data(void) {
    char folder[64] = "/dev/shm/btf-fuzz-XXXXXX";
    data = step_data(&context);
    FUZZ_CHECK(data && mkdtemp(folder));
    FUZZ_CHECK(enc_checkpoint_open(&context, folder, "fuzz", data, false, &context.checkpoint) == BTF_OK);
}

static void remove_data(void) {
    enc_checkpoint_close(&context.checkpoint, true);
    enc_data_destroy(&data);
}

static void check_fit(void) {
    const enc_fit_options options = enc_fit_options_default();
    enc_fit_stats stats;
    enc_sbrdf *sbrdf;
    if (!enc_step_take_fit(&context, data, &options, &sbrdf, &stats)) {
        return;
    }
    float out[3 * STEP_LIGHTS];
    const float x[STEP_LIGHTS] = {0, 0}, y[STEP_LIGHTS] = {0, 0.6f}, z[STEP_LIGHTS] = {1, 0.8f};
    FUZZ_CHECK(isfinite(stats.cost) && isfinite(stats.core_seconds));
    for (size_t t = 0; t < STEP_TEXELS; t++) {
        enc_sbrdf_evaluate(sbrdf, t, data->views[1].xyz, STEP_LIGHTS, x, y, z, out);
        for (int i = 0; i < 3 * STEP_LIGHTS; i++) {
            FUZZ_CHECK(!isnan(out[i]));
        }
    }
    enc_sbrdf_destroy(&sbrdf);
}

static void check_occlusion(const char *step) {
    enc_occlusion *o;
    if (!enc_step_take_occlusion(&context, step, data, &o)) {
        return;
    }
    for (size_t i = 0; i < STEP_VIEWS * STEP_TEXELS; i++) {
        FUZZ_CHECK(o->hidden[i] <= 1 && o->hidden_voted[i] <= 1 && o->ratio[i] >= 0 && o->ratio[i] <= 1 &&
                   o->centre[i] == 0);
    }
    enc_occlusion_destroy(&o);
}

static void check_cluster(void) {
    enc_occlusion *o;
    enc_centres *c;
    FUZZ_CHECK(enc_occlusion_create(STEP_VIEWS, STEP_TEXELS, &o) == BTF_OK);
    memset(o->hidden + 4, 1, 5);
    if (enc_step_take_cluster(&context, data, STEP_CENTRES, o, &c)) {
        FUZZ_CHECK(c->k >= 1 && c->k <= STEP_CENTRES && c->n_lights == STEP_LIGHTS && c->scale > 0 &&
                   isfinite(c->scale));
        unsigned sum = 0;
        for (size_t i = 0; i < STEP_VIEWS * STEP_TEXELS; i++) {
            for (size_t j = 0; o->hidden[i] && j < 3 * STEP_LIGHTS; j++) {
                sum += c->codes[o->centre[i] * 3 * STEP_LIGHTS + j];
            }
        }
        FUZZ_CHECK(sum <= 255 * 5 * 3 * STEP_LIGHTS);
        enc_centres_destroy(&c);
    }
    enc_occlusion_destroy(&o);
}

static void check_factors(bool match) {
    const enc_factor_options options = step_factors(match);
    enc_factors *f = NULL;
    FUZZ_CHECK(enc_factor_encode(&context, data, &options, &f) == BTF_OK);
    unsigned sum = 0;
    for (size_t i = 0; i < (size_t)f->n_u_texels * STEP_TEXELS * 4; i++) {
        sum += f->texels[i];
    }
    for (size_t i = 0; i < (size_t)f->n_units * STEP_VIEWS * STEP_LIGHTS * 4; i++) {
        sum += f->directions[i];
    }
    for (size_t i = 0; i < 4 * (size_t)f->n_units; i++) {
        FUZZ_CHECK(isfinite(f->scales[i]));
    }
    FUZZ_CHECK(sum || !sum);
    enc_factors_destroy(&f);
}

/* Makes the values at the nodes along the accepted surface. Its heights must be ones that a file may hold (FORMAT.md
 * section 7), since marches along higher ones would read beyond the tables of wrapped texels. */
static void bake(const enc_relief_store *store) {
    const bool map = store->heights != NULL, rises = store->step > 0;
    FUZZ_CHECK(store->base + ((255 * store->step) >> 8) <= INT16_MAX && map == rises);
    float views[STEP_VIEWS * STEP_VIEWS] = {0.75f, 0.25f, -0.25f, 1.25f};
    float lights[STEP_LIGHTS * STEP_LIGHTS] = {1, 0, 0, 1};
    const enc_node_tables tables = {STEP_VIEWS, STEP_LIGHTS, views, lights, true};
    enc_warp surface = {0};
    const enc_node_relief relief = {&surface, store->views};
    enc_data *fitted = NULL;
    FUZZ_CHECK(enc_relief_level(store, data->width, data->height, 0, NULL, &surface) == BTF_OK);
    FUZZ_CHECK(enc_node_apply(&context, &tables, &relief, data, &fitted) == BTF_OK);
    for (size_t i = 0; i < STEP_TEXELS * enc_data_texel_stride(data); i++) {
        FUZZ_CHECK(isfinite(fitted->samples[i]));
    }
    enc_data_destroy(&fitted);
    enc_warp_clear(&surface);
}

/* An accepted relief can be described in messages, stored again, and used to decode. */
static void check_relief(void) {
    char reason[ENC_RELIEF_REASON], text[ENC_RELIEF_TEXT];
    enc_relief_choice choice;
    enc_relief_store store;
    bool taken;
    FUZZ_CHECK(enc_relief_step_take(&context, data, &taken, &choice, reason, &store) == BTF_OK);
    if (!taken) {
        FUZZ_CHECK(!store.heights && !store.views && store.effects == 0);
        return;
    }
    FUZZ_CHECK(strlen(enc_relief_text(&choice, text)) < sizeof text);
    const bool gloss = store.effects & BTF_EFFECT_GLOSS, shares = store.gloss_share > 0;
    FUZZ_CHECK(store.gloss_share <= 2 && gloss == shares);
    if (store.effects & BTF_EFFECT_RELIEF) {
        bake(&store);
    }
    FUZZ_CHECK(enc_relief_step_keep(&context, data, &choice, &store) == BTF_OK);
    enc_relief_clear(&store);
}

/* Removes the steps of the previous input. */
static void forget(void) {
    for (int i = STEP_COMPONENTS; i <= STEP_MATCH; i++) {
        enc_blob empty = {0};
        FUZZ_CHECK(enc_checkpoint_put(&context, step_names[i], &empty) == BTF_OK);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size) {
    uint8_t shadow[STEP_LIGHTS * STEP_TEXELS];
    if (size == 0) {
        return 0;
    }
    if (!data) {
        make_data();
        atexit(remove_data);
    }
    const unsigned step = bytes[0] % STEP_COUNT;
    enc_blob blob = {0};
    if (step >= STEP_COMPONENTS && step <= STEP_MATCH) {
        forget();
    }
    enc_blob_put(&blob, bytes + 1, size - 1);
    FUZZ_CHECK(enc_checkpoint_put(&context, step_names[step], &blob) == BTF_OK);
    if (step == STEP_FIT) {
        check_fit();
    } else if (step == STEP_SHADOW) {
        enc_step_take_shadow(&context, data, shadow);
    } else if (step == STEP_FLOW || step == STEP_REFINE) {
        check_occlusion(step_names[step]);
    } else if (step == STEP_CLUSTER) {
        check_cluster();
    } else if (step == STEP_RELIEF) {
        check_relief();
    } else {
        check_factors(step == STEP_MATCHED || step == STEP_MATCH);
    }
    return 0;
}
