/* Draws sweeps as plots. See plots.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "plots.h"

#include <math.h>
#include <string.h>

btf_result bench_finish_plot(const bench_run *run, const char *section, plot **p) {
    char name[200];
    bool drawn;
    snprintf(name, sizeof name, "%s-%s", section, run->name);
    const btf_result result = plot_finish(run->context, p, run->out, name, &drawn);
    if (result == BTF_OK && drawn) {
        fprintf(run->summary, "![%s](%s.png)\n\n", name, name);
    }
    return result;
}

void bench_accuracy_panels(const bench_run *run, plot *p, bool headline) {
    char title[120];
    if (run->truth->count > 0) {
        snprintf(title, sizeof title, "between the samples: %.80s", run->truth->source);
    } else if (run->held->owned) {
        snprintf(title, sizeof title, "views and lights left out (ring at %.0f degrees)", run->held->theta);
    } else {
        snprintf(title, sizeof title, "%s%s", bench_seen_words(run),
                 bench_between_has(run->between, BENCH_ESTIMATE) ? " by leaving out views and lights" : "");
    }
    for (int i = 0; i < (headline ? 2 : PLOT_PANELS); i++) {
        const bool seen = headline ? i == 0 : i < 2, srgb = !headline && i % 2;
        plot_panel(p, i, seen ? title : "at the samples that were encoded",
                   srgb ? "PSNR of sRGB-coded values, dB" : "PSNR of linear values, dB");
    }
}

static void add_row(plot *p, double x, const bench_row *r, bool headline, const char *label) {
    const double seen = bench_seen(r, false);
    const double y[PLOT_PANELS] = {seen, headline ? r->linear : bench_seen(r, true), r->linear, r->srgb};
    plot_point(p, x, y, label);
}

/* Sweeps whose rows are drawn as a series, and whether its points have labels. */
typedef struct shown {
    const char *sweep, *title;
    bool joined;
    bool label; /* label points by the name without its first word, or by x */
} shown;

static void add_sweeps(plot *p, const bench_table *table, const shown *sweeps, int count,
                       double (*cost)(const bench_row *row), double unit, bool headline) {
    for (int s = 0; s < count; s++) {
        plot_series(p, sweeps[s].title, sweeps[s].joined);
        for (int i = 0; i < table->count; i++) {
            const bench_row *r = &table->rows[i];
            const char *space = strrchr(r->name, ' ');
            if (strcmp(r->sweep, sweeps[s].sweep) == 0) {
                add_row(p, unit * cost(r), r, headline,
                        sweeps[s].label ? (space ? space + 1 : r->name) : NULL);
            }
        }
    }
}

/* The plot of the README: linear values, between the samples and at them. */
static btf_result plot_headline(const bench_run *run, const bench_table *table) {
    static const struct {
        shown by;
        const char *more[6]; /* sweeps of the same series */
    } all[] = {{{"preset", "joint, by preset", true, true}, {NULL}},
               {{"budget", "joint medium, 1/2 and 1/4 of the bytes", true, false}, {NULL}},
               {{"paper", "paper, by its settings", false, true},
                {"lobes", "rejection", "lights voted", "window", "centres", NULL}}};
    char title[200];
    snprintf(title, sizeof title, "Encoding: time against accuracy, %s", run->source);
    plot *p = plot_create(title, "core time of encoding, s (all threads added)", 2);
    bench_accuracy_panels(run, p, true);
    plot_front(p);
    for (size_t s = 0; s < sizeof all / sizeof *all; s++) {
        plot_series(p, all[s].by.title, all[s].by.joined);
        for (int i = 0; i < table->count; i++) {
            const bench_row *r = &table->rows[i];
            const char *space = strrchr(r->name, ' ');
            bool in = strcmp(r->sweep, all[s].by.sweep) == 0;
            const char *label = in && all[s].by.label ? (space ? space + 1 : r->name) : NULL;
            for (int k = 0; all[s].more[k]; k++) {
                in = in || strcmp(r->sweep, all[s].more[k]) == 0;
            }
            if (in) {
                add_row(p, r->core, r, true, label);
            }
        }
    }
    return bench_finish_plot(run, "readme-encode", &p);
}

btf_result bench_plot_encode(const bench_run *run, const bench_table *table) {
    static const shown all[] = {{"preset", "joint, by preset", true, true},
                                {"tolerance", "joint medium, by tolerance", true, false},
                                {"budget", "joint medium, 1/2 and 1/4 of the bytes", true, false},
                                {"paper", "paper", false, true},
                                {"lobes", "paper, lobes 1 to 4", true, false},
                                {"rejection", "paper, rejections 0 to 3", true, false},
                                {"lights voted", "paper, lights that vote", true, false},
                                {"window", "paper, search window", true, false},
                                {"centres", "paper, cluster centres", true, false},
                                {"numbers", "paper, half floats", false, false}};
    char title[200];
    const int count = sizeof all / sizeof *all;
    snprintf(title, sizeof title, "Encoding: time against accuracy, %s", run->source);
    plot *p = plot_create(title, "core time of encoding, s (all threads added)", PLOT_PANELS);
    bench_accuracy_panels(run, p, false);
    plot_front(p);
    add_sweeps(p, table, all, count, bench_cost_core, 1, false);
    btf_result result = bench_finish_plot(run, "encode", &p);
    if (result != BTF_OK) {
        return result;
    }
    static const shown paper[] = {{"lobes", "lobes 1 to 4", true, true},
                                  {"rejection", "rejections 0 to 3", true, false},
                                  {"lights voted", "lights that vote", true, false},
                                  {"window", "search window", true, true},
                                  {"centres", "cluster centres", true, false},
                                  {"numbers", "floats, half floats", false, false}};
    snprintf(title, sizeof title, "Encoding by --method paper: its settings, %s", run->source);
    p = plot_create(title, "core time of encoding, s (all threads added)", PLOT_PANELS);
    bench_accuracy_panels(run, p, false);
    plot_front(p);
    add_sweeps(p, table, paper, sizeof paper / sizeof *paper, bench_cost_core, 1, false);
    result = bench_finish_plot(run, "encode-paper", &p);
    return result == BTF_OK ? plot_headline(run, table) : result;
}

btf_result bench_plot_storage(const bench_run *run, const bench_table *table) {
    static const shown all[] = {{"joint", "joint medium, by budget", true, false},
                                {"paper", "paper: SBRDF, STVS, full", true, false},
                                {"PCA linear", "PCA, 8 bit, linear values", true, false},
                                {"PCA sRGB", "PCA, 8 bit, sRGB-coded values", true, false},
                                {"PCA half", "PCA, half floats, linear values", true, false},
                                {"PCA clusters 8", "PCA in 8 clusters, 8 bit", true, false},
                                {"PCA clusters 16", "PCA in 16 clusters, 8 bit", true, false},
                                {"split PCA", "split PCA, 8 bit, square root", true, false},
                                {"low-bit PCA", "low-bit split PCA, square root", true, false},
                                {"uncompressed", "uncompressed, barycentric", false, false},
                                {"splines", "uncompressed, thin-plate splines", false, false}};
    char title[200];
    snprintf(title, sizeof title, "Storage: bytes against accuracy, %s", run->source);
    btf_result result = BTF_OK;
    for (int headline = 0; headline < 2 && result == BTF_OK; headline++) {
        plot *p = plot_create(title, "bytes on the GPU, MB (10^6)", headline ? 2 : PLOT_PANELS);
        bench_accuracy_panels(run, p, headline);
        plot_front(p);
        add_sweeps(p, table, all, sizeof all / sizeof *all, bench_cost_bytes, 1e-6, headline);
        result = bench_finish_plot(run, headline ? "readme-storage" : "storage", &p);
    }
    return result;
}
