/* The parts of btf-view: what they share.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_VIEW_VIEWER_H
#define OPENBTF_VIEW_VIEWER_H

#include "costs.h"
#include "drawing.h"
#include "options.h"
#include "overlay.h"
#include "planner.h"
#include "../render/bvh.h"
#include "../render/plan_table.h"
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

/* What a plan was or is being made in, a part between two frames each. */
typedef enum planning_stage { STAGE_MAKE, STAGE_UPLOAD, STAGE_LINK, STAGE_TRY, STAGES } planning_stage;

typedef struct planning {
    planner planner;
    planning_stage stage; /* the next of the pending plan */
    double ms[STAGES];    /* of the last plan that was made */
    bool folds;           /* the mesh that is shown is flat */
    view_state seen;      /* when it was last looked at */
    int size[2];
    btf_scene needed;
    double moved, light_moved; /* seconds */
} planning;

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
    mesh *own_mesh, *built_in; /* the latter is shown unless the state says own */
    bvh *bvh;                  /* of the mesh that is shown */
    char material_name[64], message[160];
    planning planning; /* with --plan auto */
    double pointer[2], frame_ms, animated_at;
    bool dirty;
    btf_result failed; /* ends the loop */
} viewer;

/* Says what changed: in the panel, and on stdout with --verbose. */
void viewer_tell(viewer *v, const char *text);
void viewer_frame_size(const viewer *v, int *width, int *height);

/* viewer_load.c: files and meshes. Errors are told. */
const char *viewer_base_name(const char *path);
btf_result viewer_choose_mesh(viewer *v); /* that of the command line */
btf_result viewer_load_mesh(viewer *v, const char *path);
btf_result viewer_use_mesh(viewer *v); /* the one that the state names */
const mesh *viewer_mesh(const viewer *v);
double viewer_repeat(const viewer *v); /* copies of the material a unit of its uv */
btf_result viewer_open_images(viewer *v, const char *path);
/* Another material; what is shown stays when it cannot be opened. The images belong to the old one. */
btf_result viewer_load_material(viewer *v, const char *path);
/* What the panel and the keys need to know of the material. */
void viewer_use_material_facts(viewer *v, const char *path);

/* viewer_panel.c: pictures and what stands over them. */
btf_result viewer_draw_frame(viewer *v);
btf_result viewer_measure(viewer *v);
btf_result viewer_save_picture(viewer *v);

/* viewer_plan.c, with --plan auto. */
/* Nothing is planned any more: another material. */
void viewer_forget_plans(viewer *v);
/* Looks what the picture needs and does the next part of a plan that is due; the first plan at once, all of
 * it. *out_wait: seconds until there is something to do though nothing happens, 0: now, below 0: never. */
btf_result viewer_plan(viewer *v, double *out_wait);
/* The plan and the reason for each effect, for the panel. */
void viewer_plan_text(const viewer *v, char *text, size_t size);

#endif
