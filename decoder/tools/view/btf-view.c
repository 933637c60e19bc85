/* btf-view: a material in a window.
 *
 * SPDX-License-Identifier: MIT
 */
#include "history.h"
#include "options.h"
#include "viewer_load.h"
#include "viewer_panel.h"
#include "viewer_plan.h"
#include "decoder/toolkit/file.h"
#include "decoder/tools/original/data_set.h"

#include <stdio.h>
#include <string.h>

/* Errors and warnings go to stderr and to the panel. */
static void log_message(void *user, btf_log_level level, const char *message) {
    viewer *v = user;
    if (level <= BTF_LOG_WARNING) {
        cli_print("btf-view", level, message);
        snprintf(v->message, sizeof v->message, "%.150s", message);
        v->dirty = true;
    }
}

static btf_gl_function find_function(void *user, const char *name) {
    (void)user;
    return (btf_gl_function)glfwGetProcAddress(name);
}

static viewer *viewer_of(GLFWwindow *window) {
    return glfwGetWindowUserPointer(window);
}

/* The program's own code of a GLFW key; those of letters and digits are the same. */
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
    viewer *v = viewer_of(window);
    char text[160];
    const int mesh_before = v->state.mesh;
    (void)scan_code;
    if (action == GLFW_RELEASE || modifiers & (GLFW_MOD_CONTROL | GLFW_MOD_ALT | GLFW_MOD_SUPER)) {
        return;
    }
    switch (view_state_key(&v->state, key_code(key), text, sizeof text)) {
    case VIEW_NOTHING:
        return;
    case VIEW_QUIT:
        glfwSetWindowShouldClose(window, GLFW_TRUE);
        return;
    case VIEW_SCREENSHOT:
        v->failed = viewer_save_picture(v);
        return;
    case VIEW_MEASURE:
        v->failed = viewer_measure(v);
        return;
    case VIEW_CHANGED:
        break;
    }
    if (key == GLFW_KEY_N || key == GLFW_KEY_B || key == GLFW_KEY_X || key == GLFW_KEY_L ||
        key == GLFW_KEY_T || key == GLFW_KEY_R) {
        costs_clear(&v->costs);
    }
    if (v->state.mesh != mesh_before) {
        v->failed = viewer_use_mesh(v);
    }
    v->animated_at = glfwGetTime();
    viewer_tell(v, text);
}

static void on_pointer(GLFWwindow *window, double x, double y) {
    viewer *v = viewer_of(window);
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
    if (!left && !right && !middle) {
        return;
    }
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
    viewer_tell(v, text);
}

static void on_scroll(GLFWwindow *window, double dx, double dy) {
    viewer *v = viewer_of(window);
    char text[80];
    (void)dx;
    view_state_scroll(&v->state, dy);
    snprintf(text, sizeof text, "zoom %.2f", v->state.zoom);
    viewer_tell(v, text);
}

/* Whether a file is a model rather than a material: no EXR file, and it either has a name in .obj or begins as
 * statements or comments of OBJ do. */
static bool is_model(const char *path) {
    char begin[256] = "";
    FILE *file = file_is_exr(path) ? NULL : fopen(path, "rb");
    if (!file) {
        return false;
    }
    begin[fread(begin, 1, sizeof begin - 1, file)] = '\0';
    fclose(file);
    const char *text = begin + (strncmp(begin, "\xef\xbb\xbf", 3) == 0 ? 3 : 0);
    text += strspn(text, " \t\r\n");
    return file_ends_in(path, ".obj") || (*text && strchr("#vfgosmu", *text));
}

static void on_drop(GLFWwindow *window, int count, const char **paths) {
    viewer *v = viewer_of(window);
    for (int i = 0; i < count; i++) {
        const bool is_mesh = is_model(paths[i]);
        btf_result result = is_mesh ? viewer_load_mesh(v, paths[i]) : viewer_load_material(v, paths[i]);
        if (!result && is_mesh) {
            result = viewer_use_mesh(v);
        }
        if (!result) {
            char text[160];
            snprintf(text, sizeof text, "opened %.120s", viewer_base_name(paths[i]));
            viewer_tell(v, text);
        }
    }
}

static void on_refresh(GLFWwindow *window) {
    viewer_of(window)->dirty = true;
}

static void on_resize(GLFWwindow *window, int width, int height) {
    (void)width;
    (void)height;
    costs_clear(&viewer_of(window)->costs);
    viewer_of(window)->dirty = true;
}

static btf_result open_window(viewer *v) {
    const char *reason = NULL;
    if (!glfwInit()) {
        glfwGetError(&reason);
        return cli_error(&view_program, BTF_ERROR_UNSUPPORTED,
                         "no display: %s; btf-render makes pictures without one",
                         reason ? reason : "unknown");
    }
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    glfwWindowHint(GLFW_OPENGL_FORWARD_COMPAT, GLFW_TRUE);
    v->window = glfwCreateWindow(view_options.size[0], view_options.size[1], "btf-view", NULL, NULL);
    if (!v->window) {
        glfwGetError(&reason);
        return cli_error(&view_program, BTF_ERROR_UNSUPPORTED, "no OpenGL 3.3 here: %s",
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

/* Warns of a device that does not keep to the format's arithmetic; it is drawn with all the same. */
static btf_result check_device(viewer *v) {
    const btf_gl_options gl_options = {sizeof gl_options, find_function, NULL, NULL};
    uint32_t failures = 0;
    char names[200];
    btf_result result = btf_gl_self_test(&gl_options, &v->log, &failures);
    if (failures & BTF_SELF_TEST_LEVELS) {
        fprintf(stderr, "btf-view: warning: this device fetches from wrong mip levels: "
                        "materials of several levels of detail will look wrong\n");
    }
    if (failures & BTF_SELF_TEST_FACTORS) {
        fprintf(stderr, "btf-view: warning: this device multiplies or fetches packed factors wrongly: "
                        "materials that hold them will look wrong\n");
    }
    if (failures & BTF_SELF_TEST_LISTS) {
        fprintf(stderr, "btf-view: warning: this device fetches from lists of points wrongly: materials "
                        "that hold them will look wrong\n");
    }
    failures &= ~(uint32_t)(BTF_SELF_TEST_LEVELS | BTF_SELF_TEST_FACTORS | BTF_SELF_TEST_LISTS);
    if (!result && failures) {
        btf_self_test_names(failures, names, sizeof names);
        fprintf(stderr, "btf-view: warning: this device is not exact (%s): using fast math\n", names);
        v->state.math = BTF_MATH_FAST;
    }
    return result;
}

static btf_result prepare(viewer *v, const char *path) {
    btf_result result = viewer_choose_mesh(v);
    if (!result && view_options.costs_file) {
        result = btf_cost_model_open(view_options.costs_file, &v->log, &v->costs_of_device);
    }
    if (!result && path) { /* so that a missing file is told without a window */
        result = btf_material_open(path, &v->log, &v->material);
    }
    if (!result && view_options.original) {
        result = v->material ? viewer_open_images(v, view_options.original)
                             : cli_error(&view_program, BTF_ERROR_USAGE, "option --original: needs a FILE");
    }
    if (!result) {
        result = open_window(v);
    }
    if (!result) {
        result = check_device(v);
    }
    if (result) {
        return result;
    }
    v->drawing = drawing_create(&v->gl, find_function, NULL, &v->log);
    if (v->drawing && view_options.costs_file) {
        drawing_set_costs(v->drawing, &v->costs_of_device);
    }
    v->overlay = overlay_create(&v->gl, &v->log);
    if (!v->drawing || !v->overlay) {
        return BTF_ERROR_INTERNAL;
    }
    if (v->material) {
        result = drawing_set_material(v->drawing, v->material, v->images, view_options.plan == 0, &v->log);
        v->state.has_original = v->images != NULL;
        viewer_use_material_facts(v, path);
    }
    return result ? result : viewer_use_mesh(v);
}

static btf_result loop(viewer *v) {
    v->dirty = true;
    viewer_tell(v, "ready");
    v->message[0] = '\0';
    while (!glfwWindowShouldClose(v->window) && !v->failed) {
        double wait = -1; /* until there is something to do */
        if (v->state.animate) {
            const double now = glfwGetTime();
            view_state_advance(&v->state, now - v->animated_at);
            v->animated_at = now;
            v->dirty = true;
        }
        if (view_options.plan == 0 && v->material) {
            v->failed = viewer_plan(v, &wait);
        } else if (v->material) {
            v->failed = viewer_still(v, &wait);
        }
        if (v->dirty && !v->failed) {
            v->dirty = false;
            v->failed = viewer_draw_frame(v);
            glfwSwapBuffers(v->window);
        }
        if (v->state.stochastic && v->material && drawing_samples(v->drawing) < HISTORY_MOST) {
            v->dirty = true;
        }
        if (v->state.animate || wait == 0 || v->dirty) {
            glfwPollEvents();
        } else if (!v->failed && wait > 0) {
            glfwWaitEventsTimeout(wait);
        } else if (!v->failed) {
            glfwWaitEvents();
        }
    }
    return v->failed;
}

static btf_result run(const cli_arguments *arguments) {
    const char *path = arguments->count ? arguments->values[0] : NULL;
    viewer v = {.read_original = data_set_read, .planning.planner = planner_begin()};
    v.log = (btf_log){log_message, &v};
    view_state_reset(&v.state);
    v.state.effects = view_options.effects;
    v.state.interpolation = (btf_interpolation)view_options.interpolation;
    v.state.filter = (btf_filter)view_options.filter;
    v.state.math = (btf_math)view_options.math;
    v.state.levels = view_options.level == 0;
    btf_result result = prepare(&v, path);
    if (!result) {
        result = loop(&v);
    }
    overlay_destroy(&v.overlay);
    drawing_destroy(&v.drawing);
    planner_clear(&v.planning.planner);
    bvh_destroy(&v.bvh);
    mesh_destroy(&v.built_in);
    mesh_destroy(&v.own_mesh);
    original_close(&v.images);
    btf_material_close(&v.material);
    glfwTerminate();
    return result;
}

int main(int argc, char **argv) {
    return cli_run(&view_program, argc, argv, run);
}
