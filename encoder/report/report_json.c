/* A report as JSON. See report_json.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "report_json.h"

#include "decoder/toolkit/between.h"
#include "decoder/toolkit/cli.h"
#include "decoder/toolkit/output.h"

#include <string.h>

static void write_bytes(json *j, const enc_report *report, const btf_material_info *info) {
    json_object(j, "bytes");
    json_integer(j, "data", (int64_t)enc_report_data_bytes(report->data));
    json_integer(j, "file", (int64_t)report->file_bytes);
    json_integer(j, "gpu", (int64_t)info->gpu_bytes);
    json_integer(j, "tables", (int64_t)info->table_bytes);
    json_integer(j, "levels", (int64_t)enc_report_further_bytes(report));
    json_object(j, "parts");
    for (int id = 0; id < BTF_TEXTURE_COUNT; id++) {
        const btf_texture texture = btf_material_texture(report->material, (btf_texture_id)id);
        if (texture.format != BTF_FORMAT_NONE) {
            json_integer(j, btf_texture_name((btf_texture_id)id), (int64_t)texture.size);
        }
    }
    json_end(j);
    json_number(j, "a_texel", (double)info->gpu_bytes / (double)enc_data_texel_count(report->data));
    json_end(j);
}

/* Writes nothing for a residual of one component or unit, or none. */
static void write_truncations(json *j, const enc_report *report, const btf_material_info *info) {
    if (report->n_truncations < 2) {
        return;
    }
    json_array(j, "truncations");
    for (size_t i = 0; i < report->n_truncations; i++) {
        const enc_truncation *t = &report->truncations[i];
        json_object(j, NULL);
        json_integer(j, enc_report_part_name(info), t->components);
        json_integer(j, "gpu", (int64_t)t->gpu_bytes);
        json_number(j, "linear", enc_psnr_linear(&t->samples));
        json_number(j, "srgb", enc_psnr_srgb(&t->samples));
        json_number(j, "between_linear", enc_psnr_linear(&t->between));
        json_number(j, "between_srgb", enc_psnr_srgb(&t->between));
        json_end(j);
    }
    json_end(j);
}

static void write_seconds(json *j, const enc_report *report) {
    json_object(j, "seconds");
    json_number(j, "total", report->seconds_total);
    size_t count = 0;
    const progress_stage *stages = progress_stages(report->progress, &count);
    for (size_t i = 0; i < count; i++) {
        json_number(j, stages[i].name, stages[i].seconds);
    }
    json_end(j);
    json_object(j, "core_seconds");
    json_number(j, "total", report->core_total);
    for (size_t i = 0; i < count; i++) {
        json_number(j, stages[i].name, stages[i].core);
    }
    json_end(j);
    json_object(j, "predicted_core_seconds");
    for (size_t i = 0; i < report->n_parts; i++) {
        json_number(j, report->parts[i].stage, report->parts[i].cost);
    }
    json_end(j);
}

static void write_volumes(json *j, const enc_report *report) {
    json_integer(j, "ranks", report->ranks);
    if (report->n_volumes == 0) {
        return;
    }
    json_object(j, "between_ranks");
    for (size_t i = 0; i < report->n_volumes; i++) {
        const enc_ranks_volume *v = &report->volumes[i];
        json_object(j, v->stage);
        json_integer(j, "received", (int64_t)v->received);
        json_integer(j, "sent", (int64_t)v->sent);
        json_integer(j, "meetings", (int64_t)v->meetings);
        json_number(j, "waited", v->waited);
        json_number(j, "moved", v->moved);
        json_end(j);
    }
    json_end(j);
}

/* Writes nothing for a material of one level. */
static void write_levels(json *j, const enc_report *report) {
    if (report->n_levels < 2) {
        return;
    }
    json_array(j, "levels");
    for (int i = 0; i < report->n_levels; i++) {
        json_object(j, NULL);
        json_integer(j, "width", report->level[i].width);
        json_integer(j, "height", report->level[i].height);
        json_integer(j, "gpu", (int64_t)report->level[i].gpu_bytes);
        json_number(j, "linear", report->level[i].psnr_linear);
        json_number(j, "srgb", report->level[i].psnr_srgb);
        json_end(j);
    }
    json_end(j);
}

static void write_effects(json *j, const enc_report *report) {
    const enc_error_sum *full = &report->ladder[report->n_ladder - 1].metrics.total;
    json_object(j, "effects");
    for (int i = 0; i < report->n_without; i++) {
        const enc_error_sum *sum = &report->without[i].metrics.total;
        const bool between =
            (report->without[i].effects ^ report->ladder[report->n_ladder - 1].effects) & BETWEEN_EFFECTS;
        json_object(j, report->without[i].name);
        json_bool(j, "between_samples", between); /* it acts there alone, and the two values below say
                                                     nothing */
        json_number(j, "removes_linear", enc_psnr_linear(full) - enc_psnr_linear(sum));
        json_number(j, "removes_srgb", enc_psnr_srgb(full) - enc_psnr_srgb(sum));
        json_end(j);
    }
    json_end(j);
}

/* Writes the choices of effects that were tried, and the result of each. */
static void write_trials(json *j, const enc_report *report) {
    char text[64];
    json_array(j, "trials");
    for (int i = 0; i < report->n_trials; i++) {
        const enc_trial *trial = &report->trials[i];
        json_object(j, NULL);
        json_string(j, "effects", cli_effects_text(trial->effects, text));
        json_integer(j, "lobes", trial->lobes);
        json_string(j, "colour", trial->lobes == 0 ? "none" : trial->rgb ? "rgb" : "mono");
        json_integer(j, "components", trial->components);
        json_integer(j, "centres", trial->centres);
        json_integer(j, "gpu", (int64_t)trial->gpu_bytes);
        json_number(j, "psnr", trial->psnr);
        json_number(j, "core_seconds", trial->core_seconds);
        json_string(j, "verdict", trial->verdict);
        json_end(j);
    }
    json_end(j);
}

static void write_unspent(json *j, const enc_unspent *u) {
    if (u->budget == 0) {
        json_null(j, "unspent");
        return;
    }
    json_object(j, "unspent");
    json_integer(j, "budget", (int64_t)u->budget);
    json_integer(j, "pays", (int64_t)u->bytes);
    json_number(j, "more", u->more);
    json_number(j, "tolerance", u->tolerance);
    json_number(j, "gain", u->gain);
    json_array(j, "signal");
    for (int c = 0; c < 3; c++) {
        json_integer(j, NULL, (int64_t)u->signal[c]);
    }
    json_end(j);
    json_bool(j, "noise_beyond", u->ends[0] || u->ends[1] || u->ends[2]);
    json_end(j);
}

btf_result enc_report_write(const enc_context *context, const enc_report *report,
                            const char *const *options, const char *path) {
    btf_material_info info = {.struct_size = sizeof info};
    btf_material_get_info(report->material, &info);
    json j = {0};
    json_object(&j, NULL);
    json_string(&j, "input", report->input);
    json_string(&j, "output", report->output);
    json_string(&j, "method", report->method);
    json_integer(&j, "width", report->data->width);
    json_integer(&j, "height", report->data->height);
    json_integer(&j, "views", report->data->n_views);
    json_integer(&j, "lights", report->data->n_lights);
    write_bytes(&j, report, &info);
    json_number(&j, "ratio", 1 - (double)info.gpu_bytes / enc_report_data_bytes(report->data));
    write_seconds(&j, report);
    json_integer(&j, "peak_rss", (int64_t)report->peak_rss);
    write_volumes(&j, report);
    json_object(&j, "psnr");
    static const char *const steps[] = {"sbrdf", "stvs", "full"};
    for (int s = 0; s < 3; s++) {
        const enc_report_step *found = NULL;
        for (int i = 0; i < report->n_ladder; i++) {
            found = strcmp(report->ladder[i].name, steps[s]) == 0 ? &report->ladder[i] : found;
        }
        if (found) {
            enc_metrics_json(&j, steps[s], &found->metrics, true);
        } else {
            json_null(&j, steps[s]);
        }
    }
    json_end(&j);
    if (report->has_hidden) {
        json_object(&j, "hidden");
        json_integer(&j, "before", (int64_t)report->hidden_before);
        json_integer(&j, "after", (int64_t)report->hidden_after);
        json_integer(&j, "total", (int64_t)report->hidden_total);
        json_end(&j);
    } else {
        json_null(&j, "hidden");
    }
    enc_leave_one_out_json(&j, "between", &report->between);
    enc_fit_json(&j, "fit", report->fit, enc_report_at_samples(report));
    enc_relief_json(&j, "relief", report->relief);
    write_truncations(&j, report, &info);
    write_effects(&j, report);
    write_unspent(&j, &report->unspent);
    write_trials(&j, report);
    write_levels(&j, report);
    enc_messages_json(&j, "reading", &report->reading);
    json_object(&j, "options");
    for (int i = 0; options && options[i]; i += 2) {
        json_string(&j, options[i], options[i + 1]);
    }
    json_end(&j);
    json_end(&j);
    const char *text = json_text(&j);
    btf_result result = text ? BTF_OK : enc_fail(context, BTF_ERROR_MEMORY, "%s: out of memory", path);
    output *file = NULL;
    if (result == BTF_OK) {
        result = output_open(path, context->log, &file);
    }
    if (result == BTF_OK) {
        fputs(text, output_stream(file));
        result = output_commit(&file);
    }
    json_free(&j);
    return result;
}
