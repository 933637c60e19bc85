/* Materials to decode. See decode_materials.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "decode_materials.h"

#include "decoder/toolkit/reference_view.h"
#include "encoder/relief/relief.h"

#include <openbtf/shader.h>
#include <string.h>

static const decode_subset factors[] = {{.name = "whole"},
                                        {.name = "half the components", .part = 2},
                                        {.name = "a quarter of the components", .part = 4},
                                        {.name = "whole; one view", .fixed = BTF_FIXED_VIEW},
                                        {.name = "whole; one light", .fixed = BTF_FIXED_LIGHT}};
static const decode_subset paper[] = {
    {.name = "whole"},
    {.name = "without hidden points", .leave_out = BTF_EFFECT_HIDDEN},
    {.name = "SBRDF and shadow", .leave_out = BTF_EFFECT_HIDDEN | BTF_EFFECT_SHIFT},
    {.name = "SBRDF", .leave_out = BTF_EFFECT_ALL}};

static const decode_subset moved[] = {
    {.name = "whole"},
    {.name = DECODE_NO_RELIEF, .leave_out = BTF_EFFECT_RELIEF},
    {.name = DECODE_NO_GLOSS, .leave_out = BTF_EFFECT_GLOSS},
    {.name = DECODE_NEITHER, .leave_out = BTF_EFFECT_RELIEF | BTF_EFFECT_GLOSS}};

static const decode_subset relief_found[] = {
    {.name = "whole", .leave_out = BTF_EFFECT_GLOSS},
    {.name = DECODE_NO_RELIEF, .leave_out = BTF_EFFECT_RELIEF},
    {.name = DECODE_ADDED_GLOSS},
    {.name = DECODE_NEITHER, .leave_out = BTF_EFFECT_RELIEF | BTF_EFFECT_GLOSS}};
static const decode_subset gloss_alone[] = {{.name = "whole"},
                                            {.name = DECODE_NEITHER, .leave_out = BTF_EFFECT_GLOSS}};

#define SUBSETS(of) .subsets = (of), .count = sizeof(of) / sizeof *(of)

/* In the order of rows. */
static const struct {
    const char *name;
    uint32_t method;
    const decode_subset *subsets;
    int count;
} kinds[DECODE_MATERIALS] = {
    {DECODE_JOINT, BENCH_METHOD_JOINT, SUBSETS(factors)},
    {DECODE_HALF_JOINT, BENCH_METHOD_JOINT, .subsets = factors, .count = 1},
    {DECODE_PAPER, BENCH_METHOD_PAPER, SUBSETS(paper)},
    {DECODE_RELIEF, BENCH_METHOD_JOINT, SUBSETS(moved)}};

/* Returns the index of the material of this name, or DECODE_MATERIALS if there is none. */
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

static btf_result encode_joint(const bench_run *run, int preset, uint64_t budget, decode_material *m) {
    const uint64_t least = bench_joint_least(run->held->train);
    return bench_encode_joint(run->context, run->held->train, preset, budget > least ? budget : least,
                              &m->encoded);
}

/* The first preset that was asked for, else medium. */
static int preset_of(const bench_run *run) {
    int preset = 0;
    while (run->presets_given && preset < BENCH_PRESETS - 1 && !run->presets[preset]) {
        preset++;
    }
    return run->presets_given ? preset : ENC_PRESET_MEDIUM;
}

/* Encodes with the relief and gloss that the default finds. There is no material where it finds neither, or the preset
 * does not search. */
static btf_result encode_relief(const bench_run *run, uint64_t budget, decode_material *m) {
    const enc_relief_options options = {.relief = true, .gloss = -1};
    const int preset = preset_of(run);
    enc_relief_choice choice;
    enc_relief_store store = {0};
    btf_result result = preset == ENC_PRESET_FAST
                            ? BTF_OK
                            : enc_relief_choose(run->context, run->held->train, &options, &choice, &store);
    const bool relief_only = store.effects == BTF_EFFECT_RELIEF;
    if (relief_only) {
        store.effects |= BTF_EFFECT_GLOSS;
        store.gloss_share = 1;
    }
    if (result == BTF_OK && store.effects) {
        result = bench_encode_joint_between(run->context, run->held->train, preset, budget, &store, &m->encoded);
    } else {
        m->name = NULL;
    }
    if (relief_only) {
        m->subsets = relief_found;
    } else if (!(store.effects & BTF_EFFECT_RELIEF) && m->name) {
        m->subsets = gloss_alone; /* the subsets leave out gloss where others leave out both */
        m->count = 2;
    }
    enc_relief_clear(&store);
    return result;
}

btf_result decode_materials_create(const bench_run *run, decode_material out[DECODE_MATERIALS]) {
    const uint64_t budget = bench_budget(run->budget, run->held->train);
    btf_result result = BTF_OK;
    memset(out, 0, DECODE_MATERIALS * sizeof *out);
    for (int i = 0; i < DECODE_MATERIALS; i++) {
        if (run->methods & kinds[i].method) {
            out[i] = (decode_material){
                .name = kinds[i].name, .subsets = kinds[i].subsets, .count = kinds[i].count};
        }
    }
    if (run->methods & BENCH_METHOD_JOINT) {
        decode_material *joint = find(out, DECODE_JOINT);
        result = encode_joint(run, preset_of(run), budget, joint);
        if (result == BTF_OK) {
            result = encode_joint(run, preset_of(run), joint->encoded.bytes / 2, find(out, DECODE_HALF_JOINT));
        }
        if (result == BTF_OK) {
            result = encode_relief(run, budget, find(out, DECODE_RELIEF));
        }
    }
    if (result == BTF_OK && run->methods & BENCH_METHOD_PAPER) {
        result = bench_encode_paper(run->context, run->held->train, &find(out, DECODE_PAPER)->encoded);
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
