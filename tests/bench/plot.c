/* Plots by gnuplot. See plot.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "plot.h"

#include <errno.h>
#include <math.h>
#include <spawn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>

extern char **environ;

enum { MOST_LINES = 8, LABEL = 48 };

/* Of a label, by its point. */
typedef enum place { NOWHERE, ABOVE, BELOW } place;

typedef struct point {
    int series;
    double x, y[PLOT_PANELS];
    place place[PLOT_PANELS];
    char label[LABEL];
} point;

typedef struct box {
    double left, right, low, high;
} box;

struct plot {
    char title[200], x_label[120];
    int panels, series, lines;
    bool log_x, log_y, front, lower;
    struct {
        char title[120], y_label[120];
    } panel[PLOT_PANELS];
    struct {
        char title[80];
        bool joined;
    } of[PLOT_MOST_SERIES];
    struct {
        char title[80];
        double x;
    } line[MOST_LINES];
    point *points;
    size_t count;
    bool failed; /* out of memory */
};

/* The colours of Okabe and Ito, without their yellow, which is too light on white. */
static const char *const colours[] = {"#0072B2", "#D55E00", "#009E73", "#CC79A7",
                                      "#E69F00", "#56B4E9", "#000000"};
static const int marks[] = {7, 5, 9, 13, 11, 3, 4, 6, 8, 12, 10, 1, 2};
enum { COLOURS = sizeof colours / sizeof colours[0], MARKS = sizeof marks / sizeof marks[0] };

plot *plot_create(const char *title, const char *x_label, int panels) {
    plot *p = calloc(1, sizeof *p);
    if (p) {
        p->panels = panels;
        p->log_x = true;
        snprintf(p->title, sizeof p->title, "%s", title);
        snprintf(p->x_label, sizeof p->x_label, "%s", x_label);
    }
    return p;
}

void plot_panel(plot *p, int panel, const char *title, const char *y_label) {
    if (p) {
        snprintf(p->panel[panel].title, sizeof p->panel[panel].title, "%s", title);
        snprintf(p->panel[panel].y_label, sizeof p->panel[panel].y_label, "%s", y_label);
    }
}

void plot_axes(plot *p, bool log_x, bool log_y) {
    if (p) {
        p->log_x = log_x;
        p->log_y = log_y;
    }
}

void plot_lower_is_better(plot *p) {
    if (p) {
        p->lower = true;
    }
}

void plot_front(plot *p) {
    if (p) {
        p->front = true;
    }
}

void plot_series(plot *p, const char *title, bool joined) {
    if (p && p->series < PLOT_MOST_SERIES) {
        snprintf(p->of[p->series].title, sizeof p->of[0].title, "%s", title);
        p->of[p->series++].joined = joined;
    }
}

void plot_point(plot *p, double x, const double *y, const char *label) {
    point *points = p ? realloc(p->points, (p->count + 1) * sizeof *points) : NULL;
    if (!points) {
        if (p) {
            p->failed = true;
        }
        return;
    }
    p->points = points;
    point *at = &points[p->count++];
    *at = (point){.series = p->series - 1, .x = x};
    for (int i = 0; i < PLOT_PANELS; i++) {
        at->y[i] = i < p->panels ? y[i] : NAN;
    }
    snprintf(at->label, sizeof at->label, "%s", label ? label : "");
}

void plot_vertical(plot *p, double x, const char *title) {
    if (p && p->lines < MOST_LINES) {
        snprintf(p->line[p->lines].title, sizeof p->line[0].title, "%s", title);
        p->line[p->lines++].x = x;
    }
}

static void write_number(FILE *file, double x) {
    if (isfinite(x)) {
        fprintf(file, "%.9g\t", x);
    } else {
        fputs("NaN\t", file);
    }
}

/* Least and largest of a panel's values along x (k < 0) or y, logarithms where the axis has them. */
static void range_of(const plot *p, int k, double out[2]) {
    const bool logarithm = k < 0 ? p->log_x : p->log_y;
    out[0] = HUGE_VAL;
    out[1] = -HUGE_VAL;
    for (size_t i = 0; i < p->count; i++) {
        const double value = k < 0 ? p->points[i].x : p->points[i].y[k], at = logarithm ? log(value) : value;
        if (isfinite(at)) {
            out[0] = fmin(out[0], at);
            out[1] = fmax(out[1], at);
        }
    }
}

/* The box of a label, as fractions of its panel of 400 pixels: about 6 pixels a letter wide, 18 high. */
static box box_of(const plot *p, const point *at, int k, place where, const double x[2], const double y[2]) {
    const double letter = p->panels > 1 ? 0.016 : 0.010, height = p->panels > 2 ? 0.06 : 0.045;
    const double left = ((p->log_x ? log(at->x) : at->x) - x[0]) / fmax(1.3 * (x[1] - x[0]), 1e-9),
                 point = ((p->log_y ? log(at->y[k]) : at->y[k]) - y[0]) / fmax(1.15 * (y[1] - y[0]), 1e-9),
                 middle = point + (where == ABOVE ? 0.75 : -0.75) * height;
    return (box){left, left + letter * (double)strlen(at->label), middle - height / 2, middle + height / 2};
}

/* Places labels above their points, below where an earlier label covers that place, and leaves them out where both are
 * covered. */
static void place_labels(plot *p, int k) {
    double x[2], y[2];
    range_of(p, -1, x);
    range_of(p, k, y);
    for (size_t i = 0; i < p->count; i++) {
        point *at = &p->points[i];
        at->place[k] = NOWHERE;
        for (place where = ABOVE; *at->label && isfinite(at->y[k]) && where <= BELOW && !at->place[k]; where++) {
            const box b = box_of(p, at, k, where, x, y);
            bool taken = false;
            for (size_t j = 0; j < i && !taken; j++) {
                const point *before = &p->points[j];
                if (before->place[k]) {
                    const box of = box_of(p, before, k, before->place[k], x, y);
                    taken = b.left < of.right && of.left < b.right && b.low < of.high && of.low < b.high;
                }
            }
            at->place[k] = taken ? NOWHERE : where;
        }
    }
}

static bool is_empty(const plot *p, int series) {
    bool empty = true;
    for (size_t i = 0; i < p->count; i++) {
        empty = empty && p->points[i].series != series;
    }
    return empty;
}

/* Writes a data block for each series: x, a y for each panel, then the label in quotes for each panel where it stands
 * above its point, and for each panel where it stands below. */
static void write_points(const plot *p, FILE *file) {
    for (int s = 0; s < p->series; s++) {
        fprintf(file, "# %s\n", p->of[s].title);
        bool any = false;
        for (size_t i = 0; i < p->count; i++) {
            const point *at = &p->points[i];
            if (at->series != s) {
                continue;
            }
            any = true;
            write_number(file, at->x);
            for (int k = 0; k < p->panels; k++) {
                write_number(file, at->y[k]);
            }
            for (int of = 0; of < 2 * p->panels; of++) {
                const place where = of < p->panels ? ABOVE : BELOW;
                fprintf(file, "\"%s\"%s", at->place[of % p->panels] == where ? at->label : "",
                        of < 2 * p->panels - 1 ? "\t" : "\n");
            }
        }
        if (!any) {
            fputs("NaN\n", file); /* an empty series keeps its number among the blocks */
        }
        fputs("\n\n", file);
    }
}

static int by_x(const void *a, const void *b) {
    const point *const *x = a, *const *y = b;
    return ((*x)->x > (*y)->x) - ((*x)->x < (*y)->x);
}

/* A block a panel: its front, from the cheapest on. */
static void write_fronts(const plot *p, FILE *file) {
    const point **sorted = malloc((p->count + 1) * sizeof *sorted);
    for (int k = 0; k < p->panels && sorted; k++) {
        double best = -HUGE_VAL;
        size_t count = 0;
        for (size_t i = 0; i < p->count; i++) {
            if (isfinite(p->points[i].x) && isfinite(p->points[i].y[k])) {
                sorted[count++] = &p->points[i];
            }
        }
        qsort(sorted, count, sizeof *sorted, by_x);
        fprintf(file, "# front of panel %d\n", k + 1);
        bool any = false;
        for (size_t i = 0; i < count; i++) {
            const double y = p->lower ? -sorted[i]->y[k] : sorted[i]->y[k];
            if (y > best) {
                best = y;
                any = true;
                fprintf(file, "%.9g\t%.9g\n", sorted[i]->x, sorted[i]->y[k]);
            }
        }
        fputs(any ? "\n\n" : "NaN\tNaN\n\n\n", file);
    }
    free(sorted);
}

/* The range of a logarithmic axis: of x, or of panel k's y. Returns largest over smallest. */
static double write_range(const plot *p, int k, const char *axis, FILE *file) {
    double least = HUGE_VAL, most = 0;
    for (size_t i = 0; i < p->count; i++) {
        const double value = k < 0 ? p->points[i].x : p->points[i].y[k];
        if (value > 0 && isfinite(value)) {
            least = fmin(least, value);
            most = fmax(most, value);
        }
    }
    if (most > 0) {
        fprintf(file, "set %srange [%.3g:%.3g]\n", axis, least / 1.25, most * 1.6);
    }
    return most > 0 ? most / least : 1;
}

/* Labels 2 and 5 of each decade as well, where the largest value is only so many times the smallest. */
static void write_between_decades(double times, const char *axis, FILE *file) {
    if (times < 300) {
        fprintf(file,
                "set %stics add (0.0002, 0.0005, 0.002, 0.005, 0.02, 0.05, 0.2, 0.5, 2, 5, 20, 50, 200, 500, 2000, 5000)\n",
                axis);
    }
}

static void write_panel(const plot *p, int k, const char *name, FILE *file) {
    if (p->log_y) {
        write_between_decades(write_range(p, k, "y", file), "y", file);
    }
    const int columns = p->panels > 1 ? 2 : 1, rows = p->panels > 2 ? 2 : 1;
    const double width = 0.75 / columns, height = (rows == 1 ? 0.92 : 0.94) / rows;
    const double left = 0.085 + (k % columns) * width,
                 top = (rows == 1 ? 0.90 : 0.93) - (k / columns) * height;
    fprintf(file,
            "set lmargin at screen %.3f\nset rmargin at screen %.3f\nset tmargin at screen %.3f\n"
            "set bmargin at screen %.3f\nset title '%s' noenhanced\nset ylabel '%s' noenhanced\n",
            left, left + width - 0.085, top - 0.03, top - height + (rows == 1 ? 0.14 : 0.11),
            p->panel[k].title, p->panel[k].y_label);
    fprintf(file, k == 0 ? "set key at screen 0.765,0.90 left top Left reverse samplen 2 spacing 1.15\n"
                         : "unset key\n");
    fprintf(file, "plot ");
    if (p->front) {
        fprintf(file,
                "'%s.dat' index %d using 1:2 with lines lw 6 lc rgb '#d0d0d0' title 'Pareto front', \\\n  ",
                name, p->series + k);
    }
    const char *between = "";
    for (int s = 0; s < p->series; s++) {
        if (is_empty(p, s)) {
            continue;
        }
        fprintf(file,
                "%s'%s.dat' index %d using 1:%d with %s pt %d ps 1.1 lw 1.6 lc rgb '%s' title '%s' "
                "noenhanced",
                between, name, s, 2 + k, p->of[s].joined ? "linespoints" : "points",
                marks[s % MARKS], colours[s % COLOURS], p->of[s].title);
        between = ", \\\n  ";
    }
    for (int of = 0; of < 2 * p->series; of++) {
        if (!is_empty(p, of / 2)) {
            fprintf(file,
                    ", \\\n  '%s.dat' index %d using 1:%d:%d with labels noenhanced left offset 0.2,%s0.75 "
                    "font ',9' textcolor rgb '#404040' notitle",
                    name, of / 2, 2 + k, 2 + p->panels + (of % 2) * p->panels + k, of % 2 ? "-" : "");
        }
    }
    /* vertical lines are drawn as arrows, which need entries in the key of their own */
    for (int i = 0; i < p->lines; i++) {
        fprintf(file, ", \\\n  NaN with lines dt 2 lw 1.5 lc rgb '%s' title '%s' noenhanced",
                colours[(COLOURS - 1 - i % COLOURS + COLOURS) % COLOURS], p->line[i].title);
    }
    fputs("\n\n", file);
}

static void write_script(const plot *p, const char *name, FILE *file) {
    fprintf(
        file,
        "# In this folder: gnuplot -e \"set terminal pngcairo size 1200,600; set output '%s.png'\" %s.gp\n"
        "set encoding utf8\nset datafile separator '\\t'\n"
        "set multiplot title '%s' noenhanced\nset grid back lt 1 lw 0.6 lc rgb '#d8d8d8'\nset border 3\n"
        "set tics nomirror out\nset offsets graph 0.04, graph 0.14, graph 0.06, graph 0.06\n"
        "set xlabel '%s' noenhanced\n",
        name, name, p->title, p->x_label);
    if (p->log_x) {
        fputs("set logscale x\nset format x '%g'\n", file);
        write_between_decades(write_range(p, -1, "x", file), "x", file);
    }
    if (p->log_y) {
        fputs("set logscale y\nset format y '%g'\n", file);
    }
    for (int i = 0; i < p->lines; i++) {
        fprintf(
            file,
            "set arrow from first %.9g, graph 0 to first %.9g, graph 1 nohead dt 2 lw 1.5 lc rgb '%s'\n",
            p->line[i].x, p->line[i].x, colours[(COLOURS - 1 - i % COLOURS + COLOURS) % COLOURS]);
    }
    for (int k = 0; k < p->panels; k++) {
        write_panel(p, k, name, file);
    }
    fputs("unset multiplot\n", file);
}

/* Runs gnuplot in `directory` on NAME.gp; false where it is missing or fails. */
static bool draw(const char *directory, const char *name, const char *terminal, const char *extension) {
    char settings[500], script[300];
    snprintf(settings, sizeof settings, "set terminal %s; set output '%s.%s'", terminal, name, extension);
    snprintf(script, sizeof script, "%s.gp", name);
    char program[] = "gnuplot", option[] = "-e", *arguments[] = {program, option, settings, script, NULL};
    posix_spawn_file_actions_t actions;
    pid_t child;
    int status = -1;
    if (posix_spawn_file_actions_init(&actions) != 0) {
        return false;
    }
    const bool drawn = posix_spawn_file_actions_addchdir_np(&actions, directory) == 0 &&
                       posix_spawnp(&child, program, &actions, NULL, arguments, environ) == 0 &&
                       waitpid(child, &status, 0) == child && status == 0;
    posix_spawn_file_actions_destroy(&actions);
    return drawn;
}

static btf_result write_file(const enc_context *context, const plot *p, const char *directory,
                             const char *name, bool script) {
    char path[4096];
    snprintf(path, sizeof path, "%s/%s.%s", directory, name, script ? "gp" : "dat");
    FILE *file = fopen(path, "w");
    if (!file) {
        return enc_fail(context, BTF_ERROR_IO, "%s: %s", path, strerror(errno));
    }
    if (script) {
        write_script(p, name, file);
    } else {
        write_points(p, file);
        write_fronts(p, file);
    }
    return fclose(file) == 0 ? BTF_OK : enc_fail(context, BTF_ERROR_IO, "%s: cannot write", path);
}

btf_result plot_finish(const enc_context *context, plot **p, const char *directory, const char *name,
                       bool *out_drawn) {
    *out_drawn = false;
    if (!*p || (*p)->failed) {
        free(*p ? (*p)->points : NULL);
        free(*p);
        *p = NULL;
        return enc_fail(context, BTF_ERROR_MEMORY, "bench: out of memory for a plot");
    }
    for (int k = 0; k < (*p)->panels; k++) {
        place_labels(*p, k);
    }
    btf_result result = write_file(context, *p, directory, name, false);
    if (result == BTF_OK) {
        result = write_file(context, *p, directory, name, true);
    }
    if (result == BTF_OK) {
        char png[100], svg[100];
        const int width = (*p)->panels > 1 ? 1360 : 960, height = (*p)->panels > 2 ? 980 : 560;
        snprintf(png, sizeof png, "pngcairo size %d,%d font 'sans,11' background 'white'", width, height);
        snprintf(svg, sizeof svg, "svg size %d,%d font 'sans,11' background 'white'", width, height);
        *out_drawn = draw(directory, name, svg, "svg") && draw(directory, name, png, "png");
        if (!*out_drawn) {
            enc_log(context, BTF_LOG_WARNING, "%s/%s.gp: no plot: gnuplot is missing or failed", directory,
                    name);
        }
    }
    free((*p)->points);
    free(*p);
    *p = NULL;
    return result;
}
