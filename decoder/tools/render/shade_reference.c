/* The reference decoder as a device, over all cores.
 *
 * SPDX-License-Identifier: MIT
 */
#include "shade_reference.h"

#include "decoder/toolkit/filter.h"
#include "decoder/toolkit/reference_view.h"
#include "decoder/toolkit/file.h"
#include "table.h"
#include <stdlib.h>

typedef struct reference {
    btf_ref_material level[BTF_MAX_LEVELS];
    int levels;
    btf_ref_options options[SHADER_VARIANTS];
    int threads;
    int picks, picked;
    uint32_t drawn; /* random numbers of each place in a list */
} reference;

static void *create(const shader_request *request, const btf_log *log, btf_result *out_result) {
    if (request->math == BTF_MATH_FAST) {
        file_say(log,
                 "option --math fast: device reference knows exact math only; choose a device with GL");
        *out_result = BTF_ERROR_USAGE;
        return NULL;
    }
    if (!btf_ref_self_test()) {
        file_say(log, "this build of the reference decoder does not round floats as FORMAT.md section 8 "
                      "demands, so that it cannot decode exactly");
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
    self->picks = (int)request->picks;
    self->picked = request->picks ? request->picked : 1;
    for (int i = 0; i < request->variants; i++)
        self->options[i] = (btf_ref_options){
            .effects = request->effects[i],
            .components = request->components,
            .interpolation =
                request->interpolation == BTF_INTERPOLATION_NEAREST ? BTF_REF_NEAREST : BTF_REF_LINEAR,
            .filter = filter_of_reference(request->filter)};
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

/* The sum of picks of one sample, at a place in the list. */
static void pick(const reference *r, int variant, const btf_ref_material *level, uint32_t column, uint32_t row,
                 const float *in, float *out) {
    out[0] = out[1] = out[2] = 0;
    for (uint32_t i = 0; i < (uint32_t)r->picked; i++) {
        const uint32_t counter[3] = {column, row, r->drawn + i};
        uint32_t random[3];
        float rgb[3];
        btf_ref_random(counter, random);
        btf_ref_evaluate_stochastic(level, &r->options[variant], r->picks, in[0], in[1], in + 5, in + 2, random, rgb);
        for (int c = 0; c < 3; c++)
            out[c] = out[c] + rgb[c];
    }
    for (int c = 0; c < 3; c++)
        out[c] = out[c] / (float)r->picked;
}

static btf_result run(void *self, int variant, int width, int rows, const float *inputs, float *out,
                      const btf_log *log) {
    reference *r = self;
    const int count = width * rows;
    (void)log;
#pragma omp parallel for schedule(dynamic, 256) num_threads(r->threads)
    for (int i = 0; i < count; i++) {
        const float *in = inputs + TABLE_INPUTS * (size_t)i;
        const int level = (int)in[8] < r->levels ? (int)in[8] : r->levels - 1;
        if (r->picks)
            pick(r, variant, &r->level[level], (uint32_t)(i % width), (uint32_t)(i / width), in, out + 3 * (size_t)i);
        else
            btf_ref_evaluate(&r->level[level], &r->options[variant], in[0], in[1], in + 5, in + 2,
                             out + 3 * (size_t)i);
    }
    r->drawn += (uint32_t)r->picked;
    return BTF_OK;
}

static btf_result no_time(void *self, int variant, int repeats, shader_times *out_times) {
    (void)self;
    (void)variant;
    (void)repeats;
    *out_times = (shader_times){0};
    return BTF_ERROR_UNSUPPORTED;
}

const shader_class shader_class_reference = {create, free, name, max_width, run, no_time};
