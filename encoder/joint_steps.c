/* Fits of the joint method in a checkpoint. See joint_steps.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "joint_steps.h"

#include "checkpoint.h"
#include "team.h"

#include <stdlib.h>

/* What of a fit is no array. */
typedef struct scalars {
    uint64_t texels, views, row, k;
    uint32_t effects;
    int32_t rounds, has_front, has_centres;
    double error, prior;
    joint_gains gains;
    bool shift;
    joint_front_kind front;
    float shadow_scale;
    unsigned searches;
} scalars;

static scalars scalars_of(const joint_fit *fit) {
    const joint_model *m = &fit->model;
    scalars s = {0};
    s.texels = m->texels;
    s.views = m->views;
    s.row = m->row;
    s.k = m->k;
    s.effects = fit->effects;
    s.rounds = fit->rounds;
    s.has_front = m->front != NULL;
    s.has_centres = m->centre != NULL;
    s.error = fit->error;
    s.prior = m->prior;
    s.gains = m->gains;
    s.shift = m->shift;
    s.searches = m->searches;
    if (m->front) {
        s.front = m->front->kind;
        s.shadow_scale = m->front->shadow_scale;
    }
    return s;
}

/* Hands every array of a model to `piece`, always in the same order. */
static void each_array(joint_model *m, void (*piece)(enc_blob *, void *, size_t), enc_blob *blob) {
    const size_t points = m->texels * m->views;
    piece(blob, m->u, m->texels * m->k * sizeof *m->u);
    piece(blob, m->v, m->views * m->k * m->row * sizeof *m->v);
    piece(blob, m->match, points * sizeof *m->match);
    piece(blob, m->gain, points);
    if (m->centre) {
        piece(blob, m->centre, points * sizeof *m->centre);
        piece(blob, m->centre_error, points * sizeof *m->centre_error);
    }
    if (m->front) {
        const size_t stride = enc_sbrdf_stride(m->front->kind.lobes, m->front->kind.rgb);
        piece(blob, m->front->sbrdf->values, m->texels * stride * sizeof(float));
        if (m->front->shadow)
            piece(blob, m->front->shadow, m->texels * m->row / 3);
    }
}

static void put(enc_blob *blob, void *piece, size_t size) {
    enc_blob_put(blob, piece, size);
}

/* An empty fit of these scalars. */
static bool make_fit(const joint_rows *rows, const scalars *s, joint_fit *out_fit) {
    const size_t points = rows->texels * rows->views;
    joint_model *m = &out_fit->model;
    *out_fit = (joint_fit){.rows = rows, .effects = s->effects, .error = s->error, .rounds = s->rounds};
    if (joint_model_init(rows, s->k, m) != BTF_OK)
        return false;
    m->gains = s->gains;
    m->shift = s->shift;
    m->searches = s->searches;
    m->prior = s->prior;
    if (s->has_centres) {
        m->centre = malloc(points * sizeof *m->centre);
        m->centre_error = malloc(points * sizeof *m->centre_error);
        if (!m->centre || !m->centre_error)
            return false;
    }
    if (s->has_front && joint_front_create(rows, &s->front, &m->front) != BTF_OK)
        return false;
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
    bool good = !blob.failed && s.texels == rows->texels && s.views == rows->views && s.row == rows->row &&
                s.k <= JOINT_MAX_COMPONENTS;
    good = good && make_fit(rows, &s, out_fit);
    if (good) {
        each_array(&out_fit->model, enc_blob_take, &blob);
        enc_blob_take(&blob, beside, size);
        good = !blob.failed && blob.at == blob.size;
    }
    enc_blob_clear(&blob);
    good = enc_team_all(rows->context, good);
    if (!good)
        joint_fit_clear(out_fit);
    return good;
}

btf_result joint_step_keep(const char *name, const joint_fit *fit, const void *beside, size_t size) {
    const scalars s = scalars_of(fit);
    joint_model model = fit->model; /* its arrays are only read */
    enc_blob blob = {0};
    if (!fit->rows->context->checkpoint || !enc_team_leads(fit->rows->context))
        return BTF_OK;
    enc_blob_put(&blob, &s, sizeof s);
    each_array(&model, put, &blob);
    enc_blob_put(&blob, beside, size);
    return enc_checkpoint_put(fit->rows->context, name, &blob);
}
