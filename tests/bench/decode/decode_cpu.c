/* Decoding on one core, timed and compared. See decode_cpu.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "decode_cpu.h"

#include <openbtf/evaluate.h>

#include <stdlib.h>
#include <string.h>

enum { REFERENCE_PIXELS = 4096 };

/* The two decoders of the CPU, of the same bits. */
typedef struct cpu_decoder {
    const char *device;
    const decode_material *material;
    btf_evaluator *evaluator; /* NULL: the reference */
} cpu_decoder;

static void cpu_pixels(const cpu_decoder *c, const decode_row *row, const uint32_t *inputs, size_t count,
                       float *out) {
    const btf_ref_options options = {.effects = BTF_EFFECT_ALL,
                                     .components = UINT32_MAX,
                                     .interpolation = row->nearest ? BTF_REF_NEAREST : BTF_REF_LINEAR,
                                     .filter = (int)row->filter};
    const btf_evaluate_options many = {.struct_size = sizeof many,
                                       .interpolation = row->nearest ? BTF_INTERPOLATION_NEAREST
                                                                     : BTF_INTERPOLATION_LINEAR,
                                       .filter = row->filter};
    enum { CHUNK = 64 };
    for (size_t first = 0; first < count; first += CHUNK) {
        const size_t some = count - first < CHUNK ? count - first : CHUNK;
        float f[CHUNK][GPU_INPUTS];
        memcpy(f, inputs + GPU_INPUTS * first, some * sizeof *f);
        for (size_t i = 0; i < some && !c->evaluator; i++) {
            btf_ref_evaluate(&c->material->view, &options, f[i][0], f[i][1], f[i] + 2, f[i] + 5,
                             out + 3 * (first + i));
        }
        const btf_evaluations evaluations = {.struct_size = sizeof evaluations,
                                             .count = some,
                                             .uv = f[0],
                                             .lights = f[0] + 2,
                                             .views = f[0] + 5,
                                             .stride = GPU_INPUTS,
                                             .rgb = out + 3 * first};
        if (c->evaluator) {
            btf_evaluate_many(c->evaluator, &many, &evaluations);
        }
    }
}

static btf_result run_cpu_decoder(decoding *d, const cpu_decoder *c, const uint32_t *sphere,
                                  float *decoded) {
    btf_result result = BTF_OK;
    for (int way = 0; way < 4 && result == BTF_OK; way++) {
        double ns[RIG_MOST_REPEATS];
        const btf_shader_options as = {.interpolation =
                                           way & 1 ? BTF_INTERPOLATION_NEAREST : BTF_INTERPOLATION_LINEAR,
                                       .filter = way & 2 ? BTF_FILTER_BILINEAR : BTF_FILTER_TEXEL};
        decode_row row = decoding_row(c->device, c->material, c->material->subsets[0].name, &as);
        for (int r = 0; r < d->repeats; r++) {
            const double before = rig_core_seconds();
            cpu_pixels(c, &row, sphere, REFERENCE_PIXELS, decoded);
            ns[r] = 1e9 * (rig_core_seconds() - before) / REFERENCE_PIXELS;
        }
        row.ns = bench_median(ns, d->repeats, &row.spread);
        const decode_probes *const sets[] = {&d->trained, &d->held, &d->between};
        for (int set = 0; set < 3; set++) {
            if (!sets[set]->inputs) {
                continue;
            }
#pragma omp parallel for num_threads(d->run->context->threads)
            for (size_t i = 0; i < DECODE_PROBES; i++) {
                cpu_pixels(c, &row, sets[set]->inputs + GPU_INPUTS * i, 1, decoded + 3 * i);
            }
            decode_probes_compare(sets[set], decoded, 3, &row.linear[set], &row.srgb[set]);
        }
        result = decoding_estimate_material(d, c->material, &c->material->subsets[0], &row);
        decode_table_add(d->table, &row);
    }
    return result;
}

btf_result decode_cpu_run(decoding *d, const decode_material *m) {
    const size_t probes = DECODE_PROBES, pixels = REFERENCE_PIXELS, most = probes > pixels ? probes : pixels;
    float *decoded = malloc(3 * most * sizeof *decoded);
    uint32_t *sphere = malloc(REFERENCE_PIXELS * sizeof(uint32_t) * GPU_INPUTS);
    cpu_decoder decoders[2] = {{"CPU reference", m, NULL}, {"CPU evaluator", m, NULL}};
    btf_result result =
        decoded && sphere ? BTF_OK : enc_fail(d->run->context, BTF_ERROR_MEMORY, "bench: out of memory");
    for (size_t i = 0; i < REFERENCE_PIXELS && result == BTF_OK; i++) {
        float f[GPU_INPUTS];
        rig_sphere_pixel((int)(i * (RIG_PIXELS / REFERENCE_PIXELS) + i * RIG_SIDE / RIG_PIXELS), f);
        memcpy(sphere + GPU_INPUTS * i, f, sizeof f);
    }
    if (result == BTF_OK) {
        result = btf_evaluator_create(m->encoded.material, &d->run->context->log, &decoders[1].evaluator);
    }
    for (int i = 0; i < 2 && result == BTF_OK; i++) {
        result = run_cpu_decoder(d, &decoders[i], sphere, decoded);
    }
    btf_evaluator_destroy(&decoders[1].evaluator);
    free(decoded);
    free(sphere);
    return result;
}
