/* One encode from end to end. See job.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "job.h"

#include "encoder/base/stage.h"
#include "encoder/data/extent.h"
#include "encoder/data/checkpoint.h"
#include "between.h"
#include "cost.h"
#include "decoder/toolkit/output.h"
#include "encoder/report/effect_errors.h"
#include "levels.h"
#include "memory.h"
#include "encoder/report/montage.h"
#include "encoder/model/pack.h"
#include "encoder/report/pictures.h"
#include "reflectance.h"
#include "encoder/model/decode_samples.h"
#include "encoder/model/preview.h"
#include "encoder/report/report_json.h"
#include "encoder/report/report_print.h"
#include "encoder/base/ranks.h"
#include "encoder/model/unpack.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

/* Checks, before the work, that a file can be made at the path. Does not open pipes and devices for
 * that. */
static btf_result try_output(const enc_context *context, const char *path) {
    struct stat there;
    output *file = NULL;
    if (stat(path, &there) == 0 && !S_ISREG(there.st_mode) && !S_ISDIR(there.st_mode)) {
        return BTF_OK;
    }
    const btf_result result = output_open(path, context->log, &file);
    output_abort(&file);
    return result;
}

/* Refuses an output that would replace an input or another output. */
static btf_result check_outputs(const enc_context *context, const enc_job *job) {
    const char *inputs[] = {job->input, job->read.coincident}, *outputs[] = {job->output, job->report};
    for (int o = 0; o < 2; o++) {
        for (int i = 0; i < 2; i++) {
            if (outputs[o] && inputs[i] && output_is_same(outputs[o], inputs[i])) {
                return enc_fail(context, BTF_ERROR_USAGE,
                                "%s: is an input, and the output would replace it", inputs[i]);
            }
        }
    }
    if (job->report && output_is_same(job->output, job->report)) {
        return enc_fail(context, BTF_ERROR_USAGE, "%s: is given for both --output and --report",
                        job->report);
    }
    return BTF_OK;
}

static btf_result prepare_outputs(const enc_context *context, const enc_job *job, bool *out_made_folder) {
    if (!enc_ranks_leads(context)) {
        return BTF_OK;
    }
    btf_result result = check_outputs(context, job);
    if (result == BTF_OK) {
        result = try_output(context, job->output);
    }
    if (result == BTF_OK && job->report) {
        result = try_output(context, job->report);
    }
    if (result == BTF_OK && job->pictures) {
        result = output_make_folder(job->pictures, context->log, out_made_folder);
    }
    return result;
}

/* Joins options to "name=value name=value" for the material's provenance; the caller frees it. */
static char *join_options(const char *const *values) {
    size_t length = 1;
    for (int i = 0; values[i]; i++) {
        length += strlen(values[i]) + 1;
    }
    char *text = malloc(length);
    if (text) {
        text[0] = 0;
        for (int i = 0; values[i]; i += 2) {
            strcat(strcat(strcat(strcat(text, i > 0 ? " " : ""), values[i]), "="), values[i + 1]);
        }
    }
    return text;
}

static const char *base_name(const char *path) {
    const char *slash = strrchr(path, '/');
    return slash && slash[1] ? slash + 1 : path;
}

/* The results of a job's stages while it runs. */
typedef struct job_state {
    enc_data *data;
    enc_between between; /* its relief store moves to `found` */
    char *provenance; /* options as given, and the choices that they left open */
    enc_solution found, stored; /* the model as the method found it, and as the packed material holds it */
    enc_levels found_levels, stored_levels;
    enc_occlusion *occlusion;
    btf_material *material;
    enc_checkpoint *checkpoint; /* NULL: none */
    char *options;
    enc_factors_stats joint;
    bool reflectance; /* a model of it is all that the material has, in the place of factors */
    enc_paper_stats paper;
    uint16_t *preview;
} job_state;

/* The values that methods analyse: the samples, or those fitted from them. */
static const enc_data *analysed(const job_state *s) {
    return s->between.fitted ? s->between.fitted : s->data;
}

/* Forgets what was made for factors, in whose place a reflectance model is. */
static btf_result drop_between(const enc_context *context, job_state *s, enc_report *report) {
    enc_between_clear(&s->between);
    report->relief = NULL;
    report->fit = NULL;
    report->unspent = (enc_unspent){0};
    free(s->provenance);
    if (asprintf(&s->provenance, "%s model=reflectance", s->options) < 0) {
        s->provenance = NULL;
        return enc_fail(context, BTF_ERROR_MEMORY, "out of memory");
    }
    return BTF_OK;
}

static btf_result analyse_joint(const enc_context *context, const enc_job *job, job_state *s,
                                  enc_report *report) {
    const enc_data *data = analysed(s);
    const enc_factors_settings settings =
        enc_settings_of_factors(job, data->width, data->height, data->n_views, data->n_lights);
    btf_result result = enc_factors_solve(context, data, &settings, &s->found, &s->joint);
    result = enc_ranks_agree(context, result);
    if (result == BTF_OK) {
        result = enc_reflectance_try(context, job, s->data, &s->found, &s->joint, &s->reflectance);
    }
    report->trials = s->joint.trials;
    report->n_trials = s->joint.trials_count;
    report->unspent = s->joint.unspent;
    return s->reflectance ? drop_between(context, s, report) : result;
}

static btf_result analyse_paper(const enc_context *context, const enc_job *job, job_state *s,
                                enc_report *report) {
    const enc_paper_stats *stats = &s->paper;
    const btf_result result =
        enc_paper(context, analysed(s), &job->paper, &s->found, &s->occlusion, &s->paper);
    report->has_hidden = stats->hidden_total > 0;
    report->hidden_before = stats->hidden_before;
    report->hidden_after = stats->hidden_after;
    report->hidden_total = stats->hidden_total;
    report->trials = stats->trials;
    report->n_trials = stats->trials_count;
    return result;
}

static btf_result analyse(const enc_context *context, const enc_job *job, job_state *s,
                          enc_report *report) {
    return job->method == ENC_METHOD_PAPER ? analyse_paper(context, job, s, report)
                                           : analyse_joint(context, job, s, report);
}

/* Refuses more levels than the data can have, which is known once they are read. */
static btf_result check_levels(const enc_context *context, const enc_job *job, const enc_data *data,
                               int *out_count) {
    const int most = enc_level_count(data->width, data->height);
    *out_count = job->levels > 0 ? job->levels : most;
    if (*out_count > most) {
        return enc_fail(context, BTF_ERROR_USAGE,
                        "option --levels: %d, but %d x %d texels have only %d levels, down to one texel",
                        job->levels, data->width, data->height, most);
    }
    return BTF_OK;
}

static btf_result analyse_levels(const enc_context *context, const enc_job *job, int count, job_state *s) {
    const bool factors = job->method == ENC_METHOD_JOINT && !s->reflectance;
    enc_paper_options paper = s->reflectance ? enc_reflectance_options() : job->paper;
    paper.fallback = s->paper.diffuse; /* as level 0 */
    return enc_levels_fit(context, s->data, count, factors ? NULL : &paper,
                          s->between.nodes.views ? &s->between.nodes : NULL, &s->found, &s->found_levels);
}

/* The table of errors between the samples: the numbers of btf_material_desc.between_errors. */
typedef struct between_table {
    float *numbers;
    size_t count;
} between_table;

/* Measures the levels of s->material, or level 0 alone for a file of version 1, into a table, which the
 * caller frees. *out_first: the measurement of level 0. */
static btf_result measure_between(const enc_context *context, const job_state *s, enc_leave_one_out *out_first,
                                  between_table *out) {
    btf_material_info info = {.struct_size = sizeof info};
    btf_material_get_info(s->material, &info);
    const int levels = info.version < 2 ? 1 : (int)info.levels;
    enc_leave_one_out *measured = calloc((size_t)levels, sizeof *measured);
    out->numbers = malloc((size_t)levels * ENC_BETWEEN_NUMBERS * sizeof *out->numbers);
    btf_result result = enc_ranks_agree(context, measured && out->numbers ? BTF_OK : BTF_ERROR_MEMORY);
    if (result == BTF_OK) {
        result = enc_leave_one_out_measure(context, s->data, s->material, levels, measured);
    }
    for (int level = 0; result == BTF_OK && level < levels; level++) {
        out->count += enc_leave_one_out_numbers(&measured[level], level, out->numbers + out->count);
    }
    if (result == BTF_OK) {
        *out_first = measured[0];
    }
    free(measured);
    return result;
}

/* Packs, measures what was packed, and packs again with the errors in the header. */
static btf_result pack_and_measure(const enc_context *context, const enc_job *job, job_state *s,
                                   enc_report *report) {
    btf_material_error rows[2 * ENC_REPORT_STEPS];
    enc_effect_tables effects = {0};
    between_table between = {0};
    enc_pack_options options = {.layout = job->layout,
                                .half_float = job->half_float,
                                .method = report->method,
                                .options = s->provenance ? s->provenance : s->options,
                                .source = base_name(job->input),
                                .levels = s->found_levels.count,
                                .level = s->found_levels.level};
    btf_level_error level_rows[BTF_MAX_LEVELS];
    enc_stage_begin(context, ENC_STAGE_PACK, 2);
    btf_result result = enc_pack(context, s->data, &s->found, &options, &s->material);
    enc_stage_step(context, 1);
    if (result == BTF_OK) {
        result = enc_unpack(context, s->material, &s->stored);
    }
    enc_stage_step(context, 1);
    enc_stage_end(context);
    if (result == BTF_OK) {
        result = enc_report_measure(context, s->data, &s->stored, s->material, report);
    }
    if (result == BTF_OK) {
        result = enc_effect_errors(context, s->data, s->material, &effects);
        report->n_truncations = result == BTF_OK ? enc_truncations(effects.errors, effects.error_count, s->data,
                                                                   s->stored.effects, report->truncations)
                                                 : 0;
    }
    if (result == BTF_OK) {
        result = measure_between(context, s, &report->between, &between);
    }
    if (result == BTF_OK) {
        result = enc_levels_unpack(context, s->material, &s->stored, &s->stored_levels);
    }
    if (result == BTF_OK) {
        result = enc_report_measure_levels(context, s->data, &s->stored_levels, s->material, report);
    }
    if (result == BTF_OK && s->stored.factors.units > 0) {
        result = enc_preview(context, s->data, &s->stored, &s->preview);
    }
    if (result == BTF_OK) {
        options.preview = s->preview;
        options.effect_errors = effects.errors;
        options.effect_error_count = effects.error_count;
        options.effect_differences = effects.differences;
        options.effect_difference_count = effects.difference_count;
        options.between_errors = between.numbers;
        options.between_error_count = between.count;
        options.errors = rows;
        options.error_count = enc_report_errors(report, rows);
        options.level_errors = level_rows;
        options.level_error_count = enc_report_level_errors(report, level_rows);
        btf_material_close(&s->material);
        result = enc_pack(context, s->data, &s->found, &options, &s->material);
    }
    enc_effect_tables_clear(&effects);
    free(between.numbers);
    report->material = s->material;
    return result;
}

static btf_result draw(const enc_context *context, const enc_job *job, job_state *s,
                       const enc_report *report) {
    char path[4096];
    enc_sample_decoder *decoder = NULL;
    enc_decoded_samples decoded[ENC_REPORT_STEPS];
    enc_montage_column columns[1 + ENC_REPORT_STEPS] = {
        {.title = "original", .images = enc_data_images(s->data)}};
    btf_result result = BTF_OK;
    if (snprintf(path, sizeof path, "%s/montage.png", job->pictures) >= (int)sizeof path) {
        result = enc_fail(context, BTF_ERROR_USAGE, "%s: the name is too long", job->pictures);
    }
    if (result == BTF_OK) {
        result = enc_sample_decoder_create(context, s->data, &s->stored, &decoder);
    }
    enc_stage_begin(context, "pictures", 2);
    for (int i = 0; result == BTF_OK && i < report->n_ladder; i++) {
        decoded[i] = (enc_decoded_samples){.decoder = decoder, .effects = report->ladder[i].effects};
        columns[1 + i] = (enc_montage_column){report->ladder[i].name, enc_decoded_images(&decoded[i])};
    }
    if (result == BTF_OK) {
        result = enc_montage_write(context, s->data, 1 + report->n_ladder, columns, path);
    }
    enc_stage_step(context, 1);
    if (result == BTF_OK) {
        const enc_pictures pictures = {.data = s->data,
                                       .solution = &s->stored,
                                       .decoder = decoder,
                                       .material = s->material,
                                       .occlusion = s->occlusion,
                                       .t_error =
                                           job->method == ENC_METHOD_PAPER ? job->paper.fit.t_error : 0,
                                       .t_btf = job->paper.fit.t_btf};
        result = enc_pictures_write(context, &pictures, job->pictures);
    }
    enc_stage_end(context);
    enc_sample_decoder_destroy(&decoder);
    return result;
}

/* Writes the outputs, which rank 0 does alone. */
static btf_result write_outputs(const enc_context *context, const enc_job *job, job_state *s,
                                enc_report *report) {
    btf_result result = job->pictures ? draw(context, job, s, report) : BTF_OK;
    if (result == BTF_OK && enc_cancelled(context)) {
        result = BTF_ERROR_INTERRUPTED;
    }
    if (result == BTF_OK) {
        enc_stage_begin(context, ENC_STAGE_SAVE, 0);
        result = btf_material_save(s->material, job->output, &context->log);
        enc_stage_end(context);
    }
    return result;
}

/* Writes the report, as a file and on standard output. */
static btf_result write_report(const enc_context *context, const enc_job *job, double start,
                               double core_start, enc_report *report) {
    struct stat file;
    struct rusage usage;
    btf_result result = BTF_OK;
    getrusage(RUSAGE_SELF, &usage);
    report->file_bytes = stat(job->output, &file) == 0 ? (size_t)file.st_size : 0;
    report->peak_rss = (size_t)usage.ru_maxrss * 1024;
    report->seconds_total = progress_clock() - start;
    report->core_total = progress_core_clock() - core_start;
    report->ranks = enc_ranks_count(context);
    report->volumes = enc_ranks_volumes(context, &report->n_volumes);
    if (job->report) {
        result = enc_report_write(context, report, job->option_values, job->report);
    }
    if (result == BTF_OK && !job->quiet) {
        enc_report_print(report, stdout);
    }
    return result;
}

static void clear_state(job_state *s) {
    btf_material_close(&s->material);
    enc_levels_clear(&s->stored_levels);
    enc_levels_clear(&s->found_levels);
    enc_solution_clear(&s->stored);
    enc_solution_clear(&s->found);
    enc_occlusion_destroy(&s->occlusion);
    enc_between_clear(&s->between);
    enc_data_destroy(&s->data);
    free(s->provenance);
    free(s->preview);
    free(s->options);
}

/* Where the plan of the stages is written once the extent of the data is known. */
typedef struct stage_planner {
    const enc_job *job;
    enc_report *report;
} stage_planner;

/* Refuses a budget whose factors do not fit --memory, since the reader has checked the default budget
 * only. */
static btf_result check_budget(const enc_context *context, const enc_job *job, const enc_extent *e) {
    if (job->method != ENC_METHOD_JOINT || context->memory == 0) {
        return BTF_OK;
    }
    const uint64_t budget =
        enc_settings_of_factors(job, e->width, e->height, e->n_views, e->n_lights).budget;
    const uint64_t least =
        enc_memory_of_factors(e->width, e->height, e->n_views, e->n_lights, context->threads, budget);
    return least <= context->memory
               ? BTF_OK
               : enc_fail(context, BTF_ERROR_USAGE,
                          "option memory: %zu bytes are too few: factors of %llu bytes for %dx%d texels, "
                          "%d views and %d lights take at least %lluK",
                          context->memory, (unsigned long long)budget, e->width, e->height, e->n_views,
                          e->n_lights, (unsigned long long)((least + 999) / 1000));
}

static btf_result plan_stages(void *user, const enc_context *context, const enc_extent *extent) {
    const stage_planner *planner = user;
    enc_report *report = planner->report;
    const btf_result enough = check_budget(context, planner->job, extent);
    if (enough != BTF_OK) {
        return enough;
    }
    report->n_parts = enc_cost_parts(context, planner->job, extent, report->parts);
    if (context->progress) {
        progress_plan(context->progress, report->parts, report->n_parts);
    }
    return BTF_OK;
}

/* Reads the input; the stages are planned as soon as its extent is known. */
static btf_result read_input(const enc_context *context, const enc_job *job, enc_report *report,
                             enc_data **out_data) {
    stage_planner planner = {job, report};
    const enc_extent_listener listener = {plan_stages, &planner};
    enc_context reading = *context;
    reading.listener = &listener;
    report->reading.next = context->log;
    reading.log = enc_messages_log(&report->reading);
    const btf_result result = enc_read(&reading, job->input, &job->read, out_data);
    report->data = *out_data;
    return result;
}

/* Finds the model of every level; the checkpoint, which stays open, keeps what the stages of level 0
 * find. */
static btf_result find_model(const enc_context *context, const enc_job *job, job_state *s,
                             enc_report *report) {
    int levels = 1;
    enc_context first_level = *context;
    btf_result result = check_levels(context, job, s->data, &levels);
    if (result == BTF_OK && job->checkpoint) {
        result =
            enc_checkpoint_open(context, job->checkpoint, s->options, s->data, job->resume, &s->checkpoint);
    }
    first_level.checkpoint = s->checkpoint;
    if (result == BTF_OK) {
        result = enc_between_find(context, job, s->data, s->checkpoint, &s->between);
    }
    if (result == BTF_OK) {
        report->relief = s->between.relief_judged ? &s->between.relief : NULL;
        report->fit = s->between.fit_judged ? &s->between.fit : NULL;
        result = enc_between_provenance(context, job, &s->between, s->options, &s->provenance);
    }
    if (result == BTF_OK) {
        result = analyse(&first_level, job, s, report);
    }
    if (result == BTF_OK) {
        s->found.effects |= s->between.store.effects;
        s->found.relief = s->between.store;
        s->between.store = (enc_relief_store){0};
    }
    enc_data_destroy(&s->between.fitted); /* levels are filtered from the samples, errors measured against them */
    if (result == BTF_OK && levels > 1) {
        result = analyse_levels(context, job, levels, s);
    }
    return result;
}

btf_result enc_job_run(const enc_context *caller, const enc_job *job) {
    const double start = progress_clock(), core_start = progress_core_clock();
    const bool leads = enc_ranks_leads(caller);
    bool made_folder = false;
    enc_context checked = *caller;
    checked.least_memory = enc_memory_least(job->method);
    const enc_context *context = &checked;
    enc_ranks_begin(context);
    job_state state = {.options = join_options(job->option_values)};
    enc_report report = {.input = job->input,
                         .output = job->output,
                         .method = enc_method_name(job->method),
                         .progress = context->progress};
    btf_result result = state.options ? prepare_outputs(context, job, &made_folder)
                                      : enc_fail(context, BTF_ERROR_MEMORY, "out of memory");
    result = enc_ranks_agree(context, result);
    if (result == BTF_OK) {
        result = read_input(context, job, &report, &state.data);
    }
    if (result == BTF_OK) {
        result = find_model(context, job, &state, &report);
    }
    if (result == BTF_OK) {
        result = pack_and_measure(context, job, &state, &report);
    }
    result = enc_ranks_agree(context, result); /* no rank writes outputs before all are done */
    if (result == BTF_OK && leads) {
        result = write_outputs(context, job, &state, &report);
    }
    if (result == BTF_OK) {
        enc_checkpoint_close(&state.checkpoint, true);
    }
    if (result == BTF_OK && leads) {
        result = write_report(context, job, start, core_start, &report);
    }
    result = enc_ranks_agree(context, result);
    if (result != BTF_OK && made_folder) {
        rmdir(job->pictures); /* removes it if nothing was drawn */
    }
    enc_checkpoint_close(&state.checkpoint, false);
    enc_messages_clear(&report.reading);
    clear_state(&state);
    return result;
}
