/* Section `costs`: fits the prices of the cost model (openbtf/cost.h) to the times of this machine's GPU, and writes the
 * file that plans can load.
 *
 * The shaders are those of random materials with the shapes of real ones. No data are read: the contents of a texel
 * only decide how far marches go.
 *
 * SPDX-License-Identifier: MIT
 */
#include "cost_fit.h"
#include "rig_fold.h"
#include "tests/bench/bench.h"
#include "tests/conformance/synthetic.h"

#include <openbtf/plan.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    SHIFTS = BTF_EFFECT_SHIFT | BTF_EFFECT_GAIN,
    BETWEEN = BTF_EFFECT_RELIEF | BTF_EFFECT_GLOSS,
    RESIDUAL = BTF_EFFECT_RESIDUAL
};

#define LIKE_ALL                                                                                           \
    .seed = 5, .width = 64, .height = 64, .n_views = 81, .n_lights = 81, .domain = BTF_DOMAIN_SQRT,        \
    .values = SYNTHETIC_PLAUSIBLE, .directions = SYNTHETIC_RINGS
#define LIKE_JOINT LIKE_ALL, .layout = BTF_LAYOUT_TIGHT, .colour = BTF_COLOUR_NONE, .blend = BTF_BLEND_ROOTS

/* Materials like files of default options, like single classes of these, and of components. Files of the paper's method
 * get the same prices: fitting the prices to both would make predictions worse for all of version 2. */
static const struct {
    const char *name;
    bool quick;
    synthetic_spec spec;
} materials[] = {
    {"joint",
     true,
     {LIKE_JOINT, .effects = SHIFTS | RESIDUAL | BETWEEN, .packed = 1, .entries = 16, .components = 12,
      .classes = {{3, 1, 1}, {0}, {4, 1, 0}, {0}, {5, 2, 0}}, .relief = SYNTHETIC_GENTLE,
      .gloss_share = 1}},
    {"8 bits",
     false,
     {LIKE_JOINT, .effects = RESIDUAL | BTF_EFFECT_GLOSS, .components = 6, .classes = {{6, 2, 2}},
      .gloss_share = 1}},
    {"8 and 4, 4 and 2 bits",
     false,
     {LIKE_JOINT, .effects = BTF_EFFECT_SHIFT | RESIDUAL | BTF_EFFECT_RELIEF, .components = 8,
      .classes = {{0}, {4, 2, 1}, {0}, {4, 1, 0}, {0}}, .relief = SYNTHETIC_DEEP}},
    {"components", false, {LIKE_JOINT, .effects = SHIFTS | RESIDUAL, .components = 40}},
};
enum { MATERIALS = sizeof materials / sizeof *materials };

#define STILL_VIEW .fixed_view = {0, 0, 1}
#define STILL_LIGHT .fixed_light = {0.61237246f, 0.35355338f, 0.70710677f}
#define NEAREST .interpolation = BTF_INTERPOLATION_NEAREST
#define STEEP .filter = BTF_FILTER_STEEP

/* The ways in which each material is decoded. `part`: one in so many of its components; 0: all. */
static const struct {
    const char *name;
    uint32_t part;
    btf_shader_options shader;
} ways[] = {
    {"whole", 0, {0}},
    {"half the components", 2, {0}},
    {"a quarter", 4, {0}},
    {"nearest", 0, {NEAREST}},
    {"half, nearest", 2, {NEAREST}},
    {"steep", 0, {STEEP}},
    {"nearest, steep", 0, {NEAREST, STEEP}},
    {"a quarter, steep", 4, {STEEP}},
    {"one view", 0, {.fixed = BTF_FIXED_VIEW, STILL_VIEW}},
    {"one view, steep", 0, {.fixed = BTF_FIXED_VIEW, STILL_VIEW, STEEP}},
    {"one light", 0, {.fixed = BTF_FIXED_LIGHT, STILL_LIGHT}},
    {"one of each", 0, {.fixed = BTF_FIXED_VIEW | BTF_FIXED_LIGHT, STILL_VIEW, STILL_LIGHT}},
    {"without relief", 0, {.leave_out = BTF_EFFECT_RELIEF}},
    {"without gloss", 0, {.leave_out = BTF_EFFECT_GLOSS}},
    {"without gloss, one light", 0, {.leave_out = BTF_EFFECT_GLOSS, .fixed = BTF_FIXED_LIGHT, STILL_LIGHT}},
    {"without either", 0, {.leave_out = BETWEEN}},
    {"without either, one view", 2, {.leave_out = BETWEEN, .fixed = BTF_FIXED_VIEW, STILL_VIEW}},
    {"without either, steep", 0, {.leave_out = BETWEEN, STEEP}},
    {"without codes", 0, {.leave_out = SHIFTS | BTF_EFFECT_HIDDEN}},
    {"without either or codes", 0, {.leave_out = SHIFTS | BTF_EFFECT_HIDDEN | BETWEEN}},
    {"light folded", 0, {.leave_out = BTF_EFFECT_GLOSS, .fold = BTF_FOLD_LIGHT, STILL_LIGHT}},
    {"light folded, steep", 0, {.leave_out = BTF_EFFECT_GLOSS, .fold = BTF_FOLD_LIGHT, STILL_LIGHT, STEEP}},
    {"light folded, without relief", 0, {.leave_out = BETWEEN, .fold = BTF_FOLD_LIGHT, STILL_LIGHT}},
    {"both folded", 0, {.leave_out = BTF_EFFECT_RELIEF, .fold = BTF_FOLD_BOTH, STILL_VIEW, STILL_LIGHT}},
    {"both folded, steep",
     0,
     {.leave_out = BTF_EFFECT_RELIEF, .fold = BTF_FOLD_BOTH, STILL_VIEW, STILL_LIGHT, STEEP}},
};
enum { WAYS = sizeof ways / sizeof *ways, MOST = MATERIALS * WAYS, ROUNDS = 3 };

typedef struct fitting {
    const bench_run *run;
    decode_rig rig;
    uint32_t *still;       /* the rig's inputs with the directions that stand still */
    rig_variant yardstick; /* a shader that is timed in turns with every other */
    double yards;          /* its ns, summed over all `turns` */
    int turns, rounds;
    cost_sample samples[MOST];
    char names[MOST][64];
    int count;
} fitting;

/* The inputs of the rig's sphere, with the view or light replaced by one direction where the options fix it. */
static const uint32_t *inputs_of(const fitting *f, const btf_shader_options *o) {
    const bool view = o->fixed & BTF_FIXED_VIEW || o->fold == BTF_FOLD_BOTH,
               light = o->fixed & BTF_FIXED_LIGHT || o->fold != BTF_FOLD_NONE;
    memcpy(f->still, f->rig.inputs, RIG_PIXELS * GPU_INPUTS * sizeof *f->still);
    for (size_t i = 0; i < RIG_PIXELS; i++) {
        uint32_t *at = f->still + GPU_INPUTS * i;
        if (light) {
            memcpy(at + 2, o->fixed_light, sizeof o->fixed_light);
        }
        if (view) {
            memcpy(at + 5, o->fixed_view, sizeof o->fixed_view);
        }
    }
    return f->still;
}

/* Times a shader in turns with the yardstick and returns the median of their ratios, so that a machine whose speed
 * varies under other load changes both alike. 0: failed. */
static double measure_in_turns(fitting *f, unsigned program, const uint32_t *inputs) {
    double ratio[ROUNDS], spread;
    for (int i = 0; i < f->rounds; i++) {
        const double yard = rig_measure(&f->rig, f->yardstick.program, f->rig.inputs, RIG_SIDE, NULL),
                     ns = rig_measure(&f->rig, program, inputs, RIG_SIDE, NULL);
        if (!(yard > 0 && ns > 0)) {
            return 0;
        }
        f->yards += yard;
        f->turns++;
        ratio[i] = ns / yard;
    }
    return bench_median(ratio, f->rounds, &spread);
}

/* Times a way to decode a material, unless it gives the same shader as another one. It returns no errors: a shader that
 * cannot be drawn is left out with a message. */
static void measure(fitting *f, int m, int w, const btf_material *material, int first) {
    btf_material_info info = {.struct_size = sizeof info};
    btf_material_get_info(material, &info);
    btf_shader_options o = ways[w].shader;
    o.struct_size = sizeof o;
    o.components = ways[w].part ? (info.components + ways[w].part - 1) / ways[w].part : 0;
    o.have_precise = f->rig.have_precise;
    /* a material that is black decodes nothing, and compilers know that */
    const bool black = info.colour == BTF_COLOUR_NONE && o.leave_out & RESIDUAL && o.fold == BTF_FOLD_NONE;
    if (black || btf_fold_check(&info, &o, NULL) != BTF_OK) {
        return;
    }
    cost_sample *s = &f->samples[f->count];
    s->counts = btf_plan_counts(material, &o, NULL);
    for (int i = first; i < f->count; i++) {
        if (memcmp(&s->counts, &f->samples[i].counts, sizeof s->counts) == 0) {
            return;
        }
    }
    btf_gl_fold *fold = NULL;
    rig_variant made = o.fold != BTF_FOLD_NONE
                           ? rig_folded_create(&f->rig, material, &o, &fold)
                           : rig_variant_create(&f->rig, material, &o, gpu_evaluate_body, GPU_FIRST_UNIT);
    s->ns = made.program ? measure_in_turns(f, made.program, inputs_of(f, &o)) : 0;
    rig_variant_destroy(&f->rig, &made);
    btf_gl_fold_destroy(&fold);
    if (s->ns > 0) {
        snprintf(f->names[f->count++], sizeof f->names[0], "%s: %s", materials[m].name, ways[w].name);
    }
}

/* The yardstick decodes a quarter of the units of a file of default options. */
static btf_result make_yardstick(fitting *f) {
    const btf_shader_options o = {.struct_size = sizeof o, .components = 3};
    btf_material *material = NULL;
    btf_result result = synthetic_create(&materials[0].spec, &f->run->context->log, &material);
    if (result == BTF_OK) {
        f->yardstick = rig_variant_create(&f->rig, material, &o, gpu_evaluate_body,
                                          GPU_FIRST_UNIT + BTF_TEXTURE_COUNT);
        result = f->yardstick.program ? BTF_OK : BTF_ERROR_UNSUPPORTED;
    }
    btf_material_close(&material);
    return result;
}

static btf_result measure_all(fitting *f) {
    btf_result result = make_yardstick(f);
    for (int m = 0; m < MATERIALS && result == BTF_OK; m++) {
        btf_material *material = NULL;
        const int first = f->count;
        if (f->run->quick && !materials[m].quick) {
            continue;
        }
        result = synthetic_create(&materials[m].spec, &f->run->context->log, &material);
        for (int w = 0; w < WAYS && result == BTF_OK; w += f->run->quick ? 2 : 1) {
            measure(f, m, w, material, first);
        }
        btf_material_close(&material);
    }
    for (int i = 0; i < f->count; i++) { /* from yardsticks to ns */
        f->samples[i].ns *= f->yards / f->turns;
    }
    return result;
}

/* Writes the measured rows and the prices. */
static btf_result write_tables(const fitting *f, const btf_cost_model *model, const cost_deviation *d) {
    FILE *csv = NULL, *out = f->run->summary;
    const btf_result result = bench_open(f->run, "costs", "csv", &csv);
    if (result != BTF_OK) {
        return result;
    }
    fprintf(csv, "shader,ns,predicted_ns");
#define HEAD(price, name, count) fprintf(csv, "," #count);
    BTF_COST_LIST(HEAD)
    fprintf(csv, "\n");
    for (int i = 0; i < f->count; i++) {
        const btf_decode_counts *n = &f->samples[i].counts;
        fprintf(csv, "\"%s\",%.2f,%.2f", f->names[i], f->samples[i].ns, btf_cost_of(n, model));
#define CELL(price, name, count) fprintf(csv, ",%g", n->count);
        BTF_COST_LIST(CELL)
        fprintf(csv, "\n");
    }
    fclose(csv);
    fprintf(out,
            "Prices in ns on %s, of %d shaders; predictions are off by %.1f %% in the mean, by %.0f %% at "
            "most.\n\n|",
            model->device, d->count, 100 * d->mean, 100 * d->worst);
#define TITLE(price, name, count) fprintf(out, " %s |", name);
    BTF_COST_LIST(TITLE)
    fprintf(out, "\n|");
#define RULE(price, name, count) fprintf(out, " --- |");
    BTF_COST_LIST(RULE)
    fprintf(out, "\n|");
#define PRICE(price, name, count) fprintf(out, " %.4g |", model->price);
    BTF_COST_LIST(PRICE)
    fprintf(out, "\n\n");
    return BTF_OK;
}

btf_result bench_section_costs(const bench_run *run) {
    enum { LEAST = 10 };
    static fitting f; /* large */
    char why[300], path[4096];
    const context_device *device = &context_devices[0];
    bool known = false;
    f = (fitting){.run = run, .rounds = run->quick ? 1 : ROUNDS};
    for (const context_device *d = context_devices; run->device && d->name; d++) {
        if (strcmp(d->name, run->device) == 0) {
            device = d;
            known = true;
        }
    }
    if (run->device && !known) {
        return enc_fail(run->context, BTF_ERROR_USAGE, "option --device: '%s' is no device", run->device);
    }
    if (rig_create(device, 1, &run->context->log, why, sizeof why, &f.rig) != BTF_OK) {
        fprintf(run->summary, "No OpenGL context on this machine.\n\n");
        return BTF_OK;
    }
    f.still = malloc(RIG_PIXELS * GPU_INPUTS * sizeof *f.still);
    btf_result result =
        f.still ? measure_all(&f) : enc_fail(run->context, BTF_ERROR_MEMORY, "bench: out of memory");
    if (result == BTF_OK && f.count < LEAST) {
        result =
            enc_fail(run->context, BTF_ERROR_UNSUPPORTED, "bench: only %d shaders could be timed", f.count);
    }
    if (result == BTF_OK) {
        btf_cost_model model;
        const cost_deviation d = cost_fit(f.samples, f.count, &model);
        snprintf(model.device, sizeof model.device, "%s", gpu_name(f.rig.gpu));
        snprintf(path, sizeof path, "%s/costs.json", run->out);
        result = write_tables(&f, &model, &d);
        if (result == BTF_OK) {
            result = cost_write(run->context, path, &model, &d);
        }
    }
    free(f.still);
    rig_variant_destroy(&f.rig, &f.yardstick);
    rig_destroy(&f.rig);
    return result;
}
