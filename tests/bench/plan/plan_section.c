/* Section `plan`: what decoding only what a scene calls for saves, and whether it was predicted.
 *
 * SPDX-License-Identifier: MIT
 */
#include "tests/bench/bench.h"
#include "tests/bench/decode/decode_rig.h"
#include "tests/bench/encodes.h"
#include "plan_scenes.h"
#include "rig_fold.h"

#include "decoder/toolkit/cli.h"
#include <math.h>
#include <unistd.h>

enum { LEVELS = 4, ROUNDS = 7, WAYS = 3 };

static const float tolerance = 0.5f;

static const char *const fold_names[] = {"none", "light", "both"};

/* Where rows go: the whole figures, the README's table. */
typedef struct outputs {
    FILE *csv, *readme;
} outputs;

/* Nanoseconds a pixel of the plan, of everything and of the plan folded, the medians of rounds in which
 * they take turns. */
static void measure_times(decode_rig *rig, const btf_material *material, const btf_material *small,
                          const btf_plan *plan, int rounds, double out_ns[WAYS]) {
    const btf_shader_options everything = {.struct_size = sizeof everything};
    double ns[WAYS][ROUNDS];
    btf_gl_fold *fold = NULL;
    rig_variant way[WAYS] = {
        rig_variant_create(rig, small, &plan->shader, gpu_evaluate_body, GPU_FIRST_UNIT),
        rig_variant_create(rig, material, &everything, gpu_evaluate_body,
                           GPU_FIRST_UNIT + BTF_TEXTURE_COUNT)};
    btf_shader_options folded = plan->shader;
    folded.fold = plan->fold;
    if (plan->fold != BTF_FOLD_NONE) {
        way[2] = rig_folded_create(rig, small, &folded, &fold);
    }
    for (int round = 0; round < rounds; round++) {
        for (int w = 0; w < WAYS; w++) {
            ns[w][round] =
                way[w].program ? rig_measure(rig, way[w].program, rig->inputs, RIG_SIDE, NULL) : 0;
        }
    }
    for (int w = 0; w < WAYS; w++) {
        double spread;
        out_ns[w] = bench_median(ns[w], rounds, &spread);
        rig_variant_destroy(rig, &way[w]);
    }
    btf_gl_fold_destroy(&fold);
}

/* The tightest of two bounds that a prediction keeps, of the worse of linear and sRGB-coded. */
static const char *kept(const double off[2]) {
    const double worst = fmax(fabs(off[0]), fabs(off[1]));
    return worst <= 0.5 ? "0.5 dB" : worst <= 10 * log10(1.25) ? "25 %" : "**neither**";
}

/* One scene of one material: a row of the tables. rig: NULL without a GL context, then times are 0. */
static btf_result measure_scene(const bench_run *run, decode_rig *rig, const char *method,
                                const plan_scene *scene, const btf_material *material, const outputs *to) {
    btf_plan plan;
    btf_material *small = NULL;
    double mse[2], full_mse[2], ns[WAYS] = {0};
    char words[48], decoded[120], level[24] = "", components[24] = "";
    btf_result result = btf_plan_effects(material, &scene->scene, tolerance, &plan);
    if (result == BTF_OK) {
        result = btf_material_restrict(material, &plan, &run->context->log, &small);
    }
    if (result == BTF_OK) {
        result = plan_measure(run->context, run->data, material, small, &plan, mse, full_mse);
    }
    if (result == BTF_OK && rig) {
        plan_arguments(&plan, run->data, RIG_SIDE, rig->inputs);
        measure_times(rig, material, small, &plan, run->quick ? 1 : ROUNDS, ns);
    }
    if (result != BTF_OK) {
        btf_material_close(&small);
        return result;
    }
    btf_material_info info = {.struct_size = sizeof info};
    btf_material_get_info(small, &info);
    const double off[2] = {(double)plan.psnr_linear - plan_psnr(mse[0]),
                           (double)plan.psnr_srgb - plan_psnr(mse[1])};
    const double bytes = (double)info.gpu_bytes / (double)plan.full_gpu_bytes,
                 predicted = (double)(plan.cost / plan.full_cost), time = ns[1] > 0 ? ns[0] / ns[1] : 0;
    cli_effects_text(plan.effects, words);
    if (plan.components) {
        snprintf(components, sizeof components, ", k %u", (unsigned)plan.components);
    }
    if (plan.level) {
        snprintf(level, sizeof level, ", level %u", (unsigned)plan.level);
    }
    snprintf(decoded, sizeof decoded, "%s%s%s%s%s%s", words, components, level,
             plan.shader.interpolation == BTF_INTERPOLATION_NEAREST ? ", nearest" : "",
             plan.shader.fixed & BTF_FIXED_VIEW ? ", view folded" : "",
             plan.shader.fixed & BTF_FIXED_LIGHT ? ", light folded" : "");
    char row[600], folded[100] = "-";
    const double predicted_folded = (double)(plan.folded_cost / plan.full_cost);
    if (plan.fold != BTF_FOLD_NONE) {
        snprintf(folded, sizeof folded, "%s, %.2f MB: %.0f ns, %.0f %% / %.0f %%, after %.2f Mpixels",
                 fold_names[plan.fold], 1e-6 * (double)plan.fold_bytes, ns[2], 100 * predicted_folded,
                 ns[1] > 0 ? 100 * ns[2] / ns[1] : 0, 1e-6 * plan.fold_pixels);
    }
    snprintf(row, sizeof row,
             "| %s: %s | %s | %.2f / %.2f | %.2f / %.2f | %.2f / %.2f | %+.2f / %+.2f, %s | %.2f of %.2f | "
             "%.0f of %.0f | %.0f %% / %.0f %% | %.0f %% / %.0f %% | %s |\n",
             method, scene->name, decoded, (double)plan.psnr_linear, (double)plan.psnr_srgb,
             plan_psnr(mse[0]), plan_psnr(mse[1]), plan_psnr(full_mse[0]), plan_psnr(full_mse[1]), off[0],
             off[1], kept(off), 1e-6 * (double)info.gpu_bytes, 1e-6 * (double)plan.full_gpu_bytes, ns[0],
             ns[1], 100 * predicted, 100 * time, 100 * (1 - bytes), 100 * (1 - time), folded);
    fputs(row, run->summary);
    fputs(row, to->readme);
    fprintf(to->csv,
            "%s,%s,\"%s\",%u,%u,%.3f,%.3f,%.3f,%.3f,%.3f,%.3f,%zu,%zu,%.1f,%.1f,%.3f,%.3f,%.3f,%.3f,%s,%zu,"
            "%.1f,%.3f,%.0f\n",
            method, scene->name, words, (unsigned)plan.components, (unsigned)plan.level,
            (double)plan.psnr_linear, (double)plan.psnr_srgb, plan_psnr(mse[0]), plan_psnr(mse[1]),
            plan_psnr(full_mse[0]), plan_psnr(full_mse[1]), info.gpu_bytes, plan.full_gpu_bytes, ns[0],
            ns[1], (double)plan.full_psnr_linear, (double)plan.full_psnr_srgb, predicted, time,
            fold_names[plan.fold], plan.fold_bytes, ns[2], predicted_folded, plan.fold_pixels);
    btf_material_close(&small);
    return BTF_OK;
}

/* A material of each method: joint (the first preset asked for, with levels of detail) and paper. */
static btf_result encode(const bench_run *run, bool joint, int preset, btf_material **out_material) {
    bench_encoded encoded;
    btf_result result = joint ? bench_encode_joint(run->context, run->data, preset, run->budget, &encoded)
                              : bench_encode_paper(run->context, run->data, &encoded);
    if (result != BTF_OK) {
        return result;
    }
    result = plan_pack(run->context, run->data, &encoded.solution,
                       joint ? BTF_LAYOUT_TIGHT : BTF_LAYOUT_PAPER, joint ? LEVELS : 1, out_material);
    bench_encoded_clear(&encoded);
    return result;
}

/* From the folder of kept materials where it is there, else encoded and kept. */
static btf_result make_material(const bench_run *run, bool joint, btf_material **out_material) {
    char path[4096];
    int preset = 0;
    while (preset + 1 < BENCH_PRESETS && !run->presets[preset]) {
        preset++;
    }
    if (!run->keep) {
        return encode(run, joint, preset, out_material);
    }
    if (joint) {
        snprintf(path, sizeof path, "%s/%s-joint-%s.btf.exr", run->keep, run->name,
                 bench_preset_names[preset]);
    } else {
        snprintf(path, sizeof path, "%s/%s-paper.btf.exr", run->keep, run->name);
    }
    if (access(path, F_OK) != 0) {
        const btf_result result = encode(run, joint, preset, out_material);
        return result == BTF_OK ? btf_material_save(*out_material, path, &run->context->log) : result;
    }
    btf_material_info info = {.struct_size = sizeof info};
    btf_result result = btf_material_open(path, &run->context->log, out_material);
    if (result == BTF_OK) {
        result = btf_material_get_info(*out_material, &info);
    }
    if (result == BTF_OK &&
        ((int)info.width != run->data->width || (int)info.height != run->data->height ||
         (int)info.n_views != run->data->n_views || (int)info.n_lights != run->data->n_lights)) {
        btf_material_close(out_material);
        result = enc_fail(run->context, BTF_ERROR_USAGE, "bench: %s is not of %s", path, run->source);
    }
    return result;
}

static void write_head(const char *device, FILE *file) {
    fprintf(file,
            "At most %.1f dB below the full decode; time on %s.\n\n"
            "| scene | decoded | dB predicted | measured | in full | off by, within | MB uploaded | ns a "
            "pixel | time predicted / measured | saves bytes / time | folded: time predicted / measured, "
            "pays |\n"
            "| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n",
            (double)tolerance, device);
}

btf_result bench_section_plan(const bench_run *run) {
    decode_rig rig;
    char why[300];
    outputs to = {0};
    btf_result result = bench_open(run, "plan", "csv", &to.csv);
    if (result == BTF_OK) {
        result = bench_open(run, "readme-plan", "md", &to.readme);
    }
    if (result != BTF_OK) {
        if (to.csv) {
            fclose(to.csv);
        }
        return result;
    }
    const bool drawn =
        rig_create(&context_devices[0], 1, &run->context->log, why, sizeof why, &rig) == BTF_OK;
    write_head(drawn ? gpu_name(rig.gpu) : "no device", run->summary);
    write_head(drawn ? gpu_name(rig.gpu) : "no device", to.readme);
    fprintf(to.csv, "method,scene,effects,components,level,predicted_linear,predicted_srgb,measured_linear,"
                    "measured_srgb,full_linear,full_srgb,bytes,full_bytes,ns,full_ns,predicted_full_linear,"
                    "predicted_full_srgb,predicted_time,measured_time,fold,fold_bytes,folded_ns,predicted_"
                    "folded_time,fold_pixels\n");
    for (int joint = 1; joint >= 0 && result == BTF_OK; joint--) {
        btf_material *material = NULL;
        result = make_material(run, joint, &material);
        for (int i = 0; i < PLAN_SCENES && result == BTF_OK; i++) {
            result = measure_scene(run, drawn ? &rig : NULL, joint ? "joint" : "paper", &plan_scenes[i],
                                   material, &to);
        }
        btf_material_close(&material);
    }
    fprintf(run->summary, "\n");
    fclose(to.csv);
    fclose(to.readme);
    if (drawn) {
        rig_destroy(&rig);
    }
    return result;
}
