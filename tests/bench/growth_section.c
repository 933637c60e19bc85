/* Section `growth`: how time and memory of encoding grow with texels and with directions, on the built-in
 * bricks.
 *
 * SPDX-License-Identifier: MIT
 */
#include "bench.h"
#include "plot.h"
#include "plots.h"

#include "tests/sample/directions.h"
#include "tests/sample/sample.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_SIZES = 4, METHODS = 3 };

/* A data set: texels along a side, directions of both kinds by name. */
typedef struct size {
    int side;
    const char *directions;
} size;

typedef struct method {
    const char *name;
    bool paper, full; /* full: left out of a quick run */
    enc_preset preset;
} method;

static const method methods[METHODS] = {{"joint fast", .preset = ENC_PRESET_FAST},
                                        {"joint medium", .preset = ENC_PRESET_MEDIUM, .full = true},
                                        {"paper", .paper = true}};

static bool is_left_out(const bench_run *run, const method *m) {
    return run->quick && m->full;
}

/* Rows of one sweep: those of the methods for every size. */
typedef struct growth {
    const char *sweep, *unit;
    size sizes[MOST_SIZES];
    int count;
} growth;

static btf_result make_data(const bench_run *run, const size *s, enc_data **out_data) {
    enc_direction *list = NULL;
    int count;
    btf_result result = directions_parse(run->context, s->directions, &list, &count);
    if (result == BTF_OK) {
        const sample_options options = {.context = run->context,
                                        .width = s->side,
                                        .height = s->side,
                                        .views = list,
                                        .n_views = count,
                                        .lights = list,
                                        .n_lights = count};
        result = sample_render(&options, out_data, NULL);
    }
    free(list);
    return result;
}

static btf_result measure(const bench_run *run, const enc_data *data, const method *m, bench_row *row) {
    double core[BENCH_MOST_REPEATS], wall[BENCH_MOST_REPEATS];
    btf_result result = BTF_OK;
    for (int i = 0; i < run->repeats && result == BTF_OK; i++) {
        bench_encoded encoded;
        const double before = bench_peak_reset();
        result = m->paper ? bench_encode_paper(run->context, data, &encoded)
                          : bench_encode_joint(run->context, data, m->preset, 0, &encoded);
        if (result == BTF_OK) {
            row->memory = bench_peak_memory() - before + bench_samples_bytes(data);
            row->bytes = (double)encoded.bytes;
            core[i] = encoded.core;
            wall[i] = encoded.wall;
            bench_encoded_clear(&encoded);
        }
    }
    if (result == BTF_OK) {
        row->core = bench_median(core, run->repeats, &row->core_spread);
        row->wall = bench_median(wall, run->repeats, &row->wall_spread);
    }
    return result;
}

static btf_result measure_size(const bench_run *run, const growth *g, const size *s, bench_table *table) {
    enc_data *data = NULL;
    btf_result result = BTF_OK;
    for (int i = 0; i < METHODS && result == BTF_OK; i++) {
        const method *m = &methods[i];
        char name[72];
        if (is_left_out(run, m)) {
            continue;
        }
        snprintf(name, sizeof name, "%s; %dx%d texels; directions %s", m->name, s->side, s->side,
                 s->directions);
        bench_row row = bench_row_named(g->sweep, name, NAN);
        if (!bench_journal_find(run->journal, "growth", &row)) {
            if (!data) {
                result = make_data(run, s, &data);
            }
            if (result == BTF_OK) {
                row.x = strcmp(g->sweep, "texels") == 0 ? (double)s->side * s->side : data->n_views;
                result = measure(run, data, m, &row);
            }
            if (result == BTF_OK) {
                result = bench_journal_add(run->context, run->journal, "growth", &row);
            }
        }
        if (result == BTF_OK) {
            bench_table_add(table, &row);
            enc_log(run->context, BTF_LOG_INFO, "  %-52s %7.1f core s %6.0f MB", row.name, row.core,
                    1e-6 * row.memory);
        }
    }
    enc_data_destroy(&data);
    return result;
}

/* Whether a row is of that method in that sweep. */
static bool is_row_of(const bench_row *r, const char *sweep, const char *method_name) {
    return strcmp(r->sweep, sweep) == 0 && strncmp(r->name, method_name, strlen(method_name)) == 0;
}

/* The exponents with which time and memory grow over the rows of one method in one sweep. */
static void exponents(const bench_table *table, const char *sweep, const char *name, double out[2]) {
    double x[MOST_SIZES], y[2][MOST_SIZES];
    int count = 0;
    for (int i = 0; i < table->count; i++) {
        const bench_row *r = &table->rows[i];
        if (is_row_of(r, sweep, name) && count < MOST_SIZES) {
            x[count] = r->x;
            y[0][count] = r->core;
            y[1][count++] = r->memory;
        }
    }
    for (int k = 0; k < 2; k++) {
        out[k] = bench_exponent(x, y[k], count);
    }
}

static btf_result draw(const bench_run *run, const bench_table *table, const growth *g) {
    char title[120], file[40];
    snprintf(title, sizeof title, "Growth of encoding with %s, btf-sample bricks", g->sweep);
    plot *p = plot_create(title, g->unit, 2);
    plot_axes(p, true, true);
    plot_panel(p, 0, "time", "core time, s (all threads added)");
    plot_panel(p, 1, "memory", "peak memory, MB (10^6), samples included");
    for (int k = 0; k < METHODS; k++) {
        const char *name = methods[k].name;
        if (is_left_out(run, &methods[k])) {
            continue;
        }
        plot_series(p, name, true);
        for (int i = 0; i < table->count; i++) {
            const bench_row *r = &table->rows[i];
            const double y[PLOT_PANELS] = {r->core, 1e-6 * r->memory};
            if (is_row_of(r, g->sweep, name)) {
                plot_point(p, r->x, y, NULL);
            }
        }
    }
    snprintf(file, sizeof file, "growth-%s", g->sweep);
    return bench_finish_plot(run, file, &p);
}

btf_result bench_section_growth(const bench_run *run) {
    const growth quick[] = {
        {"texels", "texels", {{4, "small"}, {8, "small"}, {16, "small"}}, 3},
        {"directions", "views and as many lights", {{4, "small"}, {4, "30"}, {4, "45"}}, 3}};
    const growth full[] = {{"texels", "texels", {{16, "ubo"}, {32, "ubo"}, {64, "ubo"}, {128, "ubo"}}, 4},
                           {"directions",
                            "views and as many lights",
                            {{32, "small"}, {32, "40"}, {32, "ubo"}, {32, "ubo2014"}},
                            4}};
    const growth *sweeps = run->quick ? quick : full;
    FILE *csv = NULL;
    bench_table *table = calloc(1, sizeof *table);
    btf_result result = table ? BTF_OK : enc_fail(run->context, BTF_ERROR_MEMORY, "bench: out of memory");
    for (int g = 0; g < 2; g++) {
        for (int i = 0; i < sweeps[g].count && result == BTF_OK; i++) {
            if (run->most_side == 0 || sweeps[g].sizes[i].side <= run->most_side) {
                result = measure_size(run, &sweeps[g], &sweeps[g].sizes[i], table);
            }
        }
    }
    if (result == BTF_OK && (result = bench_open(run, "growth", "csv", &csv)) == BTF_OK) {
        bench_table_write(table, csv);
        fclose(csv);
        fprintf(run->summary,
                "Fitted exponents, time ~ n^a, peak memory ~ n^b:\n\n| method | over | a, time | "
                "b, memory |\n| --- | --- | --- | --- |\n");
        for (int g = 0; g < 2; g++) {
            for (int k = 0; k < METHODS; k++) {
                double e[2];
                if (is_left_out(run, &methods[k])) {
                    continue;
                }
                exponents(table, sweeps[g].sweep, methods[k].name, e);
                fprintf(run->summary, "| %s | %s | %.2f | %.2f |\n", methods[k].name, sweeps[g].unit, e[0],
                        e[1]);
            }
        }
        fprintf(run->summary,
                "\n| setting | core s | spread | wall s | peak MB |\n| --- | --- | --- | --- | --- |\n");
        for (int i = 0; i < table->count; i++) {
            const bench_row *r = &table->rows[i];
            fprintf(run->summary, "| %s | %.2f | %.0f%% | %.2f | %.0f |\n", r->name, r->core,
                    100 * r->core_spread, r->wall, 1e-6 * r->memory);
        }
        fputc('\n', run->summary);
        for (int g = 0; g < 2 && result == BTF_OK; g++) {
            result = draw(run, table, &sweeps[g]);
        }
    }
    free(table);
    return result;
}
