/* Exposure, and normal noise from the hash of the reliefs' noise. See camera.h.
 *
 * SPDX-License-Identifier: MIT
 */
#include "camera.h"

#include "noise.h"

#include <math.h>

/* A number of the standard normal distribution (Box and Muller 1958). */
static double normal(uint32_t seed, int image, int value) {
    const double radius = 1 - noise_hash(seed, value, image, 0); /* of (0, 1] */
    const double angle = noise_hash(seed, value, image, 1);
    return sqrt(-2 * log(radius)) * cos(6.283185307179586 * angle);
}

void sample_camera_expose(const sample_camera *camera, int number, size_t count, float *values) {
    for (size_t i = 0; i < count; ++i) {
        double value = camera->exposure * values[i];
        if (camera->noise > 0) {
            value = fmax(value + camera->noise * normal(camera->seed, number, (int)i), 0);
        }
        values[i] = (float)value;
    }
}
