/* Dispatch to the devices.
 *
 * SPDX-License-Identifier: MIT
 */
#include "shader.h"

#include "decoder/toolkit/file.h"
#include "shade_gl.h"
#include "shade_reference.h"
#include <openbtf/fold.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct shader {
    const shader_class *class;
    void *self;
    char folded[60];
    bool shows_sum;
};

static void describe_fold(const shader_request *request, btf_fold fold, char *text, size_t size) {
    btf_material_info info = {.struct_size = sizeof info};
    btf_material_get_info(request->material, &info);
    if (fold == BTF_FOLD_NONE) {
        snprintf(text, size, "nothing");
    } else if (request->lights > 0) {
        snprintf(text, size, "%zu lights%s, %zu bytes", request->lights,
                 fold == BTF_FOLD_SUM ? "" : " and view", btf_fold_bytes(&info, fold, 1));
    } else {
        snprintf(text, size, "%s, %zu bytes", fold == BTF_FOLD_LIGHT ? "light" : "light and view",
                 btf_fold_bytes(&info, fold, 1));
    }
}

btf_result shader_create(const shader_request *request, const btf_log *log, shader **out_shader) {
    btf_result result = BTF_OK;
    shader *s = calloc(1, sizeof *s);
    *out_shader = NULL;
    if (!s) {
        file_say(log, "out of memory for a device");
        return BTF_ERROR_MEMORY;
    }
    s->class = strcmp(request->device, "reference") ? &shader_class_gl : &shader_class_reference;
    s->self = s->class->create(request, log, &result);
    if (!s->self) {
        free(s);
        return result ? result : BTF_ERROR_MEMORY;
    }
    describe_fold(request, s->class->folded(s->self), s->folded, sizeof s->folded);
    s->shows_sum = request->lights > 0 && s->class->folded(s->self) != BTF_FOLD_NONE;
    *out_shader = s;
    return BTF_OK;
}

void shader_destroy(shader **s) {
    if (!s || !*s) {
        return;
    }
    (*s)->class->destroy((*s)->self);
    free(*s);
    *s = NULL;
}

const char *shader_folded(const shader *s) {
    return s->folded;
}

bool shader_shows_sum(const shader *s) {
    return s->shows_sum;
}

const char *shader_name(const shader *s) {
    return s->class->name(s->self);
}

int shader_max_width(const shader *s) {
    return s->class->max_width(s->self);
}

btf_result shader_run(shader *s, int variant, int width, int rows, const float *inputs, float *out,
                      const btf_log *log) {
    return s->class->run(s->self, variant, width, rows, inputs, out, log);
}

btf_result shader_time(shader *s, int variant, int repeats, shader_times *out_times) {
    return s->class->time(s->self, variant, repeats, out_times);
}
