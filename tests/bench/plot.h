/* Plots of one figure over another, by gnuplot: a data file, a script and two pictures side by side in one
 * folder. Colours are those of Okabe and Ito (2008), which the colour-blind can tell apart; every series
 * has its own mark as well.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TESTS_BENCH_PLOT_H
#define OPENBTF_TESTS_BENCH_PLOT_H

#include "encoder/base/context.h"

enum { PLOT_PANELS = 4, PLOT_MOST_SERIES = 24 };

typedef struct plot plot;

/* An empty plot. panels: 1, 2 or 4 pictures with the same x. Errors: NULL, out of memory. */
plot *plot_create(const char *title, const char *x_label, int panels);
/* Sets the titles of panel `panel` and of its y axis. */
void plot_panel(plot *p, int panel, const char *title, const char *y_label);
/* The x axis is logarithmic, unless this is called; y axes are linear, unless log_y. */
void plot_axes(plot *p, bool log_x, bool log_y);
/* Says that smaller y is better, for the front. */
void plot_lower_is_better(plot *p);
/* Draws, below the marks, the line of the points that no other one is both cheaper and better than. */
void plot_front(plot *p);

/* Begins a series: the following points belong to it; `joined`: a line joins them. */
void plot_series(plot *p, const char *title, bool joined);
/* y: one a panel, NAN where a panel has none. label: written beside the mark, may be NULL. */
void plot_point(plot *p, double x, const double *y, const char *label);
/* Draws a dashed vertical line at the cost of something that has no figure. */
void plot_vertical(plot *p, double x, const char *title);

/* Writes DIR/NAME.dat, NAME.gp, NAME.svg and NAME.png and frees the plot. Without gnuplot the pictures are
 * left out with a message; *out_drawn tells. Errors, on the log: BTF_ERROR_IO, BTF_ERROR_MEMORY. */
btf_result plot_finish(const enc_context *context, plot **p, const char *directory, const char *name,
                       bool *out_drawn);

#endif
