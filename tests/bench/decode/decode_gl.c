/* Variants of shaders, timed and compared. See decode_gl.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "decode_gl.h"

#include "decode_shaders.h"

#include <string.h>

/* The options of a subset; its fixed directions are the first of the material. */
static btf_shader_options options_of(const decode_material *m, const decode_subset *s,
                                     btf_shader_options how) {
    const btf_directions views = btf_material_views(m->encoded.material),
                         lights = btf_material_lights(m->encoded.material);
    how.leave_out = s->leave_out;
    how.components = decoding_part(m, s);
    how.fixed = s->fixed;
    memcpy(how.fixed_view, views.xyz, sizeof how.fixed_view);
    memcpy(how.fixed_light, lights.xyz, sizeof how.fixed_light);
    return how;
}

static btf_result run_variant(decoding *d, decode_rig *rig, const char *device, const decode_material *m,
                              const decode_subset *s, btf_shader_options how) {
    btf_result result = BTF_OK;
    const btf_shader_options shader = options_of(m, s, how);
    decode_row row = decoding_row(device, m, s->name, &shader);
    rig_variant variant =
        rig_variant_create(rig, m->encoded.material, &shader, bench_body_decode, GPU_FIRST_UNIT);
    if (variant.program) {
        row.ns = rig_measure(rig, variant.program, rig->inputs, RIG_SIDE, &row.spread);
        if (!s->fixed) {
            decoding_probe(d, rig, variant.program, &row);
            result = decoding_estimate_material(d, m, s, &row);
        }
    }
    rig_variant_destroy(rig, &variant);
    if (row.ns > 0) {
        decode_table_add(d->table, &row);
    }
    return result;
}

/* The fetches of the whole material, added up. */
static void run_floor(decoding *d, decode_rig *rig, const char *device, const decode_material *m,
                      btf_shader_options shader) {
    decode_row row = decoding_row(device, m, DECODE_FLOOR, &shader);
    row.cost.integers = row.cost.floats = 0;
    row.ns =
        rig_measure_variant(rig, m->encoded.material, &shader, bench_body_floor, d->floor, &row.spread);
    if (row.ns > 0) {
        decode_table_add(d->table, &row);
    }
}

/* Bits of a way to decode: nearest directions, bilinear texels, native mathematics, steep texels. */
enum { WAYS = 9 };

/* Whether a subset is decoded in this way. Every device decodes the whole material by texels, with both interpolations of
 * directions and both kinds of mathematics; the first device also by the bilinear filter, and the other subsets exactly
 * by texels. With `all`, every device decodes every subset in every way but `steep`. Exceptions:
 *  - the material with relief: exactly and interpolated, on the first device, the whole by each filter;
 *  - fixed directions and parts of factors: in way 0, on the first device;
 *  - further factors, without `all`: in way 0, on the first device also in native mathematics. */
static bool is_run(const decoding *d, const decode_material *m, int s, int way, bool all) {
    const decode_subset *of = &m->subsets[s];
    const bool first = d->table->devices == 1;
    const bool factors = m->view.store == BTF_REF_FACTORS, relief = strcmp(m->name, DECODE_RELIEF) == 0;
    if (relief) {
        return first && (s == 0 ? (way & 5) == 0 : way == 0);
    }
    if (of->fixed || (s > 0 && factors)) {
        return way == 0 && first;
    }
    if (factors && !all && m != decode_material_find(d->materials, DECODE_JOINT)) {
        return way == 0 || (first && way == 4);
    }
    if (way & 8) {
        return false;
    }
    return all || (s == 0 && (way & 2) == 0) || (s == 0 && first) || (first && way < 2);
}

btf_result decode_gl_material(decoding *d, decode_rig *rig, const char *device, const decode_material *m,
                              bool all) {
    btf_result result = BTF_OK;
    for (int s = 0; s < m->count; s++) {
        for (int way = 0; way < WAYS && result == BTF_OK; way++) {
            const btf_shader_options shader = {.interpolation = way & 1 ? BTF_INTERPOLATION_NEAREST
                                                                        : BTF_INTERPOLATION_LINEAR,
                                               .filter = way & 8   ? BTF_FILTER_STEEP
                                                         : way & 2 ? BTF_FILTER_BILINEAR
                                                                   : BTF_FILTER_TEXEL,
                                               .math = way & 4 ? BTF_MATH_FAST : BTF_MATH_EXACT};
            if (is_run(d, m, s, way, all)) {
                result = run_variant(d, rig, device, m, &m->subsets[s], shader);
            }
        }
    }
    if (strcmp(m->name, DECODE_RELIEF) == 0) {
        return result; /* no floor: the places of its fetches depend on the heights */
    }
    rig_floor_inputs(m->encoded.material, rig->inputs, d->floor);
    run_floor(d, rig, device, m, (btf_shader_options){0});
    if (all && d->table->devices == 1) {
        run_floor(d, rig, device, m, (btf_shader_options){.interpolation = BTF_INTERPOLATION_NEAREST});
        run_floor(d, rig, device, m, (btf_shader_options){.filter = BTF_FILTER_BILINEAR});
    }
    return result;
}

void decode_gl_sizes(decoding *d, decode_rig *rig, const char *device, const decode_material *m) {
    const btf_shader_options shader = {0};
    rig_variant variant =
        rig_variant_create(rig, m->encoded.material, &shader, bench_body_decode, GPU_FIRST_UNIT);
    for (int side = RIG_SIDE / 8; variant.program && side <= RIG_SIDE; side *= 2) {
        decode_row row = decoding_row(device, m, "whole", &shader);
        row.side = side;
        row.ns = rig_measure(rig, variant.program, rig->inputs, side, &row.spread);
        decode_table_add_size(d->table, &row);
    }
    rig_variant_destroy(rig, &variant);
}
