/* Measurements of a report. See report.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "report.h"

#include "decoder/toolkit/between.h"
#include "encoder/base/stage.h"
#include "encoder/data/level_filter.h"
#include "encoder/model/decode_samples.h"
#include "metrics.h"

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
            continue; /* tables do not count */
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

/* Fills in the step without an effect that acts between the samples alone: at them the errors are those of the full decode. */
static void leave_out_between(const enc_report_step *full, const btf_material_info *info, const char *name,
                              uint32_t effects, enc_report_step *step) {
    *step = *full;
    step->name = name;
    step->effects = effects;
    step->gpu_bytes = enc_report_gpu_bytes(info, effects);
    step->metrics.ssim = 0;
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
        left_out += (info.effects & effect_names[i].effect & ~(uint32_t)BETWEEN_EFFECTS) != 0;
    }
    enc_stage_begin(context, "measure", (size_t)data->n_views * (size_t)(steps + left_out));
    for (int i = 0; result == BTF_OK && i < steps; i++) {
        result = measure(context, data, decoder, &info, names[i], ladder[i], true, &report->ladder[i]);
        report->n_ladder = i + 1;
    }
    for (int i = 0; result == BTF_OK && i < EFFECT_COUNT; i++) {
        if (info.effects & effect_names[i].effect) {
            subset = info.effects & ~(uint32_t)effect_names[i].effect;
            enc_report_step *without = &report->without[report->n_without++];
            if (effect_names[i].effect & BETWEEN_EFFECTS) {
                leave_out_between(&report->ladder[steps - 1], &info, effect_names[i].name, subset, without);
            } else {
                result = measure(context, data, decoder, &info, effect_names[i].name, subset, false, without);
            }
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

size_t enc_report_further_bytes(const enc_report *report) {
    size_t bytes = 0;
    for (int i = 1; i < report->n_levels; i++) {
        bytes += report->level[i].gpu_bytes;
    }
    return bytes;
}

double enc_report_data_bytes(const enc_data *data) {
    return (double)enc_data_texel_count(data) * 3 * data->n_views * data->n_lights;
}

const char *enc_report_part_name(const btf_material_info *info) {
    return info->store == BTF_STORE_FACTORS ? "units" : "components";
}

enc_fit_error enc_report_at_samples(const enc_report *report) {
    const enc_error_sum *sum = &report->ladder[report->n_ladder - 1].metrics.total;
    const double count = fmax(sum->count, 1);
    return (enc_fit_error){sum->linear / count, sum->srgb / count};
}
