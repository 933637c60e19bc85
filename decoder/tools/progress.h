/* Progress of long work on stderr: a bar with stage, percent and time left on a tty, plain lines in a log.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_TOOLS_PROGRESS_H
#define OPENBTF_TOOLS_PROGRESS_H

#include <stdbool.h>
#include <stddef.h>

typedef struct progress progress;

/* Time and name of one finished stage. */
typedef struct progress_stage {
    const char *name;
    double seconds;
} progress_stage;

/* Catches SIGINT and SIGTERM until progress_destroy (a second one ends the process at once).
 * quiet: nothing is printed, times are still kept. Returns NULL when out of memory. */
progress *progress_create(bool quiet);
void progress_destroy(progress **p);

/* Stages follow one another; progress_step may be called from any thread. */
void progress_begin(progress *p, const char *stage, size_t total);
void progress_step(progress *p, size_t steps);
void progress_end(progress *p);

/* Seconds of a clock that only goes forwards. */
double progress_clock(void);

/* True once SIGINT or SIGTERM came. */
bool progress_cancelled(void);

/* Finished stages in order; stages of one name are summed. *out_count stages, owned by p. */
const progress_stage *progress_stages(const progress *p, size_t *out_count);

#endif
