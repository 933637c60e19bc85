/* Several lights that are the same in every sample of a picture, so that their sum can be folded (openbtf/fold.h):
 * lights far away on a flat mesh. In parallel projection the view is the same as well.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_RENDER_STILL_LIGHTS_H
#define OPENBTF_RENDER_STILL_LIGHTS_H

#include "render.h"

/* The lights above the horizon, in the order of the scene. All zeros: they are not the same in every sample. */
typedef struct still_lights {
    size_t count;
    float *directions; /* [count][3], unit, in the tangent frame of every sample */
    float *weights;    /* [count][3]: irradiance / pi */
    bool same_view;
    float view[3];  /* of every sample, with same_view */
    light together; /* stands for all of them where a shader shows their sum: the first, of colour 1 */
} still_lights;

/* Casts the picture and fills in *out where two or more lights shine on every sample from the same directions, bit for
 * bit: all lights of the scene must be directional, without an environment and without cast shadows. Else *out is all
 * zeros. Errors: BTF_ERROR_MEMORY. */
btf_result still_lights_find(const render_scene *scene, still_lights *out);
void still_lights_clear(still_lights *lights);

#endif
