/* Samples whose view and light have one direction. A light cannot stand where the camera stands, so these
 * are measured with the light aside, or not at all.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_COINCIDENT_H
#define OPENBTF_ENCODER_COINCIDENT_H

#include "data.h"

/* Whether a direction is (theta, phi), in degrees, up to the rounding of names and tables (0.01 degrees). */
bool enc_same_direction(const enc_direction *direction, double theta, double phi);

/* The light of the same direction as a view, or -1. */
int enc_coincident_light(const enc_data *data, int view);

#endif
