/* Bands of elevation. See bands.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "bands.h"

#include "drawn_texels.h"
#include "metrics.h"

#include <math.h>
#include <string.h>

#define DEGREE (3.14159265358979323846 / 180)

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

static double unit(uint64_t seed) {
    return (double)(enc_mix(seed) >> 11) * 0x1p-53;
}

/* Equal steps of z are equal solid angles (Archimedes' hat-box theorem): z is drawn uniformly between the limits. */
void enc_bands_draw(const enc_bands *bands, int band, uint64_t seed, float out_direction[3]) {
    const double low = cos(bands->limit[band] * DEGREE), high = cos(bands->limit[band + 1] * DEGREE);
    const double z = low + (high - low) * unit(seed), phi = 360 * DEGREE * unit(seed + 1),
                 s = sqrt(1 - z * z);
    out_direction[0] = (float)(s * cos(phi));
    out_direction[1] = (float)(s * sin(phi));
    out_direction[2] = (float)z;
}

void enc_bands_draw_sample(const enc_bands *bands, int band, const enc_direction *directions, int count,
                           uint64_t seed, float out_direction[3]) {
    int inside[ENC_MAX_DIRECTIONS];
    const int n = enc_bands_members(bands, band, directions, count, inside);
    memcpy(out_direction, directions[n > 0 ? inside[enc_mix(seed) % (uint64_t)n] : 0].xyz,
           3 * sizeof *out_direction);
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
