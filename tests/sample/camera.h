/* What a camera does to rendered images: exposure, and noise of its own in each.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_SAMPLE_CAMERA_H
#define OPENBTF_SAMPLE_CAMERA_H

#include <stddef.h>
#include <stdint.h>

typedef struct sample_camera {
    double exposure; /* factor of all values */
    double noise;    /* standard deviation of what is added to each value then; 0: nothing */
    uint32_t seed;
} sample_camera;

/* Changes the values of one image, in place. The noise is normal and independent from value to value, channels included;
 * what it takes below 0 is 0. Image `number` of the same seed has the same noise whatever thread asks for it. */
void sample_camera_expose(const sample_camera *camera, int number, size_t count, float *values);

#endif
