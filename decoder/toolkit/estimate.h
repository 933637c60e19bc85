/* Estimates how much of a job is done and how long the rest takes, from the predicted costs of its stages and a
 * clock.
 *
 * Costs are in any unit: only their ratios count. The rate is what the cost done so far took; within a
 * stage it passes over to the stage's own. A stage that is left early, or not run at all (a checkpoint had
 * it), counts as done, but its missing part tells nothing about the rate.
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
    bool active;            /* it is at work; false between stages and in one that was not foreseen */
    double began, at_began; /* times: of the job, of the stage */
    double passed, worked;  /* costs of the stages behind: whole ones; what of them was really done */
    double within;          /* part of the stage at work that is done, 0 .. 1 */
    bool jumped;            /* something was passed over since the last estimate */
    double shown;           /* largest fraction so far */
    double left, left_at;   /* smoothed time left, and when; below 0: none yet */
} estimate;

/* A job of `count` stages (at most ESTIMATE_PARTS, those beyond are one), beginning now. */
void estimate_begin(estimate *e, const estimate_part *parts, size_t count, double now);

/* The stage of this name is at work from now on; those before it that never were are passed over. A name
 * that does not come any more is no stage of the job: its time counts, its progress does not. */
void estimate_stage(estimate *e, const char *stage, double now);

/* The part 0 .. 1 of the stage that is done. */
void estimate_within(estimate *e, double part, double now);

/* The stage is over; `part` of it was run. */
void estimate_stage_end(estimate *e, double part, double now);

/* Fraction of the job that is done, 0 .. 1; never less than before. */
double estimate_fraction(const estimate *e);

/* Seconds left, or -1 while nothing can be said: not before a second has passed and 1 part in 500 is done. */
double estimate_left(const estimate *e, double now);

#endif
