/* --quality: the fewest components that reach it (see joint_run.h).
 *
 * SPDX-License-Identifier: MIT
 */
#include "run.h"

static uint64_t bytes_with(const joint_run *r, const joint_fit *from, size_t components) {
    joint_shape shape = joint_fit_shape(from);
    shape.components = components;
    return joint_bytes(r->rows.data, &shape);
}

/* Replaces *solution and *error by those of the fewest components of `from` that reach the quality, if that
 * takes fewer bytes than *io_bytes. */
static btf_result reduce(joint_run *r, const joint_fit *from, uint64_t *io_bytes, enc_solution *solution,
                         joint_error *error) {
    size_t low = 0, high = from->model.k / 4 + 1; /* in fours: low fails, high is not known to fail */
    btf_result result = BTF_OK;
    while (high > 1 && bytes_with(r, from, 4 * (high - 1)) >= *io_bytes)
        high--;
    while (low + 1 < high && result == BTF_OK) {
        const size_t middle = (low + high) / 2;
        enc_solution trial = {0};
        joint_error trial_error;
        result = joint_run_finish_part(r, from, 4 * middle, &trial, &trial_error);
        if (result == BTF_OK && joint_psnr(&r->rows, trial_error.srgb) >= r->options->quality) {
            enc_solution_clear(solution);
            *solution = trial;
            *error = trial_error;
            *io_bytes = bytes_with(r, from, 4 * middle);
            high = middle;
        } else {
            enc_solution_clear(&trial);
            low = middle;
        }
    }
    return result;
}

btf_result joint_reach_quality(joint_run *r, enc_solution *solution, joint_error *error) {
    btf_result result = BTF_OK;
    if (joint_psnr(&r->rows, error->srgb) < r->options->quality) {
        enc_log(r->rows.context, BTF_LOG_WARNING, "joint: %.2f dB of %.2f within %llu bytes",
                joint_psnr(&r->rows, error->srgb), r->options->quality, (unsigned long long)r->budget);
        return BTF_OK;
    }
    const joint_shape shape = joint_solution_shape(solution);
    uint64_t bytes = joint_bytes(r->rows.data, &shape);
    if (r->best.rows && r->best.model.k > 0)
        result = reduce(r, &r->best, &bytes, solution, error);
    if (result == BTF_OK && r->plain.rows && r->options->choose)
        result = reduce(r, &r->plain, &bytes, solution, error);
    return result;
}
