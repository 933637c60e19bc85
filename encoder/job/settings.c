/* The settings of an encode as text. See settings.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "settings.h"

#include "decoder/toolkit/cli.h"
#include "encoder/factor/factor.h"

#include <assert.h>
#include <inttypes.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

const char *enc_method_name(enc_method method) {
    static const char *const names[ENC_METHODS] = {"joint", "paper"};
    return names[method];
}

const char *enc_preset_name(enc_preset preset) {
    static const char *const names[ENC_PRESETS] = {"fast", "medium", "thorough", "exhaustive"};
    return names[preset];
}

/* Rounds of descent of each preset. */
static const int preset_sweeps[ENC_PRESETS] = {0, ENC_FACTOR_SWEEPS, 2 * ENC_FACTOR_SWEEPS,
                                               4 * ENC_FACTOR_SWEEPS};

enc_joint_options enc_joint_options_default(void) {
    return (enc_joint_options){.preset = ENC_PRESET_MEDIUM,
                               .effects = BTF_EFFECT_RESIDUAL,
                               .choose = true,
                               .tolerance = 0.05};
}

/* The default budget is at most this times the root of the number of texels. Layout `paper` takes a
 * constant number of bytes a texel, and encoding time grows with texels times bytes; but components are
 * shared by all texels, so that larger materials need fewer bytes a texel. Chosen so that 64x64 texels with 81
 * directions keep the 2.36 MB of layout `paper`, and 256x256 take 16 MB and, by the cost model, 6 minutes. */
static const double side_bytes = 62500;

uint64_t enc_default_budget(int width, int height, int n_views, int n_lights) {
    const uint64_t texels = (uint64_t)width * (uint64_t)height,
                   tiles = (uint64_t)(n_views > n_lights ? n_views : n_lights);
    const btf_material_info info = {.struct_size = sizeof info,
                                    .width = (uint32_t)width,
                                    .height = (uint32_t)height,
                                    .n_views = (uint32_t)n_views,
                                    .n_lights = (uint32_t)n_lights,
                                    .layout = BTF_LAYOUT_PAPER,
                                    .lobes = 3,
                                    .effects = BTF_EFFECT_SHADOW | BTF_EFFECT_SHIFT | BTF_EFFECT_HIDDEN};
    uint32_t columns, rows, room;
    const bool has_atlas = btf_material_atlas(&info, &columns, &rows, &room) == BTF_OK;
    const uint64_t paper =
        64 * texels + (has_atlas ? 4 * (uint64_t)columns * rows : 32 * texels * tiles / 5);
    const uint64_t most = (uint64_t)(side_bytes * sqrt((double)texels));
    const uint64_t budget = paper < most ? paper : most;
    const uint64_t least = enc_factor_least_budget(width, height, n_views, n_lights);
    return budget > least ? budget : least;
}

enc_factors_settings enc_settings_of_factors(const enc_job *job, int width, int height, int n_views,
                                             int n_lights) {
    const enc_joint_options *joint = &job->joint;
    return (enc_factors_settings){
        .budget = joint->budget > 0 ? joint->budget : enc_default_budget(width, height, n_views, n_lights),
        .quality = joint->quality,
        .effects = joint->effects,
        .choose = joint->choose && joint->preset != ENC_PRESET_FAST, /* preset fast tries no effect */
        .tolerance = joint->tolerance,
        .sweeps = preset_sweeps[joint->preset]};
}

bool enc_settings_try_relief(const enc_job *job) {
    return job->method == ENC_METHOD_JOINT && (job->relief.relief || job->relief.gloss < 0);
}

const char *enc_parse_tolerance(const char *text, void *tolerance) {
    static const double most[2] = {100, 1e6};
    double value[2] = {0, 0};
    const int count = cli_parse_doubles(text, value, 2);
    if (count == 0 || !(value[0] >= 0 && value[0] <= most[0] && value[1] >= 0 && value[1] <= most[1])) {
        return "one or two numbers of dB, 0 to 100 and 0 to 1e6 a MB, such as 0.1 or 0.05,0.2";
    }
    memcpy(tolerance, value, sizeof value);
    return NULL;
}

const char *enc_parse_levels(const char *text, void *levels) {
    int n = 0;
    if (strcmp(text, "all") != 0 && (!cli_parse_int(text, "", &n, NULL) || n < 1 || n > BTF_MAX_LEVELS)) {
        return "a number from 1 to 15, or all";
    }
    *(int *)levels = n;
    return NULL;
}

static void describe(enc_option_values *values, const char *name, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
static void describe(enc_option_values *values, const char *name, const char *format, ...) {
    va_list arguments;
    assert(values->count < sizeof values->text / sizeof values->text[0]);
    char *text = values->text[values->count];
    va_start(arguments, format);
    vsnprintf(text, sizeof values->text[0], format, arguments);
    va_end(arguments);
    values->list[2 * values->count] = name;
    values->list[2 * values->count + 1] = text;
    values->list[2 * ++values->count] = NULL;
}

static const char *yes_no(bool value) {
    return value ? "yes" : "no";
}

static void describe_input(enc_option_values *values, const enc_read_options *read) {
    if (read->transfer == ENC_TRANSFER_GAMMA) {
        describe(values, "transfer", "gamma:%g", read->gamma);
    } else {
        describe(values, "transfer", "%s",
                 read->transfer == ENC_TRANSFER_SRGB     ? "srgb"
                 : read->transfer == ENC_TRANSFER_LINEAR ? "linear"
                                                         : "default");
    }
    describe(values, "colour", "%s", read->colour == ENC_COLOUR_XYZ ? "xyz" : "rgb");
    if (read->layer) {
        describe(values, "layer", "%s", read->layer);
    }
    if (read->size[0] > 0) {
        describe(values, "size", "%dx%d", read->size[0], read->size[1]);
    }
    if (read->crop[2] > 0) {
        describe(values, "crop", "%d,%d,%d,%d", read->crop[0], read->crop[1], read->crop[2], read->crop[3]);
    }
    if (read->flip_v || read->azimuth_cw || read->azimuth_offset != 0) {
        describe(values, "flip-v", "%s", yes_no(read->flip_v));
        describe(values, "azimuth-cw", "%s", yes_no(read->azimuth_cw));
        describe(values, "azimuth-offset", "%g", read->azimuth_offset);
    }
}

static void describe_effects(enc_option_values *values, bool choose, uint32_t effects) {
    char text[48];
    describe(values, "effects", "%s", choose ? "auto" : cli_effects_text(effects, text));
}

static void describe_levels(enc_option_values *values, int levels) {
    if (levels == 0) {
        describe(values, "levels", "all");
    } else {
        describe(values, "levels", "%d", levels);
    }
}

static void describe_paper(enc_option_values *values, const enc_job *job) {
    const enc_paper_options *paper = &job->paper;
    describe_effects(values, paper->choose, paper->effects);
    if (paper->choose) {
        describe(values, "effect-tolerance", "%g,%g", paper->effect_tolerance,
                 paper->effect_tolerance_bytes);
    }
    describe(values, "layout", "%s", job->layout == BTF_LAYOUT_PAPER ? "paper" : "tight");
    describe(values, "half", "%s", yes_no(job->half_float));
    describe_levels(values, job->levels);
    describe(values, "lobes", "%d", paper->fit.lobes);
    describe(values, "rounds", "%d", paper->fit.rounds);
    describe(values, "starts", "%d", paper->fit.starts);
    describe(values, "error-threshold", "%g", (double)paper->fit.t_error);
    describe(values, "btf-threshold", "%g", (double)paper->fit.t_btf);
    if (paper->flow.lights > 0) {
        describe(values, "flow-lights", "%d", paper->flow.lights);
    } else {
        describe(values, "flow-lights", "all");
    }
    describe(values, "hidden-threshold", "%g", (double)paper->flow.hidden_threshold);
    if (paper->refine.columns > 0) {
        describe(values, "window", "%dx%d", paper->refine.columns, paper->refine.rows);
    } else {
        describe(values, "window", "default");
    }
    if (paper->centres > 0) {
        describe(values, "centres", "%u", paper->centres);
    }
    describe(values, "data-points", "%s", yes_no(paper->cluster.data_points));
}

static void describe_joint(enc_option_values *values, const enc_job *job) {
    const enc_joint_options *joint = &job->joint;
    describe_effects(values, joint->choose, joint->effects);
    describe_levels(values, job->levels);
    describe(values, "preset", "%s", enc_preset_name(joint->preset));
    if (joint->budget > 0) {
        describe(values, "budget", "%" PRIu64, joint->budget);
    }
    if (joint->quality > 0) {
        describe(values, "quality", "%g", joint->quality);
    }
    describe(values, "effect-tolerance", "%g", joint->tolerance);
    describe(values, "relief", "%s", job->relief.relief ? "auto" : "off");
    if (job->relief.gloss < 0) {
        describe(values, "gloss", "auto");
    } else {
        describe(values, "gloss", "%d", job->relief.gloss);
    }
}

void enc_settings_describe(const enc_job *job, enc_option_values *values) {
    values->count = 0;
    describe_input(values, &job->read);
    describe(values, "fit", "%s", job->fit == ENC_FIT_BETWEEN ? "between" : "samples");
    if (job->method == ENC_METHOD_PAPER) {
        describe_paper(values, job);
    } else {
        describe_joint(values, job);
    }
}
