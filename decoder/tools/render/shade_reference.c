/* The CPU as a device, over all cores: the bits of the reference decoder, by the library's evaluator; stochastic decode
 * by the reference itself, since the evaluator has no picks.
 *
 * SPDX-License-Identifier: MIT
 */
#include "shade_reference.h"

#include "decoder/toolkit/file.h"
#include "decoder/toolkit/filter.h"
#include "decoder/toolkit/reference_view.h"
#include "shade_fold.h"
#include "table.h"
#include <openbtf/evaluate.h>
#include <stdlib.h>

enum { CHUNK = 256 }; /* evaluations that a thread takes at a time */

typedef struct reference {
    btf_evaluator *evaluator;
    btf_evaluate_options options[SHADER_VARIANTS];
    int threads;
    btf_ref_folded folded[SHADER_VARIANTS][BTF_MAX_LEVELS]; /* without values: nothing is */
    /* For the reference decoder: stochastic decode, where picks is not 0, and folds. */
    btf_ref_material level[BTF_MAX_LEVELS];
    btf_ref_options reference_options[SHADER_VARIANTS];
    int levels, picks, picked;
    uint32_t drawn; /* random numbers of each place in a list */
} reference;

static void destroy(void *self) {
    reference *r = self;
    if (!r) {
        return;
    }
    for (int v = 0; v < SHADER_VARIANTS; v++) {
        for (int i = 0; i < BTF_MAX_LEVELS; i++) {
            free((void *)r->folded[v][i].values);
        }
    }
    btf_evaluator_destroy(&r->evaluator);
    free(r);
}

/* Makes ready the reference decoder, which takes the place of the library's evaluator where a list is decoded
 * stochastically or from a fold. */
static void prepare_reference(reference *self, const shader_request *request) {
    btf_material_info info = {.struct_size = sizeof info};
    btf_material_get_info(request->material, &info);
    self->picks = (int)request->picks;
    self->picked = request->picked;
    self->levels = (int)info.levels;
    for (uint32_t i = 0; i < info.levels; i++) {
        reference_view(request->material, i, &self->level[i]);
    }
    for (int i = 0; i < request->variants; i++) {
        self->reference_options[i] = (btf_ref_options){
            .effects = request->effects[i],
            .components = request->components,
            .interpolation =
                request->interpolation == BTF_INTERPOLATION_NEAREST ? BTF_REF_NEAREST : BTF_REF_LINEAR,
            .filter = filter_of_reference(request->filter)};
    }
}

/* Folds a variant at all levels; where that cannot be, nothing of it is folded, with a warning. */
static void fold(reference *r, const shader_request *request, int variant, const btf_log *log) {
    const btf_shader_options options = shade_fold_options(request, variant, log);
    for (int i = 0; i < r->levels && options.fold != BTF_FOLD_NONE; i++) {
        btf_ref_folded *f = &r->folded[variant][i];
        f->fold = (int)options.fold; /* the numbers are the same */
        f->values = shade_fold_reference(&r->level[i], r->evaluator, (uint32_t)i,
                                         &r->reference_options[variant], &options, request);
        if (!f->values) {
            file_warn(log, "no fold can be made, or there is no memory for it: nothing is folded");
            for (int j = 0; j < i; j++) {
                free((void *)r->folded[variant][j].values);
                r->folded[variant][j].values = NULL;
            }
            return;
        }
    }
}

static void *create(const shader_request *request, const btf_log *log, btf_result *out_result) {
    if (request->math == BTF_MATH_FAST) {
        file_say(log, "option --math fast: the device 'reference' computes exact math only; choose a GL "
                      "device with --device");
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
    prepare_reference(self, request);
    for (int i = 0; i < request->variants; i++) {
        self->options[i] = (btf_evaluate_options){.struct_size = sizeof self->options[i],
                                                  .leave_out = ~request->effects[i],
                                                  .components = request->components,
                                                  .interpolation = request->interpolation,
                                                  .filter = request->filter};
    }
    for (int i = 0; i < request->variants; i++) {
        fold(self, request, i, log);
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

/* The mean of the picks of one sample, at a place in the list. */
static void pick(const reference *r, int variant, const btf_ref_material *level, uint32_t column,
                 uint32_t row, const float *in, float *out) {
    out[0] = out[1] = out[2] = 0;
    for (uint32_t i = 0; i < (uint32_t)r->picked; i++) {
        const uint32_t counter[3] = {column, row, r->drawn + i};
        uint32_t random[3];
        float rgb[3];
        btf_ref_random(counter, random);
        btf_ref_evaluate_stochastic(level, &r->reference_options[variant], r->picks, in[0], in[1], in + 5,
                                    in + 2, random, rgb);
        for (int c = 0; c < 3; c++) {
            out[c] = out[c] + rgb[c];
        }
    }
    for (int c = 0; c < 3; c++) {
        out[c] = out[c] / (float)r->picked;
    }
}

static btf_result pick_all(reference *r, int variant, int width, int rows, const float *inputs,
                           float *out) {
#pragma omp parallel for schedule(dynamic, CHUNK) num_threads(r->threads)
    for (int i = 0; i < width * rows; i++) {
        const float *in = inputs + TABLE_INPUTS * (size_t)i;
        const int level = (int)in[8] < r->levels ? (int)in[8] : r->levels - 1;
        pick(r, variant, &r->level[level], (uint32_t)(i % width), (uint32_t)(i / width), in,
             out + 3 * (size_t)i);
    }
    r->drawn += (uint32_t)r->picked;
    return BTF_OK;
}

static btf_result evaluate_all(const reference *r, int variant, int count, const float *inputs,
                               float *out) {
    btf_result result = BTF_OK;
#pragma omp parallel for schedule(dynamic) num_threads(r->threads)
    for (int first = 0; first < count; first += CHUNK) {
        const float *in = inputs + TABLE_INPUTS * (size_t)first;
        int32_t levels[CHUNK];
        const int some = count - first < CHUNK ? count - first : CHUNK;
        for (int i = 0; i < some; i++) {
            levels[i] = (int32_t)in[TABLE_INPUTS * i + 8];
        }
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

static btf_result read_folds(const reference *r, int variant, int count, const float *inputs, float *out) {
#pragma omp parallel for schedule(dynamic, CHUNK) num_threads(r->threads)
    for (int i = 0; i < count; i++) {
        const float *in = inputs + TABLE_INPUTS * (size_t)i;
        const int level = (int)in[8] < r->levels ? (int)in[8] : r->levels - 1;
        btf_ref_evaluate_folded(&r->level[level], &r->reference_options[variant],
                                &r->folded[variant][level], in[0], in[1], in + 5, in + 2,
                                out + 3 * (size_t)i);
    }
    return BTF_OK;
}

static btf_result run(void *self, int variant, int width, int rows, const float *inputs, float *out,
                      const btf_log *log) {
    reference *r = self;
    (void)log;
    if (r->folded[variant][0].values) {
        return read_folds(r, variant, width * rows, inputs, out);
    }
    return r->picks ? pick_all(r, variant, width, rows, inputs, out)
                    : evaluate_all(r, variant, width * rows, inputs, out);
}

static btf_result no_time(void *self, int variant, int repeats, shader_times *out_times) {
    (void)self;
    (void)variant;
    (void)repeats;
    *out_times = (shader_times){0};
    return BTF_ERROR_UNSUPPORTED;
}

static btf_fold folded(const void *self) {
    const btf_ref_folded *of = ((const reference *)self)->folded[0];
    return of->values ? (btf_fold)of->fold : BTF_FOLD_NONE;
}

const shader_class shader_class_reference = {create, destroy, name, max_width, run, folded, no_time};
