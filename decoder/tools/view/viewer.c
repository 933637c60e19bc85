/* btf-view: functions of the viewer that its parts call.
 *
 * SPDX-License-Identifier: MIT
 */
#include "viewer.h"

#include "options.h"
#include <stdio.h>

void viewer_tell(viewer *v, const char *text) {
    snprintf(v->message, sizeof v->message, "%.150s", text);
    v->dirty = true;
    if (view_options.verbose) {
        printf("%s\n", text);
        fflush(stdout);
    }
}

void viewer_frame_size(const viewer *v, int *width, int *height) {
    glfwGetFramebufferSize(v->window, width, height);
    *width = *width > 0 ? *width : 1;
    *height = *height > 0 ? *height : 1;
}

const mesh *viewer_mesh(const viewer *v) {
    return v->built_in ? v->built_in : v->own_mesh;
}

double viewer_repeat(const viewer *v) {
    return v->state.mesh != 0 && v->state.mesh != 2 ? 2 : 3;
}
