/* Progress of long work on stderr: a bar with stage, percent and time left on a tty, plain lines in a log.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TOOLS_PROGRESS_H
#define OPENBTF_TOOLS_PROGRESS_H

#include "estimate.h"

#include <stdbool.h>
#include <stddef.h>

typedef struct progress progress;

/* Times and name of one finished stage. */
typedef struct progress_stage {
    const char *name;
    double seconds, core; /* of the clock, and of all threads added */
} progress_stage;

/* Catches SIGINT and SIGTERM until progress_destroy (a second one ends the process at once).
 * quiet: nothing is printed, times are still kept. Returns NULL when out of memory. */
progress *progress_create(bool quiet);
void progress_destroy(progress **p);

/* Sets the stages that the job will have: from here on percent and time left are those of the whole job, weighed by
 * the predicted costs. Without this call each stage is a job of its own. */
void progress_plan(progress *p, const estimate_part *parts, size_t count);

/* Begins a stage, counts its steps, ends it; stages follow one another. progress_step may be called from any
 * thread. A stage whose steps do not reach `total` was left early; a stage of total 0 has no steps. */
void progress_begin(progress *p, const char *stage, size_t total);
void progress_step(progress *p, size_t steps);
void progress_end(progress *p);

/* Seconds of a clock that only goes forwards. */
double progress_clock(void);

/* Core seconds of the process: those of all threads added. */
double progress_core_clock(void);

/* True once SIGINT or SIGTERM came. */
bool progress_cancelled(void);

/* Finished stages in order; stages of one name are summed. *out_count stages, owned by p. */
const progress_stage *progress_stages(const progress *p, size_t *out_count);

#endif
