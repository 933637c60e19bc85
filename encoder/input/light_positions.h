/* Where the lights stood that cannot stand in the direction of the camera: laboratories move them aside,
 * and some list where to (UTIA), while file names keep the nominal angles.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_ENCODER_LIGHT_POSITIONS_H
#define OPENBTF_ENCODER_LIGHT_POSITIONS_H

#include "encoder/data/data.h"
#include "read_options.h"

/* Reads a table (csv.h) of the true directions of such lights, and keeps it with the data (enc_data_light).
 * Each line has one direction, in degrees: theta, phi, theta_of_light, phi_of_light, with or without a
 * number before them; # begins a comment, and a first line without numbers is skipped with a warning.
 * Azimuths mean the same as in the data set (azimuth_cw, azimuth_offset). Errors, naming file and line:
 * those of text_read; BTF_ERROR_BAD_FILE (no numbers, a theta of the light that is not at least 0 and below
 * 90, a direction that is no view and light of the data, or twice; no direction at all),
 * BTF_ERROR_MEMORY. */
btf_result enc_coincident_read(const enc_context *context, const char *path,
                               const enc_read_options *options, enc_data *data);

#endif
