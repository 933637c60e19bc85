/* `--method paper`. See paper.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "paper.h"

#include "choose_effects.h"
#include "diffuse_fallback.h"
#include "encoder/model/pack.h"
#include "steps.h"

#include <stdlib.h>
#include <string.h>

/* Moves shifts and hidden flags to the maps of a solution. */
static btf_result take_occlusion(const enc_context *context, const enc_occlusion *occlusion,
                                 enc_solution *s) {
    const size_t points = (size_t)s->n_views * enc_solution_texels(s);
    s->shift = calloc(points, 2);
    s->gain = malloc(points);
    s->centre = calloc(points, sizeof *s->centre);
    if (!s->shift || !s->gain || !s->centre) {
        return enc_fail(context, BTF_ERROR_MEMORY, "out of memory");
    }
    for (size_t i = 0; i < points; i++) {
        const bool hidden = (s->effects & BTF_EFFECT_HIDDEN) && occlusion->hidden[i];
        s->gain[i] = hidden ? 0 : BTF_GAIN_ONE;
        s->centre[i] = hidden ? occlusion->centre[i] : 0;
        if (!hidden) {
            memcpy(s->shift + 2 * i, occlusion->shift + 2 * i, 2);
        }
    }
    return BTF_OK;
}

static btf_result run_occlusion(const enc_context *context, const enc_data *data,
                                const enc_paper_options *options, enc_solution *s,
                                enc_occlusion **out_occlusion, enc_paper_stats *stats) {
    btf_result result = enc_step_flow(context, data, &options->flow, out_occlusion);
    if (result != BTF_OK) {
        return result;
    }
    enc_occlusion *occlusion = *out_occlusion;
    stats->hidden_total = (size_t)data->n_views * enc_data_texel_count(data);
    stats->hidden_before = enc_occlusion_hidden_count(occlusion, -1);
    uint8_t *white = NULL;
    if (!s->shadow) { /* the search multiplies by shadows, which change nothing where the effect is off */
        white = malloc((size_t)data->n_lights * enc_data_texel_count(data));
        if (!white) {
            return enc_fail(context, BTF_ERROR_MEMORY, "out of memory");
        }
        memset(white, 255, (size_t)data->n_lights * enc_data_texel_count(data));
    }
    result = enc_step_refine(context, data, s->sbrdf, white ? white : s->shadow, 1.0f / 255.0f,
                             &options->refine, occlusion);
    free(white);
    stats->hidden_after = enc_occlusion_hidden_count(occlusion, -1);
    if (result == BTF_OK && stats->hidden_after == 0) {
        s->effects &= ~(uint32_t)BTF_EFFECT_HIDDEN;
    }
    if (result == BTF_OK && (s->effects & BTF_EFFECT_HIDDEN)) {
        uint32_t room = options->centres;
        enc_centres *centres = NULL;
        if (room == 0) {
            result = enc_pack_centre_room(context, data->width, data->height, data->n_views, data->n_lights,
                                          &room);
        }
        if (result == BTF_OK) {
            const uint32_t k = room < BTF_MAX_CENTRES ? room : BTF_MAX_CENTRES;
            result = enc_step_cluster(context, data, &options->cluster, (int)k, occlusion, &centres);
        }
        if (result == BTF_OK) {
            s->n_centres = (uint32_t)centres->k;
            s->centre_scale = centres->scale;
            s->centre_codes = centres->codes;
            centres->codes = NULL;
        }
        enc_centres_destroy(&centres);
    }
    return result;
}

/* Frees the arrays of effects that were left out. */
static void drop_unused(enc_solution *s) {
    if (!(s->effects & BTF_EFFECT_SHADOW)) {
        free(s->shadow);
        s->shadow = NULL;
    }
    if (!(s->effects & BTF_EFFECT_HIDDEN)) {
        free(s->centre_codes);
        s->centre_codes = NULL;
        s->n_centres = 0;
    }
}

btf_result enc_paper(const enc_context *context, const enc_data *data, const enc_paper_options *options,
                     enc_solution *out, enc_occlusion **out_occlusion, enc_paper_stats *out_stats) {
    enc_occlusion *occlusion = NULL;
    memset(out_stats, 0, sizeof *out_stats);
    *out = (enc_solution){.width = data->width,
                          .height = data->height,
                          .n_views = data->n_views,
                          .n_lights = data->n_lights,
                          .domain = BTF_DOMAIN_LINEAR,
                          .effects = options->effects,
                          .radiance_scale = 1,
                          .shadow_scale = 1.0f / 255.0f,
                          .gain_scale = BTF_GAIN_SCALE};
    btf_result result = enc_step_fit(context, data, &options->fit, &out->sbrdf, &out_stats->fit);
    if (result == BTF_OK && (out->effects & BTF_EFFECT_SHADOW)) {
        const enc_shadow_options shadow = {.t_error = options->fit.t_error, .t_btf = options->fit.t_btf};
        out->shadow = malloc((size_t)data->n_lights * enc_data_texel_count(data));
        result = out->shadow ? enc_step_shadow(context, data, out->sbrdf, &shadow, out->shadow)
                             : enc_fail(context, BTF_ERROR_MEMORY, "out of memory");
    }
    const uint32_t occluding = BTF_EFFECT_SHIFT | BTF_EFFECT_HIDDEN;
    bool promising = true;
    if (result == BTF_OK && options->choose && (out->effects & occluding)) {
        result = enc_paper_probe(context, data, options, out, out_stats, &promising);
    }
    out->effects &= promising ? UINT32_MAX : ~occluding;
    if (result == BTF_OK && (out->effects & occluding)) {
        result = run_occlusion(context, data, options, out, &occlusion, out_stats);
    }
    if (result == BTF_OK && options->choose) {
        result = enc_paper_choose(context, data, options, out, occlusion, out_stats);
    }
    if (result == BTF_OK && options->fallback) {
        result = enc_paper_fallback(context, data, options, out, occlusion, out_stats);
    }
    if (result == BTF_OK && options->choose) {
        drop_unused(out);
    }
    if (result == BTF_OK && (out->effects & occluding)) {
        result = take_occlusion(context, occlusion, out);
    }
    if (result != BTF_OK) {
        enc_solution_clear(out);
    }
    if (out_occlusion && result == BTF_OK) {
        *out_occlusion = occlusion;
    } else {
        enc_occlusion_destroy(&occlusion);
        if (out_occlusion) {
            *out_occlusion = NULL;
        }
    }
    return result;
}
