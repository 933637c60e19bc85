/* One material on one device against the reference, exactly: the integer steps, the arithmetic, the
 * radiance.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_CONFORMANCE_CHECK_H
#define OPENBTF_CONFORMANCE_CHECK_H

#include <openbtf/reference.h>
#include "gpu.h"
#include <openbtf/material.h>

/* What is compared (a material and a device), and where messages and pictures of failures go. */
typedef struct check_subject {
    gpu *gpu;
    const btf_material *material;
    const btf_shader_options *shader;
    const char *preamble; /* GLSL before the decoder, e.g. other macros; NULL for none */
    const char *(*tamper)(
        char *library); /* changes the decoder's text in place or returns another; NULL: no change */
    btf_gl_get_proc_address find; /* finds GL's functions for the library's fold; NULL: the device's finder */
    const btf_log *log;
    const char *dump_dir; /* folder for pictures of the first failing batch; NULL: none */
    const char *label;    /* begins the names of pictures */
} check_subject;

typedef struct check_outcome {
    uint64_t evaluated, different;
    char step[24];  /* of the first difference */
    uint64_t index; /* its element */
    uint32_t inputs[GPU_INPUTS], expected[GPU_OUTPUTS], actual[GPU_OUTPUTS];
} check_outcome;

/* Checks the integer steps and the arithmetic, at a level of detail that the seed chooses. `most` bounds the elements
 * of a step; a step that has more gets a random selection. `only` names the one step to run; NULL runs all. Adds to
 * *outcome. Errors: those of GL and memory; a difference is no error. */
btf_result check_steps(const check_subject *subject, uint64_t seed, uint64_t most, const char *only,
                       check_outcome *outcome);

/* Names of the steps, ended by NULL. */
extern const char *const check_step_names[];

/* `count` evaluations of btf_evaluate at random and extreme arguments; of btf_evaluate_level at every level
 * and beyond, from one pixel to the next, where the material has several. Adds to *outcome. */
btf_result check_radiance(const check_subject *subject, uint64_t seed, uint64_t count,
                          check_outcome *outcome);

/* `count` evaluations by a restriction of the material to a random scene (openbtf/plan.h), with fixed directions as
 * constants, against the reference on the whole material. The plan is chosen by the table of effect errors where the
 * material has one, else it is subject->shader. Adds to *outcome. */
btf_result check_planned(const check_subject *subject, uint64_t seed, uint64_t count,
                         check_outcome *outcome);

/* `count` evaluations of a fold of two lights, or of two pairs of light and view, at random arguments, against the
 * reference, which folds nothing; effects that would prevent the fold are left out. Adds to *outcome. */
btf_result check_folded(const check_subject *subject, uint64_t seed, uint64_t count, check_outcome *outcome);

/* The fold that check_folded makes: one of four by the seed; of a light alone where that is defined and takes no more
 * than 64 evaluations for each of `count`. */
btf_fold check_fold_kind(const btf_material_info *info, uint64_t seed, uint64_t count);

/* The effects that prevent a fold of this kind; an SBRDF may prevent it as well. */
uint32_t check_fold_left_out(btf_fold kind);

/* `count` evaluations, alternately of a stochastic decode and of the blend that it converges to, at random and extreme
 * arguments, random numbers and levels of detail. Picks are those of subject->shader; where it has none, the seed
 * chooses them. Adds to *outcome. */
btf_result check_stochastic(const check_subject *subject, uint64_t seed, uint64_t count, check_outcome *outcome);

/* `count` directions drawn to the light, and densities of lights, in turn, at random and extreme directions and random
 * numbers, by the tables that the material has (openbtf/sampling.h). Adds to *outcome. */
btf_result check_sampling(const check_subject *subject, uint64_t seed, uint64_t count,
                          check_outcome *outcome);

/* The error of fast math. A look-up that rounds to the next step of a weight (1/4096) can add a neighbour that is many
 * times brighter, so a bound that holds for every channel would have to be very wide. */
#define CHECK_FAST_BOUND 0x1p-7
typedef struct check_fast {
    uint64_t evaluated;
    uint64_t beyond;         /* channels whose relative error exceeds CHECK_FAST_BOUND */
    uint64_t ulp_counts[34]; /* channels by error: 0, 1, 2..3, 4..7, ... ULP */
    double worst_relative;   /* |fast - exact| / max(exact, 2^-10) */
    double mean_relative;    /* the sum of all, until divided by 3 * evaluated */
    double worst_absolute;
} check_fast;

/* Fast math against the reference at random arguments above the horizon; subject->shader asks for it. */
btf_result check_fast_math(const check_subject *subject, uint64_t seed, uint64_t count, check_fast *out);

#endif
