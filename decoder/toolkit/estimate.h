/* Estimates how much of a job is done and how long the rest takes, from the predicted costs of its stages and a
 * clock.
 *
 * Costs are in any unit: only their ratios count. The rate, seconds a unit of cost, is that of the stages done so
 * far; in the course of a stage it turns into the stage's own rate. A stage that is left early, or not run at all
 * (a checkpoint had it), counts as done, but its missing part tells nothing about the rate.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TOOLS_ESTIMATE_H
#define OPENBTF_TOOLS_ESTIMATE_H

#include <stdbool.h>
#include <stddef.h>

/* A stage to come. Stages of one name may come several times. */
typedef struct estimate_part {
    const char *stage; /* outlives the estimate */
    double cost;       /* 0 or more */
} estimate_part;

enum { ESTIMATE_PARTS = 32 };

typedef struct estimate {
    estimate_part parts[ESTIMATE_PARTS];
    size_t count;
    double total;           /* cost of all */
    size_t at;              /* stage at work, or that comes next */
    bool active;            /* the stage is at work; false between stages, or in one not foreseen */
    double began, at_began; /* times: of the job, of the stage */
    double passed, worked;  /* cost of the stages gone by: as predicted; the part that was done */
    double within;          /* part of the stage at work that is done, 0 .. 1 */
    bool jumped;            /* something was passed over since the last estimate */
    double shown;           /* largest fraction so far */
    double left, left_at;   /* smoothed time left, and when; below 0: none yet */
} estimate;

/* Begins a job of `count` stages now; those beyond ESTIMATE_PARTS count as one. */
void estimate_begin(estimate *e, const estimate_part *parts, size_t count, double now);

/* Says that the stage of this name is at work from now on; stages before it that never were are passed over. Where
 * no stage to come has this name, the stage is not part of the job: its time counts, its progress does not. */
void estimate_stage(estimate *e, const char *stage, double now);

/* Says which part of the stage is done, 0 .. 1. */
void estimate_within(estimate *e, double part, double now);

/* Says that the stage is over, and which part of it was run. */
void estimate_stage_end(estimate *e, double part, double now);

/* Fraction of the job that is done, 0 .. 1; never less than before. */
double estimate_fraction(const estimate *e);

/* Seconds left, or -1 while nothing can be said: not before a second has passed and 1 part in 500 is done. */
double estimate_left(const estimate *e, double now);

#endif
