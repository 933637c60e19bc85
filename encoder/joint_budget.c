/* Which fit a material gets within a budget: effects and components, rounds, rounding (see joint.h,
 * joint_budget.h).
 *
 * Candidates are shapes: effects, with as many components as the bytes beside them allow. The plain
 * factorisation comes first: it is the start of all others, and their rival where nothing moves. Shapes
 * with maps are tried for a few rounds from there; the best of them is fitted to the end, and kept unless
 * the plain one is better.
 *
 * SPDX-License-Identifier: MIT
 */
#include "joint_budget.h"
#include "joint_fit.h"
#include "joint_measure.h"
#include "joint_reach.h"

#include <math.h>
#include <openbtf/material.h>
#include <stdlib.h>
#include <string.h>

enum {
    MOST_COMPONENTS = 128, /* more would make the solves of every source dominate */
    SHAPES = 3,
    REDUCE_ROUNDS = 3, /* rounds after components were dropped for --quality */
};

/* dB in the fitted domain that 8-bit codes reach but hardly pass: better is not sought. */
static const double enough_psnr = 55.0;

/* What a preset stands for. */
typedef struct preset_values {
    int front;        /* rounds without a residual */
    int start;        /* subspace iterations of the plain factorisation */
    int shapes;       /* shapes with maps that are tried */
    int trial;        /* rounds of a trial */
    int rounds;       /* rounds of the best, trial included */
    double tolerance; /* relative decrease of the error that ends the rounds */
} preset_values;

static const preset_values presets[] = {
    [ENC_JOINT_FAST] = {2, 3, 1, 1, 5, 2e-3},
    [ENC_JOINT_MEDIUM] = {4, 4, 2, 2, 18, 5e-4},
    [ENC_JOINT_THOROUGH] = {10, 5, 3, 4, 90, 1e-4},
    [ENC_JOINT_EXHAUSTIVE] = {100, 8, 3, 6, ENC_JOINT_MAX_ROUNDS, 1e-6},
};

uint64_t joint_bytes(const enc_data *data, const joint_shape *shape) {
    const uint64_t texels = enc_data_texel_count(data), views = (uint64_t)data->n_views;
    const uint64_t lights = (uint64_t)data->n_lights, layers = (shape->components + 3) / 4;
    uint64_t bytes = 0;
    if (shape->lobes > 0) {
        const uint64_t lobes = (uint64_t)shape->lobes;
        bytes += 8 * texels * (shape->rgb ? (3 + 3 * lobes + 3) / 4 + lobes : 1 + lobes);
    }
    if (shape->effects & BTF_EFFECT_SHADOW)
        bytes += texels * lights;
    if (shape->effects & (BTF_EFFECT_SHIFT | BTF_EFFECT_HIDDEN))
        bytes += 2 * texels * views;
    if (shape->effects & (BTF_EFFECT_GAIN | BTF_EFFECT_HIDDEN))
        bytes += texels * views;
    if (shape->effects & BTF_EFFECT_HIDDEN) {
        const uint64_t blocks = (shape->centres + 4095) / 4096;
        bytes += blocks ? 4 * lights * blocks * ((shape->centres + blocks - 1) / blocks) : 0;
    }
    if (shape->effects & BTF_EFFECT_RESIDUAL)
        bytes += 4 * layers * (texels + 3 * views * lights);
    return bytes;
}

size_t joint_components_for(const enc_data *data, const joint_shape *shape, uint64_t budget, size_t limit) {
    joint_shape trial = *shape;
    if (enc_data_texel_count(data) > JOINT_EXACT && limit > JOINT_MOST_BEYOND)
        limit = JOINT_MOST_BEYOND;
    for (trial.components = limit / 4 * 4; trial.components > 0; trial.components -= 4)
        if (joint_bytes(data, &trial) <= budget)
            break;
    /* the data of a few texels or images have no higher rank */
    const size_t texels = enc_data_texel_count(data);
    const size_t columns = (size_t)data->n_views * (size_t)data->n_lights * 3;
    const size_t rank = texels < columns ? texels : columns;
    return trial.components < rank ? trial.components : rank;
}

uint64_t joint_default_budget(const enc_data *data) {
    const uint64_t texels = enc_data_texel_count(data);
    const int tiles = data->n_views > data->n_lights ? data->n_views : data->n_lights;
    uint32_t width, height, room;
    const btf_material_info info = {.struct_size = sizeof info,
                                    .width = (uint32_t)data->width,
                                    .height = (uint32_t)data->height,
                                    .n_views = (uint32_t)data->n_views,
                                    .n_lights = (uint32_t)data->n_lights,
                                    .layout = BTF_LAYOUT_PAPER,
                                    .lobes = 3,
                                    .effects = BTF_EFFECT_SHADOW | BTF_EFFECT_SHIFT | BTF_EFFECT_HIDDEN};
    /* materials of a few texels: enough for the least residual all the same */
    const joint_shape least = {.effects = BTF_EFFECT_SHIFT | BTF_EFFECT_GAIN | BTF_EFFECT_RESIDUAL, .components = 4};
    const uint64_t needed = joint_bytes(data, &least);
    const bool has_atlas = btf_material_atlas(&info, &width, &height, &room) == BTF_OK;
    const uint64_t paper = 64 * texels + (has_atlas ? 4 * (uint64_t)width * height : 32 * texels * (uint64_t)tiles / 5);
    return paper > needed ? paper : needed;
}

enc_joint_options enc_joint_options_default(void) {
    return (enc_joint_options){.preset = ENC_JOINT_MEDIUM, .effects = BTF_EFFECT_ALL};
}

/* Everything a run holds. */
typedef struct run {
    const enc_joint_options *options;
    preset_values preset;
    uint64_t budget;
    double enough; /* error below which nothing more is sought */
    joint_rows rows;
    joint_fit plain, best;
    double *energy;    /* of the plain components */
    joint_shape shape; /* chosen without a residual */
    enc_joint_stats *stats;
} run;

static size_t components_for(const run *r, uint32_t effects) {
    const joint_shape shape = {.effects = effects};
    const size_t limit = r->options->components > 0 ? (size_t)r->options->components : MOST_COMPONENTS;
    return joint_components_for(r->rows.data, &shape, r->budget, limit);
}

static uint64_t bytes_of(const run *r, uint32_t effects, size_t components) {
    const joint_shape shape = {.effects = effects, .components = components};
    return joint_bytes(r->rows.data, &shape);
}

/* Rounds until `count` are done, nothing is gained, or it is enough. */
static btf_result fit_rounds(run *r, joint_fit *fit, int count, double *history, int *io_rounds) {
    btf_result result = BTF_OK;
    while (result == BTF_OK && *io_rounds < count && fit->error > r->enough) {
        const double before = fit->error;
        result = joint_fit_round(fit);
        if (result == BTF_OK)
            history[(*io_rounds)++] = fit->error;
        if (before - fit->error < r->preset.tolerance * before)
            break;
    }
    return result;
}

/* The effects of the shapes with maps that the options allow, most promising first. */
static int list_shapes(const run *r, uint32_t *out_effects) {
    static const uint32_t maps[SHAPES] = {BTF_EFFECT_SHIFT | BTF_EFFECT_GAIN, BTF_EFFECT_SHIFT,
                                          BTF_EFFECT_GAIN};
    int count = 0;
    for (int i = 0; i < SHAPES && count < r->preset.shapes; i++) {
        const uint32_t effects = maps[i] | BTF_EFFECT_RESIDUAL;
        if (!(effects & ~r->options->effects) && components_for(r, effects) > 0)
            out_effects[count++] = effects;
    }
    return count;
}

/* Tries the shapes and fits the best of them; r->best stays empty when there is none. */
static btf_result fit_shapes(run *r) {
    uint32_t shapes[SHAPES];
    const int count = list_shapes(r, shapes);
    const int rounds = r->options->rounds > 0 ? r->options->rounds : r->preset.rounds;
    const int trial = count > 1 && r->preset.trial < rounds ? r->preset.trial : rounds;
    double history[ENC_JOINT_MAX_ROUNDS];
    btf_result result = BTF_OK;
    joint_fit_rest(&r->plain);
    for (int i = 0; i < count && result == BTF_OK; i++) {
        joint_fit fit = {0};
        int done = 0;
        const size_t k = components_for(r, shapes[i]);
        joint_fit_rest(&r->best);
        result = joint_fit_start(&r->plain, k < r->plain.model.k ? k : r->plain.model.k, shapes[i], &fit);
        if (result == BTF_OK)
            result = fit_rounds(r, &fit, trial, history, &done);
        if (result == BTF_OK && (i == 0 || fit.error < r->best.error)) {
            joint_fit_clear(&r->best);
            r->best = fit;
            fit = (joint_fit){0};
            r->stats->rounds = done;
            memcpy(r->stats->history, history, (size_t)done * sizeof *history);
        }
        joint_fit_clear(&fit);
    }
    if (result == BTF_OK && count > 0)
        result = fit_rounds(r, &r->best, rounds, r->stats->history, &r->stats->rounds);
    joint_fit_rest(&r->best);
    return result;
}

/* Rounds a fit off and measures its codes. */
static btf_result finish(run *r, joint_fit *fit, enc_solution *out_solution, joint_error *out_error) {
    btf_result result = joint_fit_round_off(fit);
    joint_fit_rest(fit);
    if (result == BTF_OK)
        result = joint_fit_solution(fit, out_solution);
    if (result == BTF_OK)
        result = joint_measure(&r->rows, out_solution, out_error);
    return result;
}

/* Finishes the first k components of a fit in its principal basis, after a few rounds or iterations. */
static btf_result finish_part(run *r, const joint_fit *from, size_t k, enc_solution *out_solution,
                              joint_error *out_error) {
    joint_fit fit = {0};
    double history[REDUCE_ROUNDS];
    int done = 0;
    btf_result result = joint_fit_start(from, k, from->effects, &fit);
    if (result == BTF_OK && k < from->model.k) {
        if (from->effects == BTF_EFFECT_RESIDUAL)
            result = joint_fit_refine_plain(&fit, 1, NULL);
        else
            result = fit_rounds(r, &fit, REDUCE_ROUNDS, history, &done);
    }
    if (result == BTF_OK)
        result = finish(r, &fit, out_solution, out_error);
    joint_fit_clear(&fit);
    return result;
}

/* Replaces *solution and *error by those of the fewest components of `from` that reach the quality, if that
 * takes fewer bytes than *io_bytes. */
static btf_result reduce(run *r, const joint_fit *from, uint64_t *io_bytes, enc_solution *solution,
                         joint_error *error) {
    size_t low = 0, high = from->model.k / 4 + 1; /* in fours: low fails, high is not known to fail */
    btf_result result = BTF_OK;
    while (high > 1 && bytes_of(r, from->effects, 4 * (high - 1)) >= *io_bytes)
        high--;
    while (low + 1 < high && result == BTF_OK) {
        const size_t middle = (low + high) / 2;
        enc_solution trial = {0};
        joint_error trial_error;
        result = finish_part(r, from, 4 * middle, &trial, &trial_error);
        if (result == BTF_OK && joint_psnr(&r->rows, trial_error.srgb) >= r->options->quality) {
            enc_solution_clear(solution);
            *solution = trial;
            *error = trial_error;
            *io_bytes = bytes_of(r, from->effects, 4 * middle);
            high = middle;
        } else {
            enc_solution_clear(&trial);
            low = middle;
        }
    }
    return result;
}

/* --quality: the fewest bytes that reach it, of the best fit and of the plain one. */
static btf_result reach_quality(run *r, enc_solution *solution, joint_error *error) {
    uint64_t bytes = UINT64_MAX;
    btf_result result = BTF_OK;
    if (joint_psnr(&r->rows, error->srgb) < r->options->quality) {
        enc_log(r->rows.context, BTF_LOG_WARNING, "joint: %.2f dB of %.2f within %llu bytes",
                joint_psnr(&r->rows, error->srgb), r->options->quality, (unsigned long long)r->budget);
        return BTF_OK;
    }
    bytes = bytes_of(r, solution->effects, solution->n_components);
    if (r->best.rows)
        result = reduce(r, &r->best, &bytes, solution, error);
    if (result == BTF_OK)
        result = reduce(r, &r->plain, &bytes, solution, error);
    return result;
}

/* The smallest plain shape whose error is small enough, or 0. */
static size_t enough_components(const run *r) {
    double error = r->rows.total;
    for (size_t j = 0; j < r->plain.model.k; j++) {
        error -= r->energy[j];
        if (error <= r->enough)
            return (j + 4) / 4 * 4 < r->plain.model.k ? (j + 4) / 4 * 4 : r->plain.model.k;
    }
    return 0;
}

/* The better of the fitted shape and the plain one, as codes. */
static btf_result choose(run *r, enc_solution *out_solution, joint_error *out_error) {
    btf_result result = BTF_OK;
    joint_error plain_error;
    enc_solution plain = {0};
    bool have = false;
    if (r->best.rows) {
        result = joint_principal_basis(&r->rows, &r->best.model, NULL);
        if (result == BTF_OK)
            result = finish_part(r, &r->best, r->best.model.k, out_solution, out_error);
        have = true;
    }
    if (result != BTF_OK || (have && r->plain.error > 1.03 * out_error->fitted))
        return result;
    result = joint_fit_refine_plain(&r->plain, r->preset.start, NULL);
    joint_fit_rest(&r->plain);
    if (result == BTF_OK)
        result = finish_part(r, &r->plain, r->plain.model.k, &plain, &plain_error);
    if (result == BTF_OK && (!have || plain_error.fitted < out_error->fitted)) {
        enc_solution_clear(out_solution);
        *out_solution = plain;
        plain = (enc_solution){0};
        *out_error = plain_error;
        r->stats->rounds = 0;
    }
    enc_solution_clear(&plain);
    return result;
}

/* From data to codes. */
static btf_result solve(run *r, enc_solution *out_solution, joint_error *out_error) {
    const size_t k = components_for(r, BTF_EFFECT_RESIDUAL);
    if (k == 0)
        return enc_fail(r->rows.context, BTF_ERROR_USAGE,
                        "joint: a budget of %llu bytes holds no component", (unsigned long long)r->budget);
    r->energy = malloc(k * sizeof *r->energy);
    if (!r->energy)
        return enc_fail(r->rows.context, BTF_ERROR_MEMORY, "joint: out of memory for %zu components", k);
    btf_result result = joint_fit_plain(&r->rows, k, r->preset.start, &r->plain, r->energy);
    if (result != BTF_OK)
        return result;
    const size_t plenty = r->options->quality > 0.0 ? 0 : enough_components(r);
    if (plenty > 0)
        return finish_part(r, &r->plain, plenty, out_solution, out_error);
    result = fit_shapes(r);
    if (result == BTF_OK)
        result = choose(r, out_solution, out_error);
    if (result == BTF_OK && r->options->quality > 0.0)
        result = reach_quality(r, out_solution, out_error);
    return result;
}

/* SBRDF times shadow, where the residual is not allowed: the richest parameters that the budget holds. */
static btf_result solve_without_residual(run *r, enc_solution *out_solution, joint_error *out_error) {
    static const struct {
        int lobes;
        bool rgb;
    } choices[] = {{3, true}, {3, false}, {2, false}, {1, false}};
    const uint32_t effects =
        r->options->effects & (BTF_EFFECT_SHADOW | BTF_EFFECT_SHIFT | BTF_EFFECT_GAIN);
    joint_front_kind kind = {.shadow = effects & BTF_EFFECT_SHADOW, .half = true};
    joint_fit fit = {0};
    int count = 1;
    for (size_t i = 0; i < sizeof choices / sizeof *choices; i++) {
        r->shape = (joint_shape){.effects = effects, .lobes = choices[i].lobes, .rgb = choices[i].rgb};
        kind.lobes = choices[i].lobes;
        kind.rgb = choices[i].rgb;
        if (joint_bytes(r->rows.data, &r->shape) <= r->budget)
            break;
        if (i + 1 == sizeof choices / sizeof *choices)
            return enc_fail(r->rows.context, BTF_ERROR_USAGE,
                            "joint: a budget of %llu bytes holds no such model",
                            (unsigned long long)r->budget);
    }
    const int rounds = !(effects & BTF_EFFECT_SHIFT) ? 1
                       : r->options->rounds > 0      ? r->options->rounds
                                                     : r->preset.front;
    btf_result result = joint_fit_lone(&r->rows, effects, &kind, 2, &fit);
    r->stats->history[0] = fit.error;
    if (result == BTF_OK)
        result = fit_rounds(r, &fit, rounds + 1, r->stats->history, &count);
    r->stats->rounds = count;
    if (result == BTF_OK)
        result = finish(r, &fit, out_solution, out_error);
    joint_fit_clear(&fit);
    return result;
}

static void fill_stats(run *r, const enc_solution *solution, const joint_error *error) {
    enc_joint_stats *stats = r->stats;
    stats->error = error->fitted;
    stats->psnr_fitted = joint_psnr(&r->rows, error->fitted);
    stats->psnr_linear = joint_psnr(&r->rows, error->linear);
    stats->psnr_srgb = joint_psnr(&r->rows, error->srgb);
    stats->gpu_bytes = solution->sbrdf ? joint_bytes(r->rows.data, &r->shape)
                                       : bytes_of(r, solution->effects, solution->n_components);
    for (size_t i = 0; i < r->rows.texels * r->rows.views && solution->shift; i++)
        stats->moved += solution->shift[2 * i] != 0 || solution->shift[2 * i + 1] != 0;
}

btf_result enc_joint(const enc_context *context, const enc_data *data, const enc_joint_options *options,
                     enc_solution *out_solution, enc_joint_stats *out_stats) {
    run r = {.options = options,
             .preset = presets[options->preset],
             .budget = options->budget ? options->budget : joint_default_budget(data),
             .stats = calloc(1, sizeof *r.stats)};
    joint_error error = {0};
    btf_result result = BTF_OK;
    *out_solution = (enc_solution){0};
    if (!r.stats)
        return enc_fail(context, BTF_ERROR_MEMORY, "joint: out of memory");
    if (options->tolerance > 0.0)
        r.preset.tolerance = options->tolerance;
    enc_stage_begin(context, "joint",
                    (size_t)(r.preset.start + r.preset.shapes * r.preset.trial + r.preset.rounds));
    result = joint_rows_init(context, data, options->metric != ENC_JOINT_LINEAR, &r.rows);
    r.enough =
        exp10(-0.1 * enough_psnr) * (double)r.rows.texels * (double)r.rows.views * (double)r.rows.row;
    if (result == BTF_OK)
        result = options->effects & BTF_EFFECT_RESIDUAL ? solve(&r, out_solution, &error)
                                                        : solve_without_residual(&r, out_solution, &error);
    enc_stage_end(context);
    if (result == BTF_OK) {
        fill_stats(&r, out_solution, &error);
        if (out_stats)
            *out_stats = *r.stats;
    }
    if (result != BTF_OK)
        enc_solution_clear(out_solution);
    joint_fit_clear(&r.plain);
    joint_fit_clear(&r.best);
    joint_rows_clear(&r.rows);
    free(r.energy);
    free(r.stats);
    return result;
}
