/* A restricted material on the device against the reference of the whole one, in the ranges of a random
 * scene.
 *
 * SPDX-License-Identifier: MIT
 */
#include "cases.h"
#include "check_internal.h"
#include "decoder/toolkit/reference_view.h"
#include "variant.h"

#include <openbtf/plan.h>

#include <math.h>

/* A random range: the hemisphere, one direction, or a part of the hemisphere. */
static btf_range random_range(random_state *r, const btf_directions *list) {
    btf_range range = {0};
    switch (random_below(r, 4)) {
    case 0:
        return range;
    case 1:
        range.fixed = 1;
        do {
            case_direction(r, list, range.direction);
        } while (!(range.direction[2] >= 0x1p-24f && range.direction[2] <= 1) ||
                 !(fabs(hypot(hypot((double)range.direction[0], (double)range.direction[1]),
                              (double)range.direction[2]) -
                        1) < 1e-4));
        return range;
    default:
        range.theta[0] = random_below(r, 2) ? 0 : (float)random_between(r, 0, 80);
        range.theta[1] = (float)random_between(r, (double)range.theta[0], 90);
        if (random_below(r, 2)) {
            range.phi[0] = (float)random_between(r, -360, 360);
            range.phi[1] = (float)random_between(r, -360, 360);
        }
        return range;
    }
}

/* Makes the plan: by the table of effect errors where the material has one, else by the subject's options. */
static btf_result make_plan(const check_subject *subject, random_state *r, btf_plan *plan) {
    const btf_material *material = subject->material;
    btf_directions views = btf_material_views(material), lights = btf_material_lights(material);
    btf_material_info info = {.struct_size = sizeof info};
    btf_scene scene = {.struct_size = sizeof scene,
                       .view = random_range(r, &views),
                       .light = random_range(r, &lights),
                       .pixels = random_below(r, 2) ? 0.4f : 1};
    btf_result result = btf_plan_effects(material, &scene, 0.5f, plan);
    if (result != BTF_OK) {
        return result;
    }
    const btf_shader_options *wanted = subject->shader;
    plan->shader.have_precise = wanted->have_precise;
    if (plan->measured) {
        return BTF_OK;
    }
    btf_material_get_info(material, &info);
    plan->effects = info.effects & ~wanted->leave_out;
    plan->components =
        wanted->components && wanted->components < info.components ? wanted->components : info.components;
    plan->shader.leave_out = wanted->leave_out;
    plan->shader.components = plan->components;
    plan->shader.interpolation = wanted->interpolation;
    plan->shader.filter = wanted->filter;
    return BTF_OK;
}

btf_result check_planned(const check_subject *subject, uint64_t seed, uint64_t count,
                         check_outcome *outcome) {
    random_state r = {seed};
    btf_plan plan;
    btf_material *small = NULL;
    check_session session;
    check_subject altered = *subject;
    btf_result result = make_plan(subject, &r, &plan);
    if (result == BTF_OK) {
        result = btf_material_restrict(subject->material, &plan, subject->log, &small);
    }
    altered.material = small;
    altered.shader = &plan.shader;
    if (result == BTF_OK) {
        result = check_begin(&altered, gpu_evaluate_body, &session);
    }
    if (result != BTF_OK) {
        btf_material_close(&small);
        return result;
    }
    reference_view(subject->material, plan.level, &session.reference);
    const btf_ref_options options = variant_reference_options(&plan.shader);
    btf_directions views = btf_material_views(subject->material),
                   lights = btf_material_lights(subject->material);
    const uint64_t batch = (uint64_t)GPU_SIDE * GPU_SIDE;
    for (uint64_t first = 0; first < count && result == BTF_OK; first += batch) {
        size_t n = (size_t)(count - first < batch ? count - first : batch);
        for (size_t i = 0; i < n; ++i) {
            float f[CASE_WORDS], rgb[3];
            f[0] = case_coordinate(&r, session.reference.width);
            f[1] = case_coordinate(&r, session.reference.height);
            case_in_range(&r, &plan.scene.light, &lights, f + 2);
            case_in_range(&r, &plan.scene.view, &views, f + 5);
            memcpy(session.inputs + GPU_INPUTS * i, f, sizeof f);
            btf_ref_evaluate(&session.reference, &options, f[0], f[1], f + 2, f + 5, rgb);
            memcpy(session.expected + GPU_OUTPUTS * i, rgb, sizeof rgb);
            session.expected[GPU_OUTPUTS * i + 3] = 0;
        }
        result = check_batch(&session, "planned", first, n, 3, outcome);
    }
    check_end(&session);
    btf_material_close(&small);
    return result;
}
