/* The stages of `--method paper` and their checkpoints. See paper_steps.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "paper_steps.h"

#include "checkpoint.h"

#include <stdlib.h>

static const char fit_step[] = "fit", shadow_step[] = "shadow", flow_step[] = "flow",
                  refine_step[] = "refine", cluster_step[] = "cluster";

/* Ends the taking of a step: everything was there, and nothing more. */
static bool taken(enc_blob *blob) {
    const bool good = !blob->failed && blob->at == blob->size;
    enc_blob_clear(blob);
    return good;
}

static size_t sbrdf_size(const enc_sbrdf *sbrdf) {
    return sbrdf->n_texels * enc_sbrdf_stride(sbrdf->lobes, sbrdf->rgb) * sizeof *sbrdf->values;
}

static bool take_fit(const enc_context *context, const enc_data *data, const enc_fit_options *options,
                     enc_sbrdf **out_sbrdf, enc_fit_stats *out_stats) {
    enc_blob blob;
    enc_fit_stats stats;
    if (!enc_checkpoint_get(context, fit_step, &blob))
        return false;
    if (enc_sbrdf_create(enc_data_texel_count(data), options->lobes, options->rgb, out_sbrdf) != BTF_OK) {
        enc_blob_clear(&blob);
        return false;
    }
    enc_blob_take(&blob, &stats, sizeof stats);
    enc_blob_take(&blob, (*out_sbrdf)->values, sbrdf_size(*out_sbrdf));
    if (!taken(&blob)) {
        enc_sbrdf_destroy(out_sbrdf);
        return false;
    }
    if (out_stats)
        *out_stats = stats;
    return true;
}

btf_result enc_step_fit(const enc_context *context, const enc_data *data, const enc_fit_options *options,
                        enc_sbrdf **out_sbrdf, enc_fit_stats *out_stats) {
    if (take_fit(context, data, options, out_sbrdf, out_stats))
        return BTF_OK;
    enc_fit_stats stats = {0};
    btf_result result = enc_fit(context, data, options, out_sbrdf, &stats);
    if (result == BTF_OK && context->checkpoint) {
        enc_blob blob = {0};
        enc_blob_put(&blob, &stats, sizeof stats);
        enc_blob_put(&blob, (*out_sbrdf)->values, sbrdf_size(*out_sbrdf));
        result = enc_checkpoint_put(context, fit_step, &blob);
        if (result != BTF_OK)
            enc_sbrdf_destroy(out_sbrdf);
    }
    if (out_stats)
        *out_stats = stats;
    return result;
}

btf_result enc_step_shadow(const enc_context *context, const enc_data *data, const enc_sbrdf *sbrdf,
                           const enc_shadow_options *options, uint8_t *out_shadow) {
    const size_t size = (size_t)data->n_lights * enc_data_texel_count(data);
    enc_blob blob;
    if (enc_checkpoint_get(context, shadow_step, &blob)) {
        enc_blob_take(&blob, out_shadow, size);
        if (taken(&blob))
            return BTF_OK;
    }
    btf_result result = enc_top_view_shadow(context, data, sbrdf, options, out_shadow);
    if (result == BTF_OK && context->checkpoint) {
        blob = (enc_blob){0};
        enc_blob_put(&blob, out_shadow, size);
        result = enc_checkpoint_put(context, shadow_step, &blob);
    }
    return result;
}

/* All of an occlusion, for steps that change it. */
static btf_result keep_occlusion(const enc_context *context, const char *step, const enc_occlusion *o) {
    const size_t points = (size_t)o->n_views * o->n_texels;
    enc_blob blob = {0};
    if (!context->checkpoint)
        return BTF_OK;
    enc_blob_put(&blob, o->shift, 2 * points);
    enc_blob_put(&blob, o->hidden, points);
    enc_blob_put(&blob, o->hidden_voted, points);
    enc_blob_put(&blob, o->ratio, points * sizeof *o->ratio);
    enc_blob_put(&blob, o->centre, points * sizeof *o->centre);
    return enc_checkpoint_put(context, step, &blob);
}

static bool take_occlusion(const enc_context *context, const char *step, const enc_data *data,
                           enc_occlusion *into) {
    const size_t points = (size_t)data->n_views * enc_data_texel_count(data);
    enc_blob blob;
    if (!enc_checkpoint_get(context, step, &blob))
        return false;
    if (blob.size != points * (4 + sizeof *into->ratio + sizeof *into->centre)) {
        enc_blob_clear(&blob);
        return false;
    }
    enc_blob_take(&blob, into->shift, 2 * points);
    enc_blob_take(&blob, into->hidden, points);
    enc_blob_take(&blob, into->hidden_voted, points);
    enc_blob_take(&blob, into->ratio, points * sizeof *into->ratio);
    enc_blob_take(&blob, into->centre, points * sizeof *into->centre);
    return taken(&blob);
}

btf_result enc_step_flow(const enc_context *context, const enc_data *data, const enc_flow_options *options,
                         enc_occlusion **out_occlusion) {
    if (context->checkpoint &&
        enc_occlusion_create(data->n_views, enc_data_texel_count(data), out_occlusion) == BTF_OK) {
        if (take_occlusion(context, flow_step, data, *out_occlusion))
            return BTF_OK;
        enc_occlusion_destroy(out_occlusion);
    }
    btf_result result = enc_flow_vote(context, data, options, out_occlusion);
    if (result == BTF_OK)
        result = keep_occlusion(context, flow_step, *out_occlusion);
    if (result != BTF_OK)
        enc_occlusion_destroy(out_occlusion);
    return result;
}

btf_result enc_step_refine(const enc_context *context, const enc_data *data, const enc_sbrdf *sbrdf,
                           const uint8_t *shadow, float shadow_scale, const enc_refine_options *options,
                           enc_occlusion *occlusion) {
    if (take_occlusion(context, refine_step, data, occlusion))
        return BTF_OK;
    const btf_result result =
        enc_refine(context, data, sbrdf, shadow, shadow_scale, options, occlusion, NULL);
    return result == BTF_OK ? keep_occlusion(context, refine_step, occlusion) : result;
}

/* Centres, and the centre of every point. */
static bool take_cluster(const enc_context *context, const enc_data *data, int k_total,
                         enc_occlusion *occlusion, enc_centres **out_centres) {
    const size_t points = (size_t)data->n_views * enc_data_texel_count(data);
    enc_centres *c = calloc(1, sizeof *c);
    enc_blob blob;
    if (!c || !enc_checkpoint_get(context, cluster_step, &blob)) {
        free(c);
        return false;
    }
    enc_blob_take(&blob, &c->k, sizeof c->k);
    enc_blob_take(&blob, &c->scale, sizeof c->scale);
    c->n_lights = data->n_lights;
    const size_t codes = c->k >= 0 && c->k <= k_total ? (size_t)c->k * (size_t)c->n_lights * 3 : 0;
    c->codes = malloc(codes + 1);
    blob.failed = blob.failed || !c->codes;
    enc_blob_take(&blob, c->codes, c->codes ? codes : 0);
    enc_blob_take(&blob, occlusion->centre, points * sizeof *occlusion->centre);
    if (!taken(&blob)) {
        enc_centres_destroy(&c);
        return false;
    }
    *out_centres = c;
    return true;
}

btf_result enc_step_cluster(const enc_context *context, const enc_data *data,
                            const enc_cluster_options *options, int k_total, enc_occlusion *occlusion,
                            enc_centres **out_centres) {
    if (take_cluster(context, data, k_total, occlusion, out_centres))
        return BTF_OK;
    btf_result result = enc_cluster(context, data, options, k_total, occlusion, out_centres);
    if (result == BTF_OK && context->checkpoint) {
        const enc_centres *c = *out_centres;
        enc_blob blob = {0};
        enc_blob_put(&blob, &c->k, sizeof c->k);
        enc_blob_put(&blob, &c->scale, sizeof c->scale);
        enc_blob_put(&blob, c->codes, (size_t)c->k * (size_t)c->n_lights * 3);
        enc_blob_put(&blob, occlusion->centre,
                     (size_t)data->n_views * enc_data_texel_count(data) * sizeof *occlusion->centre);
        result = enc_checkpoint_put(context, cluster_step, &blob);
        if (result != BTF_OK)
            enc_centres_destroy(out_centres);
    }
    return result;
}
