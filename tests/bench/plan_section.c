/* Section `plan`: what decoding only what a scene calls for saves, and whether it was predicted.
 *
 * SPDX-License-Identifier: MIT
 */
#include "bench.h"
#include "decode_rig.h"
#include "encodes.h"
#include "plan_scenes.h"

#include "decoder/tools/cli.h"

enum { LEVELS = 4 };

static const float tolerance = 0.5f;

static const char body[] =
    "uvec4 check(uvec4 a, uvec4 b) {\n"
    "    vec2 uv = uintBitsToFloat(a.xy);\n"
    "    vec3 l = vec3(uintBitsToFloat(a.zw), uintBitsToFloat(b.x));\n"
    "    return uvec4(floatBitsToUint(btf_evaluate(uv, l, uintBitsToFloat(b.yzw))), 0u);\n"
    "}\n";

/* One scene of one material: a row of the table. rig: NULL without a GL context, then times are 0. */
static btf_result measure_scene(const bench_run *run, decode_rig *rig, const char *name,
                                const plan_scene *scene, const btf_material *material, FILE *csv) {
    btf_plan plan;
    btf_material *small = NULL;
    double planned[2], full[2], ns = 0, full_ns = 0;
    char words[48];
    btf_result result = btf_plan_effects(material, &scene->scene, tolerance, &plan);
    if (result == BTF_OK)
        result = btf_material_restrict(material, &plan, &run->context->log, &small);
    if (result == BTF_OK)
        result = plan_measure(run->context, run->data, material, small, &plan, planned, full);
    if (result != BTF_OK)
        return result;
    if (rig) {
        btf_shader_options shader = plan.shader, everything = {.struct_size = sizeof everything};
        shader.have_precise = everything.have_precise = rig->have_precise;
        plan_arguments(&plan, run->data, RIG_PIXELS, rig->inputs);
        full_ns = rig_measure_variant(rig, material, &everything, body, rig->inputs, NULL);
        ns = rig_measure_variant(rig, small, &shader, body, rig->inputs, NULL);
    }
    btf_material_info info = {.struct_size = sizeof info};
    btf_material_get_info(small, &info);
    fprintf(run->summary,
            "| %s, %s | %s, k %u, level %u | %.2f / %.2f | %.2f / %.2f | %.2f / %.2f | %.2f of %.2f | %.0f "
            "of %.0f |\n",
            name, scene->name, cli_effects_text(plan.effects, words), (unsigned)plan.components,
            (unsigned)plan.level, (double)plan.psnr_linear, (double)plan.psnr_srgb, plan_psnr(planned[0]),
            plan_psnr(planned[1]), plan_psnr(full[0]), plan_psnr(full[1]), 1e-6 * (double)info.gpu_bytes,
            1e-6 * (double)plan.full_gpu_bytes, ns, full_ns);
    fprintf(csv, "%s,%s,\"%s\",%u,%u,%.3f,%.3f,%.3f,%.3f,%.3f,%.3f,%zu,%zu,%.1f,%.1f\n", name, scene->name,
            words, (unsigned)plan.components, (unsigned)plan.level, (double)plan.psnr_linear,
            (double)plan.psnr_srgb, plan_psnr(planned[0]), plan_psnr(planned[1]), plan_psnr(full[0]),
            plan_psnr(full[1]), info.gpu_bytes, plan.full_gpu_bytes, ns, full_ns);
    btf_material_close(&small);
    return BTF_OK;
}

/* A material of each method: joint (the first preset asked for, with levels of detail) and paper. */
static btf_result make_material(const bench_run *run, bool joint, btf_material **out_material) {
    bench_encoded encoded;
    int preset = 0;
    while (preset + 1 < BENCH_PRESETS && !run->presets[preset])
        preset++;
    btf_result result = joint ? bench_encode_joint(run->context, run->data, preset, run->budget, &encoded)
                              : bench_encode_paper(run->context, run->data, &encoded);
    if (result != BTF_OK)
        return result;
    result = plan_pack(run->context, run->data, &encoded.solution,
                       joint ? BTF_LAYOUT_TIGHT : BTF_LAYOUT_PAPER, joint ? LEVELS : 1, out_material);
    bench_encoded_clear(&encoded);
    return result;
}

btf_result bench_section_plan(const bench_run *run) {
    decode_rig rig;
    char why[300];
    FILE *csv = NULL;
    btf_result result = bench_open(run, "plan", "csv", &csv);
    if (result != BTF_OK)
        return result;
    const bool drawn = rig_create(&context_devices[0],
                                  run->repeats > BENCH_DECODE_REPEATS ? run->repeats : BENCH_DECODE_REPEATS,
                                  &run->context->log, why, sizeof why, &rig) == BTF_OK;
    fprintf(run->summary,
            "At most %.1f dB below the full decode; PSNR in dB, linear / sRGB-coded, at random directions "
            "of the scene; "
            "time on %s.\n\n"
            "| scene | decoded | predicted | measured | in full | MB | ns a pixel |\n"
            "| --- | --- | --- | --- | --- | --- | --- |\n",
            (double)tolerance, drawn ? gpu_name(rig.gpu) : "no device");
    fprintf(csv, "method,scene,effects,components,level,predicted_linear,predicted_srgb,measured_linear,"
                 "measured_srgb,"
                 "full_linear,full_srgb,bytes,full_bytes,ns,full_ns\n");
    for (int joint = 1; joint >= 0 && result == BTF_OK; joint--) {
        btf_material *material = NULL;
        result = make_material(run, joint, &material);
        for (int i = 0; i < PLAN_SCENES && result == BTF_OK; i++)
            result = measure_scene(run, drawn ? &rig : NULL, joint ? "joint" : "paper", &plan_scenes[i],
                                   material, csv);
        btf_material_close(&material);
    }
    fprintf(run->summary, "\n");
    fclose(csv);
    if (drawn)
        rig_destroy(&rig);
    return result;
}
