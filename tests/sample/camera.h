/* A simulated camera: changes the exposure of rendered images and adds noise, of its own in each image.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_SAMPLE_CAMERA_H
#define OPENBTF_SAMPLE_CAMERA_H

#include <stddef.h>
#include <stdint.h>

typedef struct sample_camera {
    double exposure; /* factor of all values */
    double noise;    /* standard deviation of the noise that is added to each value then; 0: none */
    uint32_t seed;
} sample_camera;

/* Changes the values of one image, in place. The noise is normal and independent from value to value, channels
 * included; values that it makes negative become 0. Image `number` has the same noise for the same seed, whichever
 * thread asks. */
void sample_camera_expose(const sample_camera *camera, int number, size_t count, float *values);

#endif
