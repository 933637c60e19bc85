/* Directions drawn to the light, and their density, against the reference, bit for bit.
 *
 * SPDX-License-Identifier: MIT
 */
#include "cases.h"
#include "check_internal.h"

#include <openbtf/sampling.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* a: view, u1; b: u2, light. Elements take turns, by u1: a direction with its density, the density of the light. */
static const char body[] = "uvec4 check(uvec4 a, uvec4 b) {\n"
                           "    vec3 v = uintBitsToFloat(a.xyz);\n"
                           "    float pdf;\n"
                           "    if ((a.w & 1u) != 0u)\n"
                           "        return uvec4(floatBitsToUint(btf_pdf_light(vec2(0.0), v, "
                           "uintBitsToFloat(b.yzw))), 0u, 0u, 0u);\n"
                           "    vec3 l = btf_sample_light(vec2(0.0), v, a.w, b.x, pdf);\n"
                           "    return uvec4(floatBitsToUint(l), floatBitsToUint(pdf));\n"
                           "}\n";

typedef struct subject {
    const btf_material *material;
    const btf_light_sampling *tables;
    btf_ref_sampling sampling;
    const btf_ref_material *reference;
} subject;

static void make_case(const subject *s, random_state *r, uint32_t *in, uint32_t *out) {
    const btf_directions views = btf_material_views(s->material), lights = btf_material_lights(s->material);
    float view[3], light[3], result[4] = {0};
    case_direction(r, &views, view);
    case_direction(r, &lights, light);
    memcpy(in, view, sizeof view);
    in[3] = (uint32_t)random_bits(r);
    in[4] = (uint32_t)random_bits(r);
    if (random_below(r, 8) == 0) { /* the first and last numbers of an interval, and of all */
        in[3] =
            s->tables->triangles[4 * (size_t)random_below(r, s->tables->n_triangles)] - random_below(r, 3);
    }
    if (random_below(r, 8) == 0) {
        in[4] = random_below(r, 2) ? 0xFFFFFFFFu : random_below(r, 300);
    }
    memcpy(in + 5, light, sizeof light);
    if (in[3] & 1) {
        result[0] = btf_ref_pdf_light(s->reference, &s->sampling, 0, 0, view, light);
    } else {
        btf_ref_sample_light(s->reference, &s->sampling, 0, 0, view, in[3], in[4], result, &result[3]);
    }
    memcpy(out, result, sizeof result);
}

btf_result check_sampling(const check_subject *of, uint64_t seed, uint64_t count, check_outcome *outcome) {
    check_session session;
    check_subject altered = *of;
    btf_evaluator *evaluator = NULL;
    btf_light_sampling *tables = NULL;
    btf_gl_light_sampling *textures = NULL;
    char preamble[200];
    uint32_t units = 0;
    snprintf(preamble, sizeof preamble, "#define BTF_SAMPLING 1\n%s", of->preamble ? of->preamble : "");
    altered.preamble = preamble;
    btf_result result = check_begin(&altered, body, &session);
    if (result != BTF_OK) {
        return result;
    }
    const btf_gl_options options = gpu_gl_options(of->gpu, of->shader);
    result = btf_evaluator_create(of->material, of->log, &evaluator);
    if (result == BTF_OK) {
        result = btf_light_sampling_create(of->material, evaluator, of->log, &tables);
    }
    if (result == BTF_OK) {
        result = btf_gl_light_sampling_create(tables, &options, of->log, &textures);
    }
    if (result == BTF_OK) {
        result = btf_gl_bind(session.gl, session.program, GPU_FIRST_UNIT, NULL, of->log, &units);
    }
    if (result == BTF_OK) {
        btf_gl_light_sampling_bind(textures, session.program, GPU_FIRST_UNIT + units, NULL, NULL);
    }
    random_state r = {seed};
    const uint64_t batch = (uint64_t)GPU_SIDE * GPU_SIDE;
    for (uint64_t first = 0; first < count && result == BTF_OK; first += batch) {
        const subject s = {of->material,
                           tables,
                           {tables->n_triangles, tables->triangles, tables->densities},
                           &session.reference};
        const size_t n = (size_t)(count - first < batch ? count - first : batch);
        for (size_t i = 0; i < n; ++i) {
            make_case(&s, &r, session.inputs + GPU_INPUTS * i, session.expected + GPU_OUTPUTS * i);
        }
        result = check_batch(&session, "sampling", first, n, GPU_OUTPUTS, outcome);
    }
    btf_gl_light_sampling_destroy(&textures);
    btf_light_sampling_destroy(&tables);
    btf_evaluator_destroy(&evaluator);
    check_end(&session);
    return result;
}
