/* Our own methods as codecs: solutions are packed and unpacked, so that the measured ones are those that a file holds.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TESTS_BENCH_ENCODES_H
#define OPENBTF_TESTS_BENCH_ENCODES_H

#include "encoder/job/settings.h"
#include "encoder/model/solution.h"

typedef struct bench_encoded {
    enc_solution solution; /* the parts of the material */
    btf_material *material;
    size_t bytes;      /* GPU bytes */
    double wall, core; /* seconds of the analysis and packing */
} bench_encoded;

/* --method joint with this preset (enc_preset) and budget (0: default), --fit samples. */
btf_result bench_encode_joint(const enc_context *context, const enc_data *data, int preset, uint64_t budget,
                              bench_encoded *out);
/* Encodes by method joint with --fit between, the default of btf-encode, and with the relief and gloss that
 * enc_relief_choose found; NULL: --relief off --gloss off. The time of that choice is not counted. */
btf_result bench_encode_joint_between(const enc_context *context, const enc_data *data, int preset,
                                      uint64_t budget, const enc_relief_store *relief, bench_encoded *out);
/* --method paper with its defaults, layout paper. */
btf_result bench_encode_paper(const enc_context *context, const enc_data *data, bench_encoded *out);
/* Encode by method joint and by method paper with any options; half: SBRDF parameters as half floats. */
btf_result bench_encode_joint_options(const enc_context *context, const enc_data *data,
                                      const enc_joint_options *options, bench_encoded *out);
btf_result bench_encode_paper_options(const enc_context *context, const enc_data *data,
                                      const enc_paper_options *options, bool half, bench_encoded *out);
/* The fewest bytes that --method joint needs for these data. */
uint64_t bench_joint_least(const enc_data *data);
/* `budget`, or where it is 0 the default of btf-encode for these data. */
uint64_t bench_budget(uint64_t budget, const enc_data *data);
void bench_encoded_clear(bench_encoded *encoded);

/* Seconds since an arbitrary moment: of the wall clock, and of all threads of this process. */
typedef struct bench_clock {
    double wall, core;
} bench_clock;
bench_clock bench_now(void);

#endif
