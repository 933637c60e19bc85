/* Direction lists for samples: named sets, rings and spirals.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef OPENBTF_SAMPLE_DIRECTIONS_H
#define OPENBTF_SAMPLE_DIRECTIONS_H

#include "encoder/data/data.h"

enum { DIRECTIONS_MAX = 256 };

/* Makes a list in paper order (theta ascending, then phi ascending) from a text:
 *   ubo       the 81 of UBO2003, ATRIUM and UTIA: 0:1,15:6,30:12,45:18,60:20,75:24
 *   ubo2014   the 151 of Bonn's Dome 1
 *   small     19: 0:1,30:6,60:12
 *   tiny      5: 0:1,45:4
 *   N         a number of 1..256: a spiral of equal areas from the pole to 75 degrees
 *   RINGS     THETA:COUNT[:OFFSET],... degrees; COUNT azimuths from OFFSET, evenly; THETA rises, 0..85
 * Angles are rounded to 1e-4 degrees, which is what file names hold.
 * *out_directions: malloc'd. Errors: BTF_ERROR_USAGE (with a message), BTF_ERROR_MEMORY. */
btf_result directions_parse(const enc_context *context, const char *text, enc_direction **out_directions,
                            int *out_count);

/* An angle as file names hold it: three digits, and four decimals where it is no whole number. buffer:
 * >= 16. */
void directions_format_angle(double degrees, char *buffer);

#endif
