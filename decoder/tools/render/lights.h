/* Lights: directional and point.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_RENDER_LIGHTS_H
#define OPENBTF_RENDER_LIGHTS_H

#include "decoder/tools/mesh/vec.h"
#include <openbtf/result.h>
#include <stdbool.h>
#include <stddef.h>

typedef struct light {
    bool is_point;
    vec3 at;          /* unit vector to the light, or the position of a point */
    double colour[3]; /* irradiance at normal incidence over pi; of a point at distance 1 */
} light;

enum { LIGHTS_MAX = 4096 };

typedef struct light_list {
    light *lights;
    size_t count;
} light_list;

/* False when out of memory or beyond LIGHTS_MAX. */
bool light_list_add(light_list *list, light l);
void light_list_clear(light_list *list);

#endif
