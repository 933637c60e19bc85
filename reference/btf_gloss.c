/* OpenBTF reference decoder: gloss, lights around a direction that keeps part of the half vector
 * (FORMAT.md, section 9).
 *
 * SPDX-License-Identifier: MIT
 */
#include "btf_reference_private.h"

#include <stddef.h>

static float within(float value, float low, float high) {
    value = value >= low ? value : low;
    return value <= high ? value : high;
}

static float dot(const float a[3], const float b[3]) {
    float x = a[0] * b[0], y = a[1] * b[1], z = a[2] * b[2];
    float sum = x + y;
    return sum + z;
}

/** Whether a view is the sampled one as nearly as makes no difference, whatever a machine does with
 * denormals. */
static bool vanishes(const float d[3]) {
    for (int i = 0; i < 3; ++i) {
        if (d[i] >= 0x1p-24f || d[i] <= -0x1p-24f) {
            return false;
        }
    }
    return true;
}

void btf_ref_gloss(const btf_ref_material *material, uint32_t index, const float light[3],
                   const float view[3], int32_t out_q[2]) {
    const float *sampled = material->view_vectors + 4 * (size_t)index;
    float d[3], h[3], c[3];
    for (int i = 0; i < 3; ++i) {
        d[i] = sampled[i] - view[i];
        h[i] = light[i] + view[i];
    }
    if (vanishes(d)) {
        btf_ref_project(light, out_q);
        return;
    }

    float r = btf_ref_reciprocal(within(dot(h, h), 0.5f, 4.0f));
    float hd = dot(h, d);
    float k = (hd + hd) * r;
    float share = (float)material->gloss_share * 0.25f;
    for (int i = 0; i < 3; ++i) {
        float g = h[i] * k;
        g = g + -d[i];
        float term = g * share;
        c[i] = light[i] + term;
    }
    c[2] = c[2] >= 0.0f ? c[2] : 0.0f;

    float n = btf_ref_pow(dot(c, c), 0.5f);
    btf_ref_project_by(c, btf_ref_reciprocal(within(n + c[2], 0.5f, 4.0f)), out_q);
}

bool btf_ref_probe_gloss(void) {
    return btf_ref_probe();
}
