/* Section `encode`: time and accuracy over the settings of the encoder, one sweep for each setting.
 *
 * SPDX-License-Identifier: MIT
 */
#include "bench.h"
#include "plots.h"
#include "readme.h"

#include "encoder/model/pack.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* One setting of one of the methods. */
typedef struct setting {
    char sweep[24], name[72];
    double x;
    int same_as; /* the setting that has the same options, -1: none */
    bool paper, half;
    enc_paper_options paper_options;
    enc_joint_options joint_options;
} setting;

enum { MOST_SETTINGS = 96 };

typedef struct plan {
    setting settings[MOST_SETTINGS];
    int count, paper, medium; /* paper, medium: indices of the defaults of both methods */
} plan;

static setting *add(plan *p, const char *sweep, double x, int same_as) {
    setting *s = &p->settings[p->count < MOST_SETTINGS ? p->count++ : MOST_SETTINGS - 1];
    *s = (setting){.x = x,
                   .same_as = same_as,
                   .paper_options = enc_paper_options_default(),
                   .joint_options = enc_joint_options_default()};
    snprintf(s->sweep, sizeof s->sweep, "%s", sweep);
    return s;
}

#define NAME(s, ...) snprintf((s)->name, sizeof(s)->name, __VA_ARGS__)

static void plan_presets(plan *p, const bench_run *run) {
    setting *s = add(p, "paper", NAN, -1);
    p->paper = p->count - 1;
    s->paper = true;
    NAME(s, "paper");
    for (int i = 0; i < BENCH_PRESETS; i++) {
        if (run->presets_given ? run->presets[i] : !run->quick || i < ENC_PRESET_EXHAUSTIVE) {
            s = add(p, "preset", i, -1);
            s->joint_options.preset = (enc_preset)i;
            NAME(s, "joint %s", bench_preset_names[i]);
            p->medium = i == ENC_PRESET_MEDIUM ? p->count - 1 : p->medium;
        }
    }
}

/* Plans the settings of the joint method: with bytes used as long as they pay, and with all of the budget. */
static void plan_joint(plan *p, const enc_data *data) {
    static const double tolerances[] = {0, 0.02, 0.2};
    for (size_t i = 0; i < sizeof tolerances / sizeof *tolerances; i++) {
        setting *s = add(p, "tolerance", tolerances[i], -1);
        s->joint_options.tolerance = tolerances[i];
        NAME(s, "joint medium; tolerance %g dB", tolerances[i]);
    }
    for (int part = 2; part <= 4; part *= 2) {
        const uint64_t budget = bench_budget(0, data) / (uint64_t)part;
        if (budget >= bench_joint_least(data)) {
            setting *s = add(p, "budget", 1.0 / part, -1);
            s->joint_options.budget = budget;
            NAME(s, "joint medium; 1/%d of the bytes", part);
        }
    }
}

static void plan_fit(plan *p) {
    for (int lobes = 1; lobes <= ENC_MAX_LOBES; lobes++) {
        setting *s = add(p, "lobes", lobes, lobes == 3 ? p->paper : -1);
        s->paper = true;
        s->paper_options.fit.lobes = lobes;
        NAME(s, "paper; %d lobe%s", lobes, lobes == 1 ? "" : "s");
    }
    for (int rounds = 0; rounds <= 3; rounds++) {
        setting *s = add(p, "rejection", rounds, rounds == 3 ? p->paper : -1);
        s->paper = true;
        s->paper_options.fit.rounds = rounds;
        NAME(s, "paper; %d rejection%s", rounds, rounds == 1 ? "" : "s");
    }
}

static void plan_points(plan *p, const enc_data *data) {
    const int votes[] = {9, 27, data->n_lights};
    for (int i = 0; i < 3; i++) {
        if (i == 2 || votes[i] < data->n_lights) {
            setting *s = add(p, "lights voted", votes[i], i == 2 ? p->paper : -1);
            s->paper = true;
            s->paper_options.flow.lights = votes[i];
            NAME(s, "paper; %d lights vote", votes[i]);
        }
    }
    const int larger = data->width > data->height ? data->width : data->height;
    for (int half = 4; half <= 32; half *= 2) {
        const bool all = half == 32 || 2 * half + 1 >= larger;
        setting *s = add(p, "window", all ? 0.5 * larger : half, all ? p->paper : -1);
        s->paper = true;
        if (all) {
            NAME(s, "paper; window all");
            break;
        }
        s->paper_options.refine.columns = s->paper_options.refine.rows = 2 * half + 1;
        NAME(s, "paper; window +-%d", half);
    }
}

static btf_result plan_centres(plan *p, const bench_run *run) {
    const enc_data *data = run->held->train;
    uint32_t room;
    const btf_result result =
        enc_pack_centre_room(run->context, data->width, data->height, data->n_views, data->n_lights, &room);
    if (result != BTF_OK) {
        return result;
    }
    const uint32_t more = room < 65536 / 4 ? 4 * room : 65536;
    const uint32_t counts[] = {0, room / 8, room, more};
    for (int i = 0; i < 4; i++) {
        setting *s = add(p, "centres", counts[i], counts[i] == room ? p->paper : -1);
        s->paper = true;
        s->paper_options.centres = counts[i];
        if (counts[i] == 0) {
            s->paper_options.effects &= ~(uint32_t)BTF_EFFECT_HIDDEN;
        }
        NAME(s, "paper; %u centres", counts[i]);
    }
    for (int half = 0; half < 2; half++) {
        setting *s = add(p, "numbers", NAN, half ? -1 : p->paper);
        s->paper = true;
        s->half = half;
        NAME(s, "paper; %s", half ? "half floats" : "floats");
    }
    return BTF_OK;
}

static btf_result encode(const bench_run *run, const setting *s, bench_encoded *out) {
    const enc_data *data = run->held->train;
    enc_joint_options joint = s->joint_options;
    joint.budget = joint.budget > 0 ? joint.budget : run->budget;
    return s->paper ? bench_encode_paper_options(run->context, data, &s->paper_options, s->half, out)
                    : bench_encode_joint_options(run->context, data, &joint, out);
}

/* Encodes run->repeats times, and measures the accuracy of the last result, since all are the same. */
static btf_result measure(const bench_run *run, const setting *s, bench_row *row) {
    double core[BENCH_MOST_REPEATS], wall[BENCH_MOST_REPEATS];
    btf_result result = BTF_OK;
    for (int i = 0; i < run->repeats && result == BTF_OK; i++) {
        bench_encoded encoded;
        const double before = bench_peak_reset();
        result = encode(run, s, &encoded);
        if (result != BTF_OK) {
            break;
        }
        core[i] = encoded.core;
        wall[i] = encoded.wall;
        if (i == run->repeats - 1) {
            row->memory = bench_peak_memory() - before + bench_samples_bytes(run->held->train);
            row->bytes = (double)encoded.bytes;
            result = bench_accuracy(run->context, run->held, run->between, &encoded, BTF_EFFECT_ALL, row);
        }
        bench_encoded_clear(&encoded);
    }
    if (result == BTF_OK) {
        row->core = bench_median(core, run->repeats, &row->core_spread);
        row->wall = bench_median(wall, run->repeats, &row->wall_spread);
    }
    return result;
}

static btf_result measure_all(const bench_run *run, const plan *p, const char *table_name,
                              bench_table *table) {
    btf_result result = BTF_OK;
    for (int i = 0; i < p->count && result == BTF_OK; i++) {
        const setting *s = &p->settings[i];
        bench_row row = bench_row_named(s->sweep, s->name, s->x);
        if (s->same_as >= 0) {
            row = table->rows[s->same_as];
            snprintf(row.sweep, sizeof row.sweep, "%s", s->sweep);
            snprintf(row.name, sizeof row.name, "%s", s->name);
            row.x = s->x;
        } else if (!bench_journal_find(run->journal, table_name, &row)) {
            result = measure(run, s, &row);
            if (result == BTF_OK) {
                result = bench_journal_add(run->context, run->journal, table_name, &row);
            }
        }
        if (result == BTF_OK) {
            bench_table_add(table, &row);
            enc_log(run->context, BTF_LOG_INFO, "  %-44s %7.1f core s %6.2f %6.2f dB", row.name, row.core,
                    row.linear, row.srgb);
        }
    }
    return result;
}

/* Prints the figures between the samples and at directions left out. */
static void print_others(const bench_row *r, FILE *out) {
    for (int i = 0; i < BENCH_BETWEEN_SETS + BENCH_HELD_SETS; i++) {
        const double *pair = i < BENCH_BETWEEN_SETS ? r->between[i] : r->held[i - BENCH_BETWEEN_SETS];
        if (isnan(pair[0])) {
            fprintf(out, " - |");
        } else {
            fprintf(out, " %.2f / %.2f |", pair[0], pair[1]);
        }
    }
    fputc('\n', out);
}

/* Prints the table. Time and decibels relative to `base` come first. */
static void print(const bench_table *table, const bench_row *base, int repeats, const char *seen,
                  FILE *out) {
    fprintf(out,
            "Times are core seconds (all threads), median of %d; spread is (largest - smallest) / median. "
            "`*`: on the Pareto front of core time and PSNR %s (linear, sRGB), of which \"dB against it\" "
            "is too.\n\n"
            "| sweep | setting | times %s | dB against it, linear / sRGB | front | core s | spread | wall "
            "s | GPU "
            "MB | peak MB | at the samples | SSIM | between | estimate | held view | held light | both |\n"
            "| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | "
            "--- | --- |\n",
            repeats, seen, base->name);
    for (int i = 0; i < table->count; i++) {
        const bench_row *r = &table->rows[i];
        fprintf(out,
                "| %s | %s | %.2f | %+.2f / %+.2f | %s %s | %.2f | %.0f%% | %.2f | %.3f | %.0f | %.2f / "
                "%.2f | %.4f |",
                r->sweep, r->name, r->core / base->core, bench_seen(r, false) - bench_seen(base, false),
                bench_seen(r, true) - bench_seen(base, true), r->pareto_linear > 0 ? "*" : "",
                r->pareto_srgb > 0 ? "*" : "", r->core, 100 * r->core_spread, r->wall, 1e-6 * r->bytes,
                1e-6 * r->memory, r->linear, r->srgb, r->ssim);
        print_others(r, out);
    }
    fputc('\n', out);
}

btf_result bench_section_encode(const bench_run *run) {
    char name[160];
    FILE *csv = NULL;
    plan *p = calloc(1, sizeof *p);
    bench_table *table = calloc(1, sizeof *table);
    btf_result result =
        p && table ? BTF_OK : enc_fail(run->context, BTF_ERROR_MEMORY, "bench: out of memory");
    if (result == BTF_OK) {
        p->medium = -1;
        plan_presets(p, run);
        plan_joint(p, run->held->train);
        plan_fit(p);
        plan_points(p, run->held->train);
        result = plan_centres(p, run);
    }
    snprintf(name, sizeof name, "encode/%s", run->name);
    if (result == BTF_OK) {
        result = measure_all(run, p, name, table);
    }
    if (result == BTF_OK && (result = bench_open(run, "encode", "csv", &csv)) == BTF_OK) {
        bench_mark_pareto(table, bench_cost_core);
        bench_table_write(table, csv);
        fclose(csv);
        print(table, &table->rows[p->medium >= 0 ? p->medium : p->paper], run->repeats,
              bench_seen_words(run), run->summary);
        result = bench_plot_encode(run, table);
    }
    if (result == BTF_OK) {
        result = bench_readme_encode(run, table);
    }
    free(p);
    free(table);
    return result;
}
