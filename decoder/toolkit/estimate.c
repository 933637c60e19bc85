/* Estimates how much of a job is done and how long the rest takes. See estimate.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "estimate.h"

#include <math.h>
#include <string.h>

static const double least_seconds = 1.0, least_part = 1.0 / 500;
static const double own_rate = 0.1; /* at this part of a stage its own rate weighs as much as the job's */
static const double memory = 0.03;  /* the time left is smoothed over this part of the whole time */

void estimate_begin(estimate *e, const estimate_part *parts, size_t count, double now) {
    *e = (estimate){.began = now, .left = -1, .left_at = now};
    for (size_t i = 0; i < count; i++) {
        if (e->count < ESTIMATE_PARTS) {
            e->parts[e->count++] = parts[i];
        } else {
            e->parts[ESTIMATE_PARTS - 1].cost += parts[i].cost;
        }
        e->total += parts[i].cost;
    }
}

/* The cost of the stage at work; 0 between stages. */
static double cost_at(const estimate *e) {
    return e->active && e->at < e->count ? e->parts[e->at].cost : 0;
}

static void show(estimate *e) {
    const double done = e->passed + e->within * cost_at(e);
    const double fraction = e->total > 0 ? done / e->total : 0;
    e->shown = fmin(fmax(e->shown, fraction), 1);
}

/* The time left, from the costs and times known now; -1: not known. */
static double raw_left(const estimate *e, double now) {
    const double here = cost_at(e), worked = e->worked + e->within * here, elapsed = now - e->began;
    if (elapsed < least_seconds || worked < least_part * e->total || worked <= 0) {
        return -1;
    }
    const double rate = elapsed / worked, weight = e->within / (e->within + own_rate);
    double left = (e->total - e->passed - here) * rate;
    if (here > 0 && e->within > 0) {
        const double own = (now - e->at_began) / (e->within * here);
        left += (1 - e->within) * here * (weight * own + (1 - weight) * rate);
    } else {
        left += here * rate;
    }
    return left > 0 ? left : 0;
}

/* Updates the time left: it falls as the clock goes on, and is drawn smoothly to what the costs and times say now. */
static void update(estimate *e, double now) {
    const double raw = raw_left(e, now), since = now - e->left_at;
    show(e);
    if (raw < 0) {
        return;
    }
    if (e->left < 0 || e->jumped) {
        e->left = raw;
        e->jumped = false;
    } else {
        const double expected = e->left > since ? e->left - since : 0;
        const double span = memory * (now - e->began + raw);
        e->left = expected + (raw - expected) * (span > 0 ? 1 - exp(-since / span) : 1);
    }
    e->left_at = now;
}

void estimate_stage(estimate *e, const char *stage, double now) {
    size_t next = e->at;
    while (next < e->count && strcmp(e->parts[next].stage, stage) != 0) {
        next++;
    }
    e->active = next < e->count;
    if (e->active) {
        for (; e->at < next; e->at++) {
            e->passed += e->parts[e->at].cost;
            e->jumped = e->jumped || e->parts[e->at].cost > 0;
        }
    }
    e->at_began = now;
    e->within = 0;
    update(e, now);
}

void estimate_within(estimate *e, double part, double now) {
    e->within = fmin(fmax(part, e->within), 1);
    update(e, now);
}

void estimate_stage_end(estimate *e, double part, double now) {
    const double here = cost_at(e);
    e->worked += fmin(fmax(part, 0), 1) * here;
    e->jumped = e->jumped || part < 0.99;
    e->passed += here;
    e->at += e->active;
    e->active = false;
    e->within = 0;
    update(e, now);
    if (e->at == e->count) {
        e->shown = 1;
    }
}

double estimate_fraction(const estimate *e) {
    return e->shown;
}

double estimate_left(const estimate *e, double now) {
    if (e->left < 0) {
        return -1;
    }
    const double since = now - e->left_at;
    return e->left > since && e->shown < 1 ? e->left - since : 0;
}
