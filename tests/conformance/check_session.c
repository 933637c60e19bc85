/* Compiles, binds, runs and compares for the checks.
 *
 * SPDX-License-Identifier: MIT
 */
#include "check_internal.h"
#include "decoder/toolkit/png_image.h"
#include "decoder/toolkit/reference_view.h"

#include <math.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

btf_result check_begin(const check_subject *subject, const char *body, check_session *out) {
    memset(out, 0, sizeof *out);
    out->subject = subject;
    reference_view(subject->material, 0, &out->reference);
    size_t elements = (size_t)GPU_SIDE * GPU_SIDE;
    out->inputs = calloc(elements, GPU_INPUTS * sizeof(uint32_t));
    out->expected = calloc(elements, GPU_OUTPUTS * sizeof(uint32_t));
    out->actual = calloc(elements, GPU_OUTPUTS * sizeof(uint32_t));
    char *text = NULL;
    btf_result result = out->inputs && out->expected && out->actual ? BTF_OK : BTF_ERROR_MEMORY;
    if (result == BTF_OK) {
        result = btf_shader_source(subject->material, subject->shader, subject->log, &text);
    }
    if (result == BTF_OK) {
        const char *library = subject->tamper ? subject->tamper(text) : text;
        out->program = gpu_program(subject->gpu, subject->preamble, library, body, subject->log);
        result = out->program ? BTF_OK : BTF_ERROR_INTERNAL;
    }
    btf_free(text);
    if (result == BTF_OK) {
        btf_gl_options options = gpu_gl_options(subject->gpu, subject->shader);
        result = btf_gl_upload(subject->material, &options, subject->log, &out->gl);
    }
    if (result == BTF_OK) {
        result = btf_gl_bind(out->gl, out->program, GPU_FIRST_UNIT, NULL, subject->log, NULL);
    }
    if (result != BTF_OK) {
        check_end(out);
    }
    return result;
}

void check_end(check_session *session) {
    if (session->program) {
        gpu_delete_program(session->subject->gpu, session->program);
    }
    btf_gl_destroy(&session->gl);
    free(session->inputs);
    free(session->expected);
    free(session->actual);
    memset(session, 0, sizeof *session);
}

/* The colour of a pixel that shows three words: floats by the square root of their value, other words by their low
 * byte. */
static void paint(const uint32_t *words, unsigned char *rgb) {
    for (int c = 0; c < 3; ++c) {
        float f;
        memcpy(&f, &words[c], sizeof f);
        uint32_t exponent = words[c] >> 23 & 255;
        if (words[c] == 0) {
            rgb[c] = 0;
        } else if (exponent > 90 && exponent < 160) {
            rgb[c] = (unsigned char)(255 * fmin(sqrt(fabs((double)f)), 1));
        } else {
            rgb[c] = (unsigned char)(words[c] & 255);
        }
    }
}

/* LABEL-STEP-reference.png, -gpu.png and -mask.png of a batch, 256 elements a row. */
static void dump(const check_session *session, const char *step, size_t count, int words) {
    const check_subject *s = session->subject;
    int rows = (int)((count + GPU_SIDE - 1) / GPU_SIDE);
    unsigned char *pictures = calloc(3 * (size_t)rows * GPU_SIDE, 3);
    if (!pictures) {
        return;
    }
    size_t plane = 3 * (size_t)rows * GPU_SIDE;
    for (size_t i = 0; i < count; ++i) {
        const uint32_t *e = session->expected + GPU_OUTPUTS * i, *a = session->actual + GPU_OUTPUTS * i;
        paint(e, pictures + 3 * i);
        paint(a, pictures + plane + 3 * i);
        for (int c = 0; c < words && c < 3; ++c) {
            pictures[2 * plane + 3 * i + (size_t)c] = e[c] != a[c] ? 255 : 0;
        }
    }
    static const char *const names[] = {"reference", "gpu", "mask"};
    for (size_t p = 0; p < 3; ++p) {
        char path[1200];
        snprintf(path, sizeof path, "%.900s/%.120s-%.30s-%s.png", s->dump_dir, s->label ? s->label : "case",
                 step, names[p]);
        png_image_write8(path, GPU_SIDE, rows, pictures + p * plane, s->log ? *s->log : (btf_log){0});
    }
    free(pictures);
}

/* Radiance is never NaN or infinite: equal bits that are count as different. */
static bool is_finite_radiance(const uint32_t *words) {
    float rgb[3];
    memcpy(rgb, words, sizeof rgb);
    return isfinite(rgb[0]) && isfinite(rgb[1]) && isfinite(rgb[2]);
}

btf_result check_batch(check_session *session, const char *step, uint64_t first, size_t count, int words,
                       check_outcome *outcome) {
    btf_result result = gpu_run(session->subject->gpu, session->program, count, session->inputs,
                                session->actual, session->subject->log);
    if (result != BTF_OK) {
        return result;
    }
    uint64_t before = outcome->different;
    for (size_t i = 0; i < count; ++i) {
        const uint32_t *e = session->expected + GPU_OUTPUTS * i, *a = session->actual + GPU_OUTPUTS * i;
        if (memcmp(e, a, (size_t)words * sizeof *e) == 0 && (words != 3 || is_finite_radiance(e))) {
            continue;
        }
        if (outcome->different++ == 0) {
            snprintf(outcome->step, sizeof outcome->step, "%s", step);
            outcome->index = first + i;
            memcpy(outcome->inputs, session->inputs + GPU_INPUTS * i, sizeof outcome->inputs);
            memcpy(outcome->expected, e, sizeof outcome->expected);
            memcpy(outcome->actual, a, sizeof outcome->actual);
        }
    }
    outcome->evaluated += count;
    if (before == 0 && outcome->different > 0 && session->subject->dump_dir) {
        dump(session, step, count, words);
    }
    return BTF_OK;
}
