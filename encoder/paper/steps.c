/* The stages of `--method paper` and their checkpoints. See paper_steps.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "steps.h"

#include "kept.h"

static const char flow_step[] = "flow", refine_step[] = "refine";

btf_result enc_step_fit(const enc_context *context, const enc_data *data, const enc_fit_options *options,
                        enc_sbrdf **out_sbrdf, enc_fit_stats *out_stats) {
    enc_fit_stats stats = {0};
    btf_result result = BTF_OK;
    if (!enc_kept_fit(context, data, options, out_sbrdf, &stats)) {
        stats = (enc_fit_stats){0};
        result = enc_fit(context, data, options, out_sbrdf, &stats);
        if (result == BTF_OK)
            result = enc_keep_fit(context, *out_sbrdf, &stats);
        if (result != BTF_OK)
            enc_sbrdf_destroy(out_sbrdf);
    }
    if (out_stats)
        *out_stats = stats;
    return result;
}

btf_result enc_step_shadow(const enc_context *context, const enc_data *data, const enc_sbrdf *sbrdf,
                           const enc_shadow_options *options, uint8_t *out_shadow) {
    if (enc_kept_shadow(context, data, out_shadow))
        return BTF_OK;
    const btf_result result = enc_top_view_shadow(context, data, sbrdf, options, out_shadow);
    return result == BTF_OK ? enc_keep_shadow(context, data, out_shadow) : result;
}

btf_result enc_step_flow(const enc_context *context, const enc_data *data, const enc_flow_options *options,
                         enc_occlusion **out_occlusion) {
    if (enc_kept_occlusion(context, flow_step, data, out_occlusion))
        return BTF_OK;
    btf_result result = enc_flow_vote(context, data, options, out_occlusion);
    if (result == BTF_OK)
        result = enc_keep_occlusion(context, flow_step, *out_occlusion);
    if (result != BTF_OK)
        enc_occlusion_destroy(out_occlusion);
    return result;
}

btf_result enc_step_refine(const enc_context *context, const enc_data *data, const enc_sbrdf *sbrdf,
                           const uint8_t *shadow, float shadow_scale, const enc_refine_options *options,
                           enc_occlusion *occlusion) {
    enc_occlusion *kept;
    if (enc_kept_occlusion(context, refine_step, data, &kept)) {
        const enc_occlusion before = *occlusion;
        *occlusion = *kept;
        *kept = before;
        enc_occlusion_destroy(&kept);
        return BTF_OK;
    }
    const btf_result result =
        enc_refine(context, data, sbrdf, shadow, shadow_scale, options, occlusion, NULL);
    return result == BTF_OK ? enc_keep_occlusion(context, refine_step, occlusion) : result;
}

btf_result enc_step_cluster(const enc_context *context, const enc_data *data,
                            const enc_cluster_options *options, int k_total, enc_occlusion *occlusion,
                            enc_centres **out_centres) {
    if (enc_kept_cluster(context, data, k_total, occlusion, out_centres))
        return BTF_OK;
    btf_result result = enc_cluster(context, data, options, k_total, occlusion, out_centres);
    if (result == BTF_OK)
        result = enc_keep_cluster(context, occlusion, *out_centres);
    if (result != BTF_OK)
        enc_centres_destroy(out_centres);
    return result;
}
