/* Progress of long work on stderr: a bar with stage, percent and time left of the job on a tty, plain lines
 * in a log.
 *
 * Workers add to one atomic counter; whoever finds that a redraw is due and the drawing lock free draws, so
 * no worker ever waits for another.
 *
 * SPDX-License-Identifier: MIT
 */
#include "progress.h"

#include "output.h"

#include <signal.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <time.h>
#include <unistd.h>

struct progress {
    bool quiet, tty;
    bool active;
    char *name; /* of the active stage */
    size_t total;
    double began, core_began;
    atomic_size_t done;
    atomic_flag drawing;
    bool planned;    /* the job has stages to come */
    estimate job;    /* of this stage alone without a plan; guarded by `drawing`, as are: */
    double drawn;    /* time of the last drawing */
    int drawn_tenth; /* tenth of the job in the last plain line */

    progress_stage *stages;
    size_t n_stages, n_allocated;
    struct sigaction on_interrupt, on_terminate; /* as they were */
};

static const double tty_interval = 0.1;   /* seconds between two drawings of the bar */
static const double plain_interval = 1.0; /* seconds between two plain lines */

static volatile sig_atomic_t cancelled;

static void on_signal(int number) {
    if (cancelled) {
        output_remove_all();
        signal(number, SIG_DFL);
        raise(number);
    }
    cancelled = 1;
}

double progress_clock(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

double progress_core_clock(void) {
    struct rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    return (double)(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) +
           1e-6 * (double)(usage.ru_utime.tv_usec + usage.ru_stime.tv_usec);
}

progress *progress_create(bool quiet) {
    progress *p = calloc(1, sizeof *p);
    if (!p) {
        return NULL;
    }
    p->quiet = quiet;
    p->tty = isatty(STDERR_FILENO) == 1;
    atomic_init(&p->done, 0);
    atomic_flag_clear(&p->drawing);
    struct sigaction action = {.sa_handler = on_signal, .sa_flags = SA_RESTART};
    sigemptyset(&action.sa_mask);
    sigaction(SIGINT, &action, &p->on_interrupt);
    sigaction(SIGTERM, &action, &p->on_terminate);
    return p;
}

void progress_destroy(progress **p) {
    if (!p || !*p) {
        return;
    }
    progress_end(*p);
    sigaction(SIGINT, &(*p)->on_interrupt, NULL);
    sigaction(SIGTERM, &(*p)->on_terminate, NULL);
    for (size_t i = 0; i < (*p)->n_stages; i++) {
        free((char *)(*p)->stages[i].name);
    }
    free((*p)->stages);
    free(*p);
    *p = NULL;
}

static void format_duration(char *out, size_t size, double seconds) {
    const long s = (long)(seconds + 0.5);
    if (s >= 3600) {
        snprintf(out, size, "%ld:%02ld:%02ld", s / 3600, s / 60 % 60, s % 60);
    } else {
        snprintf(out, size, "%ld:%02ld", s / 60, s % 60);
    }
}

/* "3:12 left", or nothing while that is not known. */
static void format_left(const progress *p, double now, char *out, size_t size) {
    const double left = estimate_left(&p->job, now);
    *out = '\0';
    if (left >= 0) {
        format_duration(out, size - 5, left);
        strcat(out, " left");
    }
}

static void draw_bar(const progress *p, double now) {
    char bar[25], left[32];
    const double fraction = estimate_fraction(&p->job);
    const int filled = (int)(fraction * (double)(sizeof bar - 1));
    memset(bar, '.', sizeof bar - 1);
    memset(bar, '#', (size_t)filled);
    bar[sizeof bar - 1] = '\0';
    format_left(p, now, left, sizeof left);
    /* The cursor returns to the first column, so that a message in between starts there. */
    fprintf(stderr, "\r\033[K%-17s [%s] %3d%%  %s\r", p->name, bar, (int)(fraction * 100.0), left);
    fflush(stderr);
}

static void draw_line(progress *p, double now) {
    const double fraction = estimate_fraction(&p->job);
    const int tenth = (int)(fraction * 10.0);
    if (tenth > p->drawn_tenth && tenth < 10 && now - p->drawn >= plain_interval) {
        char left[32];
        format_left(p, now, left, sizeof left);
        fprintf(stderr, "%s: %d%%%s%s\n", p->name, (int)(fraction * 100.0), left[0] ? ", " : "", left);
        p->drawn = now;
        p->drawn_tenth = tenth;
    }
}

/* The part of the stage that is done. */
static double part_done(const progress *p) {
    const size_t done = atomic_load(&p->done);
    return p->total == 0 ? 0.0 : done >= p->total ? 1.0 : (double)done / (double)p->total;
}

static void draw(progress *p) {
    if (p->quiet || !p->active || p->total == 0 || atomic_flag_test_and_set(&p->drawing)) {
        return;
    }
    const double now = progress_clock();
    if (!p->tty || now - p->drawn >= tty_interval) {
        estimate_within(&p->job, part_done(p), now);
        if (p->tty) {
            draw_bar(p, now);
            p->drawn = now;
        } else {
            draw_line(p, now);
        }
    }
    atomic_flag_clear(&p->drawing);
}

void progress_plan(progress *p, const estimate_part *parts, size_t count) {
    progress_end(p);
    p->drawn_tenth = 0;
    p->planned = count > 0;
    estimate_begin(&p->job, parts, count, progress_clock());
}

void progress_begin(progress *p, const char *stage, size_t total) {
    progress_end(p);
    p->name = strdup(stage);
    if (!p->name) {
        return; /* the stage goes unseen */
    }
    p->total = total;
    atomic_store(&p->done, 0);
    p->began = progress_clock();
    p->core_began = progress_core_clock();
    p->drawn = p->tty ? 0.0 : p->began;
    if (!p->planned) {
        estimate_begin(&p->job, &(estimate_part){p->name, 1}, 1, p->began);
        p->drawn_tenth = 0;
    }
    estimate_stage(&p->job, p->name, p->began);
    p->active = true;
    draw(p);
}

void progress_step(progress *p, size_t steps) {
    atomic_fetch_add(&p->done, steps);
    draw(p);
}

/* Adds the seconds of a finished stage; takes ownership of name. */
static void add_stage(progress *p, char *name, double seconds, double core) {
    for (size_t i = 0; i < p->n_stages; i++) {
        if (strcmp(p->stages[i].name, name) == 0) {
            p->stages[i].seconds += seconds;
            p->stages[i].core += core;
            free(name);
            return;
        }
    }
    if (p->n_stages == p->n_allocated) {
        const size_t n = p->n_allocated ? 2 * p->n_allocated : 16;
        progress_stage *stages = realloc(p->stages, n * sizeof *stages);
        if (!stages) {
            free(name);
            return;
        }
        p->stages = stages;
        p->n_allocated = n;
    }
    p->stages[p->n_stages++] = (progress_stage){name, seconds, core};
}

void progress_end(progress *p) {
    if (!p->active) {
        return;
    }
    p->active = false;
    const double now = progress_clock(), seconds = now - p->began;
    estimate_stage_end(&p->job, p->total > 0 ? part_done(p) : 1.0, now);
    if (!p->quiet) {
        char part[24] = "";
        if (p->planned && !cancelled) {
            snprintf(part, sizeof part, ", %d%% of all", (int)(estimate_fraction(&p->job) * 100.0));
        }
        fprintf(stderr, "%s%s: %s after %.1f s%s\n", p->tty ? "\r\033[K" : "", p->name,
                cancelled ? "stopped" : "done", seconds, part);
    }
    add_stage(p, p->name, seconds, progress_core_clock() - p->core_began);
    p->name = NULL;
}

bool progress_cancelled(void) {
    return cancelled != 0;
}

const progress_stage *progress_stages(const progress *p, size_t *out_count) {
    *out_count = p->n_stages;
    return p->stages;
}
