/* btf-view --plan auto: makes another plan when the picture leaves the range of the present one.
 *
 * SPDX-License-Identifier: MIT
 */
#include "viewer_plan.h"

#include "decoder/toolkit/cli.h"
#include "decoder/toolkit/scene_option.h"
#include "decoder/tools/render/plan_range.h"
#include "options.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

enum { RAYS = 64 }; /* along the picture's longer side, to see from where the model is seen and lit */

static const double rest_seconds = 0.4;

_Static_assert((int)PLANNER_SLOTS == (int)DRAWING_SLOTS, "a slot for each plan");

void viewer_forget_plans(viewer *v) {
    planner_clear(&v->planning.planner);
    v->planning = (planning){.planner = planner_begin()};
}

/* One normal all over: a light far away is one direction there. */
static bool is_flat(const mesh *m) {
    for (uint32_t i = 1; i < m->vertex_count; i++)
        if (memcmp(m->vertices[i].normal, m->vertices[0].normal, sizeof m->vertices[0].normal) ||
            memcmp(m->vertices[i].tangent, m->vertices[0].tangent, sizeof m->vertices[0].tangent))
            return false;
    return true;
}

static bool same_camera(const view_state *a, const view_state *b) {
    return a->theta == b->theta && a->phi == b->phi && a->zoom == b->zoom && a->mesh == b->mesh &&
           a->levels == b->levels;
}

static bool same_light(const view_state *a, const view_state *b) {
    return a->light_theta == b->light_theta && a->light_phi == b->light_phi;
}

/* Casts a coarse picture. The directions between its rays are within the margins of planner.h, or decoded by the
 * nearest directions that there are. */
static btf_result find_needed_scene(viewer *v, int width, int height) {
    planning *p = &v->planning;
    btf_material_info info = {.struct_size = sizeof info};
    btf_material_get_info(v->material, &info);
    const int longer = width > height ? width : height;
    const double step = fmax((double)longer / RAYS, 1);
    light sun = {.at = vec_from_angles(v->state.light_theta, v->state.light_phi), .colour = {1, 1, 1}};
    const light_list lights = {&sun, 1};
    const render_scene scene = {
        .table = {.mesh = viewer_mesh(v),
                  .bvh = v->bvh,
                  .camera = {v->state.theta, v->state.phi, 30, v->state.zoom},
                  .repeat = {viewer_repeat(v), viewer_repeat(v)},
                  .texels = {(int)fmax(info.width / step, 1), (int)fmax(info.height / step, 1)},
                  .levels = (int)info.levels,
                  .level = v->state.levels ? -1 : 0,
                  .threads = 1},
        .lights = &lights,
        .width = (int)fmax(width / step, 1),
        .height = (int)fmax(height / step, 1),
        .samples = 1};
    plan_range range = {0};
    const btf_result result = plan_range_add(&scene, &range);
    if (result)
        return cli_error(&view_program, result, "out of memory for a plan");
    p->needed = plan_range_scene(&range);
    if (!p->folds && p->needed.light.fixed)
        p->needed.light = plan_range_widen(&p->needed.light, 1);
    return BTF_OK;
}

/* The camera, the light, the window: what moved, and what is needed now. */
static btf_result note_movement(viewer *v) {
    planning *p = &v->planning;
    const double now = glfwGetTime();
    int size[2];
    viewer_frame_size(v, &size[0], &size[1]);
    const bool first = p->size[0] == 0, resized = size[0] != p->size[0] || size[1] != p->size[1];
    const bool camera = first || resized || !same_camera(&p->seen, &v->state),
               lit = first || !same_light(&p->seen, &v->state);
    if (!camera && !lit)
        return BTF_OK;
    if (first)
        p->folds = is_flat(viewer_mesh(v));
    p->moved = camera ? now : p->moved;
    p->light_moved = lit ? now : p->light_moved;
    p->seen = v->state;
    memcpy(p->size, size, sizeof p->size);
    return find_needed_scene(v, size[0], size[1]);
}

static void report_plan(viewer *v, const char *what, const planner_plan *made, const char *times) {
    char words[48], amount[32], text[400];
    const btf_plan *plan = &made->plan;
    const btf_scene *s = &plan->scene;
    snprintf(text, sizeof text,
             "plan %u%s: views %.1f to %.1f, light%s, level %u: %s, %s; %zu bytes of %zu, %zu uploaded%s",
             made->number, what, (double)s->view.theta[0],
             (double)(s->view.theta[1] > 0 ? s->view.theta[1] : 90), s->light.fixed ? " folded" : " free",
             (unsigned)plan->level, cli_effects_text(plan->effects, words),
             scene_plan_amount(plan, amount, sizeof amount), plan->gpu_bytes, plan->full_gpu_bytes,
             drawing_bytes(v->drawing), times);
    if (view_options.verbose) {
        printf("%s\n", text);
        fflush(stdout);
    }
    v->dirty = true;
}

/* The next part of the pending plan. The one that is shown stays until all are done. */
static btf_result do_next_part(viewer *v) {
    planning *p = &v->planning;
    const int slot = p->planner.pending;
    planner_plan *made = &p->planner.slot[slot];
    btf_result result = BTF_OK;
    const double start = glfwGetTime();
    if (p->stage == STAGE_MAKE)
        result = planner_make(&p->planner, v->material, (float)view_options.tolerance, &v->log);
    else if (p->stage == STAGE_UPLOAD)
        result = drawing_set_plan(v->drawing, slot, made->material, &made->plan, &v->log);
    else if (p->stage == STAGE_LINK)
        result = drawing_link_plan(v->drawing, slot, &v->state, &v->log);
    else
        result = drawing_try_plan(v->drawing, slot, &v->state, p->size[0], p->size[1], &v->log);
    p->ms[p->stage++] = 1e3 * (glfwGetTime() - start);
    if (result || p->stage < STAGES)
        return result;
    planner_take(&p->planner);
    drawing_use_plan(v->drawing, p->planner.current);
    char times[120];
    snprintf(times, sizeof times, "; made in %.1f ms, upload %.1f, link %.1f, first pixel %.1f",
             p->ms[STAGE_MAKE], p->ms[STAGE_UPLOAD], p->ms[STAGE_LINK], p->ms[STAGE_TRY]);
    report_plan(v, "", made, times);
    return BTF_OK;
}

btf_result viewer_plan(viewer *v, double *out_wait) {
    planning *p = &v->planning;
    btf_result result = note_movement(v);
    if (result)
        return result;
    const double now = glfwGetTime(), light_rests = now - p->light_moved, view_rests = now - p->moved;
    const bool at_rest = light_rests >= rest_seconds && view_rests >= rest_seconds && !v->state.animate;
    const planner_action action = planner_decide(
        &p->planner, &p->needed, at_rest, p->folds && light_rests >= rest_seconds && !v->state.animate);
    if (action == PLANNER_SWITCH) {
        drawing_use_plan(v->drawing, p->planner.current);
        report_plan(v, " again", &p->planner.slot[p->planner.current], "");
    } else if (action == PLANNER_MAKE) {
        p->stage = STAGE_MAKE;
    }
    do
        result = p->planner.pending >= 0 ? do_next_part(v) : BTF_OK;
    while (!result && p->planner.current < 0);
    *out_wait = p->planner.pending >= 0 || action != PLANNER_KEEP ? 0 : at_rest ? -1 : rest_seconds / 2;
    return result;
}

void viewer_plan_text(const viewer *v, char *text, size_t size) {
    const planner *p = &v->planning.planner;
    size_t length = 0;
    char reason[80], amount[32];
    if (p->current < 0) {
        snprintf(text, size, "no plan yet\n");
        return;
    }
    const planner_plan *now = &p->slot[p->current];
    for (int i = 0; i < CLI_EFFECTS_COUNT && length < size; i++)
        length +=
            (size_t)snprintf(text + length, size - length, "%d %-8s %s%s\n", i + 1, cli_effect_word(i),
                             scene_plan_reason(v->material, &now->plan, i, reason, sizeof reason),
                             v->state.effects >> i & 1 ? "" : "; switched off");
    const btf_scene *s = &now->plan.scene;
    if (length < size)
        snprintf(text + length, size - length,
                 "plan %u: views %.0f..%.0f, light%s, level %u, %s\n%.1f dB of %.1f, %.0f%% of bytes\n",
                 now->number, (double)s->view.theta[0],
                 (double)(s->view.theta[1] > 0 ? s->view.theta[1] : 90),
                 s->light.fixed ? " folded" : " free", (unsigned)now->plan.level,
                 scene_plan_amount(&now->plan, amount, sizeof amount), (double)now->plan.psnr_linear,
                 (double)now->plan.full_psnr_linear,
                 100 * (double)now->plan.gpu_bytes / (double)now->plan.full_gpu_bytes);
}
