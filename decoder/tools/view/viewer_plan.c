/* btf-view --plan auto: makes another plan when the picture leaves the range of the present one.
 *
 * SPDX-License-Identifier: MIT
 */
#include "viewer_plan.h"

#include "decoder/toolkit/cli.h"
#include "decoder/toolkit/scene_option.h"
#include "decoder/tools/render/plan_range.h"
#include "decoder/tools/mesh/vec.h"
#include "light_fold.h"
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

static bool same_camera(const view_state *a, const view_state *b) {
    return a->theta == b->theta && a->phi == b->phi && a->zoom == b->zoom && a->mesh == b->mesh &&
           a->levels == b->levels;
}

static bool same_light(const view_state *a, const view_state *b) {
    return a->light_theta == b->light_theta && a->light_phi == b->light_phi;
}

/* Casts a coarse picture to find the directions that the picture needs. Those between its rays are within the margins
 * of planner.h, or decoded by the nearest directions that the plan has. */
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
    if (result) {
        return cli_error(&view_program, result, "out of memory for a plan");
    }
    p->needed = plan_range_scene(&range);
    if (!p->folds && p->needed.light.fixed) {
        p->needed.light = plan_range_widen(&p->needed.light, 1);
    }
    return BTF_OK;
}

/* Notes whether camera, light or window moved, and if so finds what the picture needs now. */
static btf_result note_movement(viewer *v) {
    planning *p = &v->planning;
    const double now = glfwGetTime();
    int size[2];
    viewer_frame_size(v, &size[0], &size[1]);
    const bool first = p->size[0] == 0, resized = size[0] != p->size[0] || size[1] != p->size[1];
    const bool camera = first || resized || !same_camera(&p->seen, &v->state),
               lit = first || !same_light(&p->seen, &v->state);
    if (!camera && !lit) {
        return BTF_OK;
    }
    if (first) {
        p->folds = mesh_is_flat(viewer_mesh(v));
    }
    p->moved = camera ? now : p->moved;
    p->light_moved = lit ? now : p->light_moved;
    p->seen = v->state;
    memcpy(p->size, size, sizeof p->size);
    return find_needed_scene(v, size[0], size[1]);
}

/* Says how far the plan's light is folded: into a texture that holds all that it shows; else its neighbours are
 * constants of the shader, unless gloss looks lights up by the view. */
static const char *light_words(const viewer *v, const btf_plan *plan) {
    if (!plan->scene.light.fixed) {
        return " free";
    }
    return drawing_folded(v->drawing)         ? " folded into a texture"
           : plan->effects & BTF_EFFECT_GLOSS ? " folded no further than gloss allows"
                                              : " folded";
}

static void report_plan(viewer *v, const char *what, const planner_plan *made, const char *times) {
    char words[48], amount[32], text[400];
    const btf_plan *plan = &made->plan;
    const btf_scene *s = &plan->scene;
    snprintf(text, sizeof text,
             "plan %u%s: views %.1f to %.1f, light%s, level %u: %s, %s; %zu bytes of %zu, %zu uploaded%s",
             made->number, what, (double)s->view.theta[0],
             (double)(s->view.theta[1] > 0 ? s->view.theta[1] : 90), light_words(v, plan),
             (unsigned)plan->level, cli_effects_text(plan->effects, words),
             scene_plan_amount(plan, amount, sizeof amount), plan->gpu_bytes, plan->full_gpu_bytes,
             drawing_bytes(v->drawing), times);
    if (view_options.verbose) {
        printf("%s\n", text);
        fflush(stdout);
    }
    v->dirty = true;
}

/* Does the next part of the pending plan. The present plan is shown until all parts are done. */
static btf_result do_next_part(viewer *v) {
    planning *p = &v->planning;
    const int slot = p->planner.pending;
    planner_plan *made = &p->planner.slot[slot];
    btf_result result = BTF_OK;
    const double start = glfwGetTime();
    if (p->stage == STAGE_MAKE) {
        btf_scene *target = &p->planner.target;
        target->folded_pixels = (double)LIGHT_FOLD_FRAMES * p->size[0] * p->size[1];
        target->folded_bytes = LIGHT_FOLD_BYTES;
        result = planner_make(&p->planner, v->material, (float)view_options.tolerance,
                              view_options.costs_file ? &v->costs_of_device : NULL, &v->log);
    } else if (p->stage == STAGE_UPLOAD) {
        result = drawing_set_plan(v->drawing, slot, made->material, &made->plan, &v->log);
    } else if (p->stage == STAGE_FOLD) {
        result = drawing_fold_plan(v->drawing, slot, &v->state, (double)p->size[0] * p->size[1], &v->log);
    } else if (p->stage == STAGE_LINK) {
        result = drawing_link_plan(v->drawing, slot, &v->state, &v->log);
    } else {
        result = drawing_try_plan(v->drawing, slot, &v->state, p->size[0], p->size[1], &v->log);
    }
    p->ms[p->stage++] = 1e3 * (glfwGetTime() - start);
    if (result || p->stage < STAGES) {
        return result;
    }
    planner_take(&p->planner);
    drawing_use_plan(v->drawing, p->planner.current);
    char times[120];
    snprintf(times, sizeof times, "; made in %.1f ms, upload %.1f, fold %.1f, link %.1f, first pixel %.1f",
             p->ms[STAGE_MAKE], p->ms[STAGE_UPLOAD], p->ms[STAGE_FOLD], p->ms[STAGE_LINK],
             p->ms[STAGE_TRY]);
    report_plan(v, "", made, times);
    return BTF_OK;
}

btf_result viewer_plan(viewer *v, double *out_wait) {
    planning *p = &v->planning;
    btf_result result = note_movement(v);
    if (result) {
        return result;
    }
    const double now = glfwGetTime(), light_rests = now - p->light_moved, view_rests = now - p->moved;
    const bool at_rest = light_rests >= rest_seconds && view_rests >= rest_seconds && !v->state.animate;
    /* No plan counts on a fold that will not be made. */
    p->needed.no_fold = !drawing_folds(v->drawing, &v->state);
    const planner_action action = planner_decide(
        &p->planner, &p->needed, at_rest, p->folds && light_rests >= rest_seconds && !v->state.animate);
    if (action == PLANNER_SWITCH) {
        drawing_use_plan(v->drawing, p->planner.current);
        report_plan(v, " again", &p->planner.slot[p->planner.current], "");
    } else if (action == PLANNER_MAKE) {
        p->stage = STAGE_MAKE;
    }
    do {
        result = p->planner.pending >= 0 ? do_next_part(v) : BTF_OK;
    } while (!result && p->planner.current < 0);
    *out_wait = p->planner.pending >= 0 || action != PLANNER_KEEP ? 0 : at_rest ? -1 : rest_seconds / 2;
    return result;
}

/* The direction to the light at every point of a flat model, in the tangent frame of its front. */
static void flat_light(const mesh *m, const view_state *s, float out[3]) {
    const mesh_vertex *at = m->vertices;
    const vec3 n = vec(at->normal[0], at->normal[1], at->normal[2]),
               t = vec(at->tangent[0], at->tangent[1], at->tangent[2]),
               b = vec_mul(vec_cross(n, t), at->tangent[3] < 0 ? -1 : 1),
               light = vec_from_angles(s->light_theta, s->light_phi);
    vec_store(vec(vec_dot(light, t), vec_dot(light, b), vec_dot(light, n)), out);
}

btf_result viewer_still(viewer *v, double *out_wait) {
    planning *p = &v->planning;
    const double now = glfwGetTime();
    const bool first = p->size[0] == 0;
    viewer_frame_size(v, &p->size[0], &p->size[1]);
    *out_wait = -1;
    if (first || !same_light(&p->seen, &v->state) || v->state.mesh != p->seen.mesh) {
        p->seen = v->state;
        p->folds = mesh_is_flat(viewer_mesh(v));
        p->light_moved = now;
        p->folded = false;
        if (drawing_folded(v->drawing)) {
            drawing_fold_whole(v->drawing, NULL, &v->state, 0, &v->log);
        }
    }
    if (!p->folds || p->folded || v->state.animate) {
        return BTF_OK;
    }
    if (now - p->light_moved < rest_seconds) {
        *out_wait = rest_seconds / 2;
        return BTF_OK;
    }
    float light[3];
    char text[120];
    flat_light(viewer_mesh(v), &v->state, light);
    p->folded = true;
    const btf_result result =
        light[2] > 1e-6f
            ? drawing_fold_whole(v->drawing, light, &v->state, (double)p->size[0] * p->size[1], &v->log)
            : BTF_OK;
    if (result || !drawing_folded(v->drawing)) {
        return result;
    }
    snprintf(text, sizeof text, "the light rests: folded into %zu bytes, in %.1f ms",
             drawing_folded(v->drawing), 1e3 * (glfwGetTime() - now));
    viewer_tell(v, text);
    v->dirty = true;
    return BTF_OK;
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
    for (int i = 0; i < CLI_EFFECTS_COUNT && length < size; i++) {
        length +=
            (size_t)snprintf(text + length, size - length, "%d %-8s %s%s\n", i + 1, cli_effect_word(i),
                             scene_plan_reason(v->material, &now->plan, i, reason, sizeof reason),
                             v->state.effects >> i & 1 ? "" : "; switched off");
    }
    const btf_scene *s = &now->plan.scene;
    char between[64] = "";
    if (now->plan.full_between_psnr_linear > 0) {
        snprintf(between, sizeof between, ", between the samples %.1f of %.1f",
                 (double)now->plan.between_psnr_linear, (double)now->plan.full_between_psnr_linear);
    }
    if (length < size) {
        snprintf(text + length, size - length,
                 "plan %u: views %.0f..%.0f, light%s, level %u, %s\n%.1f dB of %.1f%s, %.0f%% of bytes, "
                 "%.0f%% of time\n",
                 now->number, (double)s->view.theta[0],
                 (double)(s->view.theta[1] > 0 ? s->view.theta[1] : 90), light_words(v, &now->plan),
                 (unsigned)now->plan.level, scene_plan_amount(&now->plan, amount, sizeof amount),
                 (double)now->plan.psnr_linear, (double)now->plan.full_psnr_linear, between,
                 100 * (double)now->plan.gpu_bytes / (double)now->plan.full_gpu_bytes,
                 100 * (double)(drawing_folded(v->drawing) ? now->plan.folded_cost : now->plan.cost) /
                     (double)now->plan.full_cost);
    }
}
