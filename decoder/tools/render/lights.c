/* Lists of lights.
 *
 * SPDX-License-Identifier: MIT
 */
#include "lights.h"

#include <stdlib.h>

bool light_list_add(light_list *list, light l) {
    if (list->count >= LIGHTS_MAX) {
        return false;
    }
    light *grown = realloc(list->lights, (list->count + 1) * sizeof *grown);
    if (!grown) {
        return false;
    }
    list->lights = grown;
    list->lights[list->count++] = l;
    return true;
}

void light_list_clear(light_list *list) {
    free(list->lights);
    *list = (light_list){0};
}
