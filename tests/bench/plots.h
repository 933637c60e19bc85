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

btf_result bench_plot_encode(const bench_run *run, const bench_table *table);
btf_result bench_plot_storage(const bench_run *run, const bench_table *table);

#endif
