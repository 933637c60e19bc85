/* The stages of `--method paper` and their checkpoints. See steps.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "steps.h"

#include "encoder/base/ranks.h"
#include "encoder/data/checkpoint.h"

#include <float.h>
#include <stdlib.h>

static const char fit_step[] = "fit", shadow_step[] = "shadow", flow_step[] = "flow",
                  refine_step[] = "refine", cluster_step[] = "cluster";

/* A magnitude far beyond any parameter that a file may hold. */
static const float most = 0x1p24f;

static bool is_positive(double x) {
    return x >= 0 && x <= DBL_MAX;
}

bool enc_step_take_fit(const enc_context *context, const enc_data *data, const enc_fit_options *options,
                       enc_sbrdf **out_sbrdf, enc_fit_stats *out_stats) {
    enc_blob blob;
    *out_sbrdf = NULL;
    if (!enc_checkpoint_get(context, fit_step, &blob)) {
        return false;
    }
    const bool room =
        enc_sbrdf_create(enc_data_texel_count(data), options->lobes, options->rgb, out_sbrdf) == BTF_OK;
    if (!enc_ranks_all(context, room)) {
        enc_blob_clear(&blob);
        enc_sbrdf_destroy(out_sbrdf);
        return false;
    }
    enc_sbrdf *sbrdf = *out_sbrdf;
    enc_blob_take(&blob, out_stats, sizeof *out_stats);
    enc_blob_take_floats(&blob, sbrdf->values, sbrdf->n_texels * enc_sbrdf_stride(sbrdf->lobes, sbrdf->rgb),
                         -most, most);
    const bool good =
        enc_blob_taken(&blob) && is_positive(out_stats->cost) && is_positive(out_stats->core_seconds);
    if (!good) {
        enc_sbrdf_destroy(out_sbrdf);
    }
    return good;
}

btf_result enc_step_keep_fit(const enc_context *context, const enc_sbrdf *sbrdf,
                             const enc_fit_stats *stats) {
    enc_blob blob = {0};
    if (!context->checkpoint || !enc_ranks_leads(context)) {
        return BTF_OK;
    }
    enc_blob_put(&blob, stats, sizeof *stats);
    enc_blob_put(&blob, sbrdf->values,
                 sbrdf->n_texels * enc_sbrdf_stride(sbrdf->lobes, sbrdf->rgb) * sizeof *sbrdf->values);
    return enc_checkpoint_put(context, fit_step, &blob);
}

bool enc_step_take_shadow(const enc_context *context, const enc_data *data, uint8_t *out_shadow) {
    enc_blob blob;
    if (!enc_checkpoint_get(context, shadow_step, &blob)) {
        return false;
    }
    enc_blob_take(&blob, out_shadow, (size_t)data->n_lights * enc_data_texel_count(data));
    return enc_blob_taken(&blob);
}

btf_result enc_step_keep_shadow(const enc_context *context, const enc_data *data, const uint8_t *shadow) {
    enc_blob blob = {0};
    if (!context->checkpoint || !enc_ranks_leads(context)) {
        return BTF_OK;
    }
    enc_blob_put(&blob, shadow, (size_t)data->n_lights * enc_data_texel_count(data));
    return enc_checkpoint_put(context, shadow_step, &blob);
}

bool enc_step_take_occlusion(const enc_context *context, const char *step, const enc_data *data,
                             enc_occlusion **out_occlusion) {
    const size_t points = (size_t)data->n_views * enc_data_texel_count(data);
    enc_blob blob;
    *out_occlusion = NULL;
    if (!enc_checkpoint_get(context, step, &blob)) {
        return false;
    }
    const bool room =
        enc_occlusion_create(data->n_views, enc_data_texel_count(data), out_occlusion) == BTF_OK;
    if (!enc_ranks_all(context, room)) {
        enc_blob_clear(&blob);
        enc_occlusion_destroy(out_occlusion);
        return false;
    }
    enc_occlusion *into = *out_occlusion;
    enc_blob_take(&blob, into->shift, 2 * points);
    enc_blob_take_bytes(&blob, into->hidden, points, 0, 1);
    enc_blob_take_bytes(&blob, into->hidden_voted, points, 0, 1);
    enc_blob_take_floats(&blob, into->ratio, points, 0, 1);
    const bool good = enc_blob_taken(&blob);
    if (!good) {
        enc_occlusion_destroy(out_occlusion);
    }
    return good;
}

btf_result enc_step_keep_occlusion(const enc_context *context, const char *step, const enc_occlusion *o) {
    const size_t points = (size_t)o->n_views * o->n_texels;
    enc_blob blob = {0};
    if (!context->checkpoint || !enc_ranks_leads(context)) {
        return BTF_OK;
    }
    enc_blob_put(&blob, o->shift, 2 * points);
    enc_blob_put(&blob, o->hidden, points);
    enc_blob_put(&blob, o->hidden_voted, points);
    enc_blob_put(&blob, o->ratio, points * sizeof *o->ratio);
    return enc_checkpoint_put(context, step, &blob);
}

static bool are_within(const enc_occlusion *occlusion, int k) {
    const size_t points = (size_t)occlusion->n_views * occlusion->n_texels;
    for (size_t i = 0; i < points; i++) {
        if (occlusion->hidden[i] && occlusion->centre[i] >= k) {
            return false;
        }
    }
    return true;
}

bool enc_step_take_cluster(const enc_context *context, const enc_data *data, int k_total,
                           enc_occlusion *occlusion, enc_centres **out_centres) {
    const size_t points = (size_t)data->n_views * enc_data_texel_count(data);
    enc_centres *c = calloc(1, sizeof *c);
    enc_blob blob;
    *out_centres = NULL;
    if (!context->checkpoint || !enc_ranks_all(context, c != NULL) ||
        !enc_checkpoint_get(context, cluster_step, &blob)) {
        free(c);
        return false;
    }
    enc_blob_take(&blob, &c->k, sizeof c->k);
    enc_blob_take_floats(&blob, &c->scale, 1, 1 / most, most);
    c->n_lights = data->n_lights;
    blob.failed = blob.failed || c->k < 0 || c->k > k_total;
    const size_t codes = blob.failed ? 0 : (size_t)c->k * (size_t)c->n_lights * 3;
    c->codes = malloc(codes + 1);
    blob.failed = blob.failed || !c->codes;
    enc_blob_take(&blob, c->codes, c->codes ? codes : 0);
    enc_blob_take(&blob, occlusion->centre, points * sizeof *occlusion->centre);
    const bool good = enc_blob_taken(&blob) && are_within(occlusion, c->k);
    if (!enc_ranks_all(context, good)) {
        enc_centres_destroy(&c);
        return false;
    }
    *out_centres = c;
    return true;
}

btf_result enc_step_keep_cluster(const enc_context *context, const enc_occlusion *occlusion,
                                 const enc_centres *c) {
    const size_t points = (size_t)occlusion->n_views * occlusion->n_texels;
    enc_blob blob = {0};
    if (!context->checkpoint || !enc_ranks_leads(context)) {
        return BTF_OK;
    }
    enc_blob_put(&blob, &c->k, sizeof c->k);
    enc_blob_put(&blob, &c->scale, sizeof c->scale);
    enc_blob_put(&blob, c->codes, (size_t)c->k * (size_t)c->n_lights * 3);
    enc_blob_put(&blob, occlusion->centre, points * sizeof *occlusion->centre);
    return enc_checkpoint_put(context, cluster_step, &blob);
}

btf_result enc_step_fit(const enc_context *context, const enc_data *data, const enc_fit_options *options,
                        enc_sbrdf **out_sbrdf, enc_fit_stats *out_stats) {
    enc_fit_stats stats = {0};
    btf_result result = BTF_OK;
    if (!enc_step_take_fit(context, data, options, out_sbrdf, &stats)) {
        stats = (enc_fit_stats){0};
        result = enc_fit(context, data, options, out_sbrdf, &stats);
        if (result == BTF_OK) {
            result = enc_step_keep_fit(context, *out_sbrdf, &stats);
        }
        if (result != BTF_OK) {
            enc_sbrdf_destroy(out_sbrdf);
        }
    }
    if (out_stats) {
        *out_stats = stats;
    }
    return result;
}

btf_result enc_step_shadow(const enc_context *context, const enc_data *data, const enc_sbrdf *sbrdf,
                           const enc_shadow_options *options, uint8_t *out_shadow) {
    if (enc_step_take_shadow(context, data, out_shadow)) {
        return BTF_OK;
    }
    const btf_result result = enc_top_view_shadow(context, data, sbrdf, options, out_shadow);
    return result == BTF_OK ? enc_step_keep_shadow(context, data, out_shadow) : result;
}

btf_result enc_step_flow(const enc_context *context, const enc_data *data, const enc_flow_options *options,
                         enc_occlusion **out_occlusion) {
    if (enc_step_take_occlusion(context, flow_step, data, out_occlusion)) {
        return BTF_OK;
    }
    btf_result result = enc_flow_vote(context, data, options, out_occlusion);
    if (result == BTF_OK) {
        result = enc_step_keep_occlusion(context, flow_step, *out_occlusion);
    }
    if (result != BTF_OK) {
        enc_occlusion_destroy(out_occlusion);
    }
    return result;
}

btf_result enc_step_refine(const enc_context *context, const enc_data *data, const enc_sbrdf *sbrdf,
                           const uint8_t *shadow, float shadow_scale, const enc_refine_options *options,
                           enc_occlusion *occlusion) {
    enc_occlusion *kept;
    if (enc_step_take_occlusion(context, refine_step, data, &kept)) {
        const enc_occlusion before = *occlusion;
        *occlusion = *kept;
        *kept = before;
        enc_occlusion_destroy(&kept);
        return BTF_OK;
    }
    const btf_result result =
        enc_refine(context, data, sbrdf, shadow, shadow_scale, options, occlusion, NULL);
    return result == BTF_OK ? enc_step_keep_occlusion(context, refine_step, occlusion) : result;
}

btf_result enc_step_cluster(const enc_context *context, const enc_data *data,
                            const enc_cluster_options *options, int k_total, enc_occlusion *occlusion,
                            enc_centres **out_centres) {
    if (enc_step_take_cluster(context, data, k_total, occlusion, out_centres)) {
        return BTF_OK;
    }
    btf_result result = enc_cluster(context, data, options, k_total, occlusion, out_centres);
    if (result == BTF_OK) {
        result = enc_step_keep_cluster(context, occlusion, *out_centres);
    }
    if (result != BTF_OK) {
        enc_centres_destroy(out_centres);
    }
    return result;
}
