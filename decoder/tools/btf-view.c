/* btf-view: a material in a window.
 *
 * SPDX-License-Identifier: MIT
 */
#include "cli.h"
#include <openbtf/plan.h>
#include "png_image.h"
#include "progress.h"
#include "view/costs.h"
#include "view/drawing.h"
#include "view/overlay.h"
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <math.h>
#include <omp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static struct {
    const char *mesh, *original, *screenshots;
    int size[2], interpolation, filter, math, level, plan;
    double tolerance;
    uint32_t effects;
    bool verbose, quiet;
} options = {.plan = -1, .tolerance = 0.5, .screenshots = "btf-view", .size = {800, 800}, .effects = BTF_EFFECT_ALL};

static const cli_option option_table[] = {
    {.name = "mesh",
     .arg = "MESH",
     .type = CLI_STRING,
     .value = &options.mesh,
     .help = "sphere (default), plane, torus, drape, or a Wavefront file *.obj"},
    {.name = "original",
     .arg = "DATA",
     .type = CLI_STRING,
     .value = &options.original,
     .help = "directory or zip of the images that the material was made from, for the\n"
             "split screen"},
    {.name = "size",
     .type = CLI_SIZE,
     .value = options.size,
     .minimum = 16,
     .maximum = 8192,
     .help = "of the window (default 800x800)"},
    {.name = "effects",
     .type = CLI_EFFECTS,
     .value = &options.effects,
     .help = "effects to begin with (default all)"},
    {.name = "interpolation",
     .type = CLI_CHOICE,
     .choices = "linear|nearest",
     .value = &options.interpolation,
     .help = "between sampled directions (default linear)"},
    {.name = "filter",
     .type = CLI_CHOICE,
     .choices = "texel|bilinear",
     .value = &options.filter,
     .help = "between texels (default texel)"},
    {.name = "math",
     .type = CLI_CHOICE,
     .choices = "exact|fast",
     .value = &options.math,
     .help = "exact (default), or the device's own functions"},
    {.name = "level",
     .type = CLI_CHOICE,
     .choices = "auto|0",
     .value = &options.level,
     .help = "level of detail, of a file that has several: by pixel (default), or the\n"
             "finest"},
    {.name = "plan",
     .arg = "auto|none",
     .type = CLI_CHOICE,
     .choices = "auto|none",
     .value = &options.plan,
     .help = "auto: upload and decode only what an orbit under any light calls for\n"
             "(btf-info --plan interpolate); default none"},
    {.name = "tolerance",
     .arg = "DB",
     .type = CLI_DOUBLE,
     .value = &options.tolerance,
     .minimum = 0,
     .maximum = 100,
     .help = "what --plan may lose against the full decode, predicted; default 0.5"},
    {.name = "screenshots",
     .arg = "PREFIX",
     .type = CLI_STRING,
     .value = &options.screenshots,
     .help = "key P writes PREFIX-0001.png and so on (default btf-view)"},
    {.name = "verbose",
     .type = CLI_FLAG,
     .value = &options.verbose,
     .help = "print every change on stdout"},
    {.name = "quiet",
     .type = CLI_FLAG,
     .value = &options.quiet,
     .help = "no progress while reading images"},
    {.type = CLI_END},
};

static const cli_program program = {
    .name = "btf-view",
    .usage = "[FILE] [options]",
    .summary =
        "Shows a material file (*.btf.exr) on a model in a window. Press H for the keys; drop files into\n"
        "the window: another material or a model (*.obj).",
    .details =
        "Left drag turns the model, right drag (or Shift + left) moves the light, the wheel zooms.\n"
        "Keys: M model, 1..5 effects, 0 all of them, N nearest directions, B bilinear, X fast math,\n"
        "L levels of detail, S split screen (middle drag or [ ] move it), + - exposure, A animate,\n"
        "C measure the cost of each effect, P save a picture, I panel, R reset, H help, Q quit.\n"
        "Exit codes: 0 ok, 1 usage, 2 input or output failed, 3 bad file, 4 internal error or out of\n"
        "memory, 5 no display or no OpenGL 3.3.",
    .example = "btf-view bricks.btf.exr --original BRICKS64.zip",
    .options = option_table,
    .max_arguments = 1,
};

typedef struct viewer {
    GLFWwindow *window;
    gl_api gl;
    btf_log log;
    view_state state;
    costs costs;
    btf_material *material;
    original *images;
    drawing *drawing;
    overlay *overlay;
    mesh *own_mesh;
    char material_name[64], message[160];
    btf_plan plan; /* with --plan auto */
    double pointer[2], frame_ms, animated_at;
    bool dirty;
    btf_result failed; /* ends the loop */
} viewer;

static void tell(viewer *v, const char *text) {
    snprintf(v->message, sizeof v->message, "%.150s", text);
    v->dirty = true;
    if (options.verbose) {
        printf("%s\n", text);
        fflush(stdout);
    }
}

/* Errors go to stderr and to the panel. */
static void log_message(void *user, btf_log_level level, const char *message) {
    viewer *v = user;
    if (level <= BTF_LOG_WARNING) {
        fprintf(stderr, "btf-view: %s: %s\n", level == BTF_LOG_ERROR ? "error" : "warning", message);
        snprintf(v->message, sizeof v->message, "%.150s", message);
        v->dirty = true;
    }
}

static btf_gl_function find_function(void *user, const char *name) {
    (void)user;
    return (btf_gl_function)glfwGetProcAddress(name);
}

static const char *base_name(const char *path) {
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

static btf_result use_mesh(viewer *v) {
    mesh *made = NULL;
    const mesh *m = v->own_mesh;
    const bool flat = v->state.mesh != 0 && v->state.mesh != 2;
    btf_result result = BTF_OK;
    if (v->state.mesh != VIEW_OWN_MESH) {
        result = mesh_make(view_mesh_name(v->state.mesh), &v->log, &made);
        m = made;
    }
    if (!result)
        result = drawing_set_mesh(v->drawing, m, flat ? 2 : 3, &v->log);
    mesh_destroy(&made);
    costs_clear(&v->costs);
    return result;
}

static btf_result load_mesh(viewer *v, const char *path) {
    mesh *m = NULL;
    btf_result result = mesh_read_obj(path, &v->log, &m);
    if (result)
        return result;
    mesh_destroy(&v->own_mesh);
    v->own_mesh = m;
    v->state.has_own_mesh = true;
    v->state.mesh = VIEW_OWN_MESH;
    return BTF_OK;
}

static btf_result open_images(viewer *v, const char *path) {
    progress *p = progress_create(options.quiet);
    if (!p)
        return cli_error(&program, BTF_ERROR_MEMORY, "out of memory");
    btf_result result = original_open(path, v->material, omp_get_num_procs(), p, &v->log, &v->images);
    progress_destroy(&p);
    return result;
}

/* What the panel and the keys need to know of the material. */
static void use_material_facts(viewer *v, const char *path) {
    btf_material_info info = {.struct_size = sizeof info};
    btf_material_get_info(v->material, &info);
    v->state.has_sbrdf = info.colour != BTF_COLOUR_NONE;
    v->state.has_levels = info.levels > 1;
    if (options.plan == 0)
        v->state.effects &= info.effects;
    if (!v->state.has_sbrdf && v->state.split == VIEW_SPLIT_SBRDF)
        v->state.split = VIEW_SPLIT_OFF;
    snprintf(v->material_name, sizeof v->material_name, "%.60s", base_name(path));
}

/* With --plan auto the material becomes what the plan names. */
static btf_result open_planned(viewer *v, const char *path, btf_material **out_material) {
    btf_material *whole = NULL;
    btf_result result = btf_material_open(path, &v->log, &whole);
    if (result || options.plan != 0) {
        *out_material = whole;
        return result;
    }
    const btf_scene orbit = {.struct_size = sizeof orbit, .interpolate = 1};
    btf_plan plan;
    result = btf_plan_effects(whole, &orbit, (float)options.tolerance, &plan);
    if (!result)
        result = btf_material_restrict(whole, &plan, &v->log, out_material);
    if (!result)
        v->plan = plan;
    btf_material_close(&whole);
    return result;
}

/* Another material; what is shown stays when it cannot be opened. The images belong to the old one. */
static btf_result load_material(viewer *v, const char *path) {
    btf_material *fresh = NULL;
    btf_result result = open_planned(v, path, &fresh);
    if (result)
        return result;
    result = drawing_set_material(v->drawing, fresh, NULL, &v->log);
    original_close(&v->images);
    btf_material_close(&v->material);
    v->state.has_original = false;
    if (v->state.split == VIEW_SPLIT_ORIGINAL)
        v->state.split = VIEW_SPLIT_OFF;
    if (result) {
        btf_material_close(&fresh);
        v->state.has_sbrdf = false;
        return result;
    }
    v->material = fresh;
    use_material_facts(v, path);
    costs_clear(&v->costs);
    return BTF_OK;
}

static uint32_t effects_in_use(const viewer *v) {
    btf_material_info info = {.struct_size = sizeof info};
    btf_material_get_info(v->material, &info);
    return v->state.effects & info.effects;
}

static void frame_size(const viewer *v, int *width, int *height) {
    glfwGetFramebufferSize(v->window, width, height);
    *width = *width > 0 ? *width : 1;
    *height = *height > 0 ? *height : 1;
}

/* Draws the model and measures it. */
static btf_result draw_model(viewer *v, const view_state *s, double *out_ms) {
    int width, height;
    frame_size(v, &width, &height);
    v->gl.Finish();
    double start = glfwGetTime();
    btf_result result = drawing_draw(v->drawing, s, width, height, &v->log);
    v->gl.Finish();
    *out_ms = 1e3 * (glfwGetTime() - start);
    return result;
}

static void panel_text(const viewer *v, char *text, size_t size) {
    char list[600] = "", quality[80] = "not in the file", words[48];
    if (!v->material) {
        snprintf(text, size, "drop a material here: *.btf.exr\n%s", v->message);
        return;
    }
    const btf_material_error *error = costs_error(v->material, v->state.effects);
    if (error)
        snprintf(quality, sizeof quality, "%.1f dB linear, %.1f dB sRGB", (double)error->psnr_linear,
                 (double)error->psnr_srgb);
    if (options.plan == 0 && v->plan.measured)
        snprintf(quality, sizeof quality, "planned %.1f dB linear of %.1f, %.0f%% of bytes, k %u",
                 (double)v->plan.psnr_linear, (double)v->plan.full_psnr_linear,
                 100 * (double)v->plan.gpu_bytes / (double)v->plan.full_gpu_bytes, (unsigned)v->plan.components);
    costs_text(&v->costs, v->material, v->state.effects, list, sizeof list);
    snprintf(text, size,
             "%s on %s\n%s, %s, %s math%s, exposure %+.2f\nframe %.1f ms (%.0f a second)\nPSNR %s\n"
             "effects %s: time and PSNR of each\n%ssplit %s\n%s",
             v->material_name, view_mesh_name(v->state.mesh),
             v->state.interpolation == BTF_INTERPOLATION_NEAREST ? "nearest" : "linear",
             v->state.filter == BTF_FILTER_BILINEAR ? "bilinear" : "texel",
             v->state.math == BTF_MATH_FAST ? "fast" : "exact",
             !v->state.has_levels ? ""
             : v->state.levels    ? ", levels"
                                  : ", level 0",
             v->state.exposure, v->frame_ms,
             1e3 / (v->frame_ms > 0.01 ? v->frame_ms : 0.01), quality,
             cli_effects_text(v->state.effects, words), list, view_split_name(v->state.split),
             v->message[0] ? v->message : "H: help");
}

/* Letters of twice the size on large windows. */
static void draw_overlays(viewer *v) {
    char text[1600];
    int width, height, w, h;
    frame_size(v, &width, &height);
    const int zoom = width >= 1100 && height >= 900 ? 2 : 1;
    if (v->state.info || !v->material) {
        panel_text(v, text, sizeof text);
        overlay_draw(v->overlay, text, 6, 6, zoom, width, height);
    }
    if (v->state.help) {
        overlay_size(view_help_text(), zoom, &w, &h);
        overlay_draw(v->overlay, view_help_text(), (width - w) / 2, (height - h) / 2, zoom, width, height);
    }
}

static btf_result draw_frame(viewer *v) {
    btf_result result = draw_model(v, &v->state, &v->frame_ms);
    if (result)
        return result;
    if (v->material && v->state.split == VIEW_SPLIT_OFF)
        costs_record(&v->costs, effects_in_use(v), v->frame_ms);
    draw_overlays(v);
    return BTF_OK;
}

/* Times the effects as they are, then with each one changed: the median of five frames each. */
static btf_result measure(viewer *v) {
    if (!v->material)
        return BTF_OK;
    view_state s = v->state;
    btf_material_info info = {.struct_size = sizeof info};
    btf_material_get_info(v->material, &info);
    s.split = VIEW_SPLIT_OFF;
    costs_clear(&v->costs);
    for (uint32_t i = 0; i <= 5; i++) {
        const uint32_t change = i < 5 ? 1u << i : 0;
        double ms[6];
        if (change && !(info.effects & change))
            continue;
        s.effects = effects_in_use(v) ^ change;
        for (int k = 0; k < 6; k++) { /* the first compiles */
            btf_result result = draw_model(v, &s, &ms[k]);
            if (result)
                return result;
        }
        for (int a = 1; a < 6; a++)
            for (int b = a + 1; b < 6; b++)
                if (ms[b] < ms[a]) {
                    double swap = ms[a];
                    ms[a] = ms[b];
                    ms[b] = swap;
                }
        costs_record(&v->costs, s.effects, ms[3]);
    }
    char text[160];
    snprintf(text, sizeof text, "measured: %.1f ms a frame", v->costs.ms[effects_in_use(v)]);
    tell(v, text);
    return BTF_OK;
}

static btf_result save_picture(viewer *v) {
    static int number = 0;
    char path[1024], text[1100];
    int width, height;
    btf_result result = draw_frame(v);
    if (result)
        return result;
    frame_size(v, &width, &height);
    do
        snprintf(path, sizeof path, "%.900s-%04d.png", options.screenshots, ++number);
    while (access(path, F_OK) == 0 && number < 9999);
    const size_t row = (size_t)width * 3;
    unsigned char *rgba = malloc((size_t)width * (size_t)height * 4), *rgb = malloc(row * (size_t)height);
    if (!rgba || !rgb) {
        free(rgba);
        free(rgb);
        return cli_error(&program, BTF_ERROR_MEMORY, "out of memory for a picture");
    }
    v->gl.ReadPixels(0, 0, width, height, GL_RGBA, GL_UNSIGNED_BYTE, rgba);
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++)
            memcpy(rgb + (size_t)(height - 1 - y) * row + 3 * (size_t)x,
                   rgba + 4 * ((size_t)y * (size_t)width + (size_t)x), 3);
    if (png_image_write8(path, width, height, rgb, v->log) == BTF_OK) {
        snprintf(text, sizeof text, "saved %s", path);
        tell(v, text);
    }
    free(rgba);
    free(rgb);
    return BTF_OK;
}

static viewer *of(GLFWwindow *window) {
    return glfwGetWindowUserPointer(window);
}

/* The program's own codes of GLFW's keys; letters and digits are the same. */
static int key_code(int key) {
    switch (key) {
    case GLFW_KEY_ESCAPE:
        return VIEW_KEY_ESCAPE;
    case GLFW_KEY_F1:
        return VIEW_KEY_F1;
    case GLFW_KEY_KP_ADD:
        return '+';
    case GLFW_KEY_KP_SUBTRACT:
        return '-';
    default:
        return key;
    }
}

static void on_key(GLFWwindow *window, int key, int scan_code, int action, int modifiers) {
    viewer *v = of(window);
    char text[160];
    const int mesh_before = v->state.mesh;
    (void)scan_code;
    if (action == GLFW_RELEASE || modifiers & (GLFW_MOD_CONTROL | GLFW_MOD_ALT | GLFW_MOD_SUPER))
        return;
    switch (view_state_key(&v->state, key_code(key), text, sizeof text)) {
    case VIEW_NOTHING:
        return;
    case VIEW_QUIT:
        glfwSetWindowShouldClose(window, GLFW_TRUE);
        return;
    case VIEW_SCREENSHOT:
        v->failed = save_picture(v);
        return;
    case VIEW_MEASURE:
        v->failed = measure(v);
        return;
    case VIEW_CHANGED:
        break;
    }
    if (key == GLFW_KEY_N || key == GLFW_KEY_B || key == GLFW_KEY_X || key == GLFW_KEY_L ||
        key == GLFW_KEY_R)
        costs_clear(&v->costs);
    if (v->state.mesh != mesh_before)
        v->failed = use_mesh(v);
    v->animated_at = glfwGetTime();
    tell(v, text);
}

static void on_pointer(GLFWwindow *window, double x, double y) {
    viewer *v = of(window);
    int width, height;
    glfwGetWindowSize(window, &width, &height);
    const double dx = (x - v->pointer[0]) / (width > 0 ? width : 1),
                 dy = (y - v->pointer[1]) / (height > 0 ? height : 1);
    const bool shift = glfwGetKey(window, GLFW_KEY_LEFT_SHIFT) || glfwGetKey(window, GLFW_KEY_RIGHT_SHIFT);
    const bool left = glfwGetMouseButton(window, GLFW_MOUSE_BUTTON_LEFT),
               right = glfwGetMouseButton(window, GLFW_MOUSE_BUTTON_RIGHT),
               middle = glfwGetMouseButton(window, GLFW_MOUSE_BUTTON_MIDDLE);
    v->pointer[0] = x;
    v->pointer[1] = y;
    if (!left && !right && !middle)
        return;
    char text[160];
    if (middle) {
        view_state_drag(&v->state, VIEW_DRAG_SPLIT, dx, dy);
        snprintf(text, sizeof text, "split at %.2f", v->state.split_at);
    } else if (right || shift) {
        view_state_drag(&v->state, VIEW_DRAG_LIGHT, dx, dy);
        snprintf(text, sizeof text, "light %.0f,%.0f", v->state.light_theta, v->state.light_phi);
    } else {
        view_state_drag(&v->state, VIEW_DRAG_ORBIT, dx, dy);
        snprintf(text, sizeof text, "view %.0f,%.0f", v->state.theta, v->state.phi);
    }
    tell(v, text);
}

static void on_scroll(GLFWwindow *window, double dx, double dy) {
    viewer *v = of(window);
    char text[80];
    (void)dx;
    view_state_scroll(&v->state, dy);
    snprintf(text, sizeof text, "zoom %.2f", v->state.zoom);
    tell(v, text);
}

static void on_drop(GLFWwindow *window, int count, const char **paths) {
    viewer *v = of(window);
    for (int i = 0; i < count; i++) {
        const size_t length = strlen(paths[i]);
        const bool is_mesh = length > 4 && !strcmp(paths[i] + length - 4, ".obj");
        btf_result result = is_mesh ? load_mesh(v, paths[i]) : load_material(v, paths[i]);
        if (!result && is_mesh)
            result = use_mesh(v);
        if (!result) {
            char text[160];
            snprintf(text, sizeof text, "opened %.120s", base_name(paths[i]));
            tell(v, text);
        }
    }
}

static void on_refresh(GLFWwindow *window) {
    of(window)->dirty = true;
}

static void on_resize(GLFWwindow *window, int width, int height) {
    (void)width;
    (void)height;
    costs_clear(&of(window)->costs);
    of(window)->dirty = true;
}

static btf_result open_window(viewer *v) {
    const char *reason = NULL;
    if (!glfwInit()) {
        glfwGetError(&reason);
        return cli_error(&program, BTF_ERROR_UNSUPPORTED,
                         "no display: %s; btf-render makes pictures without one",
                         reason ? reason : "unknown");
    }
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    glfwWindowHint(GLFW_OPENGL_FORWARD_COMPAT, GLFW_TRUE);
    v->window = glfwCreateWindow(options.size[0], options.size[1], "btf-view", NULL, NULL);
    if (!v->window) {
        glfwGetError(&reason);
        return cli_error(&program, BTF_ERROR_UNSUPPORTED, "no OpenGL 3.3 here: %s",
                         reason ? reason : "unknown");
    }
    glfwSetWindowUserPointer(v->window, v);
    glfwMakeContextCurrent(v->window);
    glfwSwapInterval(0);
    glfwSetKeyCallback(v->window, on_key);
    glfwSetCursorPosCallback(v->window, on_pointer);
    glfwSetScrollCallback(v->window, on_scroll);
    glfwSetDropCallback(v->window, on_drop);
    glfwSetWindowRefreshCallback(v->window, on_refresh);
    glfwSetFramebufferSizeCallback(v->window, on_resize);
    return gl_api_load(&v->gl, find_function, NULL, &v->log);
}

/* A device that does not keep to the format's arithmetic is drawn with all the same, and told. */
static btf_result check_device(viewer *v) {
    const btf_gl_options gl_options = {sizeof gl_options, find_function, NULL, NULL};
    uint32_t failures = 0;
    char names[200];
    btf_result result = btf_gl_self_test(&gl_options, &v->log, &failures);
    if (failures & BTF_SELF_TEST_LEVELS)
        fprintf(stderr, "btf-view: warning: this device fetches from wrong mip levels: "
                        "materials of several levels of detail will look wrong\n");
    failures &= ~(uint32_t)BTF_SELF_TEST_LEVELS;
    if (!result && failures) {
        btf_self_test_names(failures, names, sizeof names);
        fprintf(stderr, "btf-view: warning: this device is not exact (%s): using fast math\n", names);
        v->state.math = BTF_MATH_FAST;
    }
    return result;
}

static btf_result choose_mesh(viewer *v) {
    if (!options.mesh)
        return BTF_OK;
    for (int i = 0; i < VIEW_OWN_MESH; i++)
        if (!strcmp(options.mesh, view_mesh_name(i))) {
            v->state.mesh = i;
            return BTF_OK;
        }
    const size_t length = strlen(options.mesh);
    if (length > 4 && !strcmp(options.mesh + length - 4, ".obj"))
        return load_mesh(v, options.mesh);
    return cli_error(&program, BTF_ERROR_USAGE,
                     "option --mesh: '%s', expected sphere, plane, torus, drape or a file *.obj",
                     options.mesh);
}

static btf_result prepare(viewer *v, const char *path) {
    btf_result result = choose_mesh(v);
    if (!result && path) /* so that a missing file is told without a window */
        result = open_planned(v, path, &v->material);
    if (!result && options.original)
        result = v->material ? open_images(v, options.original)
                             : cli_error(&program, BTF_ERROR_USAGE, "option --original: needs a FILE");
    if (!result)
        result = open_window(v);
    if (!result)
        result = check_device(v);
    if (result)
        return result;
    v->drawing = drawing_create(&v->gl, find_function, NULL, &v->log);
    v->overlay = overlay_create(&v->gl, &v->log);
    if (!v->drawing || !v->overlay)
        return BTF_ERROR_INTERNAL;
    if (v->material) {
        result = drawing_set_material(v->drawing, v->material, v->images, &v->log);
        v->state.has_original = v->images != NULL;
        use_material_facts(v, path);
    }
    return result ? result : use_mesh(v);
}

static btf_result loop(viewer *v) {
    v->dirty = true;
    tell(v, "ready");
    v->message[0] = '\0';
    while (!glfwWindowShouldClose(v->window) && !v->failed) {
        if (v->state.animate) {
            const double now = glfwGetTime();
            view_state_advance(&v->state, now - v->animated_at);
            v->animated_at = now;
            v->dirty = true;
        }
        if (v->dirty) {
            v->dirty = false;
            v->failed = draw_frame(v);
            glfwSwapBuffers(v->window);
        }
        if (v->state.animate)
            glfwPollEvents();
        else if (!v->failed)
            glfwWaitEvents();
    }
    return v->failed;
}

static btf_result run(const char *path) {
    viewer v = {0};
    v.log = (btf_log){log_message, &v};
    view_state_reset(&v.state);
    v.state.effects = options.effects;
    v.state.interpolation = (btf_interpolation)options.interpolation;
    v.state.filter = (btf_filter)options.filter;
    v.state.math = (btf_math)options.math;
    v.state.levels = options.level == 0;
    btf_result result = prepare(&v, path);
    if (!result)
        result = loop(&v);
    overlay_destroy(&v.overlay);
    drawing_destroy(&v.drawing);
    mesh_destroy(&v.own_mesh);
    original_close(&v.images);
    btf_material_close(&v.material);
    glfwTerminate();
    return result;
}

int main(int argc, char **argv) {
    cli_arguments arguments;
    int exit_code;
    if (!cli_parse(&program, argc, argv, &arguments, &exit_code))
        return exit_code;
    return cli_finish(&program, run(arguments.count ? arguments.values[0] : NULL));
}
