/* The plots of the sections.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TESTS_BENCH_PLOTS_H
#define OPENBTF_TESTS_BENCH_PLOTS_H

#include "bench.h"
#include "plot.h"

/* SECTION-MATERIAL as a plot's name, and a line in the summary. Errors: those of plot_finish. */
btf_result bench_finish_plot(const bench_run *run, const char *section, plot **p);

/* The titles and axes of a plot's panels. Headline: two of linear values, between the samples (or what
 * stands for it, bench_seen_words) and at them; else four, linear and sRGB-coded. */
void bench_accuracy_panels(const bench_run *run, plot *p, bool headline);

btf_result bench_plot_encode(const bench_run *run, const bench_table *table);
btf_result bench_plot_storage(const bench_run *run, const bench_table *table);

#endif
