/* Samples whose view and light have one direction. See coincident.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "coincident.h"

#include <math.h>

static const double same = 0.01; /* degrees */

bool enc_same_direction(const enc_direction *direction, double theta, double phi) {
    const double turn = fabs(remainder(direction->phi - phi, 360.0));
    return fabs(direction->theta - theta) <= same && (turn <= same || theta <= same);
}

int enc_coincident_light(const enc_data *data, int view) {
    for (int l = 0; l < data->n_lights; l++) {
        if (enc_same_direction(&data->lights[l], data->views[view].theta, data->views[view].phi)) {
            return l;
        }
    }
    return -1;
}
