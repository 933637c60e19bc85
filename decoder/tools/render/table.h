/* The ray-cast table: for each sample of the picture what the material's decoder needs, in single
 * precision, so that every device is handed the same bits.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_RENDER_TABLE_H
#define OPENBTF_RENDER_TABLE_H

#include "decoder/tools/mesh/bvh.h"
#include "lights.h"

/* Seen from direction theta, phi (degrees; 0,0 looks along -z, +y up on the picture). At the origin the
 * picture's smaller side spans 2 / zoom. */
typedef struct camera {
    double theta, phi;
    double fov; /* degrees across the smaller side; 0: parallel projection */
    double zoom;
} camera;

/* Where the camera is and what its picture's axes are. */
typedef struct camera_frame {
    vec3 right, up, back; /* unit; back points from the origin to the camera */
    double distance;      /* from the origin, 0 for parallel projection */
    double half;          /* half the smaller side at the origin */
} camera_frame;

camera_frame camera_get_frame(const camera *c);

/* One sample. A miss has view[2] = 0, which decodes to black. */
typedef struct table_sample {
    float uv[2];       /* in [0, 1), the fraction of the mesh's uv times the repeats */
    float view[3];     /* to the viewer, in the tangent frame */
    int level;         /* of detail */
    float position[3]; /* in the world */
    float tangent[3], bitangent[3], normal[3];
} table_sample;

typedef struct table_scene {
    const mesh *mesh;
    const bvh *bvh;
    camera camera;
    double repeat[2];
    int width, height; /* samples: pixels times supersampling */
    int texels[2];     /* columns and rows of the material */
    int levels;        /* of detail that it has, 1 at least */
    int level;         /* the one to take; below 0: by the sample's footprint */
    bool cast_shadows;
    int threads;
} table_scene;

/* Casts rows first_row .. first_row + rows - 1: out[rows][width]. A surface seen from behind is lit from
 * there (the frame's normal is turned); at the silhouette, where the interpolated normal looks away, the
 * view is raised to just above the horizon. The footprint of a sample is the longer of the two steps of
 * uv, in texels, from it to the next sample along a row and along a column, on the plane of the triangle
 * that is hit (H. Igehy, "Tracing Ray Differentials", 1999); its level is the log2 of that, rounded to
 * nearest, from 0 to levels - 1: what btf_level of the GLSL library says for dFdx and dFdy of uv. */
void table_cast(const table_scene *scene, int first_row, int rows, table_sample *out);

/* Floats that an evaluator is handed for a sample: u, v, view, direction to the light in the tangent frame,
 * level of detail. */
enum { TABLE_INPUTS = 9 };

/* For `count` samples under one light: inputs[count][TABLE_INPUTS]; weights[count][3] = the light's colour
 * as it arrives (0 for a miss or a cast shadow). */
void table_light(const table_scene *scene, const light *l, size_t count, const table_sample *samples,
                 float *inputs, float *weights);

/* Sets the inputs of one sample that do not depend on the light; its direction is 0. */
void table_set_sample(const table_sample *sample, float *inputs);

/* A direction of the world in the sample's tangent frame. */
vec3 table_to_local(const table_sample *sample, vec3 direction);

/* Whether the mesh stands between the sample and a light far away. */
bool table_is_shadowed(const table_scene *scene, const table_sample *sample, vec3 to_light);

#endif
