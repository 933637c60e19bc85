/* Levels of detail. See levels.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "levels.h"

#include "encoder/base/stage.h"
#include "encoder/factor/level.h"
#include "encoder/model/decode_samples.h"
#include "encoder/model/pack.h"
#include "encoder/model/unpack.h"
#include "encoder/relief/relief.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The analysis of one level after another. */
typedef struct fit_pass {
    enc_context quiet; /* without the stages of each analysis */
    const enc_context *context;
    const enc_paper_options *paper;
    const enc_node_tables *nodes; /* NULL: the samples are taken as they are */
    enc_solution *base;
    enc_levels *levels;
} fit_pass;

/* Appends the centres of a level to those of the base, in the scale of the base. */
static btf_result append_centres(const enc_context *context, const enc_solution *level,
                                 enc_solution *base) {
    const size_t bytes = (size_t)3 * (size_t)base->n_lights;
    uint8_t *codes = realloc(base->centre_codes, (base->n_centres + (size_t)level->n_centres) * bytes);
    if (!codes) {
        return enc_fail(context, BTF_ERROR_MEMORY, "levels: out of memory for %u centres",
                        base->n_centres + level->n_centres);
    }
    base->centre_codes = codes;
    codes += base->n_centres * bytes;
    for (size_t i = 0; i < level->n_centres * bytes; i++) {
        const long code = lrintf((float)level->centre_codes[i] * level->centre_scale / base->centre_scale);
        codes[i] = (uint8_t)(code < 255 ? code : 255);
    }
    base->n_centres += level->n_centres;
    return BTF_OK;
}

static btf_result fit_paper(fit_pass *pass, const enc_data *data, int level, enc_solution *out) {
    enc_solution *base = pass->base, found = {0};
    const uint32_t first = base->n_centres, room = BTF_MAX_CENTRES - first;
    enc_paper_options options = *pass->paper;
    enc_paper_stats stats;
    uint32_t most = 0;
    btf_result result = BTF_OK;
    options.effects = base->effects;
    options.choose = false;
    if (base->effects & BTF_EFFECT_HIDDEN) {
        const int shift = 2 * level < 31 ? 2 * level : 31;
        result = enc_pack_centre_room(&pass->quiet, data->width, data->height, data->n_views,
                                      data->n_lights, &most);
        /* of centres that the user asked for, a level gets the share that its texels are of those of level 0 */
        most = options.centres > 0 ? (options.centres >> shift) + 1 : most;
        options.centres = most < room ? most : room;
        if (options.centres == 0) {
            options.effects &= ~(uint32_t)BTF_EFFECT_HIDDEN;
        }
    }
    if (result == BTF_OK) {
        result = enc_paper(&pass->quiet, data, &options, &found, NULL, &stats);
    }
    if (result == BTF_OK && found.n_centres > 0) {
        result = append_centres(pass->context, &found, base);
    }
    if (result == BTF_OK) {
        /* centres of all levels lie in one list, where those of this level begin at `first` */
        const size_t points = enc_solution_texels(&found) * (size_t)data->n_views;
        for (size_t i = 0; i < points && found.gain; i++) {
            if (found.gain[i] == 0) {
                found.centre[i] = (uint16_t)(found.centre[i] + first);
            }
        }
        *out = enc_level_of(base, data->width, data->height);
        out->sbrdf = found.sbrdf;
        out->shadow = found.shadow;
        out->shift = found.shift;
        out->gain = found.gain;
        out->centre = found.centre;
        free(found.centre_codes);
    } else {
        enc_solution_clear(&found);
    }
    return result;
}

/* Finds the values at the nodes of a level, if nodes are fitted, along its surface unless relief has ended
 * before it; and the codes of its heights, which the file has in any case. */
static btf_result prepare_level(const fit_pass *pass, int level, const enc_data *samples, uint8_t **out_codes,
                                enc_data **out_fitted) {
    const enc_relief_store *relief = &pass->base->relief;
    enc_warp surface = {0};
    const enc_node_relief along = {&surface, relief->views};
    const bool heights = relief->effects & BTF_EFFECT_RELIEF,
               moves = heights && (relief->end == 0 || level < (int)relief->end);
    btf_result result =
        heights ? enc_relief_level(relief, samples->width, samples->height, level, out_codes, &surface) : BTF_OK;
    if (result == BTF_ERROR_MEMORY) {
        return enc_fail(pass->context, result, "levels: out of memory");
    }
    if (pass->nodes) {
        result = enc_node_apply(&pass->quiet, pass->nodes, moves ? &along : NULL, samples, out_fitted);
    }
    enc_warp_clear(&surface);
    return result;
}

static btf_result fit_level(void *user, int level, const enc_data *samples) {
    fit_pass *pass = user;
    enc_solution *out = &pass->levels->level[level - 1];
    enc_data *fitted = NULL;
    uint8_t *codes = NULL;
    const btf_result ready = prepare_level(pass, level, samples, &codes, &fitted);
    if (ready != BTF_OK) {
        free(codes);
        return ready;
    }
    const enc_data *data = fitted ? fitted : samples;
    const btf_result result = pass->paper ? fit_paper(pass, data, level, out)
                                          : enc_factors_level(&pass->quiet, data, pass->base, out);
    if (result == BTF_OK) {
        out->relief.heights = codes;
    } else {
        free(codes);
    }
    enc_stage_step(pass->context, enc_data_texel_count(data));
    enc_data_destroy(&fitted);
    return result;
}

btf_result enc_levels_fit(const enc_context *context, const enc_data *data, int count,
                          const enc_paper_options *paper, const enc_node_tables *nodes, enc_solution *base,
                          enc_levels *out_levels) {
    fit_pass pass = {.quiet = *context,
                     .context = context,
                     .paper = paper,
                     .nodes = nodes,
                     .base = base,
                     .levels = out_levels};
    pass.quiet.progress = NULL;
    pass.quiet.checkpoint = NULL; /* its steps are those of level 0 */
    *out_levels = (enc_levels){.count = count, .level = calloc((size_t)count, sizeof(enc_solution))};
    if (!out_levels->level) {
        *out_levels = (enc_levels){0};
        return enc_fail(context, BTF_ERROR_MEMORY, "levels: out of memory");
    }
    enc_stage_begin(context, "levels", enc_level_further_texels(data->width, data->height, count));
    const btf_result result = enc_level_each(context, data, count, fit_level, &pass);
    enc_stage_end(context);
    if (result != BTF_OK) {
        enc_levels_clear(out_levels);
        return result;
    }
    for (int i = 0; i + 1 < count; i++) { /* appending to the centres may have moved them */
        out_levels->level[i].centre_codes = base->centre_codes;
        out_levels->level[i].n_centres = base->n_centres;
    }
    return BTF_OK;
}
