/* The state that btf-view shows, and that keys and the mouse change. No window, no GL.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_VIEW_STATE_H
#define OPENBTF_VIEW_STATE_H

#include <openbtf/shader.h>
#include <stdbool.h>
#include <stddef.h>

typedef enum view_split {
    VIEW_SPLIT_OFF = 0,
    VIEW_SPLIT_SBRDF,    /* right side: no effects */
    VIEW_SPLIT_ORIGINAL, /* right side: the images, when given */
    VIEW_SPLITS
} view_split;

enum { VIEW_MESHES = 5, VIEW_OWN_MESH = 4 }; /* the last is the user's OBJ */

typedef struct view_state {
    double theta, phi;               /* of the camera, degrees */
    double light_theta, light_phi;   /* to the light, in the world */
    double zoom, exposure, split_at; /* exposure in stops; split_at 0..1 of the width */
    int mesh;                        /* 0..3 built in, 4 own */
    uint32_t effects;
    btf_interpolation interpolation;
    btf_filter filter;
    btf_math math;
    view_split split;
    bool levels; /* each pixel takes its level of detail; else all take the finest */
    bool stochastic; /* each picture picks one neighbour; pictures are accumulated */
    bool help, info, animate;
    bool has_own_mesh, has_original, has_sbrdf, has_levels; /* what there is to choose */
} view_state;

typedef enum view_action {
    VIEW_NOTHING = 0, /* the key means nothing */
    VIEW_CHANGED,
    VIEW_QUIT,
    VIEW_SCREENSHOT,
    VIEW_MEASURE, /* time every effect */
} view_action;

/* Keys are upper-case letters, digits and signs; F1 and Escape have codes of their own. */
enum { VIEW_KEY_ESCAPE = 27, VIEW_KEY_F1 = 256 };

void view_state_reset(view_state *s);

/* text[size] gets a line that says what changed. */
view_action view_state_key(view_state *s, int key, char *text, size_t size);

typedef enum view_drag { VIEW_DRAG_ORBIT, VIEW_DRAG_LIGHT, VIEW_DRAG_SPLIT } view_drag;

/* The pointer moved by (dx, dy) of the window's width and height. */
void view_state_drag(view_state *s, view_drag kind, double dx, double dy);
void view_state_scroll(view_state *s, double steps);

/* One step of the animation, seconds long: the light goes round. */
void view_state_advance(view_state *s, double seconds);

const char *view_mesh_name(int mesh);
const char *view_split_name(view_split split);

/* The help overlay: one line a key. */
const char *view_help_text(void);

#endif
