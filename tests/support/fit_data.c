/* Data of known lobes for the tests of the fit. See fit_data.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "fit_data.h"

#include "test.h"

uint32_t fit_random_state = 1;
float fit_random(void) {
    fit_random_state ^= fit_random_state << 13;
    fit_random_state ^= fit_random_state >> 17;
    fit_random_state ^= fit_random_state << 5;
    return (float)(fit_random_state >> 8) * 0x1p-24f;
}

void fit_directions(enc_direction out[DIRECTIONS]) {
    static const int count[6] = {1, 6, 12, 18, 20, 24};
    for (int ring = 0, n = 0; ring < 6; ring++) {
        for (int i = 0; i < count[ring]; i++) {
            out[n++] = enc_direction_from_angles(15.0 * ring, 360.0 * i / count[ring]);
        }
    }
}

double fit_model_value(const float *parameters, int lobes, bool rgb, const double product[3], int channel) {
    const float *shape = parameters + (rgb ? 3 + 3 * lobes : 4);
    double sum = (double)parameters[rgb ? channel : 3];
    for (int j = 0; j < lobes; j++, shape += 4) {
        double base = 0;
        for (int k = 0; k < 3; k++) {
            base += (double)shape[k] * product[k];
        }
        const double power = base > 0x1p-24 ? pow(base, (double)shape[3]) : 0;
        sum += rgb ? (double)parameters[3 + 3 * j + channel] * power : power;
    }
    return rgb ? sum : sum * (double)parameters[channel];
}

void fit_assert_storable(const float *parameters, size_t count) {
    for (size_t i = 0; i < count; i++) {
        const float magnitude = fabsf(parameters[i]);
        assert_true(parameters[i] == 0 || (magnitude >= 0x1p-24f && magnitude <= 0x1p24f));
    }
}
