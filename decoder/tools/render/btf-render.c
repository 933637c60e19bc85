/* btf-render: a material on a mesh, without a window.
 *
 * SPDX-License-Identifier: MIT
 */
#include "decoder/toolkit/file.h"
#include "decoder/toolkit/output.h"
#include "decoder/toolkit/progress.h"
#include "decoder/toolkit/scene_option.h"
#include "decoder/tools/original/data_set.h"
#include "environment.h"
#include "frame_plan.h"
#include "job.h"
#include "light_option.h"
#include "decoder/tools/mesh/obj.h"
#include "original.h"
#include "render.h"
#include "sampled_environment.h"
#include "settings.h"
#include "shade_fold.h"
#include "still_lights.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static btf_result make_lights(const btf_log *log) {
    if (render_options.environment && !render_options.env_sampled) {
        return light_list_read_environment(&render_options.lights, render_options.environment,
                                           render_options.environment_layer, render_options.env_lights,
                                           render_options.env_rotate, render_options.env_gain, log);
    }
    if (!render_options.env_sampled && !render_options.lights.count &&
        light_parse_directional("40,120", &render_options.lights)) {
        return BTF_ERROR_MEMORY;
    }
    return BTF_OK;
}

/* Opens the map of --light environment. Directions are drawn from the material as the file has it, so that they are
 * the same with a plan. */
static btf_result open_environment(job *j) {
    float *pixels;
    int width, height;
    btf_result result = environment_read(render_options.environment, render_options.environment_layer,
                                         &j->log, &width, &height, &pixels);
    if (result) {
        return result;
    }
    result = sampled_environment_create(width, height, pixels, render_options.env_rotate,
                                        render_options.env_gain, j->material, render_options.spp, &j->log,
                                        &j->environment);
    free(pixels);
    return result;
}

static btf_result load_mesh(job *j) {
    const char *name = render_options.mesh;
    bool flat = !strcmp(name, "plane") || !strcmp(name, "drape");
    btf_result result;
    if (file_ends_in(name, ".obj") || (!mesh_is_built_in(name) && strpbrk(name, "./"))) {
        result = mesh_read_obj(name, &j->log, &j->mesh);
        flat = true;
    } else {
        result = mesh_make(name, &j->log, &j->mesh);
    }
    if (result) {
        return result;
    }
    if (!render_options.repeat_given) {
        render_options.repeat = flat ? 2 : 3;
    }
    if (!render_options.zoom_given) {
        render_options.zoom = strcmp(name, "plane") ? 0.9 : 1;
    }
    j->bvh = bvh_create(j->mesh);
    return j->bvh ? BTF_OK : cli_error(&render_program, BTF_ERROR_MEMORY, "out of memory for the mesh");
}

/* Samples that the shader will evaluate, in pictures of so many frames. */
static double count_samples(const job *j, int frames) {
    return (double)j->scene.width * j->scene.height * j->scene.samples * j->scene.samples * frames *
           ((double)render_options.lights.count + (render_options.env_sampled ? render_options.spp : 0));
}

/* The same where the sum of several lights can be folded: a fold is read once for all of them. */
static double count_read(const job *j, int frames) {
    return count_samples(j, frames) / (j->still_lights.count > 0 ? (double)render_options.lights.count : 1);
}

static const btf_cost_model *costs_of(const job *j) {
    return render_options.costs_file ? &j->costs : NULL;
}

static btf_result open_shader(job *j, int frames) {
    shader_request request = {.device = render_options.device,
                              .material = j->material,
                              .variants = render_options.figure13 ? 3 : 1,
                              .effects = {render_options.effects},
                              .components = (uint32_t)render_options.components,
                              .interpolation = (btf_interpolation)render_options.interpolation,
                              .filter = (btf_filter)render_options.filter,
                              .math = (btf_math)render_options.math,
                              .fold = (shader_fold)render_options.fold,
                              .samples = count_read(j, frames),
                              .picks = render_options.stochastic ? BTF_PICK_ALL : BTF_PICK_NONE,
                              .picked = render_options.env_sampled ? 1 : render_options.spp,
                              .level = render_options.figure13 ? 0 : render_options.level,
                              .threads = render_options.threads,
                              .costs = costs_of(j)};
    if (j->still_lights.count > 0) {
        request.lights = j->still_lights.count;
        request.light_directions = j->still_lights.directions;
        request.light_weights = j->still_lights.weights;
        request.sum_of_views =
            render_options.fold == SHADER_FOLD_ALWAYS || (j->whole && j->plan.fold == BTF_FOLD_SUM);
    }
    if (render_options.figure13) {
        request.effects[0] = 0;
        request.effects[1] = BTF_EFFECT_SHADOW;
        request.effects[2] = render_options.effects;
    }
    /* To a shader 0 components mean all of them; to this option none. */
    for (int i = 0; i < request.variants && request.components == 0; i++) {
        request.effects[i] &= ~(uint32_t)BTF_EFFECT_RESIDUAL;
    }
    if (j->whole) {
        const btf_shader_options *planned = &j->plan.shader;
        request.effects[0] &= j->plan.effects;
        if (j->plan.components && j->plan.components < request.components) {
            request.components = j->plan.components;
        }
        if (!render_options.interpolation_given) {
            request.interpolation = planned->interpolation;
        }
        request.fixed = planned->fixed;
        memcpy(request.fixed_view, planned->fixed_view, sizeof request.fixed_view);
        memcpy(request.fixed_light, planned->fixed_light, sizeof request.fixed_light);
    } else if (!render_options.figure13) {
        request.fixed = j->still.fixed;
        memcpy(request.fixed_view, j->still.fixed_view, sizeof request.fixed_view);
        memcpy(request.fixed_light, j->still.fixed_light, sizeof request.fixed_light);
    }
    btf_result result = shader_create(&request, &j->log, &j->shader);
    j->scene.lights = !result && shader_shows_sum(j->shader) ? &j->together : &render_options.lights;
    if (!result && render_options.size[0] * render_options.samples > shader_max_width(j->shader)) {
        return cli_error(&render_program, BTF_ERROR_UNSUPPORTED,
                         "%d samples a row exceed the device's GL_MAX_TEXTURE_SIZE %d",
                         render_options.size[0] * render_options.samples, shader_max_width(j->shader));
    }
    return result;
}

/* Opens the other material that the panels SBRDF and STVS of figure 13 show. */
static btf_result open_baseline(job *j) {
    btf_material_info info = {.struct_size = sizeof info};
    btf_result result = btf_material_open(render_options.baseline, &j->log, &j->baseline);
    if (result) {
        return result;
    }
    btf_material_get_info(j->baseline, &info);
    if (info.colour == BTF_COLOUR_NONE) {
        return cli_error(&render_program, BTF_ERROR_USAGE, "option --baseline: %s has no SBRDF",
                         render_options.baseline);
    }
    const shader_request request = {.device = "reference",
                                    .material = j->baseline,
                                    .variants = 2,
                                    .effects = {0, BTF_EFFECT_SHADOW},
                                    .interpolation = (btf_interpolation)render_options.interpolation,
                                    .filter = (btf_filter)render_options.filter,
                                    .threads = render_options.threads};
    return shader_create(&request, &j->log, &j->baseline_shader);
}

static btf_result open_original(job *j) {
    progress *p = progress_create(render_options.quiet);
    if (!p) {
        return cli_error(&render_program, BTF_ERROR_MEMORY, "out of memory");
    }
    btf_result result = original_open(data_set_read, render_options.original, j->material,
                                      render_options.threads, p, &j->log, &j->original);
    progress_destroy(&p);
    return result;
}

/* Sets all lights to what was given, turned by `degrees` of phi. */
static void turn_lights(const job *j, double degrees) {
    const double c = cos(degrees * (RENDER_PI / 180)), s = sin(degrees * (RENDER_PI / 180));
    for (size_t i = 0; i < render_options.lights.count && degrees != 0; i++) {
        const vec3 at = j->lights[i].at;
        render_options.lights.lights[i].at = vec(c * at.x - s * at.y, s * at.x + c * at.y, at.z);
    }
    if (j->environment) {
        sampled_environment_turn(j->environment, degrees);
    }
}

/* Sets the camera or the lights for a frame of an animation. */
static void set_frame(job *j, int frame) {
    const double degrees = frame * (360.0 / render_options.frames);
    if (render_options.animate == 0) {
        j->scene.table.camera.phi = render_options.view[1] + degrees;
    } else {
        turn_lights(j, degrees);
    }
}

/* Finds the samples of the whole material that each frame shows. */
static btf_result see_frames(job *j) {
    btf_result result = BTF_OK;
    j->seen = calloc((size_t)render_options.frames, sizeof *j->seen);
    if (!j->seen) {
        result = BTF_ERROR_MEMORY;
    }
    for (int frame = 0; frame < render_options.frames && !result; frame++) {
        set_frame(j, frame);
        result = plan_range_add(&j->scene, &j->seen[frame]);
    }
    return result ? cli_error(&render_program, result, "out of memory for a plan") : BTF_OK;
}

static bool wants_folds(void) {
    return shade_fold_wanted((shader_fold)render_options.fold, render_options.device,
                             render_options.stochastic ? BTF_PICK_ALL : BTF_PICK_NONE);
}

/* Finds several lights that are the same in every sample, so that their sum can be folded. */
static btf_result find_still_lights(job *j) {
    const bool animated = render_options.frames > 1;
    if (render_options.fold == SHADER_FOLD_NEVER || render_options.stochastic || render_options.figure13 ||
        (animated && render_options.animate != 0)) {
        return BTF_OK;
    }
    const btf_result result = still_lights_find(&j->scene, &j->still_lights);
    j->still_lights.same_view = j->still_lights.same_view && !animated;
    j->together = (light_list){&j->still_lights.together, 1};
    return result ? cli_error(&render_program, result, "out of memory for lights") : BTF_OK;
}

/* Finds, without a plan, what never changes: a light on a flat mesh, perhaps the view, too; or several lights and the
 * view. */
static btf_result find_still(job *j) {
    const bool turns = render_options.frames > 1 && render_options.animate != 0;
    if (j->still_lights.count > 0) {
        j->still.fixed = j->still_lights.same_view ? BTF_FIXED_VIEW : 0u;
        memcpy(j->still.fixed_view, j->still_lights.view, sizeof j->still.fixed_view);
        return BTF_OK;
    }
    if (render_options.fold == SHADER_FOLD_NEVER || render_options.lights.count != 1 || j->environment ||
        turns || !mesh_is_flat(j->mesh)) {
        return BTF_OK;
    }
    btf_result result = see_frames(j);
    for (int frame = 1; frame < render_options.frames && !result; frame++) {
        plan_range_join(&j->seen[0], &j->seen[frame]);
    }
    if (result) {
        return result;
    }
    const btf_scene scene = plan_range_scene(&j->seen[0]);
    j->still.fixed = (scene.light.fixed ? (uint32_t)BTF_FIXED_LIGHT : 0u) |
                     (scene.view.fixed ? (uint32_t)BTF_FIXED_VIEW : 0u);
    memcpy(j->still.fixed_light, scene.light.direction, sizeof j->still.fixed_light);
    memcpy(j->still.fixed_view, scene.view.direction, sizeof j->still.fixed_view);
    return BTF_OK;
}

/* Makes the plan for a range of frames that begins with `first`, and the material and shader that it calls for. */
static btf_result plan_frames(job *j, int first) {
    const frame_wishes wishes = {
        .tolerance = (float)render_options.tolerance,
        .interpolate = render_options.frames > 1 || render_options.interpolation_given,
        .finest = render_options.level >= 0,
        .costs = costs_of(j),
        .still_lights = (uint32_t)j->still_lights.count,
        .folds = j->still_lights.count > 0 ? render_options.fold != SHADER_FOLD_NEVER : wants_folds(),
        .samples = render_options.fold == SHADER_FOLD_ALWAYS ? 0 : count_read(j, 1),
        .fold_bytes = SHADE_FOLD_BYTES};
    btf_result result =
        frame_plan(j->whole, j->seen, first, render_options.frames, &wishes, &j->planned_end, &j->plan);
    shader_destroy(&j->shader);
    btf_material_close(&j->material);
    if (!result) {
        result = btf_material_restrict(j->whole, &j->plan, &j->log, &j->material);
    }
    if (result) {
        return cli_error(&render_program, result, "option --plan: no plan can be made for these pictures");
    }
    if (render_options.stats) {
        printf("plan for frames %d to %d:\n", first + 1, j->planned_end);
        scene_plan_print(stdout, "  ", j->whole, &j->plan);
    }
    btf_material_get_info(j->material, &j->info);
    j->scene.table.texels[0] = (int)j->info.width;
    j->scene.table.texels[1] = (int)j->info.height;
    j->scene.table.levels = (int)j->info.levels;
    return open_shader(j, j->planned_end - first);
}

static btf_result prepare(job *j, const char *path) {
    btf_result result = make_lights(&j->log);
    if (!result && render_options.costs_file) {
        result = btf_cost_model_open(render_options.costs_file, &j->log, &j->costs);
    }
    if (!result) {
        result = btf_material_open(path, &j->log, &j->material);
    }
    if (!result) {
        result = load_mesh(j);
    }
    if (!result) {
        btf_material_get_info(j->material, &j->info);
    }
    if (!result && render_options.level >= (int)j->info.levels) {
        return cli_error(&render_program, BTF_ERROR_USAGE, "option --level: %d, but %s has %u level%s",
                         render_options.level, path, (unsigned)j->info.levels,
                         j->info.levels == 1 ? "" : "s");
    }
    if (!result && render_options.figure13 && !render_options.baseline &&
        j->info.colour == BTF_COLOUR_NONE) {
        return cli_error(&render_program, BTF_ERROR_USAGE,
                         "option --figure13: %s has no SBRDF; give a material that has one with --baseline",
                         path);
    }
    if (!result && render_options.env_sampled) {
        result = open_environment(j);
    }
    if (!result && render_options.baseline) {
        result = open_baseline(j);
    }
    if (!result && render_options.original) {
        result = open_original(j);
    }
    if (result) {
        return result;
    }
    j->scene = (render_scene){.table = {.mesh = j->mesh,
                                        .bvh = j->bvh,
                                        .camera = {render_options.view[0], render_options.view[1],
                                                   render_options.fov, render_options.zoom},
                                        .repeat = {render_options.repeat, render_options.repeat},
                                        .texels = {(int)j->info.width, (int)j->info.height},
                                        .levels = (int)j->info.levels,
                                        .level = render_options.figure13 ? 0 : render_options.level,
                                        .cast_shadows = render_options.cast_shadows,
                                        .threads = render_options.threads},
                              .lights = &render_options.lights,
                              .environment = j->environment,
                              .width = render_options.size[0],
                              .height = render_options.size[1],
                              .samples = render_options.samples,
                              .background = render_options.background};
    const size_t size = render_options.lights.count * sizeof *j->lights;
    j->lights = malloc(size ? size : 1);
    if (!j->lights) {
        return cli_error(&render_program, BTF_ERROR_MEMORY, "out of memory for lights");
    }
    if (size) {
        memcpy(j->lights, render_options.lights.lights, size);
    }
    if ((result = find_still_lights(j))) {
        return result;
    }
    if (render_options.plan != 0) {
        result = find_still(j);
        return result ? result : open_shader(j, render_options.frames);
    }
    j->whole = j->material;
    j->material = NULL;
    return see_frames(j);
}

/* OUT, or for an animation OUT with a number before its ending; false when it is too long. */
static bool frame_path(int frame, char *path, size_t size) {
    const char *dot = strrchr(render_options.out, '.');
    int length = render_options.frames == 1
                     ? snprintf(path, size, "%s", render_options.out)
                     : snprintf(path, size, "%.*s.%04d%s", (int)(dot - render_options.out),
                                render_options.out, frame + 1, dot);
    return length >= 0 && (size_t)length < size;
}

static btf_result render_all(job *j) {
    btf_result result = BTF_OK;
    for (int frame = 0; frame < render_options.frames && !result; frame++) {
        char path[4096];
        if (!frame_path(frame, path, sizeof path)) {
            return cli_error(&render_program, BTF_ERROR_USAGE, "option --output: the name is too long");
        }
        if (j->whole && frame == j->planned_end) {
            result = plan_frames(j, frame);
        }
        if (result) {
            break;
        }
        set_frame(j, frame);
        result = render_options.figure13 ? job_render_figure(j, path) : job_render(j, path);
        if (render_options.frames > 1 && !render_options.quiet && !result) {
            fprintf(stderr, "%s\n", path);
        }
    }
    return result;
}

/* Refuses a picture that would replace a file that it is made from. */
static btf_result check_output(const char *path) {
    const char *inputs[] = {path, render_options.mesh, render_options.environment, render_options.baseline};
    for (size_t i = 0; i < sizeof inputs / sizeof *inputs; i++) {
        if (inputs[i] && output_is_same(render_options.out, inputs[i])) {
            return cli_error(&render_program, BTF_ERROR_USAGE, "option --output: %s is an input",
                             inputs[i]);
        }
    }
    return BTF_OK;
}

static btf_result run(const cli_arguments *arguments) {
    const char *path = arguments->values[0];
    job j = {.log = cli_log(&render_program, render_options.quiet), .info = {.struct_size = sizeof j.info}};
    btf_result result = settings_check();
    if (!result) {
        result = check_output(path);
    }
    if (!result) {
        result = prepare(&j, path);
    }
    if (!result) {
        result = render_all(&j);
    }
    if (result == BTF_ERROR_INTERRUPTED) {
        cli_error(&render_program, result, "interrupted");
    }
    job_close(&j);
    return result;
}

int main(int argc, char **argv) {
    return cli_run(&render_program, argc, argv, run);
}
