/* Places of components. See codes.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "codes.h"

#include <stdlib.h>
#include <string.h>

bool enc_factor_unit_is_pure(const enc_factor_plan *plan, int class, uint32_t unit) {
    const uint32_t chroma = plan->words[class][1] + plan->words[class][2];
    return class > 0 && unit * ENC_FACTOR_UNIT_WORDS >= chroma;
}

/* Sets the places of the components that one channel has in a class, from component `at` on. first_unit,
 * first_texel: where the class begins. */
static void place_class(const enc_factor_plan *plan, int class, int channel, uint32_t first_unit,
                        uint32_t first_texel, size_t count, enc_factor_place *out) {
    const enc_factor_class *k = &enc_factor_classes[class];
    const uint32_t *words = plan->words[class];
    const uint32_t before = channel == 1 ? 0 : channel == 2 ? words[1] : words[1] + words[2];
    for (size_t j = 0; j < count; j++) {
        const uint32_t word = before + (uint32_t)(j / k->word), unit = word / ENC_FACTOR_UNIT_WORDS;
        const uint32_t scale =
            enc_factor_unit_is_pure(plan, class, unit) ? unit * ENC_FACTOR_UNIT_WORDS : word;
        out[j] = (enc_factor_place){
            .class = (uint8_t) class,
            .word = (uint8_t)(word % ENC_FACTOR_UNIT_WORDS),
            .index = (uint8_t)(j % k->word),
            .unit = (uint16_t)(first_unit + unit),
            .u_texel = (uint16_t)(first_texel + unit * k->u_texels),
            .group = (uint16_t)(first_unit * ENC_FACTOR_UNIT_WORDS + scale),
        };
    }
}

static void channel_clear(enc_factor_channel *channel) {
    free(channel->place);
    free(channel->step_u);
    free(channel->step_w);
    free(channel->u);
    free(channel->w);
}

static bool channel_init(const enc_factor_plan *plan, int channel, const enc_components *from,
                         size_t texels, size_t columns, enc_factor_channel *out) {
    uint32_t unit = 0, texel = 0;
    for (int k = 0; k < ENC_FACTOR_CLASSES; k++) {
        out->rank += enc_factor_held(plan, k, channel, from->rank);
    }
    out->place = calloc(out->rank + 1, sizeof *out->place);
    out->step_u = calloc(out->rank + 1, sizeof *out->step_u);
    out->step_w = calloc(out->rank + 1, sizeof *out->step_w);
    out->u = enc_gemm_alloc(out->rank * texels);
    out->w = enc_gemm_alloc(out->rank * columns);
    if (!out->place || !out->step_u || !out->step_w || !out->u || !out->w) {
        return false;
    }
    if (out->rank > 0) {
        memcpy(out->u, from->u, out->rank * texels * sizeof *out->u);
        memcpy(out->w, from->w, out->rank * columns * sizeof *out->w);
    }
    size_t at = 0;
    for (int k = 0; k < ENC_FACTOR_CLASSES; k++) {
        const size_t held = enc_factor_held(plan, k, channel, from->rank);
        place_class(plan, k, channel, unit, texel, held, out->place + at);
        at += held;
        unit += enc_factor_units(plan, k);
        texel += enc_factor_units(plan, k) * (uint32_t)enc_factor_classes[k].u_texels;
    }
    return true;
}

btf_result enc_factor_codes_create(const enc_factor_matrix *m, const enc_factor_plan *plan,
                                   const enc_components components[3], enc_factor_codes *out) {
    const size_t views = (size_t)m->data->n_views;
    *out = (enc_factor_codes){.plan = *plan,
                              .texels = m->texels,
                              .views = views,
                              .lights = (size_t)m->data->n_lights,
                              .columns = m->columns};
    out->view = calloc(views * ENC_FACTOR_TIERS * ENC_FACTOR_CHANNELS, sizeof *out->view);
    bool room = out->view;
    for (int c = 0; c < ENC_FACTOR_CHANNELS; c++) {
        room = channel_init(plan, c, &components[c], m->texels, m->columns, &out->channel[c]) && room;
    }
    if (!room) {
        enc_factor_codes_clear(out);
        return enc_fail(m->context, BTF_ERROR_MEMORY, "factors: out of memory");
    }
    return BTF_OK;
}

bool enc_factor_codes_extend(enc_factor_codes *codes, int channel) {
    enc_factor_channel *from = &codes->channel[channel];
    const size_t rank = codes->plan.words[0][channel] * enc_factor_classes[0].word;
    if (rank <= from->rank) {
        return true;
    }
    enc_factor_channel to = {.rank = rank,
                             .place = calloc(rank + 1, sizeof *to.place),
                             .step_u = calloc(rank + 1, sizeof *to.step_u),
                             .step_w = calloc(rank + 1, sizeof *to.step_w),
                             .u = enc_gemm_alloc(rank * codes->texels),
                             .w = enc_gemm_alloc(rank * codes->columns)};
    if (!to.place || !to.step_u || !to.step_w || !to.u || !to.w) {
        channel_clear(&to);
        return false;
    }
    place_class(&codes->plan, 0, channel, 0, 0, rank, to.place);
    memset(to.u, 0, rank * codes->texels * sizeof *to.u);
    memset(to.w, 0, rank * codes->columns * sizeof *to.w);
    memcpy(to.u, from->u, from->rank * codes->texels * sizeof *to.u);
    memcpy(to.w, from->w, from->rank * codes->columns * sizeof *to.w);
    for (size_t j = 0; j < rank; j++) {
        const bool kept = j < from->rank, beside = !kept && j > 0 && to.place[j].group == to.place[j - 1].group;
        to.step_u[j] = kept ? from->step_u[j] : beside ? to.step_u[j - 1] : 0;
        to.step_w[j] = kept ? from->step_w[j] : beside ? to.step_w[j - 1] : 0;
    }
    channel_clear(from);
    *from = to;
    return true;
}

void enc_factor_codes_clear(enc_factor_codes *codes) {
    for (int c = 0; c < ENC_FACTOR_CHANNELS; c++) {
        channel_clear(&codes->channel[c]);
    }
    free(codes->view);
    *codes = (enc_factor_codes){0};
}
