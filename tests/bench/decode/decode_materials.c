/* Materials to decode. See decode_materials.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "decode_materials.h"

#include "decoder/toolkit/reference_view.h"
#include "encoder/joint/cost.h"
#include "encoder/model/decode_samples.h"
#include "encoder/report/metrics.h"

#include <math.h>
#include <openbtf/shader.h>
#include <string.h>

enum { SEARCH_ENCODES = 4 };

static const decode_subset low_rank[] = {{.name = "whole"},
                                         {.name = "half the components", .part = 2},
                                         {.name = "a quarter of the components", .part = 4},
                                         {.name = "without gain", .leave_out = BTF_EFFECT_GAIN},
                                         {.name = "whole; one view", .fixed = BTF_FIXED_VIEW},
                                         {.name = "whole; one light", .fixed = BTF_FIXED_LIGHT}};
static const decode_subset sources[] = {
    {.name = "whole"},
    {.name = "without gain", .leave_out = BTF_EFFECT_GAIN},
    {.name = "SBRDF and shadow", .leave_out = BTF_EFFECT_SHIFT | BTF_EFFECT_GAIN},
    {.name = "SBRDF", .leave_out = BTF_EFFECT_ALL}};
static const decode_subset paper[] = {
    {.name = "whole"},
    {.name = "without hidden points", .leave_out = BTF_EFFECT_HIDDEN},
    {.name = "SBRDF and shadow", .leave_out = BTF_EFFECT_HIDDEN | BTF_EFFECT_SHIFT},
    {.name = "SBRDF", .leave_out = BTF_EFFECT_ALL}};
static const decode_subset factors[] = {{.name = "whole"},
                                        {.name = "half the components", .part = 2},
                                        {.name = "a quarter of the components", .part = 4},
                                        {.name = "whole; one view", .fixed = BTF_FIXED_VIEW},
                                        {.name = "whole; one light", .fixed = BTF_FIXED_LIGHT}};

#define SUBSETS(of) .subsets = (of), .count = sizeof(of) / sizeof *(of)

/* In the order of rows. */
static const struct {
    const char *name;
    uint32_t method;
    const decode_subset *subsets;
    int count;
} kinds[DECODE_MATERIALS] = {
    {DECODE_JOINT, BENCH_METHOD_JOINT, SUBSETS(low_rank)},
    {DECODE_SOURCES, BENCH_METHOD_SOURCES, SUBSETS(sources)},
    {DECODE_PAPER, BENCH_METHOD_PAPER, SUBSETS(paper)},
    {DECODE_FACTORS, BENCH_METHOD_FACTORS, SUBSETS(factors)},
    {DECODE_HALF_FACTORS, BENCH_METHOD_FACTORS, .subsets = factors, .count = 1},
    {DECODE_EQUAL_FACTORS, BENCH_METHOD_FACTORS, .subsets = factors, .count = 1}};

/* DECODE_MATERIALS: not there. */
static int index_of(const decode_material *materials, const char *name) {
    int i = 0;
    while (i < DECODE_MATERIALS && !(materials[i].name && strcmp(materials[i].name, name) == 0)) {
        i++;
    }
    return i;
}

static decode_material *find(decode_material *materials, const char *name) {
    const int i = index_of(materials, name);
    return i < DECODE_MATERIALS ? &materials[i] : NULL;
}

const decode_material *decode_material_find(const decode_material materials[DECODE_MATERIALS],
                                            const char *name) {
    const int i = index_of(materials, name);
    return i < DECODE_MATERIALS ? &materials[i] : NULL;
}

/* PSNR over all samples. */
static btf_result measure(const bench_run *run, decode_material *m) {
    const enc_data *data = run->held->train;
    enc_sample_decoder *decoder = NULL;
    enc_metrics metrics;
    btf_result result = enc_sample_decoder_create(run->context, data, &m->encoded.solution, &decoder);
    const enc_decoded_samples played = {.decoder = decoder, .effects = BTF_EFFECT_ALL};
    if (result == BTF_OK) {
        result = enc_metrics_compare(run->context, data, enc_data_images(data), enc_decoded_images(&played),
                                     false, &metrics);
    }
    if (result == BTF_OK) {
        m->linear = enc_psnr_linear(&metrics.total);
        m->srgb = enc_psnr_srgb(&metrics.total);
    }
    enc_sample_decoder_destroy(&decoder);
    return result;
}

static btf_result encode_factors(const bench_run *run, uint64_t budget, decode_material *m) {
    const uint64_t least = bench_factors_least(run->held->train);
    const btf_result result = bench_encode_factors(run->context, run->held->train, ENC_JOINT_MEDIUM,
                                                   budget > least ? budget : least, &m->encoded);
    return result == BTF_OK ? measure(run, m) : result;
}

/* dB by which a material exceeds another one, in the figure where that is least. */
static double margin(const decode_material *m, const decode_material *of) {
    return fmin(m->linear - of->linear, m->srgb - of->srgb);
}

/* Bytes and what they lack or exceed in dB. bytes 0: not known. */
typedef struct tried {
    double bytes, over;
} tried;

/* Keeps the most bytes that fall short and the fewest that reach the target. */
static void note(tried *low, tried *high, double bytes, double over) {
    if (over < 0 && bytes > low->bytes) {
        *low = (tried){bytes, over};
    } else if (over >= 0 && (high->bytes == 0 || bytes < high->bytes)) {
        *high = (tried){bytes, over};
    }
}

/* Along the straight line of dB over the logarithm of bytes, a little above the target, between the two or
 * beyond the one that is known. */
static double next_bytes(const tried *low, const tried *high) {
    static const double usual_rise = 3.5, aim = 0.05; /* dB each e-fold of the bytes; dB */
    if (low->bytes > 0 && high->bytes > 0) {
        const double share = (aim - low->over) / fmax(high->over - low->over, aim);
        return low->bytes * pow(high->bytes / low->bytes, fmin(fmax(share, 0.1), 0.9));
    }
    const tried *known = low->bytes > 0 ? low : high;
    return known->bytes * exp((aim - known->over) / usual_rise);
}

/* The fewest bytes that reach joint's PSNR, at most SEARCH_ENCODES encodes beyond those of `whole` and
 * `half`. Where none of them is as small as one of these, that is encoded again; where not even twice the
 * bytes of joint reach it, nothing is there. */
static btf_result search_equal(const bench_run *run, const decode_material *joint,
                               const decode_material *whole, const decode_material *half,
                               decode_material *out) {
    const decode_material empty = *out;
    const double most = 2.0 * (double)joint->encoded.bytes;
    tried low = {0}, high = {0};
    btf_result result = BTF_OK;
    out->name = NULL;
    note(&low, &high, (double)whole->encoded.bytes, margin(whole, joint));
    note(&low, &high, (double)half->encoded.bytes, margin(half, joint));
    for (int i = 0; i <= SEARCH_ENCODES && result == BTF_OK; i++) {
        const bool done = (high.bytes > 0 && (high.over < 0.1 || high.bytes < 1.02 * low.bytes)) ||
                          i == SEARCH_ENCODES || low.bytes >= most;
        const double budget = done ? high.bytes : fmin(next_bytes(&low, &high), most);
        if (done && (out->name || high.bytes == 0)) {
            break;
        }
        decode_material trial = empty;
        result = encode_factors(run, (uint64_t)budget, &trial);
        const double over = result == BTF_OK ? margin(&trial, joint) : -HUGE_VAL,
                     bytes = (double)trial.encoded.bytes;
        const bool best = over >= 0 && bytes <= (high.bytes > 0 ? high.bytes : HUGE_VAL);
        enc_log(run->context, BTF_LOG_INFO, "  %s: %.3f MB, %+.2f dB", empty.name, 1e-6 * bytes, over);
        note(&low, &high, over < 0 ? budget : bytes, over);
        decode_material *loser = best ? out : &trial;
        bench_encoded_clear(&loser->encoded);
        if (best) {
            *out = trial;
        }
        if (done) {
            break;
        }
    }
    return result;
}

/* Factors by way of joint, where that is there. */
static btf_result create_factors(const bench_run *run, decode_material *materials) {
    const enc_data *data = run->held->train;
    const decode_material *joint = decode_material_find(materials, DECODE_JOINT);
    decode_material *whole = find(materials, DECODE_FACTORS), *half = find(materials, DECODE_HALF_FACTORS),
                    *equal = find(materials, DECODE_EQUAL_FACTORS);
    const uint64_t bytes = joint         ? joint->encoded.bytes
                           : run->budget ? run->budget
                                         : joint_default_budget(data);
    btf_result result = encode_factors(run, bytes, whole);
    if (result == BTF_OK) {
        result = encode_factors(run, bytes / 2, half);
    }
    if (result == BTF_OK && joint) {
        result = search_equal(run, joint, whole, half, equal);
    } else {
        equal->name = NULL;
    }
    return result;
}

static btf_result create_sources(const bench_run *run, decode_material *m) {
    enc_joint_options options = enc_joint_options_default();
    options.budget = run->budget;
    options.effects &= ~(uint32_t)BTF_EFFECT_RESIDUAL;
    options.rounds = 2;
    return bench_encode_joint_options(run->context, run->held->train, &options, false, &m->encoded);
}

/* The first preset that was asked for, else medium. */
static int preset_of(const bench_run *run) {
    int preset = 0;
    while (run->presets_given && preset < BENCH_PRESETS - 1 && !run->presets[preset]) {
        preset++;
    }
    return run->presets_given ? preset : ENC_JOINT_MEDIUM;
}

btf_result decode_materials_create(const bench_run *run, decode_material out[DECODE_MATERIALS]) {
    const enc_context *context = run->context;
    const enc_data *data = run->held->train;
    btf_result result = BTF_OK;
    memset(out, 0, DECODE_MATERIALS * sizeof *out);
    for (int i = 0; i < DECODE_MATERIALS; i++) {
        if (run->methods & kinds[i].method) {
            out[i] = (decode_material){.name = kinds[i].name,
                                       .subsets = kinds[i].subsets,
                                       .count = kinds[i].count,
                                       .linear = NAN,
                                       .srgb = NAN};
        }
    }
    if (run->methods & BENCH_METHOD_JOINT) {
        decode_material *joint = find(out, DECODE_JOINT);
        result = bench_encode_joint(context, data, preset_of(run), run->budget, &joint->encoded);
        if (result == BTF_OK) {
            result = measure(run, joint);
        }
    }
    if (result == BTF_OK && run->methods & BENCH_METHOD_SOURCES) {
        result = create_sources(run, find(out, DECODE_SOURCES));
    }
    if (result == BTF_OK && run->methods & BENCH_METHOD_PAPER) {
        result = bench_encode_paper(context, data, &find(out, DECODE_PAPER)->encoded);
    }
    if (result == BTF_OK && run->methods & BENCH_METHOD_FACTORS) {
        result = create_factors(run, out);
    }
    for (int i = 0; i < DECODE_MATERIALS && result == BTF_OK; i++) {
        if (out[i].name) {
            reference_view(out[i].encoded.material, 0, &out[i].view);
        }
    }
    return result;
}

void decode_materials_clear(decode_material materials[DECODE_MATERIALS]) {
    for (int i = 0; i < DECODE_MATERIALS; i++) {
        bench_encoded_clear(&materials[i].encoded);
        materials[i] = (decode_material){0};
    }
}
