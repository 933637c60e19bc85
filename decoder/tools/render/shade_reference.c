/* The CPU as a device, over all cores: the bits of the reference decoder, by the library's evaluator.
 *
 * SPDX-License-Identifier: MIT
 */
#include "shade_reference.h"

#include "decoder/toolkit/file.h"
#include "table.h"
#include <openbtf/evaluate.h>
#include <stdlib.h>

enum { CHUNK = 256 }; /* evaluations that a thread takes at a time */

typedef struct reference {
    btf_evaluator *evaluator;
    btf_evaluate_options options[SHADER_VARIANTS];
    int threads;
} reference;

static void destroy(void *self) {
    reference *r = self;
    if (r)
        btf_evaluator_destroy(&r->evaluator);
    free(r);
}

static void *create(const shader_request *request, const btf_log *log, btf_result *out_result) {
    if (request->math == BTF_MATH_FAST) {
        file_say(log, "option --math fast: the reference is exact; take a device with GL");
        *out_result = BTF_ERROR_USAGE;
        return NULL;
    }
    reference *self = calloc(1, sizeof *self);
    if (!self) {
        file_say(log, "out of memory for the reference");
        *out_result = BTF_ERROR_MEMORY;
        return NULL;
    }
    if ((*out_result = btf_evaluator_create(request->material, log, &self->evaluator))) {
        destroy(self);
        return NULL;
    }
    self->threads = request->threads;
    for (int i = 0; i < request->variants; i++)
        self->options[i] = (btf_evaluate_options){.struct_size = sizeof self->options[i],
                                                  .leave_out = ~request->effects[i],
                                                  .components = request->components,
                                                  .interpolation = request->interpolation,
                                                  .filter = request->filter};
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
    btf_result result = BTF_OK;
    (void)log;
#pragma omp parallel for schedule(dynamic) num_threads(r->threads)
    for (int first = 0; first < count; first += CHUNK) {
        const float *in = inputs + TABLE_INPUTS * (size_t)first;
        int32_t levels[CHUNK];
        const int some = count - first < CHUNK ? count - first : CHUNK;
        for (int i = 0; i < some; i++)
            levels[i] = (int32_t)in[TABLE_INPUTS * i + 8];
        const btf_evaluations evaluations = {.struct_size = sizeof evaluations,
                                             .count = (size_t)some,
                                             .uv = in,
                                             .lights = in + 5,
                                             .views = in + 2,
                                             .levels = levels,
                                             .stride = TABLE_INPUTS,
                                             .rgb = out + 3 * (size_t)first};
        const btf_result mine = btf_evaluate_many(r->evaluator, &r->options[variant], &evaluations);
        if (mine) {
#pragma omp atomic write
            result = mine;
        }
    }
    return result;
}

static btf_result no_time(void *self, int variant, int repeats, shader_times *out_times) {
    (void)self;
    (void)variant;
    (void)repeats;
    *out_times = (shader_times){0};
    return BTF_ERROR_UNSUPPORTED;
}

const shader_class shader_class_reference = {create, destroy, name, max_width, run, no_time};
