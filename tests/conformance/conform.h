/* Runs the cases of a device in a process of its own, and collects verdicts.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_CONFORMANCE_CONFORM_H
#define OPENBTF_CONFORMANCE_CONFORM_H

#include "check.h"
#include "variant.h"

typedef enum conform_verdict {
    CONFORM_PASS,
    CONFORM_FAIL,
    CONFORM_NOT_SUPPORTED, /* no context, a refused shader, or a failed self-test: says why */
    CONFORM_WAIVED,        /* a difference that a waiver names */
} conform_verdict;

/* The command line of btf-conform. */
typedef struct conform_options {
    uint64_t seed, count, steps; /* evaluations of radiance and elements of a step, each variant */
    int first, stride;           /* variants first, first + stride, ...; first alone when stride is 0 */
    bool fast;                   /* measure fast math too */
    bool sabotage;               /* swap the shift bytes in the decoder, to see a failure */
    const char *dump_dir;        /* NULL: no pictures */
    const char *waiver;          /* "CASE:RENDERER:REASON", NULL: none */
    char **files;                /* materials to check in place of the synthetic ones */
    int file_count;
    const btf_log *log;
} conform_options;

/* One case: a variant's steps, its radiance, or a fast-math measurement. Travels through a pipe as it is.
 */
typedef struct conform_case {
    char name[VARIANT_NAME + 40];
    char reason[200]; /* of a verdict that is not pass or fail */
    conform_verdict verdict;
    bool is_fast;
    check_outcome outcome;
    check_fast fast;
    uint64_t seed;
    double seconds;
} conform_case;

typedef struct conform_device {
    const context_device *device;
    char renderer[200];
    conform_verdict verdict;
    char reason[300];
    uint32_t self_test;
    conform_case *cases;
    size_t case_count, case_capacity;
    double seconds;
} conform_device;

/* Runs a device in a child process; fills *out, whose cases the caller frees. A child that dies is a
 * failure. Errors: BTF_ERROR_INTERNAL (no process), BTF_ERROR_MEMORY. */
btf_result conform_run(const context_device *device, const conform_options *options, conform_device *out);

const char *conform_verdict_name(conform_verdict verdict);

/* Fast math passes when at most one channel in this many is off by more than CHECK_FAST_BOUND. */
enum { CONFORM_FAST_SHARE = 1000 };

#endif
