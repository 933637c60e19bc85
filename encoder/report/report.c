/* The report of an encode. See report.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "report.h"

#include "encoder/base/stage.h"
#include "encoder/data/level_filter.h"
#include "encoder/model/decode_samples.h"
#include "decoder/toolkit/between.h"
#include "decoder/toolkit/cli.h"
#include "decoder/toolkit/output.h"
#include "metrics.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const struct {
    btf_effect effect;
    const char *name;
} effect_names[] = {{BTF_EFFECT_SHADOW, "shadow"},     {BTF_EFFECT_SHIFT, "shift"},
                    {BTF_EFFECT_HIDDEN, "hidden"},     {BTF_EFFECT_GAIN, "gain"},
                    {BTF_EFFECT_RESIDUAL, "residual"}, {BTF_EFFECT_RELIEF, "relief"},
                    {BTF_EFFECT_GLOSS, "gloss"}};
enum { EFFECT_COUNT = sizeof effect_names / sizeof effect_names[0] };

size_t enc_report_gpu_bytes(const btf_material_info *info, uint32_t effects) {
    btf_material_info reduced = *info;
    reduced.effects &= effects;
    const size_t texels = (size_t)info->width * info->height;
    size_t bytes = 0;
    for (int id = 0; id < BTF_TEXTURE_COUNT; id++) {
        if (id == BTF_TEXTURE_RESIDUAL_SCALES || id == BTF_TEXTURE_FACTOR_SCALES ||
            id == BTF_TEXTURE_FACTOR_VIEWS) {
            continue; /* tables */
        }
        if (id == BTF_TEXTURE_MAPS && info->layout == BTF_LAYOUT_PAPER &&
            reduced.effects != info->effects) {
            bytes += reduced.effects & BTF_EFFECT_SHADOW ? texels * info->n_lights : 0;
            bytes += reduced.effects & (BTF_EFFECT_GAIN | BTF_EFFECT_HIDDEN) ? texels * info->n_views : 0;
            bytes +=
                reduced.effects & (BTF_EFFECT_SHIFT | BTF_EFFECT_HIDDEN) ? 2 * texels * info->n_views : 0;
            bytes += reduced.effects & BTF_EFFECT_HIDDEN ? (size_t)3 * info->centres * info->n_lights : 0;
        } else {
            bytes += btf_material_texture_shape(&reduced, (btf_texture_id)id).size;
        }
    }
    return bytes;
}

size_t enc_report_gpu_bytes_part(const btf_material_info *info, uint32_t effects, uint32_t components) {
    btf_material_info part = *info;
    part.components = components;
    if (info->store == BTF_STORE_FACTORS) {
        enc_store_truncate(info->factor_classes, components, part.factor_classes);
    }
    return enc_report_gpu_bytes(&part, effects);
}

static btf_result measure(const enc_context *context, const enc_data *data,
                          const enc_sample_decoder *decoder, const btf_material_info *info,
                          const char *name, uint32_t effects, bool with_ssim, enc_report_step *step) {
    const enc_decoded_samples decoded = {.decoder = decoder, .effects = effects};
    step->name = name;
    step->effects = effects;
    step->gpu_bytes = enc_report_gpu_bytes(info, effects);
    return enc_metrics_compare(context, data, enc_data_images(data), enc_decoded_images(&decoded),
                               with_ssim, &step->metrics);
}

btf_result enc_report_measure(const enc_context *context, const enc_data *data,
                              const enc_solution *solution, const btf_material *material,
                              enc_report *report) {
    btf_material_info info = {.struct_size = sizeof info};
    btf_result result = btf_material_get_info(material, &info);
    enc_sample_decoder *decoder = NULL;
    if (result == BTF_OK) {
        result = enc_sample_decoder_create(context, data, solution, &decoder);
    }
    uint32_t ladder[3], subset = 0;
    const char *names[3] = {"sbrdf", "stvs", "full"};
    int steps = 0, left_out = 0;
    if (solution->sbrdf) {
        ladder[steps++] = 0;
        ladder[steps++] = info.effects & BTF_EFFECT_SHADOW;
    } else {
        names[0] = "full";
    }
    ladder[steps++] = info.effects;
    for (int i = 0; i < EFFECT_COUNT; i++) {
        left_out += (info.effects & effect_names[i].effect) != 0;
    }
    enc_stage_begin(context, "measure", (size_t)data->n_views * (size_t)(steps + left_out));
    for (int i = 0; result == BTF_OK && i < steps; i++) {
        result = measure(context, data, decoder, &info, names[i], ladder[i], true, &report->ladder[i]);
        report->n_ladder = i + 1;
    }
    for (int i = 0; result == BTF_OK && i < EFFECT_COUNT; i++) {
        if (info.effects & effect_names[i].effect) {
            subset = info.effects & ~(uint32_t)effect_names[i].effect;
            result = measure(context, data, decoder, &info, effect_names[i].name, subset, false,
                             &report->without[report->n_without]);
            report->n_without++;
        }
    }
    enc_stage_end(context);
    enc_sample_decoder_destroy(&decoder);
    return result;
}

static btf_material_error error_row(const enc_report_step *step) {
    return (btf_material_error){.effects = step->effects,
                                .psnr_linear = (float)enc_psnr_linear(&step->metrics.total),
                                .psnr_srgb = (float)enc_psnr_srgb(&step->metrics.total),
                                .gpu_bytes = (float)step->gpu_bytes};
}

size_t enc_report_errors(const enc_report *report, btf_material_error *rows) {
    size_t count = 0;
    for (int i = 0; i < report->n_ladder; i++) {
        rows[count++] = error_row(&report->ladder[i]);
    }
    for (int i = 0; i < report->n_without; i++) {
        bool known = false;
        for (size_t j = 0; j < count; j++) {
            known = known || rows[j].effects == report->without[i].effects;
        }
        if (!known) {
            rows[count++] = error_row(&report->without[i]);
        }
    }
    return count;
}

btf_result enc_report_measure_levels(const enc_context *context, const enc_data *data,
                                     const enc_levels *levels, const btf_material *material,
                                     enc_report *report) {
    const enc_metrics *full = &report->ladder[report->n_ladder - 1].metrics;
    btf_material_info info = {.struct_size = sizeof info};
    btf_result result = btf_material_get_info(material, &info);
    if (result != BTF_OK || levels->count < 2) {
        return result;
    }
    enc_metrics *metrics = calloc((size_t)levels->count - 1, sizeof *metrics);
    result = metrics ? enc_levels_measure(context, data, levels, metrics)
                     : enc_fail(context, BTF_ERROR_MEMORY, "levels: out of memory");
    for (int i = 0; result == BTF_OK && i < levels->count; i++) {
        const enc_metrics *m = i > 0 ? &metrics[i - 1] : full;
        report->level[i] = (enc_report_level){.width = enc_level_side(data->width, i),
                                              .height = enc_level_side(data->height, i),
                                              .gpu_bytes = btf_level_bytes(&info, (uint32_t)i),
                                              .psnr_linear = enc_psnr_linear(&m->total),
                                              .psnr_srgb = enc_psnr_srgb(&m->total)};
        report->n_levels = i + 1;
    }
    free(metrics);
    return result;
}

size_t enc_report_level_errors(const enc_report *report, btf_level_error *rows) {
    for (int i = 0; i < report->n_levels; i++) {
        rows[i] = (btf_level_error){.level = (uint32_t)i,
                                    .psnr_linear = (float)report->level[i].psnr_linear,
                                    .psnr_srgb = (float)report->level[i].psnr_srgb,
                                    .gpu_bytes = (float)report->level[i].gpu_bytes};
    }
    return (size_t)report->n_levels;
}

/* Bytes of levels 1 and up. */
static size_t further_bytes(const enc_report *report) {
    size_t bytes = 0;
    for (int i = 1; i < report->n_levels; i++) {
        bytes += report->level[i].gpu_bytes;
    }
    return bytes;
}

/* Bytes of the data as 8-bit RGB images, as table 2 counts them. */
static double data_bytes(const enc_data *data) {
    return (double)enc_data_texel_count(data) * 3 * data->n_views * data->n_lights;
}

static void print_rings(FILE *out, const char *what, int rings, const double *theta,
                        const enc_report *report, bool lights) {
    fprintf(out, "  %-20s", what);
    for (int r = 0; r < rings; r++) {
        fprintf(out, " %11.4g", theta[r]);
    }
    fprintf(out, "\n");
    for (int i = 0; i < report->n_ladder; i++) {
        const enc_metrics *m = &report->ladder[i].metrics;
        fprintf(out, "  %-20s", report->ladder[i].name);
        for (int r = 0; r < rings; r++) {
            const enc_error_sum *sum = lights ? &m->light_ring[r] : &m->view_ring[r];
            fprintf(out, " %5.2f/%5.2f", enc_psnr_linear(sum), enc_psnr_srgb(sum));
        }
        fprintf(out, "\n");
    }
}

/* Samples whose light was, or would have been, in the way of the camera. */
static void print_coincident(const enc_report *report, FILE *out) {
    for (int i = 0; i < report->n_ladder; i++) {
        const enc_error_sum *sum = &report->ladder[i].metrics.coincident;
        if (sum->count > 0) {
            fprintf(out, "%s%s %.2f/%.2f%s", i == 0 ? "  light at the view: " : ", ",
                    report->ladder[i].name, enc_psnr_linear(sum), enc_psnr_srgb(sum),
                    i + 1 == report->n_ladder ? "\n" : "");
        }
    }
}

static void print_levels(const enc_report *report, FILE *out) {
    if (report->n_levels < 2) {
        return;
    }
    fprintf(out, "\n"
                 "Levels of detail, PSNR in dB of each against the area-filtered original\n");
    fprintf(out, "  %-8s %12s %10s %8s %8s\n", "level", "texels", "MB", "linear", "sRGB");
    for (int i = 0; i < report->n_levels; i++) {
        const enc_report_level *level = &report->level[i];
        char size[32];
        snprintf(size, sizeof size, "%d x %d", level->width, level->height);
        fprintf(out, "  %-8d %12s %10.3f %8.2f %8.2f\n", i, size, (double)level->gpu_bytes / 1e6,
                level->psnr_linear, level->psnr_srgb);
    }
}

/* Units, or components, of the residual. */
static const char *part_name(const btf_material_info *info) {
    return info->store == BTF_STORE_FACTORS ? "units" : "components";
}

static void print_truncations(const enc_report *report, const btf_material_info *info, FILE *out) {
    if (report->n_truncations < 2) {
        return;
    }
    fprintf(
        out,
        "\n"
        "Only the first %s of the residual decoded, at some samples, and between samples against the data\n"
        "interpolated there (PSNR in dB, linear / sRGB)\n"
        "  %-12s %10s %16s %16s\n",
        part_name(info), part_name(info), "MB", "samples", "between");
    for (size_t i = 0; i < report->n_truncations; i++) {
        const enc_truncation *t = &report->truncations[i];
        fprintf(out, "  %-12u %10.3f    %5.2f / %5.2f    %5.2f / %5.2f\n", t->components,
                t->gpu_bytes / 1e6, enc_psnr_linear(&t->samples), enc_psnr_srgb(&t->samples),
                enc_psnr_linear(&t->between), enc_psnr_srgb(&t->between));
    }
}

/* Textures of all levels, and how many bytes each takes for a texel of level 0. */
static void print_parts(const enc_report *report, const btf_material_info *info, FILE *out) {
    const double texels = (double)enc_data_texel_count(report->data);
    fprintf(
        out,
        "\nBytes by texture (tables of directions and scales are not part of the sum)\n  %-24s %10s %14s\n",
        "", "MB", "bytes a texel");
    for (int id = 0; id < BTF_TEXTURE_COUNT; id++) {
        double bytes = 0;
        for (uint32_t level = 0; level < info->levels; level++) {
            bytes += (double)btf_material_level_texture(report->material, level, (btf_texture_id)id).size;
        }
        if (bytes > 0) {
            fprintf(out, "  %-24s %10.3f %14.1f\n", btf_texture_name((btf_texture_id)id), bytes / 1e6,
                    bytes / texels);
        }
    }
    fprintf(out, "  %-24s %10.3f %14.1f\n", "sum", (double)info->gpu_bytes / 1e6,
            (double)info->gpu_bytes / texels);
}

/* Prints how much of a budget was left, and why. */
static void print_unspent(const enc_unspent *u, FILE *out) {
    if (u->budget == 0) {
        return;
    }
    fprintf(out,
            "\n"
            "Budget: %.3f of %.3f MB is used. ",
            (double)u->bytes / 1e6, (double)u->budget / 1e6);
    if (u->gain > 0) {
        fprintf(out,
                "At samples left out of the fit, a tenth more bytes gains less than %g dB,\n"
                "the whole budget %.2f dB. ",
                u->tolerance, u->gain);
    } else {
        fprintf(out, "No further unit of factors fits and gains.\n");
    }
    fprintf(out, "Components found to be signal, not noise:");
    for (int c = 0; c < 3; c++) {
        fprintf(out, "%s %" PRIu64 "%s", c > 0 ? "," : "", u->signal[c], u->ends[c] ? "" : " or more");
    }
    fprintf(out, " of Y, C1 and C2\n");
}

/* The traffic between ranks, as rank 0 counted it. */
static void print_volumes(const enc_report *report, FILE *out) {
    enc_ranks_volume all = {0};
    if (report->n_volumes == 0) {
        return;
    }
    fprintf(out,
            "\n"
            "%d ranks; traffic of rank 0 (MB = 10^6 bytes; seconds)\n",
            report->ranks);
    fprintf(out, "  %-20s %10s %10s %9s %9s %9s\n", "", "received", "sent", "meetings", "waited", "moved");
    for (size_t i = 0; i <= report->n_volumes; i++) {
        const enc_ranks_volume *v = i < report->n_volumes ? &report->volumes[i] : &all;
        fprintf(out, "  %-20s %10.2f %10.2f %9llu %9.2f %9.2f\n",
                i < report->n_volumes ? v->stage : "total", (double)v->received / 1e6,
                (double)v->sent / 1e6, (unsigned long long)v->meetings, v->waited, v->moved);
        all.received += v->received;
        all.sent += v->sent;
        all.meetings += v->meetings;
        all.waited += v->waited;
        all.moved += v->moved;
    }
}

/* Mean squared errors of the whole material at the samples. */
static enc_fit_error measured_at_samples(const enc_report *report) {
    const enc_error_sum *sum = &report->ladder[report->n_ladder - 1].metrics.total;
    const double count = fmax(sum->count, 1);
    return (enc_fit_error){sum->linear / count, sum->srgb / count};
}

/* An effect that changes nothing at the samples, and what it is worth between them where that is estimated. */
static void print_between_effect(const enc_report_step *without, const enc_report *report, FILE *out) {
    const enc_left_out_errors *e = &report->between.error[ENC_LEFT_VIEW];
    fprintf(out, "  %-28s acts between the samples only", without->name);
    if (strcmp(without->name, "relief") == 0 && e->no_relief.count > 0) {
        fprintf(out, ": removes %.2f/%.2f dB where views are left out",
                enc_psnr_linear(&e->material) - enc_psnr_linear(&e->no_relief),
                enc_psnr_srgb(&e->material) - enc_psnr_srgb(&e->no_relief));
    }
    fprintf(out, "\n");
}

void enc_report_print(const enc_report *report, FILE *out) {
    const enc_data *data = report->data;
    const enc_metrics *first = &report->ladder[0].metrics;
    const enc_report_step *full = &report->ladder[report->n_ladder - 1];
    const double all = data_bytes(data);
    btf_material_info info = {.struct_size = sizeof info};
    btf_material_get_info(report->material, &info);
    fprintf(out, "\n%s: %d x %d texels, %d views, %d lights; method %s\n", report->input, data->width,
            data->height, data->n_views, data->n_lights, report->method);
    if (report->has_hidden) {
        fprintf(out, "\nTable 1. Hidden surface points (paper, table 1)\n");
        fprintf(out, "  %-24s %12s %12s\n", "", "not hidden", "hidden");
        fprintf(out, "  %-24s %12zu %12zu\n", "before refinement",
                report->hidden_total - report->hidden_before, report->hidden_before);
        fprintf(out, "  %-24s %12zu %12zu\n", "after refinement",
                report->hidden_total - report->hidden_after, report->hidden_after);
    }
    fprintf(out, "\nTable 2. Storage on the GPU (paper, table 2; MB = 10^6 bytes)\n");
    fprintf(out, "  %-24s %10s %12s\n", "", "MB", "ratio");
    fprintf(out, "  %-24s %10.3f %11.2f%%\n", "BTF", all / 1e6, 0.0);
    for (int i = 0; i < report->n_ladder; i++) {
        const double bytes = (double)report->ladder[i].gpu_bytes;
        fprintf(out, "  %-24s %10.3f %11.2f%%\n", report->ladder[i].name, bytes / 1e6,
                100 * (1 - bytes / all));
    }
    if (report->n_levels > 1) {
        const double further = (double)further_bytes(report), bytes = (double)full->gpu_bytes + further;
        fprintf(out, "  %-24s %10.3f\n", "levels 1 and up", further / 1e6);
        fprintf(out, "  %-24s %10.3f %11.2f%%\n", "full, all levels", bytes / 1e6, 100 * (1 - bytes / all));
    }
    fprintf(out, "  %-24s %10.3f %11.2f%%\n", "material file", (double)report->file_bytes / 1e6,
            100 * (1 - (double)report->file_bytes / all));
    print_parts(report, &info, out);
    print_unspent(&report->unspent, out);
    fprintf(out, "\nAccuracy over all samples, clipped to [0, 1] (PSNR in dB, linear and sRGB-coded)\n");
    fprintf(out, "  %-20s %8s %8s %8s\n", "", "linear", "sRGB", "SSIM");
    for (int i = 0; i < report->n_ladder; i++) {
        const enc_metrics *m = &report->ladder[i].metrics;
        fprintf(out, "  %-20s %8.2f %8.2f %8.4f\n", report->ladder[i].name, enc_psnr_linear(&m->total),
                enc_psnr_srgb(&m->total), m->ssim);
    }
    for (int i = 0; i < report->n_without; i++) {
        const enc_metrics *m = &report->without[i].metrics;
        if ((report->without[i].effects ^ full->effects) & BETWEEN_EFFECTS) {
            print_between_effect(&report->without[i], report, out);
            continue;
        }
        fprintf(out, "  without %-12s %8.2f %8.2f   (%s removes %.2f/%.2f dB)\n", report->without[i].name,
                enc_psnr_linear(&m->total), enc_psnr_srgb(&m->total), report->without[i].name,
                enc_psnr_linear(&full->metrics.total) - enc_psnr_linear(&m->total),
                enc_psnr_srgb(&full->metrics.total) - enc_psnr_srgb(&m->total));
    }
    fprintf(out, "\n");
    print_rings(out, "by view theta", first->n_view_rings, first->view_ring_theta, report, false);
    fprintf(out, "\n");
    print_rings(out, "by light theta", first->n_light_rings, first->light_ring_theta, report, true);
    print_coincident(report, out);
    print_truncations(report, &info, out);
    fprintf(out, "\n");
    enc_leave_one_out_print(&report->between, out);
    if (report->fit) {
        enc_fit_print(report->fit, measured_at_samples(report), out);
    }
    if (report->relief) {
        enc_relief_print(report->relief, out);
    }
    print_levels(report, out);
    print_volumes(report, out);
    fprintf(out, "\nSeconds:");
    size_t count = 0;
    const progress_stage *stages = progress_stages(report->progress, &count);
    for (size_t i = 0; i < count; i++) {
        fprintf(out, " %s %.1f,", stages[i].name, stages[i].seconds);
    }
    fprintf(out, " total %.1f. Peak memory %.0f MB.\n\n", report->seconds_total,
            (double)report->peak_rss / 1e6);
}

static void write_bytes(json *j, const enc_report *report, const btf_material_info *info) {
    json_object(j, "bytes");
    json_integer(j, "data", (int64_t)data_bytes(report->data));
    json_integer(j, "file", (int64_t)report->file_bytes);
    json_integer(j, "gpu", (int64_t)info->gpu_bytes);
    json_integer(j, "tables", (int64_t)info->table_bytes);
    json_integer(j, "levels", (int64_t)further_bytes(report));
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

/* Nothing for a residual that has but one part, or none. */
static void write_truncations(json *j, const enc_report *report, const btf_material_info *info) {
    if (report->n_truncations < 2) {
        return;
    }
    json_array(j, "truncations");
    for (size_t i = 0; i < report->n_truncations; i++) {
        const enc_truncation *t = &report->truncations[i];
        json_object(j, NULL);
        json_integer(j, part_name(info), t->components);
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

/* Nothing for a material of one level. */
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
        json_bool(j, "between_samples", between); /* where the two removed values say nothing */
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
    json_number(&j, "ratio", 1 - (double)info.gpu_bytes / data_bytes(report->data));
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
    enc_fit_json(&j, "fit", report->fit, measured_at_samples(report));
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
