/* Our own methods as codecs. See encodes.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "encodes.h"

#include "encoder/factor/factor.h"
#include "encoder/model/pack.h"
#include "encoder/model/unpack.h"
#include "encoder/job/foresee.h"
#include "encoder/job/reflectance.h"
#include "encoder/relief/relief.h"

#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <time.h>

bench_clock bench_now(void) {
    struct timespec time;
    struct rusage use;
    clock_gettime(CLOCK_MONOTONIC, &time);
    getrusage(RUSAGE_SELF, &use);
    return (bench_clock){(double)time.tv_sec + 1e-9 * (double)time.tv_nsec,
                         (double)(use.ru_utime.tv_sec + use.ru_stime.tv_sec) +
                             1e-6 * (double)(use.ru_utime.tv_usec + use.ru_stime.tv_usec)};
}

/* Packs the solution, whose analysis began at `start`, unpacks it into *out and frees it. */
static btf_result store(const enc_context *context, const enc_data *data, enc_solution *found,
                        btf_layout layout, bool half, const char *method, bench_clock start,
                        bench_encoded *out) {
    const enc_pack_options options = {
        .layout = layout, .half_float = half, .method = method, .source = data->source};
    btf_result result = enc_pack(context, data, found, &options, &out->material);
    const bench_clock end = bench_now();
    enc_solution_clear(found);
    if (result == BTF_OK) {
        result = enc_unpack(context, out->material, &out->solution);
    }
    if (result == BTF_OK) {
        btf_material_info info = {.struct_size = sizeof info};
        btf_material_get_info(out->material, &info);
        out->bytes = info.gpu_bytes;
        out->wall = end.wall - start.wall;
        out->core = end.core - start.core;
    } else {
        bench_encoded_clear(out);
    }
    return result;
}

/* Adds relief, gloss and fitted nodes to a solution. Errors: BTF_ERROR_MEMORY. */
static btf_result add_relief(const enc_relief_store *relief, const enc_data *data, enc_solution *found) {
    const size_t texels = enc_data_texel_count(data), views = (size_t)data->n_views;
    enc_relief_store copy = *relief;
    copy.heights = relief->heights ? malloc(texels) : NULL;
    copy.views = relief->views ? malloc(views) : NULL;
    if ((relief->heights && !copy.heights) || (relief->views && !copy.views)) {
        enc_relief_clear(&copy);
        return BTF_ERROR_MEMORY;
    }
    if (copy.heights) {
        memcpy(copy.heights, relief->heights, texels);
    }
    if (copy.views) {
        memcpy(copy.views, relief->views, views);
    }
    found->effects |= relief->effects;
    found->relief = copy;
    return BTF_OK;
}

/* Encodes `data`, the samples or what was fitted to them; like btf-encode, by a reflectance alone where that does. */
static btf_result encode_joint(const enc_context *context, const enc_data *samples, const enc_data *data,
                               const enc_joint_options *options, const enc_relief_store *relief,
                               bench_encoded *out) {
    const bench_clock start = bench_now();
    const enc_job job = {.joint = *options};
    const enc_factors_settings settings =
        enc_settings_of_factors(&job, data->width, data->height, data->n_views, data->n_lights);
    enc_factors_stats stats;
    enc_solution found = {0};
    bool reflectance = false;
    *out = (bench_encoded){0};
    btf_result result = enc_factors_solve(context, data, &settings, &found, &stats);
    if (result == BTF_OK) {
        result = enc_reflectance_try(context, &job, samples, &found, &stats, &reflectance);
    }
    if (result == BTF_OK && relief && !reflectance) {
        result = add_relief(relief, data, &found);
    }
    if (result != BTF_OK) {
        enc_solution_clear(&found);
    }
    return result == BTF_OK ? store(context, data, &found, BTF_LAYOUT_TIGHT, false, "joint", start, out)
                            : result;
}

btf_result bench_encode_joint_options(const enc_context *context, const enc_data *data,
                                      const enc_joint_options *options, bench_encoded *out) {
    return encode_joint(context, data, data, options, NULL, out);
}

btf_result bench_encode_paper_options(const enc_context *context, const enc_data *data,
                                      const enc_paper_options *options, bool half, bench_encoded *out) {
    const bench_clock start = bench_now();
    enc_paper_stats stats;
    enc_solution found;
    *out = (bench_encoded){0};
    const btf_result result = enc_paper(context, data, options, &found, NULL, &stats);
    return result == BTF_OK ? store(context, data, &found, BTF_LAYOUT_PAPER, half, "paper", start, out)
                            : result;
}

static enc_joint_options joint_options(int preset, uint64_t budget) {
    enc_joint_options options = enc_joint_options_default();
    options.preset = (enc_preset)preset;
    options.budget = budget;
    return options;
}

btf_result bench_encode_joint(const enc_context *context, const enc_data *data, int preset, uint64_t budget,
                              bench_encoded *out) {
    const enc_joint_options options = joint_options(preset, budget);
    return bench_encode_joint_options(context, data, &options, out);
}

/* Computes the fitted values at the nodes, which follow the relief's surface. */
static btf_result apply_nodes(const enc_context *context, const enc_node_tables *nodes,
                              const enc_relief_store *relief, const enc_data *data, enc_data **out) {
    enc_warp surface = {0};
    const bool moves = relief && relief->effects & BTF_EFFECT_RELIEF;
    const enc_node_relief along = {&surface, moves ? relief->views : NULL};
    btf_result result =
        moves ? enc_relief_level(relief, data->width, data->height, 0, NULL, &surface) : BTF_OK;
    if (result == BTF_OK) {
        result = enc_node_apply(context, nodes, moves ? &along : NULL, data, out);
    }
    enc_warp_clear(&surface);
    return result;
}

btf_result bench_encode_joint_between(const enc_context *context, const enc_data *data, int preset,
                                      uint64_t budget, const enc_relief_store *relief, bench_encoded *out) {
    const bench_clock start = bench_now();
    enc_fit_choice choice;
    enc_node_tables nodes;
    enc_data *fitted = NULL;
    *out = (bench_encoded){0};
    enc_fit_error coder;
    const enc_job job = {.joint = joint_options(preset, budget)};
    const enc_factors_settings settings =
        enc_settings_of_factors(&job, data->width, data->height, data->n_views, data->n_lights);
    btf_result result = enc_foresee_error(context, data, &settings, &coder);
    if (result == BTF_OK) {
        result = enc_fit_choose(context, data, true, 0, &coder, &choice, &nodes);
    }
    if (result == BTF_OK && nodes.views) {
        result = apply_nodes(context, &nodes, relief, data, &fitted);
    }
    const bench_clock end = bench_now();
    if (result == BTF_OK) {
        result = encode_joint(context, data, fitted ? fitted : data, &job.joint, relief, out);
    }
    out->wall += end.wall - start.wall;
    out->core += end.core - start.core;
    enc_node_tables_clear(&nodes);
    enc_data_destroy(&fitted);
    return result;
}

btf_result bench_encode_paper(const enc_context *context, const enc_data *data, bench_encoded *out) {
    const enc_paper_options options = enc_paper_options_default();
    return bench_encode_paper_options(context, data, &options, false, out);
}

uint64_t bench_joint_least(const enc_data *data) {
    return enc_factor_least_budget(data->width, data->height, data->n_views, data->n_lights);
}

uint64_t bench_budget(uint64_t budget, const enc_data *data) {
    return budget > 0 ? budget
                      : enc_default_budget(data->width, data->height, data->n_views, data->n_lights);
}

void bench_encoded_clear(bench_encoded *encoded) {
    enc_solution_clear(&encoded->solution);
    btf_material_close(&encoded->material);
    *encoded = (bench_encoded){0};
}
