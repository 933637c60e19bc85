/* The report of an encode: the paper's tables 1 and 2 for this data, the accuracy ladder, times, memory.
 * report_print.h and report_json.h write it.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_REPORT_H
#define OPENBTF_ENCODER_REPORT_H

#include "decoder/toolkit/progress.h"
#include "fit_table.h"
#include "leave_one_out.h"
#include "messages.h"
#include "metrics.h"
#include "relief_table.h"
#include "truncations.h"
#include "encoder/model/solution.h"
#include "encoder/base/ranks.h"
#include "encoder/model/trial.h"

#include <stdio.h>

/* One subset of effects, measured over all samples. */
typedef struct enc_report_step {
    const char *name; /* "sbrdf", "stvs", "full", or the name of the effect that is left out */
    uint32_t effects;
    size_t gpu_bytes;
    enc_metrics metrics;
} enc_report_step;

enum { ENC_REPORT_STEPS = 8 };

/* One level of detail, decoded in full, against the area-filtered original. */
typedef struct enc_report_level {
    int width, height;
    size_t gpu_bytes; /* of its own textures */
    double psnr_linear, psnr_srgb;
} enc_report_level;

typedef struct enc_report {
    const enc_data *data;
    const btf_material *material;
    const char *input, *output, *method;
    enc_messages reading; /* notices about the input */
    /* sbrdf, stvs, full, in this order, as far as the material has them */
    enc_report_step ladder[ENC_REPORT_STEPS];
    int n_ladder;
    enc_report_step without[ENC_REPORT_STEPS]; /* full without one effect each */
    int n_without;
    /* for a material with several levels of detail; level 0 has the errors of the ladder's last step */
    enc_report_level level[BTF_MAX_LEVELS];
    int n_levels;              /* 0 or 1: no table of them */
    enc_truncation truncations[ENC_MOST_TRUNCATIONS]; /* at drawn samples, where a residual has several
                                                         components or units */
    size_t n_truncations;
    enc_leave_one_out between; /* an estimate of the accuracy between the samples */
    const enc_fit_choice *fit; /* of node values, and its candidates; NULL: not asked for */
    const enc_relief_choice *relief; /* relief and gloss; NULL: not asked for */
    bool has_hidden;           /* table 1 applies */
    size_t hidden_before, hidden_after, hidden_total;
    size_t file_bytes;
    double seconds_total, core_total;    /* wall time, and the time of all threads together */
    const struct progress *progress;     /* times by stage */
    estimate_part parts[ESTIMATE_PARTS]; /* predicted times of the stages (job/cost.h) */
    size_t n_parts;
    size_t peak_rss;                /* bytes */
    int ranks;                      /* that encoded together */
    const enc_ranks_volume *volumes; /* the bytes that ranks exchanged; NULL for one rank */
    size_t n_volumes;
    enc_unspent unspent;     /* bytes that the analysis might have used and did not */
    const enc_trial *trials; /* choices of effects that were tried */
    int n_trials;
} enc_report;

/* Bytes of the textures that decoding with `effects` needs (FORMAT.md section 3, tables apart). In layout
 * `paper` the maps' channels count by use: one byte a texel of a tile for shadow, one for the code, two for
 * shift and index, and the whole atlas once all are used. */
size_t enc_report_gpu_bytes(const btf_material_info *info, uint32_t effects);
/* enc_report_gpu_bytes of a material cut to the first `components` of its residual (units, where its store is
 * factors). */
size_t enc_report_gpu_bytes_part(const btf_material_info *info, uint32_t effects, uint32_t components);

/* Measures `ladder` and `without`: decodes the material with each subset of effects and compares it with
 * the data. Stage "measure". */
btf_result enc_report_measure(const enc_context *context, const enc_data *data,
                              const enc_solution *solution, const btf_material *material,
                              enc_report *report);

/* Writes the rows for btf_material_desc.errors; `rows` has room for 2 * ENC_REPORT_STEPS. Returns their
 * number. */
size_t enc_report_errors(const enc_report *report, btf_material_error *rows);

/* Fills in the levels: level 0 from the ladder, the others by enc_levels_measure. Does nothing for a
 * material of one level. */
btf_result enc_report_measure_levels(const enc_context *context, const enc_data *data,
                                     const enc_levels *levels, const btf_material *material,
                                     enc_report *report);

/* Writes the rows for btf_material_desc.level_errors; `rows` has room for BTF_MAX_LEVELS. Returns their
 * number. */
size_t enc_report_level_errors(const enc_report *report, btf_level_error *rows);

/* Bytes of the data as 8-bit RGB images, as the paper's table 2 counts them. */
double enc_report_data_bytes(const enc_data *data);
/* Bytes of levels 1 and up. */
size_t enc_report_further_bytes(const enc_report *report);
/* "units", or "components", of the residual. */
const char *enc_report_part_name(const btf_material_info *info);
/* Mean squared errors of the whole material at the samples. */
enc_fit_error enc_report_at_samples(const enc_report *report);

#endif
