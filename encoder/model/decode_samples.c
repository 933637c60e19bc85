/* Decoding a solution at its own sampled directions. See decode_samples.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "decode_samples.h"

#include "factor_profiles.h"
#include "occlusion.h"

#include <math.h>
#include <stdlib.h>

struct enc_sample_decoder {
    const enc_data *data;
    const enc_solution *solution;
    float *light_x, *light_y, *light_z; /* [light] */
    float *cosine;                      /* [light]: m of FORMAT.md section 9 */
    uint8_t *shadow;                    /* [texel][light]: a profile's codes side by side */
    float *residual;                    /* [view][component][channel][light], scaled */
};

btf_result enc_sample_decoder_create(const enc_context *context, const enc_data *data,
                                     const enc_solution *solution, enc_sample_decoder **out_decoder) {
    const size_t lights = (size_t)data->n_lights, texels = enc_solution_texels(solution);
    const size_t k = solution->factors.units > 0 ? 0 : enc_solution_components(solution);
    *out_decoder = NULL;
    enc_sample_decoder *d = calloc(1, sizeof *d);
    if (!d) {
        return enc_fail(context, BTF_ERROR_MEMORY, "decoding: out of memory");
    }
    d->data = data;
    d->solution = solution;
    d->light_x = malloc(lights * sizeof(float));
    d->light_y = malloc(lights * sizeof(float));
    d->light_z = malloc(lights * sizeof(float));
    d->cosine = malloc(lights * sizeof(float));
    d->shadow = solution->shadow ? malloc(texels * lights) : NULL;
    d->residual = k > 0 ? malloc((size_t)data->n_views * k * 3 * lights * sizeof(float)) : NULL;
    if (!d->light_x || !d->light_y || !d->light_z || !d->cosine || (solution->shadow && !d->shadow) ||
        (k > 0 && !d->residual)) {
        enc_sample_decoder_destroy(&d);
        return enc_fail(context, BTF_ERROR_MEMORY, "decoding: out of memory");
    }
    for (size_t l = 0; l < lights; l++) {
        const float *xyz = data->lights[l].xyz;
        d->light_x[l] = xyz[0];
        d->light_y[l] = xyz[1];
        d->light_z[l] = xyz[2];
        d->cosine[l] = solution->domain == BTF_DOMAIN_SQRT ? sqrtf(xyz[2]) : xyz[2];
        for (size_t t = 0; d->shadow && t < texels; t++) {
            d->shadow[t * lights + l] = solution->shadow[l * texels + t];
        }
    }
    for (size_t v = 0; k > 0 && v < (size_t)data->n_views; v++) {
        for (size_t i = 0; i < lights * 3; i++) {
            const size_t l = i / 3, channel = i % 3;
            const int8_t *in = solution->residual_directions + ((v * lights + l) * 3 + channel) * k;
            for (size_t j = 0; j < k; j++) {
                d->residual[((v * k + j) * 3 + channel) * lights + l] =
                    solution->residual_scales[j] * in[j];
            }
        }
    }
    *out_decoder = d;
    return BTF_OK;
}

void enc_sample_decoder_destroy(enc_sample_decoder **decoder) {
    enc_sample_decoder *d = decoder ? *decoder : NULL;
    if (!d) {
        return;
    }
    free(d->light_x);
    free(d->light_y);
    free(d->light_z);
    free(d->cosine);
    free(d->shadow);
    free(d->residual);
    free(d);
    *decoder = NULL;
}

/* Decodes the radiance of a cluster centre: out[channel * lights + light]. */
static void decode_centre(const enc_solution *s, size_t centre, size_t lights, float *out) {
    const uint8_t *codes = s->centre_codes + 3 * centre * lights;
    for (size_t l = 0; l < lights; l++) {
        for (size_t channel = 0; channel < 3; channel++) {
            const float y = (float)codes[3 * l + channel] * s->centre_scale;
            out[channel * lights + l] = y * y;
        }
    }
}

/* Decodes gain * m * (SBRDF * shadow + residual) of source texel `t` seen from `view`. `factors`
 * [channel][light] is the residual where its store is factors, which has m in it; else NULL. */
static void decode_source(const enc_sample_decoder *d, uint32_t effects, size_t t, size_t view, float gain,
                          const float *factors, float *out) {
    const enc_solution *s = d->solution;
    const size_t lights = (size_t)s->n_lights, n = 3 * lights;
    if (s->sbrdf) {
        enc_sbrdf_evaluate(s->sbrdf, t, d->data->views[view].xyz, (int)lights, d->light_x, d->light_y,
                           d->light_z, out);
        if (effects & BTF_EFFECT_SHADOW) {
            const uint8_t *codes = d->shadow + t * lights;
            for (size_t channel = 0; channel < 3; channel++) {
                for (size_t l = 0; l < lights; l++) {
                    out[channel * lights + l] *= (float)codes[l] * s->shadow_scale;
                }
            }
        }
    } else {
        for (size_t i = 0; i < n; i++) {
            out[i] = 0;
        }
    }
    if (d->residual && effects & BTF_EFFECT_RESIDUAL) {
        const size_t k = s->n_components;
        for (size_t j = 0; j < k; j++) {
            const float u = s->residual_texels[t * k + j];
            const float *v = d->residual + (view * k + j) * n;
            for (size_t i = 0; i < n; i++) {
                out[i] += u * v[i];
            }
        }
    }
    const bool square = s->domain == BTF_DOMAIN_SQRT;
    for (size_t channel = 0; channel < 3; channel++) {
        for (size_t l = 0; l < lights; l++) {
            float y = out[channel * lights + l] * d->cosine[l];
            y = (factors ? y + factors[channel * lights + l] : y) * gain;
            const float clamped = y >= 0x1p-30f ? fminf(y, 0x1p32f) : 0.0f;
            out[channel * lights + l] = square ? clamped * clamped : clamped;
        }
    }
}

/* How one point (view, texel) is shown. */
typedef struct point {
    bool centre;   /* by a cluster centre, else by a source */
    size_t source; /* texel */
    float gain;
} point;

static point point_at(const enc_solution *s, uint32_t effects, size_t view, size_t texel) {
    const size_t at = view * enc_solution_texels(s) + texel;
    const int code = s->gain ? s->gain[at] : BTF_GAIN_ONE;
    const bool hidden = (s->effects & BTF_EFFECT_HIDDEN) && code == 0;
    point p = {.centre = hidden && (effects & BTF_EFFECT_HIDDEN), .source = texel, .gain = 1.0f};
    if (!hidden && (effects & BTF_EFFECT_SHIFT)) {
        p.source = enc_occlusion_source(s->width, s->height, texel, s->shift[2 * at], s->shift[2 * at + 1]);
    }
    if (!hidden && (effects & BTF_EFFECT_GAIN)) {
        p.gain = enc_solution_gain(s, code);
    }
    return p;
}

/* Decodes texels first .. first + count - 1 of a view. `residual` has room for the profiles of `factors`,
 * or is NULL. */
static void decode_block(const enc_decoded_samples *decoded, size_t view, size_t first, size_t count,
                         enc_factor_profiles *factors, float *residual, float *profile, float *out) {
    const enc_sample_decoder *d = decoded->decoder;
    const enc_solution *s = d->solution;
    const uint32_t effects = decoded->effects & s->effects;
    const size_t lights = (size_t)s->n_lights, texels = enc_solution_texels(s);
    point points[ENC_FACTOR_BLOCK];
    size_t sources[ENC_FACTOR_BLOCK];
    for (size_t i = 0; i < count; i++) {
        points[i] = point_at(s, effects, view, first + i);
        sources[i] = points[i].source;
    }
    if (factors) {
        enc_factor_profiles_get(factors, sources, count, residual);
    }
    for (size_t i = 0; i < count; i++) {
        if (points[i].centre) {
            decode_centre(s, s->centre[view * texels + first + i], lights, profile);
        } else {
            decode_source(d, effects, sources[i], view, points[i].gain,
                          factors ? residual + i * 3 * lights : NULL, profile);
        }
        for (size_t l = 0; l < lights; l++) {
            for (size_t channel = 0; channel < 3; channel++) {
                out[(l * texels + first + i) * 3 + channel] =
                    profile[channel * lights + l] * s->radiance_scale;
            }
        }
    }
}

static btf_result decode_view(const void *user, int view, float *out) {
    const enc_decoded_samples *decoded = user;
    const enc_solution *s = decoded->decoder->solution;
    const size_t lights = (size_t)s->n_lights, texels = enc_solution_texels(s);
    const bool has_factors = s->factors.units > 0 && decoded->effects & s->effects & BTF_EFFECT_RESIDUAL;
    enc_factor_profiles *factors =
        has_factors ? enc_factor_profiles_create(s, (size_t)view, s->factors.units) : NULL;
    float *profiles = malloc((1 + ENC_FACTOR_BLOCK) * 3 * lights * sizeof *profiles);
    const btf_result result = profiles && (factors || !has_factors) ? BTF_OK : BTF_ERROR_MEMORY;
    for (size_t first = 0; result == BTF_OK && first < texels; first += ENC_FACTOR_BLOCK) {
        const size_t count = texels - first < ENC_FACTOR_BLOCK ? texels - first : ENC_FACTOR_BLOCK;
        decode_block(decoded, (size_t)view, first, count, factors, profiles + 3 * lights, profiles, out);
    }
    enc_factor_profiles_destroy(&factors);
    free(profiles);
    return result;
}

enc_image_source enc_decoded_images(const enc_decoded_samples *decoded) {
    return (enc_image_source){.view = decode_view, .user = decoded};
}
