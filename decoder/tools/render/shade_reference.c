/* The reference decoder as a device, over all cores.
 *
 * SPDX-License-Identifier: MIT
 */
#include "shade_reference.h"

#include "decoder/toolkit/filter.h"
#include "decoder/toolkit/reference_view.h"
#include "decoder/toolkit/file.h"
#include "shade_fold.h"
#include "table.h"
#include <stdlib.h>

typedef struct reference {
    btf_ref_material level[BTF_MAX_LEVELS];
    int levels;
    btf_ref_options options[SHADER_VARIANTS];
    btf_ref_folded folded[SHADER_VARIANTS][BTF_MAX_LEVELS]; /* without values: nothing is */
    int threads;
} reference;

static void destroy(void *self) {
    reference *r = self;
    for (int v = 0; v < SHADER_VARIANTS; v++)
        for (int i = 0; i < BTF_MAX_LEVELS; i++)
            free((void *)r->folded[v][i].values);
    free(r);
}

/* Of all levels; false when out of memory. */
static bool fold(reference *r, const shader_request *request, int variant) {
    const btf_shader_options options = shade_fold_options(request, variant);
    for (int i = 0; i < r->levels && options.fold != BTF_FOLD_NONE; i++) {
        btf_ref_folded *f = &r->folded[variant][i];
        f->fold = options.fold == BTF_FOLD_LIGHT ? BTF_REF_FOLD_LIGHT : BTF_REF_FOLD_BOTH;
        f->values = shade_fold_reference(&r->level[i], &r->options[variant], options.fold, options.fixed_light,
                                         options.fixed_view, r->threads);
        if (!f->values)
            return false;
    }
    return true;
}

static void *create(const shader_request *request, const btf_log *log, btf_result *out_result) {
    if (request->math == BTF_MATH_FAST) {
        file_say(log, "option --math fast: the reference is exact; take a device with GL");
        *out_result = BTF_ERROR_USAGE;
        return NULL;
    }
    if (!btf_ref_self_test()) {
        file_say(log, "this build does not round floats as FORMAT.md demands");
        *out_result = BTF_ERROR_UNSUPPORTED;
        return NULL;
    }
    reference *self = calloc(1, sizeof *self);
    if (!self) {
        file_say(log, "out of memory for the reference");
        *out_result = BTF_ERROR_MEMORY;
        return NULL;
    }
    btf_material_info info = {.struct_size = sizeof info};
    btf_material_get_info(request->material, &info);
    self->levels = (int)info.levels;
    for (uint32_t i = 0; i < info.levels; i++)
        reference_view(request->material, i, &self->level[i]);
    self->threads = request->threads;
    for (int i = 0; i < request->variants; i++)
        self->options[i] = (btf_ref_options){
            .effects = request->effects[i],
            .components = request->components,
            .interpolation =
                request->interpolation == BTF_INTERPOLATION_NEAREST ? BTF_REF_NEAREST : BTF_REF_LINEAR,
            .filter = filter_of_reference(request->filter)};
    for (int i = 0; i < request->variants; i++)
        if (!fold(self, request, i)) {
            file_say(log, "out of memory for a fold");
            *out_result = BTF_ERROR_MEMORY;
            destroy(self);
            return NULL;
        }
    return self;
}

static const char *name(const void *self) {
    (void)self;
    return "reference decoder";
}

static int max_width(const void *self) {
    (void)self;
    return 1 << 20;
}

static btf_result run(void *self, int variant, int width, int rows, const float *inputs, float *out,
                      const btf_log *log) {
    const reference *r = self;
    const int count = width * rows;
    (void)log;
#pragma omp parallel for schedule(dynamic, 256) num_threads(r->threads)
    for (int i = 0; i < count; i++) {
        const float *in = inputs + TABLE_INPUTS * (size_t)i;
        const int level = (int)in[8] < r->levels ? (int)in[8] : r->levels - 1;
        const btf_ref_folded *folded = &r->folded[variant][level];
        if (folded->values)
            btf_ref_evaluate_folded(&r->level[level], &r->options[variant], folded, in[0], in[1], in + 5,
                                    in + 2, out + 3 * (size_t)i);
        else
            btf_ref_evaluate(&r->level[level], &r->options[variant], in[0], in[1], in + 5, in + 2,
                             out + 3 * (size_t)i);
    }
    return BTF_OK;
}

static btf_result no_time(void *self, int variant, int repeats, shader_times *out_times) {
    (void)self;
    (void)variant;
    (void)repeats;
    *out_times = (shader_times){0};
    return BTF_ERROR_UNSUPPORTED;
}

const shader_class shader_class_reference = {create, destroy, name, max_width, run, no_time};
