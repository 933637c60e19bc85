/* The viewer that the parts of btf-view share, and what all of them ask of it.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_VIEW_VIEWER_H
#define OPENBTF_VIEW_VIEWER_H

#include "costs.h"
#include "decoder/tools/mesh/bvh.h"
#include "decoder/tools/render/original.h"
#include "drawing.h"
#include "overlay.h"
#include "planner.h"
#include "state.h"
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

/* The parts in which a plan is made, each between two frames. */
typedef enum planning_stage {
    STAGE_MAKE,
    STAGE_UPLOAD,
    STAGE_FOLD,
    STAGE_LINK,
    STAGE_TRY,
    STAGES
} planning_stage;

typedef struct planning {
    planner planner;
    planning_stage stage; /* the next one of the pending plan */
    double ms[STAGES];    /* milliseconds of each stage of the last plan that was made */
    bool folds;           /* the mesh that is shown is flat */
    view_state seen;      /* the state when the planner last looked */
    int size[2];
    btf_scene needed;
    double moved, light_moved; /* when anything, and when the light, last moved: seconds of GLFW's clock */
    bool folded;               /* without --plan: whether to fold the light that rests has been decided */
} planning;

typedef struct viewer {
    GLFWwindow *window;
    gl_api gl;
    btf_log log;
    view_state state;
    costs costs;
    btf_material *material;
    original_reader *read_original; /* set by the program: reads the images of --original */
    original *images;
    drawing *drawing;
    overlay *overlay;
    mesh *own_mesh, *built_in; /* own_mesh is shown where the state says so, else built_in */
    bvh *bvh;                  /* of the mesh that is shown */
    char material_name[64], message[160];
    planning planning; /* with --plan auto */
    btf_cost_model costs_of_device; /* with --costs */
    double pointer[2], frame_ms, animated_at;
    bool dirty;
    btf_result failed; /* ends the loop */
} viewer;

/* Shows a text that says what changed: in the panel, and with --verbose on stdout. */
void viewer_tell(viewer *v, const char *text);
void viewer_frame_size(const viewer *v, int *width, int *height);
const mesh *viewer_mesh(const viewer *v); /* the one that is shown */
double viewer_repeat(const viewer *v);    /* copies of the material a unit of its uv */

#endif
