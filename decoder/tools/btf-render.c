/* btf-render: a material on a mesh, without a window.
 *
 * SPDX-License-Identifier: MIT
 */
#include "cli.h"
#include "render/figure.h"
#include "render/original.h"
#include "render/plan_table.h"
#include "render/render.h"
#include "progress.h"
#include "scene_option.h"
#include <omp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static struct {
    const char *out, *mesh, *device, *environment, *original, *baseline;
    double view[2], repeat, fov, zoom, exposure, background, env_rotate, env_gain, tolerance;
    bool repeat_given, zoom_given, interpolation_given, figure13, stats, cast_shadows, quiet;
    light_list lights;
    uint32_t effects;
    int size[2], samples, env_lights, components, math, interpolation, filter, tone, frames, animate,
        threads, repeats, level, plan;
} options = {.mesh = "sphere",
             .device = "osmesa",
             .fov = 30,
             .env_gain = 1,
             .effects = BTF_EFFECT_ALL,
             .size = {512, 512},
             .samples = 1,
             .env_lights = 64,
             .components = BTF_MAX_COMPONENTS,
             .frames = 1,
             .level = -1,
             .plan = -1,
             .tolerance = 0.5,
             .repeats = 9};

static const char *parse_size(const char *text, void *value) {
    int *size = value, used = 0;
    if (sscanf(text, "%dx%d%n", &size[0], &size[1], &used) != 2 || text[used]) {
        if (sscanf(text, "%d%n", &size[0], &used) != 1 || text[used])
            return "N or WxH, each 1..8192";
        size[1] = size[0];
    }
    return size[0] >= 1 && size[0] <= 8192 && size[1] >= 1 && size[1] <= 8192 ? NULL
                                                                              : "N or WxH, each 1..8192";
}

static const char *parse_view(const char *text, void *value) {
    double *view = value;
    int used = 0;
    if (sscanf(text, "%lf,%lf%n", &view[0], &view[1], &used) != 2 || text[used] ||
        !(view[0] >= 0 && view[0] <= 180 && fabs(view[1]) <= 360))
        return "theta,phi in degrees, theta 0..180, phi -360..360";
    return NULL;
}

static const char *parse_level(const char *text, void *value) {
    int *level = value, used = 0;
    if (!strcmp(text, "auto")) {
        *level = -1;
        return NULL;
    }
    if (sscanf(text, "%d%n", level, &used) != 1 || text[used] || *level < 0)
        return "auto, or a level from 0";
    return NULL;
}

static const cli_option option_table[] = {
    {.short_name = 'o',
     .name = "output",
     .arg = "OUT",
     .type = CLI_STRING,
     .value = &options.out,
     .help = "picture to write: .png (sRGB, 8 bits) or .exr (linear float)"},
    {.name = "mesh",
     .arg = "MESH",
     .type = CLI_STRING,
     .value = &options.mesh,
     .help = "plane, sphere, torus, drape, or a Wavefront file *.obj with texture\n"
             "coordinates (default sphere)"},
    {.name = "repeat",
     .type = CLI_DOUBLE,
     .value = &options.repeat,
     .given = &options.repeat_given,
     .minimum = 0.001,
     .maximum = 1000,
     .help = "copies of the material along the mesh's unit of uv (default 3; plane, drape\n"
             "and OBJ 2)"},
    {.name = "size",
     .arg = "N|WxH",
     .type = CLI_CUSTOM,
     .value = options.size,
     .parse = parse_size,
     .help = "pixels (default 512)"},
    {.name = "samples",
     .type = CLI_INT,
     .value = &options.samples,
     .minimum = 1,
     .maximum = 8,
     .help = "N x N samples a pixel (default 1)"},
    {.name = "view",
     .type = CLI_CUSTOM,
     .arg = "T,P",
     .value = options.view,
     .parse = parse_view,
     .help = "where the camera stands, theta,phi in degrees: theta 0..180 from +z\n"
             "(default 0,0)"},
    {.name = "fov",
     .type = CLI_DOUBLE,
     .value = &options.fov,
     .minimum = 0,
     .maximum = 120,
     .help = "angle of view in degrees; 0: parallel projection (default 30)"},
    {.name = "zoom",
     .type = CLI_DOUBLE,
     .value = &options.zoom,
     .given = &options.zoom_given,
     .minimum = 0.01,
     .maximum = 100,
     .help = "the picture's smaller side spans 2/zoom at the origin (default 0.9; plane 1)"},
    {.name = "light",
     .arg = "T,P[,I[,R,G,B]]",
     .type = CLI_CUSTOM,
     .value = &options.lights,
     .parse = light_parse_directional,
     .help = "a light far away: direction, intensity, colour; may be given several times\n"
             "(default 40,120 when there is no other light)"},
    {.name = "point",
     .arg = "X,Y,Z[,I[,R,G,B]]",
     .type = CLI_CUSTOM,
     .value = &options.lights,
     .parse = light_parse_point,
     .help = "a light at a point; intensity I / distance^2; may be given several times"},
    {.name = "environment",
     .arg = "MAP",
     .type = CLI_STRING,
     .value = &options.environment,
     .help = "light from a latitude-longitude map, .exr or Radiance .hdr"},
    {.name = "environment-lights",
     .type = CLI_INT,
     .value = &options.env_lights,
     .minimum = 1,
     .maximum = 1024,
     .help = "directional lights that stand for the map (default 64)"},
    {.name = "environment-rotate",
     .arg = "DEG",
     .type = CLI_DOUBLE,
     .value = &options.env_rotate,
     .minimum = -360,
     .maximum = 360,
     .help = "turns the map to the right (default 0)"},
    {.name = "environment-gain",
     .type = CLI_DOUBLE,
     .value = &options.env_gain,
     .minimum = 0,
     .maximum = 1e6,
     .help = "multiplies the map (default 1)"},
    {.name = "cast-shadows",
     .type = CLI_FLAG,
     .value = &options.cast_shadows,
     .help = "the mesh casts shadows on itself"},
    {.name = "background",
     .arg = "GREY",
     .type = CLI_DOUBLE,
     .value = &options.background,
     .minimum = 0,
     .maximum = 1e6,
     .help = "linear value behind the mesh (default 0)"},
    {.name = "exposure",
     .arg = "STOPS",
     .type = CLI_DOUBLE,
     .value = &options.exposure,
     .minimum = -30,
     .maximum = 30,
     .help = "multiplies the picture by 2^STOPS (default 0)"},
    {.name = "tone",
     .type = CLI_CHOICE,
     .choices = "none|reinhard|filmic",
     .value = &options.tone,
     .help = "tone curve of PNG output (default none: values are clipped at 1)"},
    {.name = "effects",
     .type = CLI_EFFECTS,
     .value = &options.effects,
     .help = "effects to decode (default all that the file holds)"},
    {.name = "plan",
     .arg = "auto|none",
     .type = CLI_CHOICE,
     .value = &options.plan,
     .choices = "auto|none",
     .help = "auto: decode and upload only what the pictures call for (btf-info --plan)"},
    {.name = "tolerance",
     .arg = "DB",
     .type = CLI_DOUBLE,
     .value = &options.tolerance,
     .minimum = 0,
     .maximum = 100,
     .help = "what --plan may lose against the full decode, predicted; default 0.5"},
    {.name = "components",
     .type = CLI_INT,
     .value = &options.components,
     .minimum = 0,
     .maximum = BTF_MAX_COMPONENTS,
     .help = "residual components to decode (default all)"},
    {.name = "interpolation",
     .type = CLI_CHOICE,
     .choices = "linear|nearest",
     .value = &options.interpolation,
     .given = &options.interpolation_given,
     .help = "between sampled directions (default linear)"},
    {.name = "filter",
     .type = CLI_CHOICE,
     .choices = "texel|bilinear",
     .value = &options.filter,
     .help = "between texels (default texel)"},
    {.name = "level",
     .arg = "auto|N",
     .type = CLI_CUSTOM,
     .value = &options.level,
     .parse = parse_level,
     .help = "level of detail, of a file that has several: auto (default), by what a sample\n"
             "covers of the texture, or one for all"},
    {.name = "math",
     .type = CLI_CHOICE,
     .choices = "exact|fast",
     .value = &options.math,
     .help = "exact: the same bits on every device (default); fast: GL's own functions"},
    {.name = "device",
     .type = CLI_STRING,
     .value = &options.device,
     .help = "reference (the CPU), osmesa (default), egl, glfw, or another of\n"
             "btf-conform's devices"},
    {.name = "figure13",
     .type = CLI_FLAG,
     .value = &options.figure13,
     .help = "original, SBRDF, SBRDF with shadow (STVS) and all effects side by side,\n"
             "errors x 4 below, PSNR on stdout; needs --original"},
    {.name = "original",
     .arg = "DATA",
     .type = CLI_STRING,
     .value = &options.original,
     .help = "directory or zip of the images that the material was made from"},
    {.name = "baseline",
     .arg = "FILE",
     .type = CLI_STRING,
     .value = &options.baseline,
     .help = "with --figure13: another material for SBRDF and STVS, decoded by the\n"
             "reference; needed when FILE has no SBRDF (method joint may leave it out)"},
    {.name = "animate",
     .type = CLI_CHOICE,
     .choices = "view|light",
     .value = &options.animate,
     .help = "what turns through 360 degrees of phi over the frames: the camera\n"
             "(default) or all lights"},
    {.name = "frames",
     .type = CLI_INT,
     .value = &options.frames,
     .minimum = 1,
     .maximum = 9999,
     .help = "pictures OUT.0001.png, OUT.0002.png, ... (default 1: OUT itself)"},
    {.name = "stats",
     .type = CLI_FLAG,
     .value = &options.stats,
     .help = "print times: a frame under one light, and a textured Phong shader over the\n"
             "same pixels (GL devices; median of 9)"},
    {.name = "threads",
     .type = CLI_INT,
     .value = &options.threads,
     .minimum = 1,
     .maximum = 1024,
     .help = "threads (default: all cores); the picture does not depend on it"},
    {.name = "quiet", .type = CLI_FLAG, .value = &options.quiet, .help = "no progress"},
    {.type = CLI_END},
};

static const cli_program program = {
    .name = "btf-render",
    .usage = "FILE -o OUT [options]",
    .summary = "Renders a material file (*.btf.exr) on a mesh. Visibility, texture coordinates, light and "
               "view are\n"
               "ray-cast once on the CPU; the device evaluates the material; lights, averaging and tone "
               "curve are C.\n"
               "With exact math every device gives the same picture, pixel for pixel.",
    .details =
        "World: x to the right, y up, z towards the default camera; angles are theta from +z, phi from +x\n"
        "towards +y. Built-in meshes fill -1..1; an OBJ is centred and scaled to radius 1. A light of\n"
        "intensity 1 shows the material's own values (a white diffuse surface facing it is 1).\n"
        "Exit codes: 0 ok, 1 usage, 2 input or output failed, 3 bad file, 4 internal error or out of "
        "memory,\n"
        "5 no such device here, 130 interrupted.",
    .example = "btf-render bricks.btf.exr -o sphere.png --light 40,120 --samples 2\n"
               "btf-render bricks.btf.exr -o teapot.png --mesh teapot.obj --environment sky.exr\n"
               "btf-render bricks.btf.exr -o figure13.png --figure13 --original BRICKS64.zip --mesh plane "
               "--view 40,-90\n"
               "btf-render bricks.btf.exr -o turn.png --frames 36 --animate light",
    .options = option_table,
    .min_arguments = 1,
    .max_arguments = 1,
};

/* What a run holds. */
typedef struct job {
    btf_log log;
    btf_material *material, *baseline;
    btf_material_info info;
    mesh *mesh;
    bvh *bvh;
    shader *shader, *baseline_shader;
    original *original;
    render_scene scene;
    btf_plan plan; /* with --plan auto */
} job;

static btf_result check_options(void) {
    if (!options.out)
        return cli_error(&program, BTF_ERROR_USAGE, "option --output is missing: a picture, .png or .exr");
    if (!picture_knows(options.out))
        return cli_error(&program, BTF_ERROR_USAGE,
                         "option --output: '%s' ends neither in .png nor in .exr", options.out);
    if (options.figure13 && !options.original)
        return cli_error(&program, BTF_ERROR_USAGE,
                         "option --figure13: needs --original, the images that the material was made from");
    if (!options.figure13 && (options.original || options.baseline))
        return cli_error(&program, BTF_ERROR_USAGE, "option --%s: only together with --figure13",
                         options.original ? "original" : "baseline");
    if (options.figure13 && options.plan == 0)
        return cli_error(&program, BTF_ERROR_USAGE, "option --plan: not together with --figure13");
    if (options.figure13 && options.level > 0)
        return cli_error(&program, BTF_ERROR_USAGE,
                         "option --level: %d, but --figure13 compares the original with level 0",
                         options.level);
    if (options.environment && (options.env_lights & (options.env_lights - 1)))
        return cli_error(&program, BTF_ERROR_USAGE,
                         "option --environment-lights: %d, expected a power of two", options.env_lights);
    if (options.threads == 0)
        options.threads = omp_get_num_procs();
    return BTF_OK;
}

static btf_result make_lights(const btf_log *log) {
    if (options.environment)
        return light_list_read_environment(&options.lights, options.environment, options.env_lights,
                                           options.env_rotate, options.env_gain, log);
    if (!options.lights.count && light_parse_directional("40,120", &options.lights))
        return BTF_ERROR_MEMORY;
    return BTF_OK;
}

static btf_result load_mesh(job *j) {
    const char *name = options.mesh;
    size_t length = strlen(name);
    bool flat = !strcmp(name, "plane") || !strcmp(name, "drape");
    btf_result result;
    if (length > 4 && !strcmp(name + length - 4, ".obj")) {
        result = mesh_read_obj(name, &j->log, &j->mesh);
        flat = true;
    } else {
        result = mesh_make(name, &j->log, &j->mesh);
    }
    if (result)
        return result;
    if (!options.repeat_given)
        options.repeat = flat ? 2 : 3;
    if (!options.zoom_given)
        options.zoom = strcmp(name, "plane") ? 0.9 : 1;
    j->bvh = bvh_create(j->mesh);
    return j->bvh ? BTF_OK : cli_error(&program, BTF_ERROR_MEMORY, "out of memory for the mesh");
}

static btf_result open_shader(job *j) {
    shader_request request = {.device = options.device,
                              .material = j->material,
                              .variants = options.figure13 ? 3 : 1,
                              .effects = {options.effects},
                              .components = (uint32_t)options.components,
                              .interpolation = (btf_interpolation)options.interpolation,
                              .filter = (btf_filter)options.filter,
                              .math = (btf_math)options.math,
                              .level = options.figure13 ? 0 : options.level,
                              .threads = options.threads};
    if (options.figure13) {
        request.effects[0] = 0;
        request.effects[1] = BTF_EFFECT_SHADOW;
        request.effects[2] = options.effects;
    }
    btf_result result = shader_create(&request, &j->log, &j->shader);
    if (!result && options.size[0] * options.samples > shader_max_width(j->shader))
        return cli_error(&program, BTF_ERROR_UNSUPPORTED,
                         "%d samples a row exceed the device's GL_MAX_TEXTURE_SIZE %d",
                         options.size[0] * options.samples, shader_max_width(j->shader));
    return result;
}

/* The panels SBRDF and STVS of figure 13 from another material. */
static btf_result open_baseline(job *j) {
    btf_material_info info = {.struct_size = sizeof info};
    btf_result result = btf_material_open(options.baseline, &j->log, &j->baseline);
    if (result)
        return result;
    btf_material_get_info(j->baseline, &info);
    if (info.colour == BTF_COLOUR_NONE)
        return cli_error(&program, BTF_ERROR_USAGE, "option --baseline: %s has no SBRDF", options.baseline);
    const shader_request request = {.device = "reference",
                                    .material = j->baseline,
                                    .variants = 2,
                                    .effects = {0, BTF_EFFECT_SHADOW},
                                    .interpolation = (btf_interpolation)options.interpolation,
                                    .filter = (btf_filter)options.filter,
                                    .threads = options.threads};
    return shader_create(&request, &j->log, &j->baseline_shader);
}

static btf_result open_original(job *j) {
    progress *p = progress_create(options.quiet);
    if (!p)
        return cli_error(&program, BTF_ERROR_MEMORY, "out of memory");
    btf_result result =
        original_open(options.original, j->material, options.threads, p, &j->log, &j->original);
    progress_destroy(&p);
    return result;
}

/* All lights by `degrees` of phi. */
static void turn_lights(double degrees) {
    const double c = cos(degrees * (RENDER_PI / 180)), s = sin(degrees * (RENDER_PI / 180));
    for (size_t i = 0; i < options.lights.count; i++) {
        vec3 *at = &options.lights.lights[i].at;
        *at = vec(c * at->x - s * at->y, s * at->x + c * at->y, at->z);
    }
}

/* The camera or the lights of a frame of an animation. */
static void set_frame(job *j, int frame) {
    const double step = 360.0 / options.frames;
    if (options.animate == 0)
        j->scene.table.camera.phi = options.view[1] + frame * step;
    else if (frame > 0)
        turn_lights(step);
}

/* What all frames see; lights are left as they were. */
static btf_result range_of_frames(job *j, plan_range *range) {
    const size_t size = options.lights.count * sizeof *options.lights.lights;
    light *before = malloc(size ? size : 1);
    btf_result result = before ? BTF_OK : BTF_ERROR_MEMORY;
    if (before)
        memcpy(before, options.lights.lights, size);
    for (int frame = 0; frame < options.frames && !result; frame++) {
        set_frame(j, frame);
        result = plan_range_add(&j->scene, range);
    }
    if (before)
        memcpy(options.lights.lights, before, size);
    free(before);
    return result;
}

/* One plan for all frames: the material becomes what they call for. */
static btf_result plan_pictures(job *j) {
    plan_range range = {0};
    btf_plan *plan = &j->plan;
    btf_material *small = NULL;
    btf_result result = range_of_frames(j, &range);
    if (result)
        return cli_error(&program, result, "out of memory for a plan");
    btf_scene scene = plan_range_scene(&range);
    scene.interpolate = options.frames > 1 || options.interpolation_given;
    if (options.level >= 0)
        scene.pixels = 1;
    result = btf_plan_effects(j->material, &scene, (float)options.tolerance, plan);
    if (!result)
        result = btf_material_restrict(j->material, plan, &j->log, &small);
    if (result)
        return cli_error(&program, result, "no plan for these pictures");
    btf_material_close(&j->material);
    j->material = small;
    btf_material_get_info(j->material, &j->info);
    j->scene.table.texels[0] = (int)j->info.width;
    j->scene.table.texels[1] = (int)j->info.height;
    j->scene.table.levels = (int)j->info.levels;
    options.effects &= plan->effects;
    if (plan->components && (int)plan->components < options.components)
        options.components = (int)plan->components;
    if (!options.interpolation_given)
        options.interpolation = plan->shader.interpolation == BTF_INTERPOLATION_NEAREST
                                    ? BTF_INTERPOLATION_NEAREST
                                    : options.interpolation;
    return BTF_OK;
}

static btf_result prepare(job *j, const char *path) {
    btf_result result = make_lights(&j->log);
    if (!result)
        result = btf_material_open(path, &j->log, &j->material);
    if (!result)
        result = load_mesh(j);
    if (!result)
        btf_material_get_info(j->material, &j->info);
    if (!result && options.level >= (int)j->info.levels)
        return cli_error(&program, BTF_ERROR_USAGE, "option --level: %d, but %s has %u level%s", options.level,
                         path, (unsigned)j->info.levels, j->info.levels == 1 ? "" : "s");
    if (!result && options.figure13 && !options.baseline && j->info.colour == BTF_COLOUR_NONE)
        return cli_error(&program, BTF_ERROR_USAGE,
                         "option --figure13: %s has no SBRDF; give a material that has one with --baseline",
                         path);
    if (!result && options.baseline)
        result = open_baseline(j);
    if (!result && options.original)
        result = open_original(j);
    if (result)
        return result;
    j->scene =
        (render_scene){.table = {.mesh = j->mesh,
                                 .bvh = j->bvh,
                                 .camera = {options.view[0], options.view[1], options.fov, options.zoom},
                                 .repeat = {options.repeat, options.repeat},
                                 .texels = {(int)j->info.width, (int)j->info.height},
                                 .levels = (int)j->info.levels,
                                 .level = options.figure13 ? 0 : options.level,
                                 .cast_shadows = options.cast_shadows,
                                 .threads = options.threads},
                       .lights = &options.lights,
                       .width = options.size[0],
                       .height = options.size[1],
                       .samples = options.samples,
                       .background = options.background};
    if (options.plan == 0)
        result = plan_pictures(j);
    return result ? result : open_shader(j);
}

/* OUT, or for an animation OUT with a number before its ending; false when it is too long. */
static bool frame_path(int frame, char *path, size_t size) {
    const char *dot = strrchr(options.out, '.');
    int length = options.frames == 1 ? snprintf(path, size, "%s", options.out)
                                     : snprintf(path, size, "%.*s.%04d%s", (int)(dot - options.out),
                                                options.out, frame + 1, dot);
    return length >= 0 && (size_t)length < size;
}

static void print_times(const char *name, const shader_times *t) {
    printf("%s: %.2f ms a frame, %.1f frames a second, %.2f ms of CPU\n", name, 1e3 * t->seconds,
           1 / t->seconds, 1e3 * t->cpu);
}

static void print_stats(const job *j, const render_times *t) {
    printf("device: %s\n", shader_name(j->shader));
    printf("picture: %d x %d, %d samples a pixel, %zu lights, %s, %s, %s\n", j->scene.width,
           j->scene.height, j->scene.samples * j->scene.samples, options.lights.count,
           options.interpolation == BTF_INTERPOLATION_NEAREST ? "nearest" : "linear",
           options.filter == BTF_FILTER_BILINEAR ? "bilinear" : "texel",
           options.math == BTF_MATH_FAST ? "fast" : "exact");
    if (options.plan == 0) {
        printf("plan:\n");
        scene_plan_print(stdout, "  ", &j->plan);
    }
    printf("cast: %.1f ms\nshade: %.1f ms\n", 1e3 * t->cast, 1e3 * t->shade);
    if (t->decode.seconds > 0) {
        print_times("decode", &t->decode);
        print_times("phong", &t->phong);
    }
}

static btf_result render_one(job *j, const char *path) {
    picture picture;
    const evaluator evaluator = evaluator_of_shader(j->shader, 0);
    render_times times = {.shader = j->shader,
                          .repeats =
                              options.stats && strcmp(options.device, "reference") ? options.repeats : 0};
    btf_result result = render_frame(&j->scene, &evaluator, 1, &picture, NULL, &times, &j->log);
    if (result)
        return result;
    picture_expose(&picture, exp2(options.exposure));
    result = picture_write(&picture, path, (tone)options.tone, j->log);
    picture_clear(&picture);
    if (!result && options.stats)
        print_stats(j, &times);
    return result;
}

static btf_result render_figure(job *j, const char *path) {
    picture pictures[FIGURE_COLUMNS];
    evaluator evaluators[FIGURE_COLUMNS] = {original_evaluator(j->original)};
    render_times times = {0};
    unsigned char *mask = calloc((size_t)j->scene.width * (size_t)j->scene.height, 1);
    if (!mask)
        return cli_error(&program, BTF_ERROR_MEMORY, "out of memory for a mask");
    for (int i = 1; i < FIGURE_COLUMNS; i++)
        evaluators[i] =
            evaluator_of_shader(i < 3 && j->baseline_shader ? j->baseline_shader : j->shader, i - 1);
    btf_result result =
        render_frame(&j->scene, evaluators, FIGURE_COLUMNS, pictures, mask, &times, &j->log);
    if (!result) {
        for (int i = 0; i < FIGURE_COLUMNS; i++)
            picture_expose(&pictures[i], exp2(options.exposure));
        result = figure_write(pictures, mask, path, (tone)options.tone, j->log);
        for (int i = 0; i < FIGURE_COLUMNS; i++)
            picture_clear(&pictures[i]);
    }
    free(mask);
    if (!result && options.stats)
        print_stats(j, &times);
    return result;
}

static btf_result render_all(job *j) {
    btf_result result = BTF_OK;
    for (int frame = 0; frame < options.frames && !result; frame++) {
        char path[4096];
        if (!frame_path(frame, path, sizeof path))
            return cli_error(&program, BTF_ERROR_USAGE, "option --output: the name is too long");
        set_frame(j, frame);
        result = options.figure13 ? render_figure(j, path) : render_one(j, path);
        if (options.frames > 1 && !options.quiet && !result)
            fprintf(stderr, "%s\n", path);
    }
    return result;
}

static btf_result run(const char *path) {
    job j = {.log = cli_log(&program, options.quiet), .info = {.struct_size = sizeof j.info}};
    btf_result result = check_options();
    if (!result)
        result = prepare(&j, path);
    if (!result)
        result = render_all(&j);
    if (result == BTF_ERROR_INTERRUPTED)
        cli_error(&program, result, "interrupted");
    original_close(&j.original);
    shader_destroy(&j.shader);
    shader_destroy(&j.baseline_shader);
    bvh_destroy(&j.bvh);
    mesh_destroy(&j.mesh);
    btf_material_close(&j.material);
    btf_material_close(&j.baseline);
    light_list_clear(&options.lights);
    return result;
}

int main(int argc, char **argv) {
    cli_arguments arguments;
    int exit_code;
    if (!cli_parse(&program, argc, argv, &arguments, &exit_code))
        return exit_code;
    return cli_finish(&program, run(arguments.values[0]));
}
