/* The settings of an encode: its input, its outputs, and the options of the method.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_SETTINGS_H
#define OPENBTF_ENCODER_SETTINGS_H

#include "encoder/factor/method.h"
#include "encoder/input/reader.h"
#include "encoder/joint/joint.h"
#include "encoder/paper/paper.h"

typedef enum enc_method {
    ENC_METHOD_JOINT = 0,
    ENC_METHOD_PAPER = 1,
    ENC_METHOD_FACTORS = 2,
    ENC_METHODS, /* how many there are */
} enc_method;

/* As --method takes it. */
const char *enc_method_name(enc_method method);

/* What node values are fitted for (nodes/fit.h), as --fit takes it. */
typedef enum enc_fit_goal {
    ENC_FIT_BETWEEN = 0, /* directions between the samples, where that pays */
    ENC_FIT_SAMPLES = 1, /* the samples: values at the nodes are these */
} enc_fit_goal;

typedef struct enc_job enc_job;
struct enc_job {
    const char *input;
    const char *output;
    enc_read_options read;
    enc_method method;
    enc_paper_options paper;
    enc_joint_options joint; /* preset, budget and quality are those of the method factors as well */
    enc_fit_goal fit;
    btf_layout layout;
    int levels; /* of detail, 1 at least; 0: down to one texel */
    bool half_float;
    const char *
        checkpoint; /* folder where stages keep what they found until the material is written; NULL: none */
    bool resume;    /* go on from it */
    const char *report;   /* JSON file; NULL: none */
    const char *pictures; /* folder, made when missing; NULL: none */
    const char *const
        *option_values; /* alternating names and values, NULL at the end: for file and report */
    bool quiet;         /* no tables on stdout */
};

/* Names and values of the options that decide the result. */
typedef struct enc_option_values {
    const char *list[2 * 32 + 1]; /* alternating, NULL at the end: enc_job.option_values */
    char text[32][64];
    size_t count;
} enc_option_values;

/* For the material's provenance and the report; every member of job but option_values is set. The list
 * points to names that stay and into *out_values, which is not to be moved. */
void enc_settings_describe(const enc_job *job, enc_option_values *out_values);

/* The settings of the method factors for data of this extent. */
enc_factors_settings enc_settings_of_factors(const enc_job *job, int width, int height, int n_views,
                                             int n_lights);

/* Parsers of options, see cli_option.parse. DB[,DB] into tolerance[2], of which the second is 0 where it is
 * not given: --effect-tolerance. */
const char *enc_parse_tolerance(const char *text, void *tolerance);
/* N or "all" into an int, 0 for all: --levels. */
const char *enc_parse_levels(const char *text, void *levels);

#endif
