/* The state that btf-view shows, and that keys and the mouse change. See state.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "state.h"

#include "decoder/toolkit/cli.h"
#include "decoder/toolkit/filter.h"
#include <math.h>
#include <stdio.h>

static const char *const mesh_names[VIEW_MESHES] = {"sphere", "plane", "torus", "drape", "own"};
static const char *const split_names[VIEW_SPLITS] = {"off", "SBRDF", "original"};

const char *view_mesh_name(int mesh) {
    return mesh_names[mesh];
}

const char *view_split_name(view_split split) {
    return split_names[split];
}

const char *view_help_text(void) {
    return "left drag      turn the model\n"
           "right drag     move the light (also Shift + left)\n"
           "middle drag    move the split line\n"
           "wheel          zoom\n"
           "M              next model\n"
           "1 2 3 4 5 6 7  shadow, shift, hidden, gain, residual, relief, gloss on/off\n"
           "0              all effects\n"
           "N              directions: linear / nearest\n"
           "B              texels: one / bilinear / steep\n"
           "X              math: exact / fast\n"
           "L              levels of detail: by pixel / the finest\n"
           "T              stochastic: one neighbour a picture, accumulated\n"
           "S              split: off / SBRDF / original\n"
           "[ ]            move the split line\n"
           "+ -            exposure\n"
           "A              animate the light\n"
           "C              measure what each effect costs\n"
           "P              save a picture\n"
           "I              panel on/off\n"
           "R              reset\n"
           "H F1           this help\n"
           "Q Esc          quit\n"
           "drop a file    *.btf.exr or *.obj";
}

void view_state_reset(view_state *s) {
    s->theta = 0;
    s->phi = 0;
    s->light_theta = 40;
    s->light_phi = 120;
    s->zoom = 0.9;
    s->exposure = 0;
    s->split_at = 0.5;
    s->effects = BTF_EFFECT_ALL;
    s->interpolation = BTF_INTERPOLATION_LINEAR;
    s->filter = BTF_FILTER_TEXEL;
    s->math = BTF_MATH_EXACT;
    s->split = VIEW_SPLIT_OFF;
    s->levels = true;
    s->stochastic = false;
    s->help = false;
    s->info = true;
    s->animate = false;
    s->mesh = s->has_own_mesh ? VIEW_OWN_MESH : 0;
}

static double clamp(double x, double low, double high) {
    return fmin(fmax(x, low), high);
}

static view_action toggle_effect(view_state *s, int index, char *text, size_t size) {
    char words[48];
    s->effects ^= 1u << index;
    snprintf(text, size, "effects %s", cli_effects_text(s->effects, words));
    return VIEW_CHANGED;
}

static view_action next_split(view_state *s, char *text, size_t size) {
    do {
        s->split = (view_split)((s->split + 1) % VIEW_SPLITS);
    } while ((s->split == VIEW_SPLIT_SBRDF && !s->has_sbrdf) ||
             (s->split == VIEW_SPLIT_ORIGINAL && !s->has_original));
    snprintf(text, size, "split %s%s", split_names[s->split],
             s->split != VIEW_SPLIT_OFF || s->has_sbrdf ? "" : " (the file has no SBRDF)");
    return VIEW_CHANGED;
}

static view_action next_mesh(view_state *s, char *text, size_t size) {
    do {
        s->mesh = (s->mesh + 1) % VIEW_MESHES;
    } while (s->mesh == VIEW_OWN_MESH && !s->has_own_mesh);
    snprintf(text, size, "model %s", mesh_names[s->mesh]);
    return VIEW_CHANGED;
}

static view_action flip(bool *flag, const char *name, char *text, size_t size) {
    *flag = !*flag;
    snprintf(text, size, "%s %s", name, *flag ? "on" : "off");
    return VIEW_CHANGED;
}

static view_action toggle_levels(view_state *s, char *text, size_t size) {
    s->levels = !s->levels;
    snprintf(text, size, "levels %s%s", s->levels ? "on" : "off",
             s->has_levels ? "" : " (the file has one)");
    return VIEW_CHANGED;
}

static view_action expose(view_state *s, double stops, char *text, size_t size) {
    s->exposure = clamp(s->exposure + stops, -10, 10);
    snprintf(text, size, "exposure %+.2f", s->exposure);
    return VIEW_CHANGED;
}

static view_action move_split(view_state *s, double by, char *text, size_t size) {
    s->split_at = clamp(s->split_at + by, 0, 1);
    snprintf(text, size, "split at %.2f", s->split_at);
    return VIEW_CHANGED;
}

view_action view_state_key(view_state *s, int key, char *text, size_t size) {
    text[0] = '\0';
    switch (key) {
    case '1':
    case '2':
    case '3':
    case '4':
    case '5':
    case '6':
    case '7':
        return toggle_effect(s, key - '1', text, size);
    case '0':
        s->effects = BTF_EFFECT_ALL;
        snprintf(text, size, "effects all");
        return VIEW_CHANGED;
    case 'M':
        return next_mesh(s, text, size);
    case 'N':
        s->interpolation = s->interpolation == BTF_INTERPOLATION_LINEAR ? BTF_INTERPOLATION_NEAREST
                                                                        : BTF_INTERPOLATION_LINEAR;
        snprintf(text, size, "directions %s",
                 s->interpolation == BTF_INTERPOLATION_NEAREST ? "nearest" : "linear");
        return VIEW_CHANGED;
    case 'B':
        s->filter = (btf_filter)((s->filter + 1) % (BTF_FILTER_STEEP + 1));
        snprintf(text, size, "filter %s", filter_name(s->filter));
        return VIEW_CHANGED;
    case 'X':
        s->math = s->math == BTF_MATH_EXACT ? BTF_MATH_FAST : BTF_MATH_EXACT;
        snprintf(text, size, "math %s", s->math == BTF_MATH_FAST ? "fast" : "exact");
        return VIEW_CHANGED;
    case 'L':
        return toggle_levels(s, text, size);
    case 'T':
        return flip(&s->stochastic, "stochastic", text, size);
    case 'S':
        return next_split(s, text, size);
    case '[':
        return move_split(s, -0.05, text, size);
    case ']':
        return move_split(s, 0.05, text, size);
    case '+':
    case '=':
        return expose(s, 0.25, text, size);
    case '-':
        return expose(s, -0.25, text, size);
    case 'A':
        return flip(&s->animate, "animation", text, size);
    case 'I':
        return flip(&s->info, "panel", text, size);
    case 'H':
    case VIEW_KEY_F1:
        return flip(&s->help, "help", text, size);
    case 'R':
        view_state_reset(s);
        snprintf(text, size, "reset");
        return VIEW_CHANGED;
    case 'C':
        return VIEW_MEASURE;
    case 'P':
        return VIEW_SCREENSHOT;
    case 'Q':
    case VIEW_KEY_ESCAPE:
        return VIEW_QUIT;
    default:
        return VIEW_NOTHING;
    }
}

/* Turns a direction about the picture's axes: left and right round y, up and down towards y. Angles are theta from z
 * and phi, so it goes through longitude (round y) and latitude. */
static void turn(double *theta, double *phi, double dx, double dy) {
    const double degree = 0.017453292519943295;
    double x = sin(*theta * degree) * cos(*phi * degree), y = sin(*theta * degree) * sin(*phi * degree),
           z = cos(*theta * degree);
    double longitude = atan2(x, z) + dx, latitude = asin(clamp(y, -1, 1)) + dy;
    latitude = clamp(latitude, -89 * degree, 89 * degree);
    x = cos(latitude) * sin(longitude);
    y = sin(latitude);
    z = cos(latitude) * cos(longitude);
    *theta = acos(clamp(z, -1, 1)) / degree;
    *phi = atan2(y, x) / degree;
}

void view_state_drag(view_state *s, view_drag kind, double dx, double dy) {
    const double pi = 3.14159265358979323846;
    if (kind == VIEW_DRAG_ORBIT) {
        turn(&s->theta, &s->phi, -dx * pi, dy * pi);
    } else if (kind == VIEW_DRAG_LIGHT) {
        turn(&s->light_theta, &s->light_phi, dx * pi, -dy * pi);
    } else {
        s->split_at = clamp(s->split_at + dx, 0, 1);
    }
}

void view_state_scroll(view_state *s, double steps) {
    s->zoom = clamp(s->zoom * pow(1.1, steps), 0.2, 3);
}

void view_state_advance(view_state *s, double seconds) {
    s->light_phi = fmod(s->light_phi + 60 * clamp(seconds, 0, 0.5), 360);
}
