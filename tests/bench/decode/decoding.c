/* Rows, accuracy and estimates. See decoding.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "decoding.h"

#include <string.h>

void decoding_probe(const decoding *d, decode_rig *rig, unsigned program, decode_row *row) {
    const decode_probes *const sets[] = {&d->trained, &d->held, &d->between};
    for (int i = 0; i < 3; i++) {
        if (sets[i]->inputs &&
            gpu_run(rig->gpu, program, DECODE_PROBES, sets[i]->inputs, rig->outputs, rig->log) == BTF_OK) {
            decode_probes_compare(sets[i], (const float *)(const void *)rig->outputs, GPU_OUTPUTS,
                                  &row->linear[i], &row->srgb[i]);
        }
    }
}

static bool estimates(const decoding *d) {
    return d->run->truth->count == 0 && bench_between_has(d->run->between, BENCH_ESTIMATE);
}

/* Copies the estimate from a row that has it already, of any device and mathematics; false if there is none. */
static bool estimated_before(const decoding *d, decode_row *row) {
    for (int i = 0; i < d->table->count; i++) {
        const decode_row *r = &d->table->rows[i];
        if (r->estimated && strcmp(r->material, row->material) == 0 &&
            strcmp(r->effects, row->effects) == 0 && r->nearest == row->nearest &&
            r->filter == row->filter) {
            row->linear[2] = r->linear[2];
            row->srgb[2] = r->srgb[2];
            row->estimated = true;
            return true;
        }
    }
    return false;
}

static void take_estimate(const double figures[2], decode_row *row) {
    row->linear[2] = figures[0];
    row->srgb[2] = figures[1];
    row->estimated = true;
}

uint32_t decoding_part(const decode_material *m, const decode_subset *s) {
    const uint32_t group = m->view.store == BTF_REF_FACTORS ? 1 : 4, of = s->part * group;
    return s->part ? (m->view.components + of - 1) / of * group : 0;
}

btf_result decoding_estimate_material(const decoding *d, const decode_material *m, const decode_subset *s,
                                      decode_row *row) {
    const btf_ref_options options = {.effects = BTF_EFFECT_ALL & ~s->leave_out,
                                     .components = s->part ? decoding_part(m, s) : UINT32_MAX,
                                     .interpolation = row->nearest ? BTF_REF_NEAREST : BTF_REF_LINEAR,
                                     .filter = (int)row->filter};
    bench_between_figures figures;
    if (!estimates(d) || estimated_before(d, row)) {
        return BTF_OK;
    }
    const btf_result result =
        bench_between_material(d->run->context, d->run->between, &m->view, &options, figures);
    if (result == BTF_OK) {
        take_estimate(figures[BENCH_ESTIMATE], row);
    }
    return result;
}

btf_result decoding_estimate_peer(const decoding *d, const enc_image_source *images, decode_row *row) {
    const enc_data *data = d->run->held->train;
    bench_between_figures figures = {[BENCH_ESTIMATE] = {row->linear[0], row->srgb[0]}};
    enc_data *decoded = NULL;
    btf_result result = BTF_OK;
    if (!estimates(d) || estimated_before(d, row)) {
        return BTF_OK;
    }
    if (images) {
        result = bench_decode_all(d->run->context, data, *images, &decoded);
        if (result == BTF_OK) {
            result = bench_between_images(d->run->context, d->run->between, decoded, ENC_INTERPOLATE_LINEAR,
                                          figures);
        }
        enc_data_destroy(&decoded);
    }
    if (result == BTF_OK) {
        take_estimate(figures[BENCH_ESTIMATE], row);
    }
    return result;
}

/* A row's counts and bytes. */
static void count(const decode_material *m, const btf_shader_options *shader, decode_row *row) {
    btf_material_info info = {.struct_size = sizeof info};
    btf_material_get_info(m->encoded.material, &info);
    row->gpu_bytes = (double)m->encoded.bytes;
    row->cost = decode_cost_of(&info, shader);
    row->counted = true;
}

decode_row decoding_row(const char *device, const decode_material *m, const char *effects,
                        const btf_shader_options *shader) {
    decode_row row = decode_row_named(device, m->name, effects);
    row.nearest = shader->interpolation == BTF_INTERPOLATION_NEAREST;
    row.filter = shader->filter;
    row.fast = shader->math == BTF_MATH_FAST;
    count(m, shader, &row);
    return row;
}
