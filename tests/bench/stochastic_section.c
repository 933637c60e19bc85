/* Section `stochastic`: time and noise of decoding one picked neighbour in place of all, compared with the full decode;
 * and the difference between the full decode and the blend that the stochastic one converges to.
 *
 * SPDX-License-Identifier: MIT
 */
#include "bench.h"
#include "encodes.h"
#include "plots.h"
#include "tests/bench/decode/decode_rig.h"

#include "encoder/math/srgb.h"
#include "encoder/relief/relief.h"
#include "tests/conformance/random.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* The mean of bench_samples picks of a pixel. */
static const char body_picks[] =
    "uniform int bench_samples;\n"
    "uvec4 check(uvec4 a, uvec4 b) {\n"
    "    vec2 uv = uintBitsToFloat(a.xy);\n"
    "    vec3 l = vec3(uintBitsToFloat(a.zw), uintBitsToFloat(b.x)), v = uintBitsToFloat(b.yzw), sum = "
    "vec3(0.0);\n"
    "    int i = 0;\n"
    "    do {\n"
    "        sum += btf_evaluate_stochastic(uv, l, v, btf_random(uvec3(gl_FragCoord.xy, i)));\n"
    "    } while (++i < bench_samples);\n"
    "    return uvec4(floatBitsToUint(sum / float(i)), 0u);\n"
    "}\n";

/* The same of the geometric means of two picks, of one texel but where the filter blends roots. */
static const char body_products[] =
    "uniform int bench_samples;\n"
    "uvec4 check(uvec4 a, uvec4 b) {\n"
    "    vec2 uv = uintBitsToFloat(a.xy);\n"
    "    vec3 l = vec3(uintBitsToFloat(a.zw), uintBitsToFloat(b.x)), v = uintBitsToFloat(b.yzw), sum = "
    "vec3(0.0);\n"
    "    int i = 0;\n"
    "    do {\n"
    "        uvec3 random = btf_random(uvec3(gl_FragCoord.xy, i));\n"
    "        vec3 product = btf_evaluate_stochastic(uv, l, v, random);\n"
    "        uvec3 other = btf_random(uvec3(gl_FragCoord.xy, ~i));\n"
    "#if !BTF_RELIEF\n"
    "        other.z = random.z;\n"
    "#endif\n"
    "        sum += sqrt(product * btf_evaluate_stochastic(uv, l, v, other));\n"
    "    } while (++i < bench_samples);\n"
    "    return uvec4(floatBitsToUint(sum / float(i)), 0u);\n"
    "}\n";

static const char body_blend[] =
    "uvec4 check(uvec4 a, uvec4 b) {\n"
    "    vec2 uv = uintBitsToFloat(a.xy);\n"
    "    vec3 l = vec3(uintBitsToFloat(a.zw), uintBitsToFloat(b.x));\n"
    "    return uvec4(floatBitsToUint(btf_evaluate_radiance_blend(uv, l, uintBitsToFloat(b.yzw))), 0u);\n"
    "}\n";

enum { COUNTS = 4, WAYS = 5, ROUNDS = 5, VALUES = GPU_OUTPUTS * RIG_PIXELS, QUICK_ROWS = 32 };
static const int counts[COUNTS] = {1, 4, 16, 64};

static const struct {
    const char *name;
    btf_shader_options shader;
} ways[WAYS] = {
    {"full decode", {0}},
    {"view picked", {.picks = BTF_PICK_VIEW}},
    {"view and light picked", {.picks = BTF_PICK_LIGHT}},
    {"all picked", {.picks = BTF_PICK_ALL}},
    {"nearest directions", {.interpolation = BTF_INTERPOLATION_NEAREST}},
};

typedef struct section {
    const bench_run *run;
    decode_rig rig;
    btf_material *material;
    size_t pixels; /* pixels whose noise is measured: all of the rig, with --quick the rows in the middle */
    const uint32_t *inputs; /* of these */
    float *named[WAYS];     /* [pixels][GPU_OUTPUTS]: the image that a way converges to */
    double ns[WAYS], noise[WAYS][COUNTS], product_noise[COUNTS], product_ns, off;
} section;

/* Runs a shader over the inputs and writes its radiance to out. */
static btf_result decode(section *s, btf_shader_options shader, const char *body, size_t count,
                         const uint32_t *inputs, float *out) {
    shader.struct_size = sizeof shader;
    rig_variant variant = rig_variant_create(&s->rig, s->material, &shader, body, GPU_FIRST_UNIT);
    btf_result result =
        variant.program ? gpu_run(s->rig.gpu, variant.program, count, inputs, s->rig.outputs, s->rig.log)
                        : BTF_ERROR_INTERNAL;
    if (result == BTF_OK) {
        memcpy(out, s->rig.outputs, GPU_OUTPUTS * count * sizeof *out);
    }
    rig_variant_destroy(&s->rig, &variant);
    return result;
}

/* The root mean square of the difference over pixels and channels. */
static double distance(size_t pixels, const float *a, const float *b) {
    double sum = 0;
    for (size_t i = 0; i < GPU_OUTPUTS * pixels; i++) {
        const double d = (double)a[i] - (double)b[i];
        sum += i % GPU_OUTPUTS < 3 ? d * d : 0;
    }
    return sqrt(sum / (3.0 * (double)pixels));
}

static double mean_of(size_t pixels, const float *a) {
    double sum = 0;
    for (size_t i = 0; i < GPU_OUTPUTS * pixels; i++) {
        sum += i % GPU_OUTPUTS < 3 ? (double)a[i] : 0;
    }
    return sum / (3.0 * (double)pixels);
}

/* PSNR of values clipped to [0, 1], linear and sRGB-coded. */
static void psnr(const float *a, const float *b, double out[2]) {
    double sum[2] = {0, 0};
    for (size_t i = 0; i < VALUES; i++) {
        if (i % GPU_OUTPUTS == 3) {
            continue;
        }
        const float x = fminf(fmaxf(a[i], 0), 1), y = fminf(fmaxf(b[i], 0), 1);
        const double d = (double)x - (double)y, e = (double)enc_srgb_encode(x) - (double)enc_srgb_encode(y);
        sum[0] += d * d;
        sum[1] += e * e;
    }
    for (int i = 0; i < 2; i++) {
        out[i] = sum[i] > 0 ? -10 * log10(sum[i] / (3.0 * RIG_PIXELS)) : INFINITY;
    }
}

static btf_shader_options way_options(int way) {
    btf_shader_options shader = ways[way].shader;
    shader.filter = BTF_FILTER_BILINEAR;
    return shader;
}

/* Decodes the image that each way converges to: for a way that picks neighbours their blend, for another its own. */
static btf_result find_named(section *s) {
    btf_result result = BTF_OK;
    for (int w = 0; w < WAYS && result == BTF_OK; w++) {
        s->named[w] = calloc(VALUES, sizeof *s->named[w]);
        result = s->named[w]
                     ? decode(s, way_options(w), ways[w].shader.picks ? body_blend : gpu_evaluate_body,
                              s->pixels, s->inputs, s->named[w])
                     : BTF_ERROR_MEMORY;
    }
    return result;
}

/* Noise at each count of samples, against `truth`; the same random numbers must give the same noise again. */
static btf_result find_noise(section *s, int way, const char *body, const float *truth,
                             double out[COUNTS]) {
    btf_shader_options shader = way_options(way);
    shader.struct_size = sizeof shader;
    rig_variant variant = rig_variant_create(&s->rig, s->material, &shader, body, GPU_FIRST_UNIT);
    btf_result result = variant.program ? BTF_OK : BTF_ERROR_INTERNAL;
    for (int i = 0; i < COUNTS && result == BTF_OK; i++) {
        rig_sampler(&s->rig, variant.program, "bench_samples", counts[i]);
        result = gpu_run(s->rig.gpu, variant.program, s->pixels, s->inputs, s->rig.outputs, s->rig.log);
        out[i] = distance(s->pixels, (const float *)(const void *)s->rig.outputs, truth);
        if (body == body_products && i == COUNTS - 1) {
            const float *mean = (const float *)(const void *)s->rig.outputs;
            s->off = mean_of(s->pixels, mean) / mean_of(s->pixels, truth) - 1;
        }
    }
    if (result == BTF_OK) {
        rig_sampler(&s->rig, variant.program, "bench_samples", counts[0]);
        result = gpu_run(s->rig.gpu, variant.program, s->pixels, s->inputs, s->rig.outputs, s->rig.log);
    }
    if (result == BTF_OK &&
        distance(s->pixels, (const float *)(const void *)s->rig.outputs, truth) != out[0]) {
        result = enc_fail(s->run->context, BTF_ERROR_INTERNAL,
                          "bench: %s: another picture from the same random numbers", ways[way].name);
    }
    rig_variant_destroy(&s->rig, &variant);
    return result;
}

/* Times of all ways in turn, medians of the rounds; the last is of two picks a sample. */
static btf_result find_times(section *s) {
    double ns[WAYS + 1][ROUNDS];
    rig_variant variants[WAYS + 1];
    const int rounds = s->run->quick ? 1 : ROUNDS;
    btf_result result = BTF_OK;
    for (int w = 0; w <= WAYS; w++) {
        btf_shader_options shader = way_options(w < WAYS ? w : 3);
        shader.struct_size = sizeof shader;
        variants[w] = rig_variant_create(&s->rig, s->material, &shader,
                                         w == WAYS              ? body_products
                                         : ways[w].shader.picks ? body_picks
                                                                : gpu_evaluate_body,
                                         GPU_FIRST_UNIT + w * BTF_TEXTURE_COUNT);
        if (!variants[w].program) {
            result = BTF_ERROR_INTERNAL;
        } else if (w == WAYS || ways[w].shader.picks) {
            rig_sampler(&s->rig, variants[w].program, "bench_samples", 1);
        }
    }
    for (int round = 0; round < rounds && result == BTF_OK; round++) {
        for (int w = 0; w <= WAYS; w++) {
            ns[w][round] = rig_measure(&s->rig, variants[w].program, s->rig.inputs, RIG_SIDE, NULL);
        }
    }
    for (int w = 0; w <= WAYS; w++) {
        double spread;
        if (result == BTF_OK) {
            *(w < WAYS ? &s->ns[w] : &s->product_ns) = bench_median(ns[w], rounds, &spread);
        }
        rig_variant_destroy(&s->rig, &variants[w]);
    }
    return result;
}

static btf_result measure(section *s) {
    btf_result result = find_named(s);
    for (int w = 0; w < WAYS && result == BTF_OK; w++) {
        if (ways[w].shader.picks) {
            result = find_noise(s, w, body_picks, s->named[w], s->noise[w]);
        } else {
            s->noise[w][0] = distance(s->pixels, s->named[w], s->named[3]);
        }
    }
    if (result == BTF_OK) {
        result = find_noise(s, 3, body_products, s->named[0], s->product_noise);
    }
    return result == BTF_OK ? find_times(s) : result;
}

/* Writes time and noise of each way as a table, as CSV and as a plot. The noise of picks is measured against the blend
 * that they converge to, so that it does not count the blend's difference to the full decode. */
static btf_result write_rows(section *s, FILE *csv) {
    FILE *out = s->run->summary;
    fprintf(
        out,
        "%s; core ns a pixel, bilinear, the median of %d rounds in which all take turns. RMS of linear "
        "radiance "
        "(its mean is %.4f) at 1, 4, 16 and 64 samples a pixel, against the blend that the picks converge "
        "to; of "
        "the full decode and of nearest directions, how far these are from the blend of all.\n\n"
        "| decoded | ns | times faster | 1 | 4 | 16 | 64 |\n| --- | --- | --- | --- | --- | --- | --- |\n",
        gpu_name(s->rig.gpu), s->run->quick ? 1 : ROUNDS, mean_of(s->pixels, s->named[3]));
    fprintf(csv, "decoded,ns,rms_1,rms_4,rms_16,rms_64\n");
    for (int w = 0; w <= WAYS; w++) {
        const bool picks = w == WAYS || ways[w].shader.picks;
        const double *noise = w == WAYS ? s->product_noise : s->noise[w],
                     ns = w == WAYS ? s->product_ns : s->ns[w];
        const char *name =
            w == WAYS ? "geometric mean of two picks of all (against the full decode)" : ways[w].name;
        fprintf(out, "| %s | %.0f | %.2f | %.5f |", name, ns, s->ns[0] / ns, noise[0]);
        fprintf(csv, "%s,%.1f,%.6f", name, ns, noise[0]);
        for (int i = 1; i < COUNTS; i++) {
            fprintf(out, picks ? " %.5f |" : " |", noise[i]);
            fprintf(csv, picks ? ",%.6f" : ",", noise[i]);
        }
        fprintf(out, "\n");
        fprintf(csv, "\n");
    }
    const double samples = s->ns[0] / s->ns[3];
    fprintf(out,
            "\nIn the time of one full decode %.1f samples of all picked: RMS %.5f. Geometric means: the "
            "mean of all "
            "pixels is off by %+.3f %% of the full decode's.\n\n",
            samples, s->noise[3][0] / sqrt(samples), 100 * s->off);

    char title[200];
    snprintf(title, sizeof title, "Stochastic decode: time against error, %s", s->run->source);
    plot *p = plot_create(title, "core ns a pixel, all samples", 1);
    plot_panel(p, 0, "bilinear, on llvmpipe", "RMS error of linear radiance");
    plot_axes(p, true, true);
    for (int w = 0; w < WAYS; w++) {
        plot_series(p, ways[w].name, ways[w].shader.picks != BTF_PICK_NONE);
        for (int i = 0; i < (ways[w].shader.picks ? COUNTS : 1); i++) {
            char label[16];
            snprintf(label, sizeof label, "%d", counts[i]);
            if (s->noise[w][i] > 0) {
                plot_point(p, s->ns[w] * counts[i], &s->noise[w][i], ways[w].shader.picks ? label : NULL);
            }
        }
    }
    return bench_finish_plot(s->run, "stochastic", &p);
}

/* --- the blends that ways converge to, against the full decode --- */

/* The centre of a texel, moved by a little, because u * 2^18 is rounded down. */
static void put_probe(const section *s, size_t texel, const float *light, const float *view,
                      uint32_t *out) {
    const int width = s->run->data->width, height = s->run->data->height;
    const float u = ((float)(texel % (size_t)width) + 0.5f) / (float)width + 0x1p-18f;
    const float v = 1 - ((float)(texel / (size_t)width) + 0.5f) / (float)height + 0x1p-18f;
    const float f[GPU_INPUTS] = {u, v, light[0], light[1], light[2], view[0], view[1], view[2]};
    memcpy(out, f, sizeof f);
}

static void random_direction(random_state *r, float out[3]) {
    const double z = random_between(r, 0.2, 1), phi = random_between(r, 0, 2 * M_PI),
                 across = sqrt(1 - z * z);
    out[0] = (float)(across * cos(phi));
    out[1] = (float)(across * sin(phi));
    out[2] = (float)z;
}

enum { PROBES_AT, PROBES_BETWEEN, PROBES_TRUTH, PROBE_SETS };

/* Makes probes spread evenly over texels: at the samples, anywhere, or where the truth is known. */
static void make_probes(const section *s, int set, uint32_t *inputs, float *truth) {
    const enc_data *data = s->run->data;
    const size_t texels = (size_t)data->width * (size_t)data->height;
    random_state r = {(uint64_t)set + 1};
    for (size_t i = 0; i < RIG_PIXELS; i++) {
        const size_t texel = i * texels / RIG_PIXELS;
        float light[3], view[3];
        if (set == PROBES_TRUTH) {
            const bench_truth *known = s->run->truth;
            const size_t at = (size_t)(random_bits(&r) % known->count);
            memcpy(light, known->pair[at].light.xyz, sizeof light);
            memcpy(view, known->pair[at].view.xyz, sizeof view);
            memcpy(truth + GPU_OUTPUTS * i, known->images + 3 * (at * texels + texel), 3 * sizeof *truth);
        } else if (set == PROBES_AT) {
            memcpy(light, data->lights[random_below(&r, (uint32_t)data->n_lights)].xyz, sizeof light);
            memcpy(view, data->views[random_below(&r, (uint32_t)data->n_views)].xyz, sizeof view);
        } else {
            random_direction(&r, light);
            random_direction(&r, view);
        }
        put_probe(s, texel, light, view, inputs + GPU_INPUTS * i);
    }
}

static void print_psnr(FILE *out, const float *a, const float *b) {
    double db[2];
    psnr(a, b, db);
    if (isinf(db[0])) {
        fprintf(out, " equal |");
    } else {
        fprintf(out, " %.2f / %.2f |", db[0], db[1]);
    }
}

static btf_result compare_blends(section *s) {
    static const char *const names[] = {"full decode", "blend of views", "of views and lights"};
    FILE *out = s->run->summary;
    uint32_t *inputs = calloc(RIG_PIXELS, GPU_INPUTS * sizeof *inputs);
    float *full = calloc(VALUES, sizeof *full), *blend = calloc(VALUES, sizeof *blend),
          *truth = calloc(VALUES, sizeof *truth);
    btf_result result = inputs && full && blend && truth ? BTF_OK : BTF_ERROR_MEMORY;
    fprintf(out, "The blends that picks converge to, of whole texels: PSNR in dB, linear / sRGB-coded.\n\n"
                 "| decoded | against the full decode, at the samples | between them | against truth "
                 "between them |\n"
                 "| --- | --- | --- | --- |\n");
    for (int kind = 0; kind < 3 && result == BTF_OK; kind++) {
        fprintf(out, "| %s |", names[kind]);
        for (int set = 0; set < PROBE_SETS && result == BTF_OK; set++) {
            if (set == PROBES_TRUTH && s->run->truth->count == 0) {
                fprintf(out, " |");
                continue;
            }
            make_probes(s, set, inputs, truth);
            result = decode(s, (btf_shader_options){0}, gpu_evaluate_body, RIG_PIXELS, inputs, full);
            if (result == BTF_OK && kind > 0) {
                result = decode(s, (btf_shader_options){.picks = (btf_picks)kind}, body_blend, RIG_PIXELS,
                                inputs, blend);
            }
            print_psnr(out, kind > 0 ? blend : full, set == PROBES_TRUTH ? truth : full);
        }
        fprintf(out, "\n");
    }
    fprintf(out, "\n");
    free(inputs);
    free(full);
    free(blend);
    free(truth);
    return result;
}

/* A material of --method joint with btf-encode's default fit and the first preset asked for, taken from the folder of
 * kept materials if it is there. */
static btf_result make_material(const bench_run *run, btf_material **out_material) {
    char path[4096];
    int preset = 0;
    while (preset + 1 < BENCH_PRESETS && !run->presets[preset]) {
        preset++;
    }
    snprintf(path, sizeof path, "%s/%s-between-%s.btf.exr", run->keep ? run->keep : ".", run->name,
             bench_preset_names[preset]);
    if (run->keep && access(path, F_OK) == 0) {
        btf_material_info info = {.struct_size = sizeof info};
        btf_result opened = btf_material_open(path, &run->context->log, out_material);
        if (opened == BTF_OK) {
            opened = btf_material_get_info(*out_material, &info);
        }
        if (opened == BTF_OK &&
            ((int)info.width != run->data->width || (int)info.height != run->data->height ||
             (int)info.n_views != run->data->n_views || (int)info.n_lights != run->data->n_lights)) {
            btf_material_close(out_material);
            return enc_fail(run->context, BTF_ERROR_USAGE,
                            "bench: the material %s was not made from %s: texels or directions differ",
                            path, run->source);
        }
        return opened;
    }
    const enc_relief_options options = {.relief = true, .gloss = -1};
    enc_relief_choice choice;
    enc_relief_store relief = {0};
    bench_encoded encoded;
    btf_result result = enc_relief_choose(run->context, run->data, &options, &choice, &relief);
    if (result == BTF_OK) {
        result =
            bench_encode_joint_between(run->context, run->data, preset, run->budget, &relief, &encoded);
    }
    enc_relief_clear(&relief);
    if (result != BTF_OK) {
        return result;
    }
    *out_material = encoded.material;
    encoded.material = NULL;
    bench_encoded_clear(&encoded);
    return run->keep ? btf_material_save(*out_material, path, &run->context->log) : BTF_OK;
}

btf_result bench_section_stochastic(const bench_run *run) {
    section s = {.run = run};
    char why[300];
    FILE *csv = NULL;
    if (rig_create(&context_devices[0], 1, &run->context->log, why, sizeof why, &s.rig) != BTF_OK) {
        fprintf(run->summary, "No OpenGL context on this machine.\n\n");
        return BTF_OK;
    }
    const size_t rows = run->quick ? QUICK_ROWS : RIG_SIDE;
    s.pixels = rows * RIG_SIDE;
    s.inputs = s.rig.inputs + GPU_INPUTS * ((RIG_SIDE - rows) / 2 * RIG_SIDE);
    btf_result result = make_material(run, &s.material);
    if (result == BTF_OK) {
        result = measure(&s);
    }
    if (result == BTF_OK) {
        result = bench_open(run, "stochastic", "csv", &csv);
    }
    if (result == BTF_OK) {
        result = write_rows(&s, csv);
    }
    if (csv && fclose(csv) != 0 && result == BTF_OK) {
        result = enc_fail(run->context, BTF_ERROR_IO, "stochastic-%s.csv: cannot write", run->name);
    }
    if (result == BTF_OK) {
        result = compare_blends(&s);
    }
    for (int w = 0; w < WAYS; w++) {
        free(s.named[w]);
    }
    btf_material_close(&s.material);
    rig_destroy(&s.rig);
    return result;
}
