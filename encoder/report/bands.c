/* Bands of elevation. See bands.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "bands.h"

#include "metrics.h"

#include <math.h>

enc_bands enc_bands_make(const enc_direction *directions, int count) {
    double theta[ENC_MAX_DIRECTIONS];
    int ring_of[ENC_MAX_DIRECTIONS];
    const int rings = enc_rings(directions, count, theta, ring_of);
    enc_bands b = {.count = rings < BTF_MAX_BANDS ? rings : BTF_MAX_BANDS};
    for (int i = 1; i < b.count; i++) {
        const int first = i * rings / b.count;
        b.limit[i] = (theta[first - 1] + theta[first]) / 2;
    }
    b.limit[b.count] = fmin(fmax(theta[rings - 1], b.limit[b.count - 1] + 1), 90);
    return b;
}

int enc_bands_members(const enc_bands *bands, int band, const enc_direction *directions, int count,
                      int out_members[ENC_MAX_DIRECTIONS]) {
    int n = 0;
    for (int i = 0; i < count; i++) {
        if (directions[i].theta >= bands->limit[band] - 1e-3 &&
            directions[i].theta <= bands->limit[band + 1] + 1e-3) {
            out_members[n++] = i;
        }
    }
    return n;
}

float *enc_bands_write(const enc_bands *views, const enc_bands *lights, float *out) {
    *out++ = (float)views->count;
    *out++ = (float)lights->count;
    for (int i = 0; i <= views->count; i++) {
        *out++ = (float)views->limit[i];
    }
    for (int i = 0; i <= lights->count; i++) {
        *out++ = (float)lights->limit[i];
    }
    return out;
}
