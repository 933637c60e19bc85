/* The settings of an encode: its input, its outputs, and the options of the method.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_SETTINGS_H
#define OPENBTF_ENCODER_SETTINGS_H

#include "encoder/factor/method.h"
#include "encoder/input/reader.h"
#include "encoder/paper/paper.h"
#include "encoder/relief/relief.h"

typedef enum enc_method {
    ENC_METHOD_JOINT = 0,
    ENC_METHOD_PAPER = 1,
    ENC_METHODS, /* how many there are */
} enc_method;

/* As --method takes it. */
const char *enc_method_name(enc_method method);

/* The time that --method joint spends to be more accurate in the same bytes. */
typedef enum enc_preset {
    ENC_PRESET_FAST = 0,
    ENC_PRESET_MEDIUM = 1,
    ENC_PRESET_THOROUGH = 2,
    ENC_PRESET_EXHAUSTIVE = 3,
    ENC_PRESETS, /* how many there are */
} enc_preset;

/* As --preset takes it. */
const char *enc_preset_name(enc_preset preset);

/* The options of --method joint. */
typedef struct enc_joint_options {
    enc_preset preset; /* default medium */
    uint32_t effects;  /* btf_effect bits: exactly these, unless `choose` */
    bool choose;       /* default: shift and gain where they pay; preset fast tries none */
    double tolerance;  /* dB that a tenth more bytes must gain at samples left out of the fit; 0: all of the
                          budget is used; default 0.05 */
    uint64_t budget;   /* GPU bytes at most; 0: enc_default_budget */
    double quality;    /* dB of sRGB-coded PSNR that is enough; 0: none is */
} enc_joint_options;

/* The defaults above. */
enc_joint_options enc_joint_options_default(void);

/* The GPU bytes that layout `paper` takes for such data, 64 W H + 4 AW AH by the formula of FORMAT.md
 * section 5, or where it has no legal atlas 64 W H + 4 * 1.6 * T W H; at most 62,500 times the root of W H,
 * which is less from 109x109 texels on with 81 directions, from 70x70 on with 151: 8 MB for 128x128, 16 MB
 * for 256x256, 25 MB for 400x400. For data of a few texels, what the least factors take. */
uint64_t enc_default_budget(int width, int height, int n_views, int n_lights);

/* What node values are fitted for (nodes/fit.h), as --fit takes it. */
typedef enum enc_fit_goal {
    ENC_FIT_BETWEEN = 0, /* directions between the samples, where that pays */
    ENC_FIT_SAMPLES = 1, /* the samples, which are the values at the nodes then */
} enc_fit_goal;

typedef struct enc_job enc_job;
struct enc_job {
    const char *input;
    const char *output;
    enc_read_options read;
    enc_method method;
    enc_paper_options paper;
    enc_joint_options joint;
    enc_fit_goal fit;
    enc_relief_options relief; /* --method joint */
    btf_layout layout;
    int levels; /* of detail, 1 at least; 0: down to one texel */
    bool half_float;
    const char *checkpoint; /* folder where stages keep their results until the material is written; NULL: none */
    bool resume;            /* go on from the checkpoint */
    const char *report;   /* JSON file; NULL: none */
    const char *pictures; /* folder, made when missing; NULL: none */
    const char *const *option_values; /* alternating names and values, NULL at the end: for file and report */
    bool quiet;                       /* no tables on stdout */
};

/* Names and values of the options that decide the result. */
typedef struct enc_option_values {
    const char *list[2 * 32 + 1]; /* alternating, NULL at the end: enc_job.option_values */
    char text[32][64];
    size_t count;
} enc_option_values;

/* Lists the options for the material's provenance and the report. Every member of `job` but option_values
 * must be set. The list points to constants and into *out_values itself, which must not be moved. */
void enc_settings_describe(const enc_job *job, enc_option_values *out_values);

/* Whether the job looks for relief, or judges gloss. */
bool enc_settings_try_relief(const enc_job *job);

/* The settings of the factors that the options of --method joint make for data of this extent. */
enc_factors_settings enc_settings_of_factors(const enc_job *job, int width, int height, int n_views,
                                             int n_lights);

/* Parsers of options, see cli_option.parse. DB[,DB] into tolerance[2], of which the second is 0 where it is
 * not given: --effect-tolerance. */
const char *enc_parse_tolerance(const char *text, void *tolerance);
/* N or "all" into an int, 0 for all: --levels. */
const char *enc_parse_levels(const char *text, void *levels);

#endif
