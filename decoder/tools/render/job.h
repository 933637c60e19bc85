/* One run of btf-render: all that it has open, and how it draws and writes a picture.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TOOLS_JOB_H
#define OPENBTF_TOOLS_JOB_H

#include "decoder/tools/mesh/bvh.h"
#include "original.h"
#include "plan_range.h"
#include "render.h"
#include "sampled_environment.h"
#include "shader.h"
#include "still_lights.h"

/* All that one run of btf-render has open. */
typedef struct job {
    btf_log log;
    btf_material *material, *baseline;
    btf_material_info info;
    mesh *mesh;
    bvh *bvh;
    shader *shader, *baseline_shader;
    original *original;
    render_scene scene;
    light *lights;                    /* as given */
    sampled_environment *environment; /* with --light environment */
    btf_shader_options still;         /* without a plan: what is the same in every sample of every frame */
    still_lights still_lights;        /* several that are the same in every sample */
    light_list together;              /* one that stands for them */
    /* with --plan auto */
    btf_material *whole;
    plan_range *seen; /* [frame] */
    btf_plan plan;
    btf_cost_model costs; /* with --costs */
    int planned_end;      /* the first frame after those that `plan` is for */
} job;

/* Draws the scene as it stands and writes the picture; with --stats prints times. Errors, told by btf-render: those
 * of render_frame and picture_write. */
btf_result job_render(const job *j, const char *path);

/* Draws and writes the figure of --figure13: the original and three decodes side by side. Errors: those of
 * render_frame and figure_write, BTF_ERROR_MEMORY. */
btf_result job_render_figure(const job *j, const char *path);

/* Closes all that is open, the lights of the options included. */
void job_close(job *j);

#endif
