/* Fits of the joint method in a checkpoint. See steps.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "steps.h"

#include "encoder/base/ranks.h"
#include "encoder/data/checkpoint.h"
#include "options.h"

#include <assert.h>
#include <float.h>
#include <math.h>

/* The parts of a fit that are no arrays. Numbers only: a file may hold anything. */
typedef struct scalars {
    uint64_t texels, views, row, k;
    double error, prior;
    uint32_t effects, searches;
    int32_t rounds, lobes, rgb, shadow, half; /* lobes 0: no front */
    float shadow_scale;
} scalars;

/* Magnitude of what is far from any fit, and whose squares still have finite sums. */
static const float most = 0x1p24f;

static scalars scalars_of(const joint_fit *fit) {
    const joint_model *m = &fit->model;
    scalars s = {.texels = m->texels,
                 .views = m->views,
                 .row = m->row,
                 .k = m->k,
                 .error = fit->error,
                 .prior = m->prior,
                 .effects = fit->effects,
                 .searches = m->searches,
                 .rounds = fit->rounds};
    if (m->front) {
        s.lobes = m->front->kind.lobes;
        s.rgb = m->front->kind.rgb;
        s.shadow = m->front->kind.shadow;
        s.half = m->front->kind.half;
        s.shadow_scale = m->front->shadow_scale;
    }
    return s;
}

static bool is_flag(int32_t value) {
    return value == 0 || value == 1;
}

/* Whether a fit of these rows can have such scalars: one that goes through rounds, so without centres. */
static bool are_sound(const joint_rows *rows, const scalars *s) {
    const uint32_t known = BTF_EFFECT_SHADOW | BTF_EFFECT_SHIFT | BTF_EFFECT_GAIN | BTF_EFFECT_RESIDUAL;
    return s->texels == rows->texels && s->views == rows->views && s->row == rows->row &&
           s->k <= JOINT_MAX_COMPONENTS && s->error >= 0 && s->error <= DBL_MAX && s->prior >= 0 &&
           s->prior <= DBL_MAX && !(s->effects & ~known) && s->rounds >= 0 &&
           s->rounds <= 2 * ENC_JOINT_MAX_ROUNDS && s->lobes >= 0 && s->lobes <= ENC_MAX_LOBES &&
           is_flag(s->rgb) && is_flag(s->shadow) && is_flag(s->half) &&
           ((s->effects & BTF_EFFECT_RESIDUAL) != 0) == (s->k > 0) &&
           ((s->effects & BTF_EFFECT_SHADOW) != 0) == (s->shadow == 1) && s->shadow <= s->lobes &&
           (s->k > 0 || s->lobes > 0) &&
           (s->lobes == 0 || (s->shadow_scale >= 1 / most && s->shadow_scale <= most));
}

static size_t sbrdf_count(const joint_front *front, size_t texels) {
    return texels * enc_sbrdf_stride(front->kind.lobes, front->kind.rgb);
}

static void take_arrays(enc_blob *blob, joint_model *m) {
    const size_t points = m->texels * m->views;
    enc_blob_take_floats(blob, m->u, m->texels * m->k, -most, most);
    enc_blob_take_floats(blob, m->v, m->views * m->k * m->row, -most, most);
    enc_blob_take(blob, m->match, points * sizeof *m->match);
    enc_blob_take_bytes(blob, m->gain, points, m->gains.low, m->gains.high);
    if (m->front)
        enc_blob_take_floats(blob, m->front->sbrdf->values, sbrdf_count(m->front, m->texels), -most, most);
    if (m->front && m->front->shadow)
        enc_blob_take(blob, m->front->shadow, m->texels * m->row / 3);
}

static void put_arrays(enc_blob *blob, const joint_model *m) {
    const size_t points = m->texels * m->views;
    enc_blob_put(blob, m->u, m->texels * m->k * sizeof *m->u);
    enc_blob_put(blob, m->v, m->views * m->k * m->row * sizeof *m->v);
    enc_blob_put(blob, m->match, points * sizeof *m->match);
    enc_blob_put(blob, m->gain, points);
    if (m->front)
        enc_blob_put(blob, m->front->sbrdf->values, sbrdf_count(m->front, m->texels) * sizeof(float));
    if (m->front && m->front->shadow)
        enc_blob_put(blob, m->front->shadow, m->texels * m->row / 3);
}

/* Whether every point's source is one that its effects let it have. */
static bool are_sources(const joint_rows *rows, const joint_model *m) {
    bool good = true;
    for (size_t i = 0; i < m->texels * m->views && good; i++) {
        const uint32_t texel = (uint32_t)(i % m->texels);
        int dx, dy;
        good = m->shift ? m->match[i] < m->texels && joint_shift(rows->data->width, rows->data->height,
                                                                 texel, m->match[i], &dx, &dy)
                        : m->match[i] == texel;
    }
    return good;
}

/* An empty fit of these scalars. */
static bool make_fit(const joint_rows *rows, const scalars *s, joint_fit *out_fit) {
    const joint_front_kind kind = {s->lobes, s->rgb != 0, s->shadow != 0, s->half != 0};
    joint_model *m = &out_fit->model;
    if (joint_fit_init(rows, s->k, s->effects, out_fit) != BTF_OK ||
        (s->lobes > 0 && joint_front_create(rows, &kind, &m->front) != BTF_OK))
        return false;
    out_fit->error = s->error;
    out_fit->rounds = s->rounds;
    m->searches = s->searches;
    m->prior = s->prior;
    if (m->front)
        m->front->shadow_scale = s->shadow_scale;
    return true;
}

bool joint_step_take(const joint_rows *rows, const char *name, joint_fit *out_fit, void *beside,
                     size_t size) {
    enc_blob blob;
    scalars s;
    *out_fit = (joint_fit){0};
    if (!enc_checkpoint_get(rows->context, name, &blob))
        return false;
    enc_blob_take(&blob, &s, sizeof s);
    bool good = !blob.failed && are_sound(rows, &s) && make_fit(rows, &s, out_fit);
    if (good) {
        take_arrays(&blob, &out_fit->model);
        enc_blob_take(&blob, beside, size);
    }
    good = enc_blob_taken(&blob) && good && are_sources(rows, &out_fit->model);
    good = enc_ranks_all(rows->context, good);
    if (!good)
        joint_fit_clear(out_fit);
    return good;
}

btf_result joint_step_keep(const char *name, const joint_fit *fit, const void *beside, size_t size) {
    const scalars s = scalars_of(fit);
    enc_blob blob = {0};
    assert(fit->n_centres == 0);
    if (!fit->rows->context->checkpoint || !enc_ranks_leads(fit->rows->context))
        return BTF_OK;
    enc_blob_put(&blob, &s, sizeof s);
    put_arrays(&blob, &fit->model);
    enc_blob_put(&blob, beside, size);
    return enc_checkpoint_put(fit->rows->context, name, &blob);
}

bool joint_step_finite(const double *values, size_t count) {
    bool good = true;
    for (size_t i = 0; good && i < count; i++)
        good = isfinite(values[i]);
    return good;
}
