/* The stages that improve the decode between the samples. See between.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "between.h"

#include "encoder/base/ranks.h"
#include "encoder/data/level_filter.h"
#include "encoder/report/fit_table.h"
#include "encoder/report/relief_table.h"
#include "foresee.h"

#include <stdio.h>

/* The least PSNR that a fit may leave at the samples: half of the squared error that the wanted quality
 * allows; the other half is for the codec. */
static double fit_least_psnr(const enc_job *job) {
    return job->method != ENC_METHOD_PAPER && job->joint.quality > 0 ? job->joint.quality + 3 : 0;
}

/* Tells the user which effects between the samples are taken. */
static void log_choice(const enc_context *context, const enc_job *job, const enc_relief_choice *choice) {
    if (choice->chosen > 0) {
        enc_log(context, BTF_LOG_INFO, "relief: heights of %.2f to %.2f texels", choice->least, choice->most);
    } else if (job->relief.relief) {
        enc_log(context, BTF_LOG_INFO, choice->tried ? "relief: none: %s" : "relief: not tried: %s",
                choice->reason);
    }
    if (choice->gloss.quarters > 0) {
        enc_log(context, BTF_LOG_INFO, "gloss: views keep %d quarters of the half vector", choice->gloss.quarters);
    }
}

/* Chooses relief and gloss, or takes them from the checkpoint. */
static btf_result find_relief(const enc_context *context, const enc_job *job, const enc_data *data,
                              enc_between *s) {
    if (job->method != ENC_METHOD_JOINT) {
        return BTF_OK;
    }
    if (!enc_settings_try_relief(job)) {
        s->store = (enc_relief_store){.effects = job->relief.gloss > 0 ? BTF_EFFECT_GLOSS : 0,
                                      .gloss_share = (uint32_t)job->relief.gloss};
        return BTF_OK;
    }
    bool taken = false;
    enc_relief_options options = job->relief;
    options.levels = job->levels > 0 ? job->levels : enc_level_count(data->width, data->height);
    btf_result result = enc_relief_step_take(context, data, &taken, &s->relief, s->reason, &s->store);
    if (result == BTF_OK && !taken) {
        result = enc_relief_choose(context, data, &options, &s->relief, &s->store);
        if (result == BTF_OK) {
            result = enc_relief_step_keep(context, data, &s->relief, &s->store);
        }
        result = enc_ranks_agree(context, result);
    }
    if (result == BTF_OK) {
        s->relief_judged = true;
        log_choice(context, job, &s->relief);
    }
    return result;
}

/* Makes the values of the chosen fit; with relief they follow the surface. */
static btf_result apply_nodes(const enc_context *context, const enc_data *data, enc_between *s) {
    enc_warp surface = {0};
    const enc_node_relief relief = {&surface, s->store.views};
    const bool moves = s->store.effects & BTF_EFFECT_RELIEF;
    btf_result result =
        moves ? enc_relief_level(&s->store, data->width, data->height, 0, NULL, &surface) : BTF_OK;
    result = result == BTF_ERROR_MEMORY ? enc_fail(context, result, "relief: out of memory") : result;
    if (result == BTF_OK) {
        result = enc_node_apply(context, &s->nodes, moves ? &relief : NULL, data, &s->fitted);
    }
    enc_warp_clear(&surface);
    return result;
}

/* Predicts the error that the factors will have. */
static btf_result foresee(const enc_context *context, const enc_job *job, const enc_data *data,
                          enc_fit_error *out) {
    const enc_factors_settings settings =
        enc_settings_of_factors(job, data->width, data->height, data->n_views, data->n_lights);
    return enc_foresee_error(context, data, &settings, out);
}

/* Judges fits of values at views and lights, and takes the best where the job asks for one. For the paper's method
 * fits are judged only then. */
static btf_result fit_nodes(const enc_context *context, const enc_job *job, const enc_data *data,
                            enc_between *s) {
    const bool roots = job->method != ENC_METHOD_PAPER; /* whether the decoder blends roots of radiance */
    const bool taken = job->fit == ENC_FIT_BETWEEN;
    enc_fit_error coder;
    if (!taken && !roots) {
        return BTF_OK;
    }
    btf_result result = roots ? foresee(context, job, data, &coder) : BTF_OK;
    if (result == BTF_OK) {
        result = enc_fit_choose(context, data, roots, fit_least_psnr(job), roots ? &coder : NULL, &s->fit,
                                &s->nodes);
    }
    if (!taken) {
        enc_node_tables_clear(&s->nodes);
        s->fit.chosen = 0;
    }
    if (result == BTF_OK && s->nodes.views) {
        result = apply_nodes(context, data, s);
    }
    s->fit_judged = result == BTF_OK;
    return result;
}

btf_result enc_between_find(const enc_context *context, const enc_job *job, const enc_data *data,
                            enc_checkpoint *checkpoint, enc_between *out) {
    enc_context keeping = *context;
    keeping.checkpoint = checkpoint;
    *out = (enc_between){0};
    const btf_result result = find_relief(&keeping, job, data, out);
    return result == BTF_OK ? fit_nodes(context, job, data, out) : result;
}

btf_result enc_between_provenance(const enc_context *context, const enc_job *job, const enc_between *s,
                                  const char *options, char **out_text) {
    char kappa[ENC_FIT_TEXT] = "", between[ENC_RELIEF_TEXT] = "";
    const bool fitted = s->fit_judged && job->fit == ENC_FIT_BETWEEN;
    if (fitted) {
        enc_fit_text(&s->fit, kappa);
        if (s->fit.chosen > 0) {
            enc_log(context, BTF_LOG_INFO, "fit: values at views and lights are fitted with kappa %s", kappa);
        } else {
            enc_log(context, BTF_LOG_INFO, "fit: values at views and lights are the samples");
        }
    }
    if (s->relief_judged) {
        enc_relief_text(&s->relief, between);
    }
    if (asprintf(out_text, "%s%s%s%s%s", options, fitted ? " fit-kappa=" : "", kappa,
                 s->relief_judged ? " " : "", between) < 0) {
        *out_text = NULL;
        return enc_fail(context, BTF_ERROR_MEMORY, "out of memory");
    }
    return BTF_OK;
}

void enc_between_clear(enc_between *between) {
    enc_data_destroy(&between->fitted);
    enc_node_tables_clear(&between->nodes);
    enc_relief_clear(&between->store);
}
