/* The steps that all checks share: the decoder compiled around a body, textures bound, batches run and
 * compared.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_CONFORMANCE_CHECK_INTERNAL_H
#define OPENBTF_CONFORMANCE_CHECK_INTERNAL_H

#include "check.h"

typedef struct check_session {
    const check_subject *subject;
    btf_gl *gl;
    unsigned program;
    btf_ref_material reference;
    uint32_t *inputs, *expected, *actual; /* a batch of GPU_SIDE^2 elements */
} check_session;

/* Compiles the subject's decoder with `body` (gpu_program), uploads and binds. Errors: of GL, memory. */
btf_result check_begin(const check_subject *subject, const char *body, check_session *out_session);
void check_end(check_session *session);

/* Runs the first `count` inputs and compares the first `words` words of each output with `expected`; three words are
 * radiance, which must be finite as well. `first` is the index of element 0 within the step. Adds to *outcome, and
 * writes pictures of the subject's first failing batch. */
btf_result check_batch(check_session *session, const char *step, uint64_t first, size_t count, int words,
                       check_outcome *outcome);

#endif
