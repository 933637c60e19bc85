/* A plan's material decoded against the whole one. See plan_decode.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "plan_decode.h"

#include <openbtf/reference.h>
#include "decoder/toolkit/filter.h"
#include "decoder/toolkit/reference_view.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

void plan_angles(double theta, double phi, float out[3]) {
    const double s = sin(theta * M_PI / 180);
    out[0] = (float)(s * cos(phi * M_PI / 180));
    out[1] = (float)(s * sin(phi * M_PI / 180));
    out[2] = (float)cos(theta * M_PI / 180);
}

/* Draws a direction of the range: on its borders, one of the samples in it, or anything between. */
void plan_direction(random_state *r, const btf_range *range, const btf_directions *list, float out[3]) {
    if (range->fixed) {
        memcpy(out, range->direction, 3 * sizeof *out);
        return;
    }
    const bool all = range->theta[0] == 0 && range->theta[1] == 0;
    const double low = range->theta[0], high = all ? 89.9 : range->theta[1];
    double turn = fmod((double)range->phi[1] - range->phi[0], 360);
    turn += turn < 0 ? 360 : 0;
    turn = turn > 0 ? turn : 360;
    const uint32_t kind = random_below(r, 8);
    if (kind == 0) { /* a sample, if it is in range */
        const float *d = list->xyz + 3 * (size_t)random_below(r, list->count);
        const double theta = acos(fmin((double)d[2], 1)) * 180 / M_PI;
        const double phi = fmod(atan2((double)d[1], (double)d[0]) * 180 / M_PI - range->phi[0] + 1080, 360);
        if (theta >= low && theta <= high && phi <= turn) {
            memcpy(out, d, 3 * sizeof *out);
            return;
        }
    }
    const double theta = kind == 1 ? low : kind == 2 ? high : low + (high - low) * random_unit(r);
    const double part = kind == 3 ? 0 : kind == 4 ? 1 : random_unit(r);
    plan_angles(fmin(theta, fmax(low, 89.9)), range->phi[0] + turn * part, out);
}

static btf_ref_options reference_options(const btf_shader_options *o) {
    return (btf_ref_options){
        .effects = BTF_EFFECT_ALL & ~o->leave_out,
        .components = o->components ? o->components : UINT32_MAX,
        .interpolation = o->interpolation == BTF_INTERPOLATION_NEAREST ? BTF_REF_NEAREST : BTF_REF_LINEAR,
        .filter = filter_of_reference(o->filter)};
}

int plan_differences(random_state *r, const btf_material *whole, const btf_material *small,
                     const btf_plan *plan, int count, int *out_lit) {
    btf_ref_material a, b;
    reference_view(whole, plan->level, &a);
    reference_view(small, 0, &b);
    const btf_ref_options options = reference_options(&plan->shader);
    const btf_directions views = btf_material_views(whole), lights = btf_material_lights(whole);
    int different = 0;
    *out_lit = 0;
    for (int i = 0; i < count; i++) {
        float view[3], light[3], rgb[2][3];
        plan_direction(r, &plan->scene.view, &views, view);
        plan_direction(r, &plan->scene.light, &lights, light);
        const float u = (float)random_unit(r), v = (float)random_unit(r);
        btf_ref_evaluate(&a, &options, u, v, light, view, rgb[0]);
        btf_ref_evaluate(&b, &options, u, v, light, view, rgb[1]);
        different += memcmp(rgb[0], rgb[1], sizeof rgb[0]) != 0;
        *out_lit += rgb[0][0] > 0;
    }
    return different;
}
