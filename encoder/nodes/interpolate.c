/* Weights of samples in a direction between them. See interpolate.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "interpolate.h"

#include "spline.h"

#include <openbtf/reference.h>

#include <math.h>
#include <openbtf/material.h>
#include <stdlib.h>
#include <string.h>

struct enc_interpolator {
    enc_interpolation kind;
    int count;
    btf_material *tables; /* of one texel: holds the decoder's table of these directions */
    const uint16_t *table;
    uint32_t grid;
    enc_spline *spline; /* NULL: not a spline, or of a single sample, which weighs 1 */
};

static bool is_spline(enc_interpolation kind) {
    return kind == ENC_INTERPOLATE_SPLINE || kind == ENC_INTERPOLATE_CUBIC;
}

/* A material of one texel with these directions as views: the decoder's own triangulation and table. */
static btf_result make_tables(const enc_context *context, const enc_direction *directions, int count,
                              enc_interpolator *out) {
    static const int8_t texel[4] = {0};
    static const float scales[4] = {1, 0, 0, 0}, pole[3] = {0, 0, 1};
    float xyz[ENC_MAX_DIRECTIONS][3];
    for (int i = 0; i < count; i++) {
        memcpy(xyz[i], directions[i].xyz, sizeof xyz[i]);
    }
    btf_material_desc desc = {.struct_size = sizeof desc,
                              .info = {.struct_size = sizeof desc.info,
                                       .layout = BTF_LAYOUT_TIGHT,
                                       .domain = BTF_DOMAIN_LINEAR,
                                       .colour = BTF_COLOUR_NONE,
                                       .width = 1,
                                       .height = 1,
                                       .n_views = (uint32_t)count,
                                       .n_lights = 1,
                                       .levels = 1,
                                       .effects = BTF_EFFECT_RESIDUAL,
                                       .components = 1,
                                       .radiance_scale = 1,
                                       .shadow_scale = 1,
                                       .gain_scale = 1,
                                       .centre_scale = 1},
                              .views = xyz[0],
                              .lights = pole};
    int8_t *none = calloc((size_t)count * 3, 4);
    desc.texture[BTF_TEXTURE_RESIDUAL_TEXELS] = texel;
    desc.texture[BTF_TEXTURE_RESIDUAL_DIRECTIONS] = none;
    desc.texture[BTF_TEXTURE_RESIDUAL_SCALES] = scales;
    const btf_result result =
        none ? btf_material_create(&desc, context ? &context->log : NULL, &out->tables) : BTF_ERROR_MEMORY;
    free(none);
    if (result == BTF_OK) {
        out->table = btf_material_texture(out->tables, BTF_TEXTURE_VIEW_TABLE).data;
        out->grid = btf_material_views(out->tables).grid;
    }
    return result;
}

static btf_result make_spline(const enc_context *context, const char *name, const enc_direction *directions,
                              enc_interpolator *out) {
    const btf_result result = enc_spline_create(
        directions, out->count, out->kind == ENC_INTERPOLATE_CUBIC ? ENC_KERNEL_CUBIC : ENC_KERNEL_THIN_PLATE,
        &out->spline);
    if (result == BTF_ERROR_UNSUPPORTED) {
        return enc_fail(context, result,
                        "%d %s are too few for a spline, or lie in one line: a spline needs three that do not",
                        out->count, name);
    }
    return result;
}

btf_result enc_interpolator_create(const enc_context *context, const char *name,
                                   const enc_direction *directions, int count, enc_interpolation kind,
                                   enc_interpolator **out_interpolator) {
    enc_interpolator *made = calloc(1, sizeof *made);
    btf_result result = made ? BTF_OK : BTF_ERROR_MEMORY;
    *out_interpolator = NULL;
    if (made) {
        made->kind = kind;
        made->count = count;
    }
    if (result == BTF_OK && !is_spline(kind)) {
        result = make_tables(context, directions, count, made);
    } else if (result == BTF_OK && count > 1) { /* a single sample weighs 1 */
        result = make_spline(context, name, directions, made);
    }
    if (result != BTF_OK) {
        enc_interpolator_destroy(&made);
    }
    *out_interpolator = made;
    return result == BTF_ERROR_MEMORY
               ? enc_fail(context, result, "interpolation of %d %s: out of memory", count, name)
               : result;
}

void enc_interpolator_destroy(enc_interpolator **interpolator) {
    if (!interpolator || !*interpolator) {
        return;
    }
    btf_material_close(&(*interpolator)->tables);
    enc_spline_destroy(&(*interpolator)->spline);
    free(*interpolator);
    *interpolator = NULL;
}

static void table_weights(const enc_interpolator *s, const float to[3], enc_weights *out) {
    int32_t q[2];
    btf_ref_project(to, q);
    btf_ref_neighbours near = btf_ref_lookup(s->table, s->grid, q);
    if (s->kind == ENC_INTERPOLATE_NEAREST) {
        near = btf_ref_nearest(near);
    }
    out->count = 0;
    for (int i = 0; i < 3; i++) {
        if (near.weight[i] == 0) {
            continue;
        }
        out->index[out->count] = near.index[i];
        out->weight[out->count++] = (float)near.weight[i] * 0x1p-12f;
    }
}

static void spline_weights(const enc_interpolator *s, const float to[3], enc_weights *out) {
    out->count = s->count;
    for (int i = 0; i < s->count; i++) {
        out->index[i] = (uint32_t)i;
    }
    out->weight[0] = 1;
    if (s->spline) {
        enc_spline_weights(s->spline, to, out->weight);
    }
}

void enc_interpolator_weights(const enc_interpolator *interpolator, const float to[3], enc_weights *out) {
    if (is_spline(interpolator->kind)) {
        spline_weights(interpolator, to, out);
    } else {
        table_weights(interpolator, to, out);
    }
}

double enc_nearest_angle(const enc_direction *directions, int count, const float to[3]) {
    double least = HUGE_VAL; /* squared chord: an arc cosine would lose the digits of small angles */
    for (int i = 0; i < count; i++) {
        double square = 0;
        for (int axis = 0; axis < 3; axis++) {
            const double step = (double)directions[i].xyz[axis] - to[axis];
            square += step * step;
        }
        least = fmin(least, square);
    }
    return 2 * asin(fmin(sqrt(least) / 2, 1)) * 180 / 3.14159265358979323846;
}
