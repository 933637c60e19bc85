/* Section `plan`: the time and bytes that plans for scenes save, the accuracy that they lose, and whether the file
 * predicted these.
 *
 * SPDX-License-Identifier: MIT
 */
#include "tests/bench/bench.h"
#include "tests/bench/decode/decode_rig.h"
#include "tests/bench/encodes.h"
#include "plan_scenes.h"
#include "plan_truth.h"
#include "rig_fold.h"

#include "decoder/toolkit/cli.h"
#include <math.h>
#include <string.h>
#include <unistd.h>

enum { LEVELS = 4, ROUNDS = 3, WAYS = 3 };

static const float tolerance = 0.5f;

static const char *const fold_names[] = {"none", "light", "both", "neighbours"};

/* The outputs of rows: all figures, and the README's table. */
typedef struct outputs {
    FILE *csv, *readme;
} outputs;

/* Nanoseconds a pixel of the plan, of decoding everything, and of the folded plan: medians over rounds in which all
 * three are timed in turn. */
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

/* The findings of one scene. */
typedef struct found {
    btf_plan plan;
    size_t bytes;
    double mse[2], full_mse[2];     /* against the data, interpolated */
    double truth[2], full_truth[2]; /* against images between the samples */
    size_t images;                  /* 0: none are known there */
    double ns[WAYS];
    bool folded; /* shown by reading a fold */
} found;

/* The predicted loss in dB against the full decode where the scene looks, as the plan counts it: between the samples
 * where the file has these errors, relative to half of its estimate there; else against the data. */
static double predict_loss(float full_between, float between, float full, float planned) {
    if (full_between <= 0) {
        return (double)full - (double)planned;
    }
    const double of_full = pow(10, -(double)full_between / 10),
                 more = pow(10, -(double)between / 10) - of_full,
                 base = fmax(of_full / 2, pow(10, -(double)full / 10));
    return 10 * log10(1 + more / base);
}

/* The measured loss: against images between the samples; at other levels against the data. False where it is not
 * known. */
static bool measure_loss(const found *f, double out[2]) {
    for (int i = 0; i < 2; i++) {
        out[i] = f->images > 0 ? plan_psnr(f->full_truth[i]) - plan_psnr(f->truth[i])
                               : plan_psnr(f->full_mse[i]) - plan_psnr(f->mse[i]);
    }
    return f->images > 0 || f->plan.full_between_psnr_linear <= 0;
}

static btf_result find(const bench_run *run, decode_rig *rig, const plan_scene *scene,
                       const btf_material *material, found *f) {
    btf_material *small = NULL;
    btf_material_info info = {.struct_size = sizeof info};
    *f = (found){0};
    btf_result result = btf_plan_effects(material, &scene->scene, tolerance, &f->plan);
    if (result == BTF_OK) {
        result = btf_material_restrict(material, &f->plan, &run->context->log, &small);
    }
    if (result == BTF_OK) {
        result = plan_measure(run->context, run->data, material, small, &f->plan, f->mse, f->full_mse);
    }
    if (result == BTF_OK) {
        btf_material_get_info(small, &info);
        f->bytes = info.gpu_bytes;
        f->folded = f->plan.fold != BTF_FOLD_NONE && f->plan.folded_cost < f->plan.cost;
        f->images = plan_truth(run->truth, material, small, &f->plan, f->truth, f->full_truth);
    }
    if (result == BTF_OK && rig) {
        plan_arguments(&f->plan, run->data, RIG_SIDE, rig->inputs);
        measure_times(rig, material, small, &f->plan, run->quick ? 1 : ROUNDS, f->ns);
    }
    btf_material_close(&small);
    return result;
}

/* Writes in words which parts of the material a plan leaves out, and how it decodes the rest: "gain, 6 of 12 units, 62
 * views; light folded". */
static void tell_left_out(const btf_material *material, const found *f, char *out, size_t size) {
    btf_material_info info = {.struct_size = sizeof info};
    btf_material_get_info(material, &info);
    const btf_plan *p = &f->plan;
    const uint32_t effects = info.effects & ~p->effects;
    char words[48];
    const char *separator = "";
    size_t length = 0;
#define TELL(...)                                                                                          \
    do {                                                                                                   \
        length += (size_t)snprintf(out + length, length < size ? size - length : 0, "%s", separator);      \
        length += (size_t)snprintf(out + length, length < size ? size - length : 0, __VA_ARGS__);          \
        separator = ", ";                                                                                  \
    } while (0)
    out[0] = 0;
    if (effects) {
        TELL("%s", cli_effects_text(effects, words));
    }
    if (p->components < info.components && p->effects & BTF_EFFECT_RESIDUAL) {
        TELL("%u of %u %s", (unsigned)(info.components - p->components), (unsigned)info.components,
             info.store == BTF_STORE_FACTORS ? "units" : "components");
    }
    if (p->views < info.n_views) {
        TELL("%u views", (unsigned)(info.n_views - p->views));
    }
    if (p->lights < info.n_lights) {
        TELL("%u lights", (unsigned)(info.n_lights - p->lights));
    }
    if (p->level) {
        TELL("%u levels", (unsigned)p->level);
    }
    if (p->shader.interpolation == BTF_INTERPOLATION_NEAREST) {
        TELL("neighbouring directions");
    }
    if (!*separator) {
        TELL("nothing");
    }
    if (f->folded) {
        separator = "; ";
        TELL("folded: %s", fold_names[p->fold]);
    }
#undef TELL
}

static double of(double part, double whole) {
    return whole > 0 ? part / whole : 0;
}

/* A row of the tables. */
static void write_row(const bench_run *run, const char *method, const plan_scene *scene,
                      const btf_material *material, const found *f, const outputs *to) {
    const btf_plan *p = &f->plan;
    const double ns = f->ns[f->folded ? 2 : 0], time = of(ns, f->ns[1]),
                 predicted = (double)((f->folded ? p->folded_cost : p->cost) / p->full_cost);
    double lost[2];
    const double expected[2] = {
        predict_loss(p->full_between_psnr_linear, p->between_psnr_linear, p->full_psnr_linear,
                     p->psnr_linear),
        predict_loss(p->full_between_psnr_srgb, p->between_psnr_srgb, p->full_psnr_srgb, p->psnr_srgb)};
    char row[700], left_out[200], pays[40] = "", words[48], told[80] = "not known";
    tell_left_out(material, f, left_out, sizeof left_out);
    if (measure_loss(f, lost)) {
        snprintf(told, sizeof told, "%.2f / %.2f", lost[0], lost[1]);
    }
    if (f->images > 0) {
        snprintf(told + strlen(told), sizeof told - strlen(told), ", %zu images", f->images);
    }
    if (f->folded) {
        snprintf(pays, sizeof pays, ", after %.2f Mpixels", 1e-6 * p->fold_pixels);
    }
    snprintf(row, sizeof row,
             "| %s: %s | %s | %.2f / %.2f | %.2f / %.2f | %.2f / %.2f | %.2f / %.2f | %s | "
             "%.2f of %.2f | %.0f of %.0f%s | %.0f %% / %.0f %% | %.0f %% / %.0f %% |\n",
             method, scene->name, left_out, (double)p->psnr_linear, (double)p->psnr_srgb,
             plan_psnr(f->mse[0]), plan_psnr(f->mse[1]), plan_psnr(f->full_mse[0]),
             plan_psnr(f->full_mse[1]), expected[0], expected[1], told, 1e-6 * (double)f->bytes,
             1e-6 * (double)p->full_gpu_bytes, ns, f->ns[1], pays, 100 * predicted, 100 * time,
             100 * (1 - of((double)f->bytes, (double)p->full_gpu_bytes)), 100 * (1 - time));
    fputs(row, run->summary);
    fputs(row, to->readme);
    fprintf(to->csv,
            "%s,%s,\"%s\",%u,%u,%.3f,%.3f,%.3f,%.3f,%.3f,%.3f,%zu,%zu,%.1f,%.1f,%.3f,%.3f,%.3f,%.3f,%s,%zu,"
            "%.1f,%.3f,%.0f,%.3f,%.3f,%.3f,%.3f,%zu,%.3f,%.3f\n",
            method, scene->name, cli_effects_text(p->effects, words), (unsigned)p->components,
            (unsigned)p->level, (double)p->psnr_linear, (double)p->psnr_srgb, plan_psnr(f->mse[0]),
            plan_psnr(f->mse[1]), plan_psnr(f->full_mse[0]), plan_psnr(f->full_mse[1]), f->bytes,
            p->full_gpu_bytes, f->ns[0], f->ns[1], (double)p->full_psnr_linear, (double)p->full_psnr_srgb,
            (double)(p->cost / p->full_cost), of(f->ns[0], f->ns[1]), fold_names[p->fold], p->fold_bytes,
            f->ns[2], (double)(p->folded_cost / p->full_cost), p->fold_pixels, expected[0], expected[1],
            lost[0], lost[1], f->images, f->images > 0 ? plan_psnr(f->full_truth[0]) : 0,
            f->images > 0 ? plan_psnr(f->full_truth[1]) : 0);
}

/* Encodes the material of a method: joint (with the first preset asked for and levels of detail) or paper. */
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

/* Opens the material from the folder of kept materials, or encodes it and keeps it there. */
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
            "At most %.1f dB below the full decode where the scene looks; time on %s.\n\n"
            "| scene | left out | dB predicted | measured | in full | lost where it looks, predicted | "
            "measured | MB "
            "uploaded | ns a pixel | time predicted / measured | saves bytes / time |\n"
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
                    "folded_time,fold_pixels,predicted_loss_linear,predicted_loss_srgb,loss_linear,loss_"
                    "srgb,images,full_truth_linear,full_truth_srgb\n");
    for (int joint = 1; joint >= 0 && result == BTF_OK; joint--) {
        btf_material *material = NULL;
        if (!(run->methods & (joint ? BENCH_METHOD_JOINT : BENCH_METHOD_PAPER))) {
            continue;
        }
        result = make_material(run, joint, &material);
        for (int i = 0; i < PLAN_SCENES && result == BTF_OK; i++) {
            found f;
            result = find(run, drawn ? &rig : NULL, &plan_scenes[i], material, &f);
            if (result == BTF_OK) {
                write_row(run, joint ? "joint" : "paper", &plan_scenes[i], material, &f, &to);
            }
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
